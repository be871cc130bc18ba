from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from vgio import quake2

from followspot.assets import md2
from followspot.assets.md2 import NORMALS, Md2Model, animations_from_names, read_md2
from followspot.errors import AssetError
from model_fixtures import HAND_MD2, facing, md2_models, small_md2, write_md2

SMALL = write_md2(small_md2())
LOW, HIGH = -(2**31), 2**31 - 1
NAN, INFINITY = float("nan"), float("inf")


def load(**replaced: Any) -> Md2Model:
    """Read the small model with some lumps replaced."""
    return read_md2(write_md2(small_md2() | replaced), "small.md2")


def use_everything(model: Md2Model) -> None:
    """Check what code behind the reader relies on."""
    frames, vertices, axes = model.positions.shape
    assert frames == len(model.frame_names) >= 1
    assert axes == 3
    assert model.normals.shape == model.positions.shape
    assert model.texcoords.shape == (vertices, 2)
    assert len(model.indices) % 3 == 0
    assert model.indices.max() == vertices - 1
    assert np.array_equal(np.unique(model.indices), np.arange(vertices))  # no vertex is unused
    for array in (model.positions, model.normals, model.texcoords):
        assert array.dtype == np.float32
        assert np.isfinite(array).all()
        assert not array.flags.writeable
    assert model.indices.dtype == np.uint32
    assert not model.indices.flags.writeable
    np.testing.assert_allclose(np.linalg.norm(model.normals, axis=-1), 1, atol=1e-6)
    runs = [range(a.first, a.first + a.count) for a in model.animations.values()]
    assert [frame for run in runs for frame in run] == list(range(frames))


def test_normals_are_the_games() -> None:
    """Against another table of them; the set is that of an icosahedron: -n is in it for each n."""
    np.testing.assert_allclose(NORMALS, quake2.anorms, atol=1e-6)
    assert NORMALS.shape == (162, 3)
    distance = np.linalg.norm(NORMALS[:, np.newaxis] + NORMALS, axis=-1)
    np.testing.assert_allclose(distance.min(axis=0), 0, atol=1e-6)


def test_hand_written_model() -> None:
    model = read_md2(HAND_MD2, "hand.md2")
    assert model.source == "hand.md2"
    assert model.skins == ("a/b.pcx",)
    assert model.frame_names == ("salute01",)
    assert list(model.animations) == ["salute"]
    corners = model.indices
    assert model.positions[0, corners].tolist() == [[-1, 0, 8], [254, 0, 8], [0, 4, 13]]
    assert np.array_equal(model.normals[0, corners], NORMALS[[0, 5, 32]])
    texels = (model.texcoords[corners] * (4, 2)).tolist()
    assert texels == [[-0.5, 2.5], [3.5, 1.5], [0.5, 0.5]]
    use_everything(model)


def test_vertices_are_split_where_the_skin_has_a_seam() -> None:
    lumps, model = small_md2(), read_md2(SMALL, "small.md2")
    assert model.positions.shape == (3, 5, 3)  # vertex 2 has two texture coordinates
    vertex = lumps["triangles"]["vertices"].ravel()
    texcoord = lumps["triangles"]["texcoords"].ravel()
    frames = lumps["frames"]
    positions = frames["vertices"]["position"] * frames["scale"][:, np.newaxis]
    positions += frames["translate"][:, np.newaxis]
    assert np.array_equal(model.positions[:, model.indices], positions[:, vertex])
    normals = NORMALS[frames["vertices"]["normal"]]
    assert np.array_equal(model.normals[:, model.indices], normals[:, vertex])
    middles = (lumps["texcoords"] + 0.5) / (16, 8)
    assert np.array_equal(model.texcoords[model.indices], middles[texcoord].astype(np.float32))
    assert model.skins == ("players/bot/skin.pcx",)
    assert model.frame_names == ("run1", "run2", "stand01")
    assert [(a.first, a.count, a.looping) for a in model.animations.values()] == [
        (0, 2, 2),
        (2, 1, 1),
    ]
    use_everything(model)


def test_front_faces_stay_clockwise() -> None:
    """The square lies in a plane and its normals, number 5, point up."""
    model = read_md2(SMALL, "small.md2")
    assert model.normals[0, 0].tolist() == [0, 0, 1]
    assert (facing(model.positions[0], model.normals[0], model.indices) > 0).all()


