"""Props from scene files: where they come to be, what they wear, what is refused."""

import json
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image
from prop_scenes import CUBE, FILES, FLOOR, cube_files, place, require_whole

from followspot.assets.archive import Archive
from followspot.assets.shader_values import Sides
from followspot.errors import AssetError
from followspot.present.inspect import inspect
from followspot.scene.figure_file import FigureFiles
from followspot.scene.load import load, load_figure
from followspot.scene.prop_file import PropEntry
from followspot.scene.prop_mesh import with_props
from followspot.scene.props import Prop, PropFiles
from mesh_fixtures import gltf_cube, md3_cube
from synthetic import rotation


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return cube_files(tmp_path)


def points(prop: Prop) -> Any:
    """Positions in an order that no file decides."""
    found = np.concatenate([s.vertices["position"] for s in prop.surfaces])
    return np.unique(found.round(3) + 0.0, axis=0)


@pytest.mark.parametrize("name", FILES)
def test_every_format_ends_up_in_the_same_place(folder: Path, name: str) -> None:
    where = "origin = [100, 20, 30]\nangles = [10, 20, 30]\nscale = 2"
    (prop,) = place(folder, f'file = "{name}"\n{where}')
    turn = rotation((0, 0, 1), 20) @ rotation((0, 1, 0), 10) @ rotation((1, 0, 0), 30)
    wanted = 2 * CUBE.positions @ turn.T + (100, 20, 30)
    assert_allclose(points(prop), np.unique(wanted.round(3), axis=0), atol=2e-3)
    (surface,) = prop.surfaces
    assert surface.material.image == "wood.png"
    assert not surface.material.is_tinted and surface.tints is None
    assert prop.triangle_count == 12
    # Normals look away from the middle, and so do the (clockwise) triangles.
    normal, at = surface.vertices["normal"], surface.vertices["position"]
    assert_allclose(np.linalg.norm(normal, axis=1), 1, atol=1e-5)
    assert_allclose(((at - (100, 20, 30)) * normal).sum(axis=1), 32, atol=1e-2)
    a, b, c = at[surface.indices.reshape(-1, 3)].transpose(1, 0, 2)
    assert (((a - (100, 20, 30)) * np.cross(c - a, b - a)).sum(axis=1) > 0).all()


def test_angles_are_the_games(folder: Path) -> None:
    """Pitch looks down, yaw to the left, roll leans to the right; and yaw alone may be given."""
    points_of = {}
    for angles in ("angles = [90, 0, 0]", "angles = [0, 90, 0]", "angles = [0, 0, 90]", "yaw = 90"):
        arrow = 'file = "arrow.obj"\norigin = [0, 0, 0]\n'
        (folder / "arrow.obj").write_text("v 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n")
        (prop,) = place(folder, arrow + angles)
        points_of[angles] = prop.surfaces[0].vertices["position"].round(4) + 0.0
    assert points_of["angles = [90, 0, 0]"].tolist() == [[0, 0, -1], [0, 2, 0], [3, 0, 0]]
    assert points_of["angles = [0, 90, 0]"].tolist() == [[0, 1, 0], [-2, 0, 0], [0, 0, 3]]
    assert points_of["angles = [0, 0, 90]"].tolist() == [[1, 0, 0], [0, 0, 2], [0, -3, 0]]
    assert (points_of["yaw = 90"] == points_of["angles = [0, 90, 0]"]).all()


def test_up_and_metres(folder: Path) -> None:
    """glTF is Y up and in metres unless a scene says otherwise; OBJ is neither."""
    (folder / "arrow.obj").write_text("v 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n")
    where = 'origin = [0, 0, 0]\nfile = "arrow.obj"'
    (as_it_is,) = place(folder, where, metres=0.5)
    assert as_it_is.surfaces[0].vertices["position"].tolist() == [[1, 0, 0], [0, 2, 0], [0, 0, 3]]
    (turned,) = place(folder, where + '\nup = "y"')
    assert turned.surfaces[0].vertices["position"].tolist() == [[0, 1, 0], [0, 0, 2], [3, 0, 0]]
    (prop,) = place(folder, 'file = "cube.glb"\norigin = [0, 0, 0]', metres=0.06)
    assert_allclose(prop.bounds[1], [8, 8, 8], rtol=1e-6)


