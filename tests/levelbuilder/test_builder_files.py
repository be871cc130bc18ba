"""Whole levels: what our reader, another project's reader and plain geometry say of the files."""

import io
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import bsp_tool
import numpy as np
import pytest
from bsp_tool.branches.id_software import quake3

import followspot.levelbuilder
from followspot.assets.bsp import LUMPS, BspFile, FaceType
from followspot.assets.bsp_reader import read_bsp
from followspot.errors import UsageError
from followspot.levelbuilder import (
    CAULK,
    CLIP,
    Level,
    Material,
    Surface,
    box,
    compile_level,
    hull,
    lathe,
    pk3_bytes,
    quads,
    room,
)
from followspot.levelbuilder.pk3 import image_file

STONE = Material("textures/test/stone", (64, 64), 1.0)
LEAF = Material("textures/test/leaf", surface=Surface.NONSOLID | Surface.NOLIGHTMAP, opacity=0.5)
SKY = Material(
    "textures/test/sky",
    surface=Surface.SKY | Surface.NOLIGHTMAP,
    script="q3map_sun 1 1 1 100 40 50\nq3map_skyLight 40 3",
)
RAMP = [(-200, y, z) for y in (-64, 64) for z in (0, 48)] + [(-64, y, 0) for y in (-64, 64)]


def make_level() -> Level:
    """A room under the sky with everything in it that a level can have."""
    level = Level("test")
    level.add(room((-256, -256, 0), (256, 256, 192), STONE, faces={"+z": SKY}))
    level.add(box((32, -64, 0), (64, 256, 192), STONE), hull(RAMP, STONE))
    level.add(box((100, 100, 0), (132, 132, 32), STONE, detail=True))
    level.add(box((90, 90, 0), (142, 142, 40), CLIP))
    level.add(lathe(STONE, (160, -160, 0), np.array([(16.0, 0.0), (20.0, 40.0), (16.0, 80.0)])))
    corners = np.array([[[0, -80, 90], [0, -140, 90], [0, -140, 40], [0, -80, 40]]], dtype=float)
    level.add(quads(LEAF, corners))
    level.entity("func_static", box((-40, 180, 0), (-8, 212, 64), STONE))
    level.spawn(0, 0, 0, 90)
    level.light((120, 0, 100))
    return level


@pytest.fixture(scope="module")
def data() -> bytes:
    return compile_level(make_level())


@pytest.fixture(scope="module")
def bsp(data: bytes) -> BspFile:
    return read_bsp(data, "test.bsp")


def leaf_at(bsp: BspFile, point: np.ndarray) -> int:
    node = 0
    while node >= 0:
        plane = bsp.planes[bsp.nodes["plane"][node]]
        node = bsp.nodes["children"][node][int(plane["normal"] @ point < plane["distance"])]
    return -1 - int(node)


def test_the_same_level_gives_the_same_bytes(data: bytes) -> None:
    assert compile_level(make_level()) == data


def test_bsp_tool_agrees_on_every_lump(data: bytes, bsp: BspFile) -> None:
    other = bsp_tool.IdTechBsp.from_bytes(quake3, "test.bsp", data)
    assert other.branch.FILE_MAGIC == b"IBSP"
    assert not other.loading_errors
    for theirs, ours in {
        "TEXTURES": bsp.shaders,
        "PLANES": bsp.planes,
        "NODES": bsp.nodes,
        "LEAVES": bsp.leafs,
        "LEAF_FACES": bsp.leaf_faces,
        "LEAF_BRUSHES": bsp.leaf_brushes,
        "MODELS": bsp.models,
        "BRUSHES": bsp.brushes,
        "BRUSH_SIDES": bsp.brush_sides,
        "VERTICES": bsp.vertices,
        "INDICES": bsp.indices,
        "FACES": bsp.faces,
    }.items():
        assert len(getattr(other, theirs)) == len(ours) > 0, theirs
    assert [dict(e) for e in other.ENTITIES] == [dict(e) for e in bsp.entities]
    vertices = [(v.position.x, v.position.y, v.position.z) for v in other.VERTICES]
    np.testing.assert_array_equal(np.array(vertices, np.float32), bsp.vertices["position"])
    np.testing.assert_array_equal(list(other.INDICES), bsp.indices)
    assert b"".join(page.as_bytes() for page in other.LIGHTMAPS) == bsp.lightmaps.tobytes()
    assert [row.tobytes() for row in bsp.cluster_visible] == list(other.VISIBILITY)


