from typing import Any

import numpy as np
import pytest
from bsp_fixtures import (
    hand_written_level,
    openarena_levels,
    small_level,
    write_bsp,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot.assets.binary import run_members
from followspot.assets.bsp import HEADER, LUMPS, WORLD_LIMIT, BspFile, FaceType
from followspot.assets.bsp_reader import read_bsp
from followspot.errors import AssetError

ARRAYS = [name for name in LUMPS if name not in ("entities", "visibility")]
SMALL = write_bsp(small_level())


def lump_offset(data: bytes, name: str) -> int:
    header = np.frombuffer(data, HEADER, 1)[0]
    return int(header["directory"]["offset"][list(LUMPS).index(name)])


def load(**replaced: Any) -> BspFile:
    """Read the small level with some lumps replaced."""
    return read_bsp(write_bsp(small_level() | replaced), "small.bsp")


def use_every_reference(bsp: BspFile) -> None:
    """Index with every number that points somewhere, as code behind the reader does."""
    leafs, faces, brushes = bsp.leafs, bsp.faces, bsp.brushes
    for values, table in (
        (bsp.nodes["plane"], bsp.planes),
        (bsp.leaf_faces, faces),
        (bsp.leaf_brushes, brushes),
        (brushes["shader"], bsp.shader_names),
        (bsp.brush_sides["plane"], bsp.planes),
        (bsp.brush_sides["shader"], bsp.shader_names),
        (bsp.effects["brush"], brushes),
        (faces["shader"], bsp.shader_names),
        (run_members(leafs["first_leaf_face"], leafs["leaf_face_count"]), bsp.leaf_faces),
        (run_members(leafs["first_leaf_brush"], leafs["leaf_brush_count"]), bsp.leaf_brushes),
        (run_members(bsp.models["first_face"], bsp.models["face_count"]), faces),
        (run_members(bsp.models["first_brush"], bsp.models["brush_count"]), brushes),
        (run_members(brushes["first_side"], brushes["side_count"]), bsp.brush_sides),
        (run_members(faces["first_vertex"], faces["vertex_count"]), bsp.vertices),
    ):
        assert len(values) == 0 or (values.min() >= 0 and values.max() < len(table))
    first_vertex = np.repeat(faces["first_vertex"], faces["index_count"])
    corner = first_vertex + bsp.indices[run_members(faces["first_index"], faces["index_count"])]
    if len(corner):
        end = np.repeat(faces["first_vertex"] + faces["vertex_count"], faces["index_count"])
        assert (corner >= first_vertex).all()
        assert (corner < end).all()
    patches = faces[faces["type"] == FaceType.PATCH]
    assert (patches["patch_size"].prod(axis=1) == patches["vertex_count"]).all()
    assert faces["lightmap"].min(initial=0) >= -3
    for cluster in np.unique(leafs["cluster"]):
        assert bsp.visible_clusters(int(cluster)).shape == (bsp.cluster_count,)
    seen, walk = 0, np.array([0])
    while walk.size:
        seen += len(walk)
        assert seen <= len(bsp.nodes)
        children = bsp.nodes["children"][walk].ravel()
        assert (~children[children < 0] < len(leafs)).all()
        walk = children[children >= 0]


def test_hand_written_level() -> None:
    data = hand_written_level()
    bsp = read_bsp(data, "hand.bsp")
    assert bsp.source == "hand.bsp"
    assert bsp.entities == ({"a": "b"},)
    assert bsp.shaders.tolist() == [(b"A/B\\C\0xxxx", 0x84, 0x80000001)]
    assert bsp.shader_names == ("a/b/c",)

    def values(record: np.void) -> list[Any]:
        return [np.asarray(record[field]).tolist() for field in record.dtype.names or ()]

    assert values(bsp.planes[0]) == [[0, 0, 1], 8]
    assert values(bsp.nodes[0]) == [0, [-2, -1], [-1, -2, -3], [4, 5, 6]]
    assert values(bsp.leafs[0]) == [0, 7, [1, 2, 3], [4, 5, 6], 0, 1, 1, 0]
    assert values(bsp.leafs[1]) == [-1, -1, [0, 0, 0], [0, 0, 0], 1, 0, 0, 1]
    assert bsp.leaf_faces.tolist() == [0]
    assert bsp.leaf_brushes.tolist() == [0]
    assert values(bsp.models[0]) == [[-1, -2, -3], [1, 2, 3], 0, 1, 1, 0]
    assert values(bsp.brushes[0]) == [0, 1, 0]
    assert values(bsp.brush_sides[0]) == [0, 0]
    vertex = [[1, 2, 3], [4, 5], [6, 7], [0, -1, 0], [10, 20, 30, 255]]
    assert values(bsp.vertices[1]) == vertex
    assert bsp.indices.tolist() == [5, 4, 0, 0, 0]
    assert values(bsp.effects[0]) == [b"fog", 0, -1]
    face = bsp.faces[0]
    assert {field: np.asarray(face[field]).tolist() for field in LUMPS["faces"].names or ()} == {
        "shader": 0,
        "effect": -1,
        "type": FaceType.MESH,
        "first_vertex": 1,
        "vertex_count": 1,
        "first_index": 2,
        "index_count": 3,
        "lightmap": 0,
        "lightmap_corner": [8, 9],
        "lightmap_size": [10, 11],
        "lightmap_origin": [1, 2, 3],
        "lightmap_axes": [[4, 5, 6], [7, 8, 9]],
        "normal": [0, 1, 0],
        "patch_size": [12, 13],
    }
    assert bsp.lightmaps.shape == (1, 128, 128, 3)
    assert bsp.lightmaps[0, 0, 0].tolist() == [0xFF, 0x80, 0x40]
    assert bsp.lightmaps[0, 127, 127].tolist() == [10, 11, 12]
    assert values(bsp.light_grid[0]) == [[1, 2, 3], [4, 5, 6], [7, 8]]
    assert bsp.cluster_count == 1
    assert bsp.cluster_visible.tolist() == [[1]]


def test_small_level_comes_back_as_it_was_built() -> None:
    lumps, bsp = small_level(), read_bsp(SMALL, "small.bsp")
    for name in ARRAYS:
        array = getattr(bsp, name)
        assert array.dtype == LUMPS[name].base
        assert array.tobytes() == lumps[name].tobytes()
        assert not array.flags.writeable
        assert np.shares_memory(array, np.frombuffer(SMALL, "u1"))
    assert bsp.entities[0]["message"] == "Two rooms"
    assert bsp.shader_names == ("textures/base/wall", "textures/base/arch", "flareshader")
    use_every_reference(bsp)


def test_visible_clusters() -> None:
    bsp = load()
    assert bsp.visible_clusters(0).tolist() == [True, True]
    assert bsp.visible_clusters(1).tolist() == [False, True]
    assert bsp.visible_clusters(-1).tolist() == [True, True]
    assert not bsp.cluster_visible.flags.writeable


def test_without_visibility_every_cluster_sees_all() -> None:
    bsp = load(visibility=np.zeros(0, "u1"))
    assert bsp.cluster_count == 2
    for cluster in (-1, 0, 1):
        assert bsp.visible_clusters(cluster).tolist() == [True, True]
    with pytest.raises(AssetError, match="for each cluster in 7 bytes"):
        load(visibility=np.zeros(7, "u1"))
    leafs = small_level()["leafs"]
    leafs["cluster"][3] = len(leafs)  # more clusters than leafs could have
    with pytest.raises(AssetError, match=r"leafs\[3\].cluster"):
        load(leafs=leafs, visibility=np.zeros(0, "u1"))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "byte 0: expected the letters IBSP, found an empty file"),
        (b"\x89PNG" + SMALL[4:], "byte 0: expected the letters IBSP, found '\\x89PNG'"),
        (b"IBSP", "header: expected 1 x 144 bytes from offset 0 on, found a file of 4 b"),
        (
            write_bsp(small_level(), version=47),
            "byte 4: expected version 46 (Quake III Arena), "
            "found version 47 (Return to Castle Wolfenstein or Quake Live)",
        ),
        (write_bsp(small_level(), version=38), "found version 38"),
    ],
)
def test_other_files_are_told_apart(data: bytes, message: str) -> None:
    with pytest.raises(AssetError) as error:
        read_bsp(data, "x.bsp")
    assert message in str(error.value)


