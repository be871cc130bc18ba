from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from followspot.assets import md3
from followspot.assets.animation import Pose
from followspot.assets.md3 import Md3Model, between, orthonormalised, read_md3
from followspot.errors import AssetError
from model_fixtures import HAND_MD3, facing, openarena_files, small_md3, write_md3

SMALL = write_md3(small_md3())
LOW, HIGH = -(2**31), 2**31 - 1
NAN, INFINITY = float("nan"), float("inf")


def use_everything(model: Md3Model) -> None:
    """Check what code behind the reader relies on."""
    frames = len(model.frames)
    assert frames >= 1
    for surface in model.surfaces:
        vertices = len(surface.texcoords)
        assert surface.positions.shape == surface.normals.shape == (frames, vertices, 3)
        assert surface.texcoords.shape == (vertices, 2)
        assert len(surface.indices) % 3 == 0
        assert surface.indices.max(initial=0) < max(vertices, 1)
        assert surface.indices.dtype == np.uint32
        for array in (surface.positions, surface.normals, surface.texcoords):
            assert array.dtype == np.float32
            assert np.isfinite(array).all()
            assert not array.flags.writeable
        np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=-1), 1, atol=1e-6)
    for keys in model.tags.values():
        assert keys.shape == (frames, 4, 4)
        assert not keys.flags.writeable
        require_rigid(keys)


def require_rigid(matrices: NDArray[Any]) -> None:
    """Rotation and shift alone: columns at right angles, of unit length, right-handed."""
    rotations = matrices[..., :3, :3]
    eye = np.broadcast_to(np.eye(3), rotations.shape)
    np.testing.assert_allclose(rotations.swapaxes(-1, -2) @ rotations, eye, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(rotations), 1, atol=1e-12)
    assert np.isfinite(matrices).all()
    assert (matrices[..., 3, :] == [0, 0, 0, 1]).all()


def poses(*rows: tuple[int, int, float]) -> Pose:
    frame, next_frame, blend = zip(*rows, strict=True)
    return Pose(np.array(frame), np.array(next_frame), np.array(blend))


def test_hand_written_model() -> None:
    model = read_md3(HAND_MD3, "hand.md3")
    assert model.source == "hand.md3"
    frame = model.frames[0]
    assert [frame[name].tolist() for name in ("mins", "maxs", "origin", "radius")] == [
        [-1, 0, 0],
        [1, 2, 3],
        [0, 0.5, 0],
        4,
    ]
    assert frame["name"].startswith(b"base\0")
    assert list(model.tags) == ["tag_head"]
    expected = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]]
    assert model.tags["tag_head"][0].tolist() == expected
    (surface,) = model.surfaces
    assert surface.name == "u_torso"
    assert surface.shaders == ("m/a.tga",)
    assert surface.indices.tolist() == [2, 1, 0]
    assert surface.texcoords.tolist() == [[0, 0], [1, 0], [0.5, 1]]
    positions = [[1, 2, -1], [0, 0, 0], [32767 / 64, -512, 1 / 64]]
    assert surface.positions.tolist() == [positions]
    np.testing.assert_allclose(surface.normals[0], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], atol=1e-7)
    use_everything(model)


def test_small_model_comes_back_as_it_was_built() -> None:
    built, model = small_md3(), read_md3(SMALL, "small.md3")
    assert model.frames.tobytes() == built["frames"].tobytes()
    assert [surface.name for surface in model.surfaces] == ["l_legs", "belt"]
    for surface, lumps in zip(model.surfaces, built["surfaces"], strict=True):
        assert surface.shaders == ("models/bot.tga",)
        assert np.array_equal(surface.positions, lumps["vertices"]["position"] / 64)
        assert np.array_equal(surface.texcoords, lumps["texcoords"])
        assert surface.indices.tolist() == [0, 1, 2]
    assert list(model.tags) == ["tag_torso", "tag_flash"]
    use_everything(model)