@pytest.mark.parametrize("name", FILES)
def test_props_are_dropped_to_the_floor(folder: Path, name: str) -> None:
    for origin, height in (([0, 0, 200], -16), ([0, 0, -20], -16), ([100, 0, 50], 0)):
        (prop,) = place(folder, f'file = "{name}"\norigin = {origin}\nyaw = 45\nground = true')
        mins, maxs = prop.bounds
        assert mins[2] == pytest.approx(height, abs=1e-3)
        assert_allclose((mins[:2] + maxs[:2]) / 2, origin[:2], atol=1e-3)
    (hung,) = place(folder, f'file = "{name}"\norigin = [0, 0, 200]')
    assert hung.bounds[0][2] == pytest.approx(184, abs=1e-3)
    (lost,) = place(folder, f'file = "{name}"\norigin = [5000, 0, 200]\nground = true')
    assert lost.bounds[0][2] == pytest.approx(184, abs=1e-3)


def test_a_file_is_read_once(folder: Path) -> None:
    archive = Archive.open([folder])
    files = PropFiles(archive, FigureFiles(archive, lambda _: None))
    assert files.open("cube.glb") is files.open("CUBE.glb")


def test_images_inside_of_files_are_found_in_the_archive(folder: Path) -> None:
    document = gltf_cube(CUBE)
    picture = (folder / "wood.png").read_bytes()
    document.json |= {
        "images": [{"bufferView": document.view(picture), "mimeType": "image/png"}] * 2,
        "textures": [{"source": 1}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    }
    document.primitive["material"] = 0
    (folder / "inside.glb").write_bytes(document.glb())
    archive = Archive.open([folder])
    files = PropFiles(archive, FigureFiles(archive, lambda _: None))
    image = files.open("inside.glb").surfaces[0].material.image
    assert image is not None and archive.read(image) == picture
    assert archive.source(image).startswith(str(folder / "inside.glb"))


def test_what_is_missing_is_listed_and_white(folder: Path) -> None:
    (folder / "wood.png").unlink()
    (folder / "cube.mtl").unlink()
    archive = Archive.open([folder])
    figures = FigureFiles(archive, lambda _: None)
    files = PropFiles(archive, figures)
    for name in FILES:
        assert files.open(name).surfaces[0].material.image is None
    assert "wood.png" in figures.missing["wood.png"]
    assert ["found cube.mtl" in str(p) for p in figures.problems] == [True]


def test_factors_and_cut_outs_become_tints_and_tests(folder: Path) -> None:
    document = gltf_cube(
        CUBE,
        materials=[
            {
                "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 1, 0.5]},
                "alphaMode": "MASK",
                "alphaCutoff": 0.25,
            }
        ],
    )
    document.primitive["material"] = 0
    colors = np.linspace(0, 1, 96, dtype=np.float32).reshape(24, 4)
    document.attribute("COLOR_0", colors)
    (folder / "tinted.glb").write_bytes(document.glb())
    (prop,) = place(folder, 'file = "tinted.glb"\norigin = [0, 0, 0]')
    (surface,) = prop.surfaces
    assert surface.tints is not None and surface.material.is_tinted
    assert_allclose(surface.tints, colors * (0.5, 0.25, 1, 0.5), rtol=1e-6)
    # Half of a texel's alpha counts, and a quarter is asked for: bytes from 128 on stay.
    assert surface.material.alpha_scale == pytest.approx(2 * 128 / 255)
    level = with_props(FLOOR, (prop,))
    assert level.mesh.tints is not None
    before = len(FLOOR.mesh.vertices)
    assert (level.mesh.tints[:before] == 1).all()
    assert_allclose(level.mesh.tints[before:], surface.tints)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('file = "cube.glb"', r"props\[0\]: expected the key origin, found none"),
        (
            'file = "cube.glb"\norigin = [0, 0]',
            r"props\[0\].origin: expected a list of length 3, found 2",
        ),
        (
            'file = "cube.glb"\norigin = [0, 0, 0]\nsize = 2',
            r"known keys \(file, .*found size",
        ),
        (
            'file = "cube.glb"\norigin = [0, 0, 0]\nscale = 0',
            r"props\[0\].scale: expected a number >= 1e-06, found 0",
        ),
        (
            'file = "cube.glb"\norigin = [0, 0, 0]\nscale = "big"',
            r"props\[0\].scale: expected a number, found 'big'",
        ),
        ('file = "cube.glb"\norigin = [0, 0, 0]\nup = "x"', r"props\[0\].up: expected y, z, found"),
        ('file = "cube.glb"\norigin = [0, 0, 0]\nyaw = nan', r"props\[0\].yaw: expected a finite"),
        (
            'file = "cube.glb"\norigin = [0, 0, 0]\nyaw = 1\nangles = [0, 0, 0]',
            r"props\[0\]: expected `yaw` or `angles`, found both",
        ),
        (
            'file = "cube.glb"\norigin = [0, 0, 0]\nground = 1',
            r"props\[0\].ground: expected true or false, found 1",
        ),
        (
            'file = "no.glb"\norigin = [0, 0, 0]',
            r"x.toml: props\[0\].file: no.glb: exp.*found none",
        ),
        (
            'file = "wood.png"\norigin = [0, 0, 0]',
            r"props\[0\].file: wood.png: expected a file .glb",
        ),
        ('file = "player:x"\norigin = [0, 0, 0]', "player:x: expected a file .glb"),
        (
            'file = "bad.glb"\norigin = [0, 0, 0]',
            r"x.toml: props\[0\].file: .*bad.glb: header: expected",
        ),
        (
            'file = "cube.glb"\norigin = [0, 0, 0]\nscale = 1e6',
            r"x.toml: props\[0\]: expected a prop within 1e\+07 units of 0, found 1.6e\+07",
        ),
    ],
)
def test_what_a_scene_file_gets_wrong(folder: Path, text: str, message: str) -> None:
    (folder / "bad.glb").write_bytes(b"glTF")
    with pytest.raises(AssetError, match=message):
        place(folder, text)