def test_every_truncation_is_an_asset_error() -> None:
    """At every byte, and so at every field; inside of the lightmaps' texels at the ends only."""
    texels = range(lump_offset(SMALL, "lightmaps") + 8, lump_offset(SMALL, "light_grid") - 8)
    for length in (*range(texels.start), *range(texels.stop, len(SMALL))):
        with pytest.raises(AssetError):
            read_bsp(SMALL[:length], "cut.bsp")


@pytest.mark.parametrize("name", LUMPS)
@pytest.mark.parametrize("field", ["offset", "length"])
@pytest.mark.parametrize("value", [-1, -(2**31), 1, 2**31 - 1, len(SMALL)])
def test_directory_entries_that_lie(name: str, field: str, value: int) -> None:
    header = np.frombuffer(SMALL, HEADER, 1).copy()
    header["directory"][field][0, list(LUMPS).index(name)] = value
    try:
        use_every_reference(read_bsp(header.tobytes() + SMALL[HEADER.itemsize :], "lie.bsp"))
    except AssetError as error:
        assert error.place
    else:
        assert 0 < value <= len(SMALL)


@pytest.mark.parametrize("name", LUMPS)
def test_lumps_of_broken_records_or_none(name: str) -> None:
    lump = small_level()[name]
    if lump.itemsize > 1:
        cut = np.frombuffer(lump.tobytes()[:-1], "u1")
        with pytest.raises(AssetError, match=f"{name} lump: expected a length in whole records"):
            load(**{name: cut})
    if name in ("entities", "lightmaps", "light_grid", "visibility"):
        # Lightmaps may lie in image files, while faces go on to name them by number.
        assert isinstance(load(**{name: lump[:0]}), BspFile)
    elif name == "effects":
        load(effects=lump[:0])  # faces may name effect 0 where there are none
    else:
        with pytest.raises(AssetError):
            load(**{name: lump[:0]})