@pytest.mark.parametrize(
    ("names", "runs"),
    [
        ("stand01 stand02 stand03 run1 run2", {"stand": (0, 3), "run": (3, 2)}),
        ("pain101 pain102 pain201 pain202", {"pain1": (0, 2), "pain2": (2, 2)}),
        ("taunt001 taunt002 run001", {"taunt": (0, 2), "run": (2, 1)}),
        ("walk98 walk99 walk100 walk101", {"walk": (0, 4)}),
        ("walk198 walk199 walk200", {"walk1": (0, 3)}),
        ("run1 run2 run4", {"run": (0, 3)}),
        ("run1 run2 run1 run2", {"run": (0, 2), "run_2": (2, 2)}),
        ("run1 jump1 run1", {"run": (0, 1), "jump": (1, 1), "run_2": (2, 1)}),
        ("Frame_01 frame_02", {"frame": (0, 2)}),
        ("base base", {"base": (0, 2)}),
        ("base base1", {"base": (0, 1), "base_2": (1, 1)}),
        ("1 2 3", {"frames": (0, 3)}),
        ("0 100", {"frames": (0, 1), "frames1": (1, 1)}),
        ("²", {"²": (0, 1)}),
    ],
)
def test_animations_by_the_frames_names(names: str, runs: dict[str, tuple[int, int]]) -> None:
    found = animations_from_names(tuple(names.split()))
    assert {name: (a.first, a.count) for name, a in found.items()} == runs


def test_deaths_are_held_and_all_else_repeats() -> None:
    found = animations_from_names(("death1", "death2", "crdeath1", "run1", "run2", ""))
    assert {name: a.looping for name, a in found.items()} == {
        "death": 0,
        "crdeath": 0,
        "run": 2,
        "frames": 1,
    }
    assert all(a.fps == 10 for a in found.values())


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "byte 0: expected the letters IDP2, found an empty file"),
        (b"IDPO" + SMALL[4:], "byte 0: expected the letters IDP2, found 'IDPO'"),
        (b"IDP2", "header: expected 1 x 68 bytes from offset 0 on, found a file of 4 bytes"),
        (write_md2(small_md2(), version=7), "byte 4: expected version 8, found 7"),
    ],
)
def test_other_files_are_told_apart(data: bytes, message: str) -> None:
    with pytest.raises(AssetError) as error:
        read_md2(data, "x.md2")
    assert message in str(error.value)


@pytest.mark.parametrize("data", [SMALL, HAND_MD2])
def test_every_truncation_is_an_asset_error(data: bytes) -> None:
    """At every byte, and so at every field."""
    for length in range(len(data)):
        with pytest.raises(AssetError):
            read_md2(data[:length], "cut.md2")


@pytest.mark.parametrize(
    ("field", "values", "place"),
    [
        ("skin_size", [(0, 8), (8, 0), (-1, 8), (LOW, 8)], "header, size of the skin"),
        ("frame_bytes", [0, -1, 55, 57, HIGH], "header, bytes of a frame"),
        ("skins_count", [-1, LOW, HIGH], "header, count of skins"),
        ("skins_count", [65536], "skins lump"),
        ("vertices_count", [0, -1, LOW, HIGH], "header, count of vertices"),
        ("vertices_count", [3, 5, 65536], "header, bytes of a frame"),
        ("texcoords_count", [0, -1, HIGH], "header, count of texcoords"),
        ("texcoords_count", [3], "triangles[1].texcoords"),
        ("texcoords_count", [65536], "texcoords lump"),
        ("triangles_count", [0, -1, HIGH], "header, count of triangles"),
        ("triangles_count", [65536], "triangles lump"),
        ("frames_count", [0, -1, HIGH], "header, count of frames"),
        ("frames_count", [5, 65536], "frames lump"),
        ("gl_commands_count", [-1, HIGH], "header, count of gl_commands"),
        ("gl_commands_count", [1, 12, 23, 25], "gl_commands lump"),
        ("skins_offset", [-1, LOW, HIGH, len(SMALL)], "skins lump"),
        ("texcoords_offset", [-1, LOW, HIGH, len(SMALL)], "texcoords lump"),
        ("triangles_offset", [-1, LOW, HIGH, len(SMALL)], "triangles lump"),
        ("frames_offset", [-1, LOW, HIGH, len(SMALL)], "frames lump"),
        ("gl_commands_offset", [-1, LOW, HIGH, len(SMALL)], "gl_commands lump"),
        ("end_offset", [-1, 0, 67, len(SMALL) + 1, HIGH], "header, offset of the end"),
    ],
)
def test_headers_that_lie(field: str, values: list[Any], place: str) -> None:
    for value in values:
        with pytest.raises(AssetError) as error:
            read_md2(write_md2(small_md2(), **{field: value}), "lie.md2")
        assert error.value.place == place
        assert error.value.expected


