"""Props in pictures: where they should be, as they should look, with their shadows."""

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

from conftest import Draw
from followspot.assets.archive import Archive
from followspot.assets.image import srgb_to_linear
from followspot.scene import scene_file
from followspot.scene.camera import Camera
from followspot.scene.figure_file import FigureFiles
from followspot.scene.material import Material
from followspot.scene.prop_mesh import with_props
from followspot.scene.props import PropFiles, props
from followspot.scene.scene import Scene
from mesh_fixtures import cube, gltf_cube, md3_cube, obj, ply
from synthetic import DIM, box, floor, looking, make_scene, of, on_plane, spot, srgb_decoded, turned
from synthetic import rotation as rotation_about

pytestmark = pytest.mark.gl

CUBE = cube()
LIGHT = spot((-60, 80, 160), (0, 0, 0), 40, 400)
EYE = looking((110, 40, 70), (0, 0, 10), 60)
FRONT = looking((60, 0, 16), (0, 0, 16), 60)
QUARTERS = np.array([[(255, 0, 0), (0, 255, 0)], [(0, 0, 255), (90, 90, 90)]], np.uint8)


def png(pixels: Any) -> bytes:
    file = io.BytesIO()
    Image.fromarray(np.asarray(pixels, np.uint8)).save(file, "png")
    return file.getvalue()


def scene_of(folder: Path, text: str, *, with_floor: bool = True) -> Scene:
    """Props of a scene file's text on a floor at height 0, or alone, under one light."""
    archive = Archive.open([folder])
    files = PropFiles(archive, FigureFiles(archive, lambda _: None))
    entries = scene_file.parse(f'level = "x"\n[[props]]\n{text}', "x.toml").props
    placed = props(entries, files, 0.03, "x.toml")
    bare = make_scene([floor(400)] if with_floor else [], LIGHT, archive=archive)
    level = with_props(bare.level, placed)
    return replace(bare, level=level)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    document = gltf_cube(
        CUBE,
        textures=[{"source": 0}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    )
    picture = png(QUARTERS.repeat(8, axis=0).repeat(8, axis=1))
    document.json["images"] = [{"bufferView": document.view(picture), "mimeType": "image/png"}]
    document.primitive["material"] = 0
    (tmp_path / "cube.glb").write_bytes(document.glb())
    (tmp_path / "cube.obj").write_bytes(obj(CUBE, "cube.mtl", "wood"))
    (tmp_path / "cube.mtl").write_text("newmtl wood\nmap_Kd wood.png\n")
    (tmp_path / "cube.ply").write_bytes(ply(CUBE, "wood.png"))
    (tmp_path / "cube.md3").write_bytes(md3_cube(CUBE, "wood.png"))
    (tmp_path / "wood.png").write_bytes(picture)
    return tmp_path


@pytest.mark.parametrize("name", ["cube.obj", "cube.ply", "cube.md3"])
def test_one_cube_of_four_formats_is_one_picture(folder: Path, draw: Draw, name: str) -> None:
    where = "origin = [3, -5, 16]\nyaw = 20"
    wanted, found = (scene_of(folder, f'file = "{n}"\n{where}') for n in ("cube.glb", name))
    for view in ("final", "normals", "shadow"):
        a, b = (draw(scene, EYE, view, DIM) for scene in (wanted, found))
        # glTF's metres are rounded, so an edge may fall to the other side of a pixel's middle.
        assert (np.abs(a - b) > 2e-3 * a.max()).mean() < 2e-3
        assert np.abs(a - b).mean() < 1e-3 * a.mean()
    assert draw(wanted, EYE, "lambertian", DIM).std() > 0.1


def test_a_prop_stands_and_casts_as_a_box_of_the_level_does(folder: Path, draw: Draw) -> None:
    scene = scene_of(folder, 'file = "cube.obj"\norigin = [3, -5, 16]\nyaw = 20')
    same = turned(box((-16, -16, -16), (16, 16, 16)), rotation_about((0, 0, 1), 20), (3, -5, 16))
    wanted = make_scene([floor(400), *same], LIGHT)
    for view in ("depth", "normals", "shadow", "shading", "direct"):
        a, b = draw(wanted, EYE, view, DIM), draw(scene, EYE, view, DIM)
        a, b = (np.where(np.isfinite(each), each, 0) for each in (a, b))
        if view == "direct":  # its floor alone is of one colour
            on_floor = draw(wanted, EYE, "normals", DIM)[..., 2] > 0.99
            on_floor &= np.abs(draw(wanted, EYE, "depth", DIM) - floor_depth(EYE)) < 0.1
            a, b = a[on_floor], b[on_floor]
        assert (np.abs(a - b) > 1e-3 * np.abs(a).max()).mean() < 1e-3, view
    lit = draw(scene, EYE, "shadow", DIM)
    assert (lit < 0.5).mean() > 0.05 and (lit > 0.5).mean() > 0.3


def floor_depth(view: Camera) -> Any:
    return on_plane(view, (0, 0, 1))[1]


@pytest.mark.parametrize("name", ["cube.glb", "cube.obj", "cube.ply", "cube.md3"])
def test_images_stand_the_right_way_up(folder: Path, draw: Draw, name: str) -> None:
    """Seen from in front, the image's top left is at the top left."""
    scene = scene_of(folder, f'file = "{name}"\norigin = [0, 0, 16]', with_floor=False)
    picture = draw(scene, FRONT, "lambertian", DIM)
    at = [(y, x) for y in (45, 75) for x in (65, 95)]
    found = np.array([picture[y, x] for y, x in at])
    assert_allclose(found, srgb_decoded(QUARTERS.reshape(4, 3) / 255), atol=2e-3)
    there = np.isfinite(draw(scene, FRONT, "depth", DIM))
    half = np.flatnonzero(there.any(axis=0))  # 16 units at a distance of 44
    wide = 80 * 16 / 44 / np.tan(np.radians(30))
    assert half[0] == pytest.approx(80 - wide, abs=1) and half[-1] == pytest.approx(
        79 + wide, abs=1
    )


def test_base_colour_is_the_lambertian_coefficient(folder: Path, draw: Draw) -> None:
    document = gltf_cube(
        CUBE, materials=[{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.123, 0.004, 1]}}]
    )
    document.primitive["material"] = 0
    (folder / "plain.glb").write_bytes(document.glb())
    scene = scene_of(folder, 'file = "plain.glb"\norigin = [0, 0, 16]', with_floor=False)
    picture = draw(scene, FRONT, "lambertian", DIM)
    assert_allclose(picture[60, 80], (0.8, 0.123, 0.004), rtol=1e-6)
    white, tinted = draw(scene, FRONT, "shading", DIM), draw(scene, FRONT, "final", DIM)
    assert_allclose(tinted[60, 80], white[60, 80] * (0.8, 0.123, 0.004), rtol=1e-5)
    grey = draw(scene, FRONT, "final", replace_albedo(0.5))
    assert_allclose(grey[60, 80], white[60, 80] * 0.5, rtol=1e-5)