def test_triangles_are_clockwise_and_flat_on_their_normal(bsp: BspFile) -> None:
    for face in bsp.faces[bsp.faces["type"] == FaceType.POLYGON]:
        first, count = face["first_index"], face["index_count"]
        corner = bsp.indices[first : first + count].reshape(-1, 3) + face["first_vertex"]
        a, b, c = bsp.vertices["position"][corner].transpose(1, 0, 2).astype(float)
        doubled = np.cross(c - a, b - a)
        np.testing.assert_allclose(
            doubled / np.linalg.norm(doubled, axis=1, keepdims=True),
            np.tile(face["normal"], (len(doubled), 1)),
            atol=1e-4,
        )


def test_the_tree_tells_solid_from_air(bsp: BspFile) -> None:
    points = np.random.default_rng(1).uniform((-270, -270, -14), (270, 270, 206), (600, 3))
    inside = (np.abs(points[:, :2]) < 256).all(axis=1) & (points[:, 2] > 0) & (points[:, 2] < 192)
    wall = (points[:, 0] > 32) & (points[:, 0] < 64) & (points[:, 1] > -64)
    slope = 48 * (-64 - points[:, 0]) / 136
    ramp = (np.abs(points[:, 1]) < 64) & (points[:, 0] > -200) & (points[:, 2] < slope)
    solid = ~inside | wall | ramp
    for point, expected in zip(points, solid, strict=True):
        leaf = bsp.leafs[leaf_at(bsp, point)]
        assert (leaf["cluster"] < 0) == expected, point
        assert (leaf["mins"] <= point).all() and (point <= leaf["maxs"]).all()


def test_a_leaf_lists_the_faces_and_brushes_within_it(bsp: BspFile) -> None:
    for index in range(bsp.models["face_count"][0]):
        face = bsp.faces[index]
        first, count = face["first_vertex"], face["vertex_count"]
        points = bsp.vertices["position"][first : first + count]
        probe = points.mean(axis=0) + 0.1 * face["normal"]
        if face["type"] == FaceType.PATCH:
            continue
        leaf = bsp.leafs[leaf_at(bsp, probe)]
        run = slice(leaf["first_leaf_face"], leaf["first_leaf_face"] + leaf["leaf_face_count"])
        assert index in bsp.leaf_faces[run]
    for index in range(bsp.models["brush_count"][0]):
        first, count = bsp.brushes["first_side"][index], bsp.brushes["side_count"][index]
        dists = bsp.planes["distance"][bsp.brush_sides["plane"][first : first + 6]]
        centre = (dists[1::2] - dists[0::2]) / 2 - 1e-3
        leaf = bsp.leafs[leaf_at(bsp, centre)]
        run = slice(leaf["first_leaf_brush"], leaf["first_leaf_brush"] + leaf["leaf_brush_count"])
        assert index in bsp.leaf_brushes[run]


def test_a_brush_begins_with_the_six_planes_of_its_box(bsp: BspFile) -> None:
    axial = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]])
    for brush in bsp.brushes:
        sides = bsp.brush_sides[brush["first_side"] : brush["first_side"] + 6]
        np.testing.assert_array_equal(bsp.planes["normal"][sides["plane"]], axial)


def test_nothing_is_drawn_in_the_void_or_under_a_crate(bsp: BspFile) -> None:
    world = bsp.faces[: bsp.models["face_count"][0]]
    first, count = world["first_vertex"], world["vertex_count"]
    for a, n in zip(first, count, strict=True):
        points = bsp.vertices["position"][a : a + n]
        assert (np.abs(points[:, :2]) <= 256).all()
        low, high = points.min(axis=0), points.max(axis=0)
        under = (low[:2] >= 100).all() and (high[:2] <= 132).all() and high[2] == 0
        assert not under


def test_lightmap_coordinates_stay_in_their_faces_rectangle(bsp: BspFile) -> None:
    lit = bsp.faces[bsp.faces["lightmap"] >= 0]
    assert len(lit) > 20
    taken = np.zeros((len(bsp.lightmaps), 128, 128), int)
    for face in lit:
        first, count = face["first_vertex"], face["vertex_count"]
        luxels = bsp.vertices["lightmap_texcoord"][first : first + count] * 128
        low, size = face["lightmap_corner"], face["lightmap_size"]
        assert (luxels >= low + 0.49).all() and (luxels <= low + size - 0.49).all()
        (x, y), (w, h) = low, size
        taken[face["lightmap"], y : y + h, x : x + w] += 1
    assert taken.max() == 1


def test_the_light_grid_has_the_cells_that_the_game_counts(bsp: BspFile) -> None:
    size = np.array([64, 64, 128])
    low = np.ceil(bsp.models["mins"][0] / size)
    high = np.floor(bsp.models["maxs"][0] / size)
    assert len(bsp.light_grid) == (high - low + 1).prod()


def test_a_leak_is_told_with_its_place() -> None:
    level = Level()
    level.add(room((-64, -64, 0), (64, 64, 64), STONE)[:-1])
    level.spawn(0, 0, 0)
    with pytest.raises(UsageError, match="leaks into the void near"):
        compile_level(level)