def test_tags_are_rotation_and_shift() -> None:
    """The stretched axes of the second frame keep their directions alone."""
    keys = read_md3(SMALL, "small.md3").tags["tag_torso"]
    assert keys[0].tolist() == [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 8], [0, 0, 0, 1]]
    quarter = [[0, -1, 0, 0], [1, 0, 0, 2], [0, 0, 1, 8], [0, 0, 0, 1]]
    assert keys[1].tolist() == quarter


def test_of_tags_with_one_name_the_first_counts() -> None:
    model = small_md3()
    model["tags"]["name"] = b"tag_x"
    assert read_md3(write_md3(model), "x").tags["tag_x"][0, 2, 3] == 8


@pytest.mark.parametrize(
    ("written", "name"),
    [
        (b"h_head", "h_head"),
        (b"H_Head_2", "h_head"),
        (b"belt_10", "belt_10"),
        (b"_1", "_1"),
        (b"a_1\0_2", "a"),
        (b"", ""),
    ],
)
def test_surface_names_lose_a_suffix(written: bytes, name: str) -> None:
    model = small_md3()
    model["surfaces"][0]["name"] = np.array(written)
    assert read_md3(write_md3(model), "x").surfaces[0].name == name


def test_tags_between_key_frames() -> None:
    keys = read_md3(SMALL, "small.md3").tags["tag_torso"]
    pose = poses((0, 1, 0.0), (0, 1, 0.5), (0, 1, 1.0), (1, 0, 0.25), (1, 1, 0.7))
    found = between(keys, pose)
    require_rigid(found)
    assert np.array_equal(found[[0, 2]], keys[[0, 1]])  # keys exactly
    np.testing.assert_allclose(found[4], keys[1], atol=1e-15)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(found[1, :3, 0], [half, half, 0], atol=1e-15)
    assert found[:, :3, 3].tolist() == [[0, 0, 8], [0, 1, 8], [0, 2, 8], [0, 1.5, 8], [0, 2, 8]]
    single = between(keys, Pose(*(np.asarray(part[1]) for part in pose)))
    assert np.array_equal(single, found[1])


def test_tags_that_turn_by_half_a_circle_stay_rotations() -> None:
    """Their axes meet in nothing; the nearer key stands in."""
    keys = np.array([np.diag([1.0, 1, 1, 1]), np.diag([-1.0, -1, 1, 1])])
    found = between(keys, poses((0, 1, 0.4999999), (0, 1, 0.5), (0, 1, 0.3), (1, 0, 0.5)))
    require_rigid(found)
    assert np.array_equal(found, keys[[0, 1, 0, 0]])


@given(st.lists(st.floats(-1, 1), min_size=9, max_size=9))
def test_orthonormalised_axes(numbers: list[float]) -> None:
    axes = np.array(numbers).reshape(3, 3)
    if np.linalg.norm(np.cross(axes[:, 0], axes[:, 1])) > 1e-3:
        found, _ = orthonormalised(axes)
        np.testing.assert_allclose(found.T @ found, np.eye(3), atol=1e-12)
        assert np.linalg.det(found) == pytest.approx(1)
        assert found[:, 0] @ axes[:, 0] == pytest.approx(np.linalg.norm(axes[:, 0]))
        np.testing.assert_allclose(orthonormalised(found)[0], found, atol=1e-14)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "byte 0: expected the letters IDP3, found an empty file"),
        (b"IDP2" + SMALL[4:], "byte 0: expected the letters IDP3, found 'IDP2'"),
        (b"IDP3", "header: expected 1 x 108 bytes from offset 0 on, found a file of 4 bytes"),
        (write_md3(small_md3(), version=14), "byte 4: expected version 15, found version 14"),
    ],
)
def test_other_files_are_told_apart(data: bytes, message: str) -> None:
    with pytest.raises(AssetError) as error:
        read_md3(data, "x.md3")
    assert message in str(error.value)


@pytest.mark.parametrize("data", [SMALL, HAND_MD3])
def test_every_truncation_is_an_asset_error(data: bytes) -> None:
    """At every byte, and so at every field."""
    for length in range(len(data)):
        with pytest.raises(AssetError):
            read_md3(data[:length], "cut.md3")