NAN, INFINITY = float("nan"), float("inf")
LOW, HIGH = -(2**31), 2**31 - 1


@pytest.mark.parametrize(
    ("lump", "index", "field", "values", "place"),
    [
        ("planes", 2, "normal", [(NAN, 0, 0), (0, INFINITY, 0)], "planes[2].normal"),
        ("planes", 6, "distance", [NAN, -INFINITY], "planes[6].distance"),
        ("nodes", 1, "plane", [-1, 7, LOW, HIGH], "nodes[1].plane"),
        ("nodes", 6, "children", [(7, -1), (-1, -5), (LOW, -1), (HIGH, -1)], "nodes[6].children"),
        ("nodes", 6, "children", [(-1, 0)], "nodes[0]"),  # back to the root
        ("nodes", 5, "children", [(6, 6)], "nodes[6]"),  # twice the same
        ("nodes", 4, "children", [(-1, 4)], "nodes[4]"),  # itself
        ("nodes", 6, "children", [(-1, 3)], "nodes[3]"),  # a loop behind the root
        ("leafs", 2, "cluster", [-2, 2, LOW, HIGH], "leafs[2].cluster"),
        ("leafs", 2, "area", [-2, LOW], "leafs[2].area"),
        ("leafs", 2, "first_leaf_face", [-1, 2, LOW, HIGH], "leafs[2].faces"),
        ("leafs", 2, "leaf_face_count", [-1, 5, LOW, HIGH], "leafs[2].faces"),
        ("leafs", 1, "first_leaf_brush", [-1, 2, LOW, HIGH], "leafs[1].brushes"),
        ("leafs", 1, "leaf_brush_count", [-1, 3, LOW, HIGH], "leafs[1].brushes"),
        ("leaf_faces", 3, None, [-1, 5, LOW, HIGH], "leaf_faces[3]"),
        ("leaf_brushes", 1, None, [-1, 2, LOW, HIGH], "leaf_brushes[1]"),
        ("models", 0, "mins", [(NAN, 0, 0), (0, 0, -1e6)], "models[0].mins"),
        ("models", 1, "maxs", [(0, INFINITY, 0), (0, 0, 1e6)], "models[1].maxs"),
        ("models", 1, "first_face", [-1, 5, LOW, HIGH], "models[1].faces"),
        ("models", 1, "face_count", [-1, 2, LOW, HIGH], "models[1].faces"),
        ("models", 1, "first_brush", [-1, 2, LOW, HIGH], "models[1].brushes"),
        ("models", 1, "brush_count", [-1, 2, LOW, HIGH], "models[1].brushes"),
        ("brushes", 1, "first_side", [-1, 7, LOW, HIGH], "brushes[1].sides"),
        ("brushes", 1, "side_count", [-1, 7, LOW, HIGH], "brushes[1].sides"),
        ("brushes", 1, "shader", [-1, 3, LOW, HIGH], "brushes[1].shader"),
        ("brush_sides", 11, "plane", [-1, 7, LOW, HIGH], "brush_sides[11].plane"),
        ("brush_sides", 11, "shader", [-1, 3, LOW, HIGH], "brush_sides[11].shader"),
        ("vertices", 5, "position", [(0, 0, NAN), (0, 1e6, 0)], "vertices[5].position"),
        ("vertices", 5, "texcoord", [(0, NAN), (INFINITY, 0)], "vertices[5].texcoord"),
        ("vertices", 5, "normal", [(0, 0, NAN), (-INFINITY, 0, 0)], "vertices[5].normal"),
        ("indices", 7, None, [-1, 3, LOW, HIGH], "faces[2], lowest and highest index"),
        ("effects", 0, "brush", [-1, 2, LOW, HIGH], "effects[0].brush"),
        ("effects", 0, "visible_side", [-2, 6, LOW, HIGH], "effects[0].visible_side"),
        ("faces", 3, "shader", [-1, 3, LOW, HIGH], "faces[3].shader"),
        ("faces", 3, "effect", [-2, 1, LOW, HIGH], "faces[3].effect"),
        ("faces", 3, "type", [0, 5, LOW, HIGH], "faces[3].type"),
        ("faces", 4, "first_vertex", [-1, 16, LOW, HIGH], "faces[4].vertices"),
        ("faces", 4, "vertex_count", [-1, 20, LOW, HIGH], "faces[4].vertices"),
        ("faces", 4, "vertex_count", [3], "faces[4], lowest and highest index"),
        ("faces", 4, "first_index", [-1, 4, LOW, HIGH], "faces[4].indices"),
        ("faces", 4, "index_count", [-3, 12, LOW, HIGH], "faces[4].indices"),
        ("faces", 4, "index_count", [5], "faces[4].index_count"),
        ("faces", 3, "lightmap", [-4, LOW], "faces[3].lightmap"),
        ("faces", 1, "patch_size", [(3, 5), (9, 1), (-3, -3), (HIGH, HIGH)], "faces[1], patch"),
        ("faces", 1, "vertex_count", [8], "faces[1], patch"),
        ("visibility", 0, None, [3, 255], "visibility lump"),
        ("visibility", 4, None, [0, 7, 9], "visibility lump"),
        ("visibility", 3, None, [128], "visibility lump"),  # a negative count of clusters
    ],
)
def test_numbers_out_of_range_are_told_with_their_place(
    lump: str, index: int, field: str | None, values: list[Any], place: str
) -> None:
    for value in values:
        array = small_level()[lump].copy()
        (array if field is None else array[field])[index] = value
        with pytest.raises(AssetError) as error:
            load(**{lump: array})
        assert error.value.place.startswith(place)
        assert error.value.expected