def test_a_level_without_walls_or_without_anything_to_see_is_refused() -> None:
    with pytest.raises(UsageError, match="at least one structural brush"):
        compile_level(Level())
    level = Level()
    level.add(room((-64, -64, 0), (64, 64, 64), CAULK))
    level.spawn(0, 0, 0)
    with pytest.raises(UsageError, match="can be seen"):
        compile_level(level)


def test_an_archive_is_the_same_bytes_in_any_order() -> None:
    files = {"b.txt": b"2", "a.txt": b"1" * 1000}
    packed = pk3_bytes(files)
    assert packed == pk3_bytes(dict(reversed(files.items())))
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        assert archive.namelist() == ["a.txt", "b.txt"]
        assert archive.read("b.txt") == b"2"


def test_only_an_image_with_alpha_becomes_a_png() -> None:
    assert image_file(np.zeros((4, 4, 3), np.uint8))[0] == ".jpg"
    assert image_file(np.zeros((4, 4, 4), np.uint8))[0] == ".png"


def sky_of(script: str) -> Level:
    """A room with one more wall under a sky of a script."""
    sky = Material("textures/test/odd", surface=Surface.SKY | Surface.NOLIGHTMAP, script=script)
    level = Level()
    level.add(room((-64, -64, 0), (64, 64, 64), STONE, faces={"+z": sky}))
    level.spawn(0, 0, 0)
    return level


def with_entity(**keys: str) -> Level:
    level = sky_of("")
    level.entity("light", **keys)
    return level


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: sky_of("q3map_sun 1 1 1 100 0"), "red, green, blue"),
        (lambda: sky_of("q3map_sun a 1 1 100 0 40"), "red, green, blue"),
        (lambda: sky_of("q3map_sun 0 0 0 100 0 40"), "red, green, blue"),
        (lambda: sky_of("q3map_skyLight x 3"), "no number: 'q3map_skylight x 3'"),
        (lambda: sky_of("{\nmap a.tga"), "at the end of textures/test/odd"),
        (lambda: with_entity(origin="1 2"), "origin needs finite numbers, 3 in all, not '1 2'"),
        (lambda: with_entity(origin="1 2 nan"), "origin needs"),
        (lambda: with_entity(origin="1 2 3", light="bright"), "light needs finite numbers, 1"),
        (lambda: with_entity(origin="1 2 3", _color="red"), "_color needs"),
        (lambda: with_entity(message="5 \u20ac"), "Latin-1"),
        (lambda: with_entity(message="\0"), "Latin-1"),
        (lambda: hull([(0, 0, 0), (1, 1, 1)], STONE), "four points, not 2"),
        (lambda: hull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], STONE), "encloses nothing"),
        (lambda: hull([(k, k, k) for k in range(5)], STONE), "encloses nothing"),
        (lambda: Material("textures/" + "a" * 55), "at most 63"),
        (lambda: Material("textures/caf\u00e9"), "ASCII"),
        (lambda: box((0, 0, 0), (1, 1, 1), STONE, faces={"up": STONE}), "not 'up'"),
        (lambda: room((0, 0, 0), (9, 9, 9), STONE, faces={"z": STONE}), "not 'z'"),
    ],
)
def test_mistakes_are_told(make: Callable[[], object], told: str) -> None:
    with pytest.raises(UsageError, match=told):
        made = make()
        if isinstance(made, Level):
            compile_level(made)


def test_the_longest_name_of_a_material_is_written_whole() -> None:
    name = "textures/" + "a" * 54
    level = Level()
    level.add(room((-64, -64, 0), (64, 64, 64), Material(name, (64, 64), 1.0)))
    level.spawn(0, 0, 0)
    assert read_bsp(compile_level(level), "x.bsp").shader_names == (name,)


def test_an_entitys_text_cannot_break_out_of_its_quotes() -> None:
    with pytest.raises(UsageError, match="quotes"):
        Level().entity("light", origin='0 0 0"')


def test_the_example_of_the_documentation_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = followspot.levelbuilder.__doc__ or ""
    (example,) = re.findall(r"\n\n((?:    .*\n|\n)+)", text)
    monkeypatch.chdir(tmp_path)
    exec("\n".join(line[4:] for line in example.splitlines()), {})
    with zipfile.ZipFile("demo.pk3") as archive:
        names = set(archive.namelist())
        demo = read_bsp(archive.read("maps/demo.bsp"), "demo.bsp")
    assert names == {"maps/demo.bsp", "scripts/demo.shader", "textures/demo/stone.jpg"}
    assert set(LUMPS) >= {"faces"} and len(demo.faces) > 10
