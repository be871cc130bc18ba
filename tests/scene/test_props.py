"""Props from scene files: where they come to be, what the level makes of them, what is refused."""

import json
import zipfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from PIL import Image

from followspot.assets.archive import Archive
from followspot.assets.bsp import LUMPS
from followspot.assets.shader_values import Sides
from followspot.errors import AssetError
from followspot.present.inspect import inspect
from followspot.scene import bsp_tree, scene_file
from followspot.scene.deform import RIGID
from followspot.scene.figure_file import FigureFiles
from followspot.scene.fog import Fog
from followspot.scene.ground import Ground
from followspot.scene.level import Level
from followspot.scene.load import load, load_figure
from followspot.scene.mesh import Mesh, face_boxes, face_planes
from followspot.scene.prop_file import PropEntry
from followspot.scene.prop_mesh import with_props
from followspot.scene.props import Prop, PropFiles, props
from mesh_fixtures import cube, gltf_cube, md3_cube, obj, ply
from synthetic import box, floor, make_scene, open_bsp, rotation

CUBE = cube()
FLOOR = make_scene([floor(1000, z=-16), *box((90, -50, -16), (300, 50, 0))]).level


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One cube of 32 units in every format, and its image."""
    document = gltf_cube(
        CUBE,
        images=[{"uri": "wood.png"}],
        textures=[{"source": 0}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    )
    document.primitive["material"] = 0
    (tmp_path / "cube.glb").write_bytes(document.glb())
    (tmp_path / "cube.obj").write_bytes(obj(CUBE, "cube.mtl", "wood"))
    (tmp_path / "cube.mtl").write_text("newmtl wood\nmap_Kd wood.png\n")
    (tmp_path / "cube.ply").write_bytes(ply(CUBE, "wood.png"))
    (tmp_path / "cube.md3").write_bytes(md3_cube(CUBE, "wood.png"))
    Image.new("RGB", (4, 4), (200, 100, 50)).save(tmp_path / "wood.png")
    return tmp_path


def place(folder: Path, *texts: str, ground: Level = FLOOR, metres: float = 0.03) -> Any:
    text = "".join(f"[[props]]\n{text}\n" for text in texts)
    entries = scene_file.parse(f'level = "x"\n{text}', "x.toml").props
    archive = Archive.open([folder])
    files = PropFiles(archive, FigureFiles(archive, lambda _: None))
    return props(entries, files, metres, "x.toml", Ground(ground))


def points(prop: Prop) -> Any:
    """Positions in an order that no file decides."""
    found = np.concatenate([s.vertices["position"] for s in prop.surfaces])
    return np.unique(found.round(3) + 0.0, axis=0)


FILES = ["cube.glb", "cube.obj", "cube.ply", "cube.md3"]


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


def test_a_level_keeps_its_fog(folder: Path) -> None:
    fog = Fog(np.zeros(3), np.full(3, 64.0), np.full(3, 0.5), 0.01)
    (prop,) = place(folder, 'file = "cube.obj"\norigin = [0, 0, 0]')
    assert with_props(replace(FLOOR, fogs=(fog,)), (prop,)).fogs == (fog,)


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


def test_a_level_with_props_is_one_mesh_in_order(folder: Path) -> None:
    document = gltf_cube(CUBE, materials=[{"alphaMode": "BLEND"}])
    document.primitive["material"] = 0
    (folder / "glass.glb").write_bytes(document.glb())
    texts = [
        f'file = "{n}"\norigin = [0, {60 * k}, 0]' for k, n in enumerate([*FILES, "glass.glb"])
    ]
    placed = place(folder, *texts)
    level = with_props(FLOOR, placed)
    mesh = level.mesh
    require_whole(level)
    before, after = FLOOR.mesh.triangle_count, sum(p.triangle_count for p in placed)
    assert mesh.triangle_count == before + after
    number = level.visibility.level_face
    assert sorted(number[number >= 0].tolist()) == FLOOR.visibility.level_face.tolist()
    assert (number < 0).sum() == len(placed)
    # What was there is there still, and every prop's triangles are in one face's box.
    assert corner_set(FLOOR.mesh) <= corner_set(mesh)
    boxes = {tuple(face["mins"].round(2).tolist()) for face in mesh.faces[number < 0]}
    assert boxes == {tuple(p.bounds[0].round(2).tolist()) for p in placed}
    blended = [m.blend is not None for m in level.materials]
    assert blended == sorted(blended) and any(blended)
    assert with_props(FLOOR, ()) is FLOOR


def require_whole(level: Level) -> None:
    """All that holds of a mesh's table of faces."""
    mesh = level.mesh
    first, count = mesh.faces["first_index"], mesh.faces["index_count"]
    assert first.tolist() == (np.cumsum(count) - count).tolist() and count.sum() == len(
        mesh.indices
    )
    assert (np.diff(mesh.faces["material"]) >= 0).all()
    orders = [m.order for m in level.materials]
    assert orders == sorted(orders)
    runs = mesh.vertices["position"], mesh.indices, first
    is_rigid = np.array([m.deforms == RIGID for m in level.materials])[mesh.faces["material"]]
    for name, value in zip(("mins", "maxs"), face_boxes(*runs), strict=True):
        assert (mesh.faces[name] == value)[is_rigid].all()
    own = level.visibility.level_face < 0
    normal, _ = face_planes(*runs)
    assert (mesh.faces["normal"][own] == normal[own]).all()