def test_signalling_nan_is_an_asset_error_like_any_other() -> None:
    vertices = small_level()["vertices"]
    vertices["position"].view("<u4")[4, 1] = 0x7F800001
    with pytest.raises(AssetError, match=r"vertices\[4\].position"):
        load(vertices=vertices)


def test_what_real_levels_do_is_taken() -> None:
    vertices = small_level()["vertices"]
    vertices["position"][0] = WORLD_LIMIT
    vertices["lightmap_texcoord"][0] = (NAN, INFINITY)
    vertices["normal"][1] = 0
    load(vertices=vertices)
    nodes = small_level()["nodes"]  # children before their parents
    nodes[[1, 6]] = nodes[[6, 1]]
    nodes["children"] = [[-2, 6], [-3, -4], [-2, 3], [-2, 4], [-2, 5], [-2, 1], [-2, 2]]
    load(nodes=nodes)


TEXELS = range(lump_offset(SMALL, "lightmaps"), lump_offset(SMALL, "light_grid"))
flips = st.tuples(
    st.integers(0, len(SMALL) - len(TEXELS) - 1).map(
        lambda i: i if i < TEXELS.start else i + len(TEXELS)
    ),
    st.integers(0, 255),
)


@settings(max_examples=500)
@given(st.lists(flips, min_size=1, max_size=8))
def test_any_bytes_load_or_are_an_asset_error(changes: list[tuple[int, int]]) -> None:
    data = bytearray(SMALL)
    for offset, value in changes:
        data[offset] = value
    try:
        bsp = read_bsp(bytes(data), "flipped.bsp")
    except AssetError as error:
        assert error.source == "flipped.bsp"
    else:
        use_every_reference(bsp)


@pytest.mark.openarena
def test_all_levels_of_openarena_load() -> None:
    count = 0
    for source, data in openarena_levels():
        bsp = read_bsp(data, source)
        count += 1
        assert bsp.entities[0]["classname"] == "worldspawn"
        assert all(name.isascii() and name.isprintable() for name in bsp.shader_names)
        cell = np.array(bsp.entities[0].get("gridsize", "64 64 128").split(), float)
        world = bsp.models[0]
        grid = np.floor(world["maxs"] / cell) - np.ceil(world["mins"] / cell) + 1
        assert len(bsp.light_grid) in (0, grid.prod())
        use_every_reference(bsp)
    assert count >= 85