SCENE = """level = "courtyard"
[[props]]
file = "things/cube.glb"
origin = [-170, -60, 40]
ground = true
[[props]]
file = "things/cube.md3"
origin = [-490, 100, 40]
yaw = 30
[[props]]
file = "things/cube.obj"
origin = [0, 0, 9000]
[cameras.start]
position = [-352, -118, 78]
"""


@pytest.fixture
def yard(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    own = tmp_path_factory.mktemp("yard")
    (own / "things").mkdir()
    for path in folder.iterdir():
        (own / "things" / path.name).write_bytes(path.read_bytes())
    (own / "yard.toml").write_text(SCENE)
    yield own / "yard.toml"


def test_a_scene_file_puts_props_beside_it_into_its_level(yard: Path) -> None:
    scene = load(str(yard))
    bare = load("courtyard")
    names = ["things/cube.glb", "things/cube.md3", "things/cube.obj"]
    assert [prop.name for prop in scene.props] == names
    assert scene.mesh.triangle_count == bare.mesh.triangle_count + 36
    assert {m.name for m in scene.missing} == {m.name for m in bare.missing}
    assert "beside:/things/wood.png" in scene.images
    assert scene.archive.source("beside:/things/wood.png") == str(yard.parent / "things/wood.png")
    require_whole(scene.level)
    assert scene.bounds[1][2] == pytest.approx(9016)
    told = inspect(str(yard), ())
    assert [(p["name"], p["triangles"]) for p in told["props"]] == [(name, 12) for name in names]
    json.dumps(told)


@pytest.mark.parametrize("place", ["", "things/"])
def test_what_lies_beside_a_prop_is_there_for_props_alone(yard: Path, place: str) -> None:
    """No level, texture or script; the level is found as it is without the prop."""
    bare = load("courtyard")
    own = yard.parent / place
    for path in (yard.parent / "things").iterdir():
        (own / path.name).write_bytes(path.read_bytes())
    image = next(image for image in bare.images if image.startswith("textures/"))
    for name in ("maps", "scripts", Path(image).parent):
        (own / name).mkdir(parents=True)
    (own / "maps/courtyard.bsp").write_bytes(b"no level")
    (own / image).write_bytes(b"no image")
    (own / "scripts/a.shader").write_text(
        "".join(f"{m.name} {{ {{ map wood.png }} }}\n" for m in bare.materials)
    )
    with zipfile.ZipFile(own / "zzz.pk3", "w") as pak:
        pak.writestr("maps/courtyard.bsp", b"no level either")
    text = f'level = "courtyard"\n[[props]]\nfile = "{place}cube.glb"\norigin = [0, 0, 9000]\n'
    yard.write_text(text)
    scene = load(str(yard))
    assert scene.level.bsp.source == bare.level.bsp.source
    assert set(scene.images) == {*bare.images, f"beside:/{place}wood.png"}
    assert [scene.archive.source(i) for i in bare.images] == list(
        map(bare.archive.source, bare.images)
    )
    # A level that is asked for by folder is there, with or without the prop.
    other = yard.parent / "other"
    (other / "maps").mkdir(parents=True)
    (other / "maps/courtyard.bsp").write_bytes(bare.archive.read("maps/courtyard.bsp"))
    found = load(str(yard), [other]).level.bsp.source
    assert found == str(other / "maps/courtyard.bsp")


def test_a_prop_wears_what_lies_beside_it_by_its_own_script(yard: Path) -> None:
    """A model in a game folder of its own: scripts and images there come before the game's."""
    game = yard.parent / "mod"
    for name in ("models/cube", "scripts", "textures"):
        (game / name).mkdir(parents=True)
    (game / "models/cube/cube.md3").write_bytes(md3_cube(CUBE, "textures/mine", "textures/other"))
    (game / "scripts/mine.shader").write_text(
        "textures/mine { cull none\n { map textures/other.png } }"
    )
    Image.new("RGB", (4, 4)).save(game / "textures/other.png")
    yard.write_text(
        'level = "courtyard"\n[[props]]\nfile = "mod/models/cube/cube.md3"\norigin = [0, 0, 9000]\n'
    )
    scene = load(str(yard))
    (prop,) = scene.props
    assert prop.name == "mod/models/cube/cube.md3"
    looks = {s.material.name: (s.material.image, s.material.sides) for s in prop.surfaces}
    assert looks == {
        "textures/mine": ("beside:/mod/textures/other.png", Sides.BOTH),
        "textures/other": ("beside:/mod/textures/other.png", Sides.FRONT),
    }
    assert {m.name for m in scene.missing} == {m.name for m in load("courtyard").missing}


def test_where_a_prop_is_looked_for_is_told(yard: Path) -> None:
    yard.write_text('level = "courtyard"\n[[props]]\nfile = "no.glb"\norigin = [0, 0, 0]\n')
    told = rf"yard.toml: props\[0\].file: no.glb: expected a file in {yard.parent}, /.*, found none"
    with pytest.raises(AssetError, match=told):
        load(str(yard))


def test_every_material_of_a_model_has_its_own_vertices_alone(folder: Path) -> None:
    (folder / "two.md3").write_bytes(md3_cube(CUBE, "wood.png", "stone.png"))
    (prop,) = place(folder, 'file = "two.md3"\norigin = [1, 2, 3]')
    assert {surface.material.image for surface in prop.surfaces} == {"wood.png", None}
    (one,) = place(folder, 'file = "cube.md3"\norigin = [1, 2, 3]')
    for surface in prop.surfaces:
        assert np.array_equal(surface.vertices, one.surfaces[0].vertices)
        assert np.array_equal(surface.indices, one.surfaces[0].indices)


@pytest.mark.parametrize("name", FILES)
def test_a_mesh_alone_stands_on_a_plain_floor(folder: Path, name: str) -> None:
    scene = load_figure(str(folder / name))
    assert {"start", "front", "back"} <= set(scene.cameras)
    assert scene.triangle_count == 2 + 12
    if name != "cube.md3":
        (prop,) = scene.props
        assert_allclose(prop.bounds[0], [-16, -16, 0], atol=1e-3)
        assert_allclose(prop.bounds[1], [16, 16, 32], atol=1e-3)
        eye = scene.camera().position
        assert scene.visibility.faces_from(eye).all()
        with pytest.raises(AssetError, match="animation: expected none, found run"):
            load_figure(str(folder / name), animation="run")


def test_entries_have_one_turn() -> None:
    assert PropEntry(file="x", origin=(0, 0, 0), yaw=5).turn == (0, 5, 0)
    assert PropEntry(file="x", origin=(0, 0, 0)).turn == (0, 0, 0)