@pytest.mark.parametrize(
    ("field", "values", "place"),
    [
        ("frames_count", [0, -1, 1025, LOW, HIGH], "header.frames_count"),
        ("frames_count", [1, 3], "surfaces[0].frames_count"),
        ("frames_count", [1024], "frames"),
        ("tags_count", [-1, 17, HIGH], "header.tags_count"),
        ("tags_count", [16], "tags"),
        ("surfaces_count", [-1, 33, HIGH], "header.surfaces_count"),
        ("surfaces_count", [3], "surfaces[2]"),
        ("frames_offset", [-1, LOW, HIGH, len(SMALL)], "frames"),
        ("tags_offset", [-1, LOW, HIGH, len(SMALL)], "tags"),
        ("surfaces_offset", [-1, 4, LOW, HIGH, len(SMALL)], "surfaces[0]"),
        ("end_offset", [-1, 0, 107, len(SMALL) + 1, HIGH], "header.end_offset"),
        ("surface_magic", [b"IDP2", b""], "surfaces[0]"),
        ("surface_frames_count", [0, 1, 3, -1, HIGH], "surfaces[0].frames_count"),
        ("surface_shaders_count", [-1, 257, HIGH], "surfaces[0].shaders_count"),
        ("surface_shaders_count", [256], "surfaces[0].shaders"),
        ("surface_vertices_count", [-1, 4097, HIGH], "surfaces[0].vertices_count"),
        ("surface_vertices_count", [0, 2], "surfaces[0].triangles[0]"),
        ("surface_vertices_count", [4096], "surfaces[0].texcoords"),
        ("surface_triangles_count", [-1, 8193, HIGH], "surfaces[0].triangles_count"),
        ("surface_triangles_count", [8192], "surfaces[0].triangles"),
        ("surface_triangles_offset", [LOW, -1], "surfaces[0].triangles_offset"),
        ("surface_triangles_offset", [HIGH, len(SMALL)], "surfaces[0].triangles"),
        ("surface_shaders_offset", [LOW, -1], "surfaces[0].shaders_offset"),
        ("surface_shaders_offset", [HIGH, len(SMALL)], "surfaces[0].shaders"),
        ("surface_texcoords_offset", [LOW, -1], "surfaces[0].texcoords_offset"),
        ("surface_texcoords_offset", [HIGH, len(SMALL)], "surfaces[0].texcoords"),
        ("surface_vertices_offset", [LOW, -1], "surfaces[0].vertices_offset"),
        ("surface_vertices_offset", [HIGH, len(SMALL)], "surfaces[0].vertices"),
        ("surface_end_offset", [LOW, -1, 0, 107], "surfaces[0].end_offset"),
        ("surface_end_offset", [108, HIGH, len(SMALL)], "surfaces[1]"),
    ],
)
def test_headers_that_lie(field: str, values: list[Any], place: str) -> None:
    for value in values:
        with pytest.raises(AssetError) as error:
            read_md3(write_md3(small_md3(), **{field: value}), "lie.md3")
        assert error.value.place == place
        assert error.value.expected


@pytest.mark.parametrize(
    ("lump", "field", "index", "values", "place"),
    [
        ("frames", "mins", (1, 0), [NAN, INFINITY], "frames[1].mins"),
        ("frames", "maxs", (0, 2), [-INFINITY], "frames[0].maxs"),
        ("frames", "origin", (1, 1), [NAN], "frames[1].origin"),
        ("frames", "radius", 1, [NAN], "frames[1].radius"),
        ("tags", "origin", (1, 0, 2), [NAN, INFINITY], "tags of frame 1, origin"),
        ("tags", "axes", (1, 1, 0, 0), [NAN, INFINITY, -1, 0], "tags of frame 1, axes"),
        ("tags", "axes", (0, 1), [0, 1], "tags of frame 0, axes"),
        ("tags", "name", (1, 0), [b"tag_other", b""], "tags of frame 1"),
        ("triangles", None, (0, 2), [-1, 3, LOW, HIGH], "surfaces[0].triangles[0]"),
        ("texcoords", None, (2, 1), [NAN, -INFINITY], "surfaces[0].texcoords[2]"),
    ],
)
def test_numbers_out_of_range_are_told_with_their_place(
    lump: str, field: str | None, index: Any, values: list[Any], place: str
) -> None:
    for value in values:
        model = small_md3()
        array = model[lump] if lump in model else model["surfaces"][0][lump]
        (array if field is None else array[field])[index] = value
        with pytest.raises(AssetError) as error:
            read_md3(write_md3(model), "lie.md3")
        assert error.value.place == place
        assert error.value.expected