def replace_albedo(albedo: float) -> Any:
    import msgspec

    return msgspec.structs.replace(DIM, albedo=albedo)


def test_colours_of_vertices_are_mixed_in_linear_light(folder: Path, draw: Draw) -> None:
    colors = np.where(CUBE.texcoords[:, :1] > 0.5, (250, 60, 0), (10, 200, 90)).astype(np.uint8)
    (folder / "painted.ply").write_bytes(ply(CUBE, colors=colors))
    scene = scene_of(folder, 'file = "painted.ply"\norigin = [0, 0, 16]', with_floor=False)
    picture = draw(scene, FRONT, "lambertian", DIM)
    left, right = srgb_to_linear(np.array([(10, 200, 90), (250, 60, 0)]) / 255)
    column = np.arange(70, 90)
    share = ((column + 0.5 - 80) / 80 * np.tan(np.radians(30)) * 44 + 16) / 32
    wanted = left + (right - left) * share[:, np.newaxis]
    assert_allclose(picture[60, column], wanted, atol=1e-5)


@pytest.mark.parametrize("inside", [True, False])
def test_cut_outs_are_cut_at_the_files_own_alpha(folder: Path, draw: Draw, inside: bool) -> None:
    """Alpha 60 of 255 times a factor of one half is below a cut-off of 0.15, 100 is above."""
    alpha = np.full((8, 8), 100, np.uint8)
    alpha[:, 4:] = 60
    pixels = np.dstack([np.full((8, 8, 3), 255, np.uint8), alpha])
    document = gltf_cube(
        CUBE,
        textures=[{"source": 0, "sampler": 0}],
        samplers=[{"wrapS": 33071, "wrapT": 33071}],
        materials=[
            {
                "pbrMetallicRoughness": {
                    "baseColorFactor": [1, 1, 1, 0.5],
                    "baseColorTexture": {"index": 0},
                },
                "alphaMode": "MASK",
                "alphaCutoff": 0.15,
            }
        ],
    )
    if inside:
        document.json["images"] = [{"bufferView": document.view(png(pixels))}]
    else:
        (folder / "leaf.png").write_bytes(png(pixels))
        document.json["images"] = [{"uri": "leaf.png"}]
    document.primitive["material"] = 0
    document.primitive["indices"] = document.accessor(CUBE.triangles[:2].astype("<u2").ravel())
    (folder / "leaf.glb").write_bytes(document.glb())
    scene = scene_of(folder, 'file = "leaf.glb"\norigin = [0, 0, 16]')
    depth = draw(scene, FRONT, "depth", DIM)[60]
    near = np.abs(depth - 44) < 0.01
    assert near[56:78].all() and not near[82:].any()
    # Its shadow is that of the half that is there: the corner at -Y, as seen from +X the left.
    lit = draw(scene, EYE, "shadow", DIM)
    half = turned(of(Material("w"), *box((15.99, -16, 0), (16, 0, 32))), np.eye(3))
    wanted = draw(make_scene([floor(400), *half], LIGHT), EYE, "shadow", DIM)
    on_floor = np.abs(draw(scene, EYE, "depth", DIM) - floor_depth(EYE)) < 0.1
    assert (np.abs(lit - wanted)[on_floor] > 0.5).mean() < 0.01
    assert (wanted[on_floor] < 0.5).mean() > 0.01


def test_glass_lets_through_what_its_factor_says(folder: Path, draw: Draw) -> None:
    document = gltf_cube(
        CUBE,
        materials=[
            {
                "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 0.25]},
                "alphaMode": "BLEND",
            }
        ],
    )
    document.primitive["material"] = 0
    (folder / "glass.glb").write_bytes(document.glb())
    scene = scene_of(folder, 'file = "glass.glb"\norigin = [0, 0, 16]')
    bare = make_scene([floor(400)], LIGHT)
    behind = draw(bare, EYE, "final", DIM)
    through = draw(scene, EYE, "final", DIM)
    ratio = through[..., 1] / np.maximum(behind[..., 1], 1e-9)
    # One side is seen, since backs are not drawn; and glass throws no shadow.
    values = np.unique(ratio[behind[..., 1] > 1e-3].round(3))
    assert set(values.tolist()) <= {0.75, 1.0, 0.562, 0.563}
    assert (np.abs(ratio - 0.75) < 1e-3).mean() > 0.05