def corner_set(mesh: Mesh) -> set[Any]:
    corners = mesh.vertices["position"][mesh.indices].reshape(-1, 9).round(3) + 0.0
    return {tuple(row) for row in corners.tolist()}


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


def three_rooms() -> Level:
    """Along x, in planes at 0 and 100: a solid end, then rooms of which neighbours see another."""
    planes, nodes, leafs = (
        np.zeros(n, LUMPS[k]) for n, k in ((3, "planes"), (3, "nodes"), (4, "leafs"))
    )
    planes["normal"], planes["distance"] = (1, 0, 0), (-100, 0, 100)
    nodes["plane"], nodes["children"] = (0, 1, 2), [(1, ~0), (2, ~1), (~3, ~2)]
    leafs["cluster"] = -1, 0, 1, 2
    sees = np.array([(1, 1, 0), (1, 1, 1), (0, 1, 1)], bool)
    bsp = replace(
        open_bsp(),
        planes=planes,
        nodes=nodes,
        leafs=leafs,
        cluster_count=3,
        cluster_visible=np.packbits(sees, axis=1, bitorder="little"),
    )
    empty = make_scene([]).level
    return replace(empty, bsp=bsp, visibility=replace(empty.visibility, bsp=bsp))


@pytest.mark.parametrize(
    ("x", "seen"),
    [
        (-50, (True, True, False)),
        (50, (True, True, True)),
        (150, (False, True, True)),
        (-10, (True, True, True)),  # in two rooms
        (-100, (True, True, False)),  # half in the solid end
        (-300, (True, True, True)),  # in it: visibility knows nothing of it
    ],
)
def test_props_are_seen_from_where_a_leaf_is_that_they_reach_into(
    folder: Path, x: float, seen: tuple[bool, ...]
) -> None:
    placed = place(folder, f'file = "cube.obj"\norigin = [{x}, 0, 0]')
    visibility = with_props(three_rooms(), placed).visibility
    eyes = np.array([(-50.0, 0, 0), (50, 0, 0), (150, 0, 0)])
    assert [visibility.faces_from(eye).tolist() for eye in eyes] == [[each] for each in seen]
    assert visibility.faces_from(np.array([-500.0, 0, 0])).tolist() == [True]


@pytest.mark.openarena
def test_no_prop_of_a_level_is_hidden_from_whom_sees_its_place(folder: Path) -> None:
    """Among many in a real level: seen whenever any point in it is in a leaf that is seen."""
    level = load("oa_dm5").level
    rng = np.random.default_rng(1)
    mins, maxs = level.mesh.bounds
    origins = rng.uniform(mins, maxs, (60, 3)).round(2).tolist()
    placed = place(folder, *(f'file = "cube.obj"\norigin = {o}' for o in origins))
    joined = with_props(level, placed)
    require_whole(joined)
    number = {tuple(f["mins"].tolist()): k for k, f in enumerate(joined.mesh.faces)}
    faces = [number[tuple(prop.bounds[0].tolist())] for prop in placed]
    inside = [
        bsp_tree.point_leafs(level.bsp, rng.uniform(low, high, (200, 3)))
        for low, high in (prop.bounds for prop in placed)
    ]
    hidden = 0
    for eye in rng.uniform(mins, maxs, (400, 3)):
        seen = joined.visibility.faces_from(eye)[faces]
        leafs = bsp_tree.visible_leafs(level.bsp, eye)
        assert (seen >= [leafs[each].any() for each in inside]).all()
        hidden += int((~seen).sum())
    assert hidden > 100


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