def test_a_small_file_cannot_ask_for_much_memory() -> None:
    """Thirty surfaces of 1024 frames share one lump of 200 vertices a frame."""
    model = small_md3()
    model["frames"] = np.zeros(1024, md3.FRAME)
    model["tags"] = np.zeros((1024, 0), md3.TAG)
    first = model["surfaces"][0]
    first["vertices"] = np.zeros((1024, 200), md3.VERTEX)
    first["texcoords"] = np.zeros((200, 2), "<f4")
    model["surfaces"] = [first]
    data = bytearray(write_md3(model, surfaces_count=30))
    header = np.frombuffer(data, md3.HEADER, 1)[0]
    start = int(header["surfaces_offset"])
    record = np.frombuffer(data, md3.SURFACE, 1, start)[0].copy()
    heads = b""
    for number in range(30):
        moved = record.copy()
        moved["end_offset"] = md3.SURFACE.itemsize
        for lump in ("triangles", "shaders", "texcoords", "vertices"):
            moved[f"{lump}_offset"] += (30 - number - 1) * md3.SURFACE.itemsize
        heads += moved.tobytes()
    shared = bytes(data[:start]) + heads + bytes(data[start + md3.SURFACE.itemsize :])
    with pytest.raises(
        AssetError, match="at most 4194304 vertices in all frames together"
    ) as error:
        read_md3(shared, "lie.md3")
    assert error.value.place == "surfaces[20]"


def test_what_real_models_do_is_taken() -> None:
    """Surfaces without triangles, models without surfaces or tags, trailing bytes."""
    model = small_md3()
    for surface in model["surfaces"]:
        for lump in ("triangles", "shaders", "texcoords"):
            surface[lump] = surface[lump][:0]
        surface["vertices"] = surface["vertices"][:, :0]
    use_everything(read_md3(write_md3(model) + b"more", "empty.md3"))
    bare = {"frames": model["frames"], "tags": model["tags"][:, :0], "surfaces": []}
    use_everything(read_md3(write_md3(bare), "bare.md3"))


flips = st.tuples(st.integers(0, len(SMALL) - 1), st.integers(0, 255))


@settings(max_examples=500)
@given(st.lists(flips, min_size=1, max_size=8))
def test_any_bytes_load_or_are_an_asset_error(changes: list[tuple[int, int]]) -> None:
    data = bytearray(SMALL)
    for offset, value in changes:
        data[offset] = value
    try:
        model = read_md3(bytes(data), "flipped.md3")
    except AssetError as error:
        assert error.source == "flipped.md3"
    else:
        use_everything(model)


@pytest.mark.openarena
def test_all_models_of_openarena_load_and_move_through_all_frames() -> None:
    """Over all triangles nearly all front faces, as their normals tell, are clockwise."""
    models, outwards, triangles = 0, 0, 0
    for source, data in openarena_files(".md3"):
        model = read_md3(data, source)
        models += 1
        use_everything(model)
        for surface in model.surfaces:
            seen = facing(surface.positions[0], surface.normals[0], surface.indices)
            outwards += int((seen > 0).sum())
            triangles += len(seen)
        count = len(model.frames)
        frame = np.arange(count)
        pose = Pose(frame, (frame + 1) % count, np.linspace(0, 1, count))
        for keys in model.tags.values():
            require_rigid(between(keys, pose))
    assert models > 300
    assert outwards / triangles > 0.95