def _set(lump: str, index: Any, value: Any, *fields: str) -> Callable[[], dict[str, Any]]:
    def change() -> dict[str, Any]:
        array = small_md2()[lump].copy()
        view = array
        for field in fields:
            view = view[field]
        view[index] = value
        return {lump: array}

    return change


@pytest.mark.parametrize(
    ("change", "place"),
    [
        (_set("triangles", (1, 2), 4, "vertices"), "triangles[1].vertices"),
        (_set("triangles", (1, 0), 65535, "vertices"), "triangles[1].vertices"),
        (_set("triangles", (0, 1), 5, "texcoords"), "triangles[0].texcoords"),
        (_set("frames", (2, 1), NAN, "scale"), "frames[2].scale"),
        (_set("frames", (2, 1), 1e38, "scale"), "frames[2].scale"),
        (_set("frames", (1, 0), -INFINITY, "translate"), "frames[1].translate"),
        (_set("frames", (1, 0), 65537, "translate"), "frames[1].translate"),
        (_set("frames", (1, 3), 162, "vertices", "normal"), "frames[1].vertices"),
        (_set("frames", (0, 0), 255, "vertices", "normal"), "frames[0].vertices"),
        (_set("gl_commands", 3, 4), "gl_commands lump, vertex 0"),
        (_set("gl_commands", 3, -1), "gl_commands lump, vertex 0"),
        (_set("gl_commands", 22, 4), "gl_commands lump, vertex 6"),
        (_set("gl_commands", 23, 1), "gl_commands lump"),
        (_set("gl_commands", 0, HIGH), "gl_commands lump"),
        (_set("gl_commands", 0, LOW), "gl_commands lump"),
    ],
)
def test_numbers_out_of_range_are_told_with_their_place(
    change: Callable[[], dict[str, Any]], place: str
) -> None:
    with pytest.raises(AssetError) as error:
        load(**change())
    assert error.value.place == place


def test_a_small_file_cannot_ask_for_much_memory() -> None:
    """7000 frames of 3 vertices, each vertex with 333 texture coordinates: 7 million to pose."""
    triangles = np.zeros(333, md2.TRIANGLE)
    triangles["vertices"] = (0, 1, 2)
    triangles["texcoords"] = np.arange(333)[:, np.newaxis]
    frames = np.zeros(7000, md2.frame_dtype(3))
    texcoords = np.zeros((333, 2), "<i2")
    none = np.zeros(0, md2.GL_COMMAND)
    with pytest.raises(AssetError, match="at most 4194304 vertices in all frames together"):
        load(triangles=triangles, frames=frames, texcoords=texcoords, gl_commands=none)


def test_what_real_models_do_is_taken() -> None:
    assert load(gl_commands=np.zeros(0, md2.GL_COMMAND)).animations
    assert load(skins=np.zeros(0, md2.SKIN)).skins == ()


flips = st.tuples(st.integers(0, len(SMALL) - 1), st.integers(0, 255))


@settings(max_examples=500)
@given(st.lists(flips, min_size=1, max_size=8))
def test_any_bytes_load_or_are_an_asset_error(changes: list[tuple[int, int]]) -> None:
    data = bytearray(SMALL)
    for offset, value in changes:
        data[offset] = value
    try:
        model = read_md2(bytes(data), "flipped.md2")
    except AssetError as error:
        assert error.source == "flipped.md2"
    else:
        use_everything(model)


@pytest.mark.openarena
def test_real_models_face_outwards_clockwise_in_all_frames() -> None:
    for path in md2_models():
        model = read_md2(path.read_bytes(), path.name)
        use_everything(model)
        assert len(model.positions) == 198
        for positions, normals in zip(model.positions, model.normals, strict=True):
            assert (facing(positions, normals, model.indices) > 0).mean() > 0.95
        assert {"stand", "run", "attack", "jump"} <= set(model.animations)
