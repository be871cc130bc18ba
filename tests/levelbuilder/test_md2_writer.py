"""MD2 files as written: read back whole, the same every time, within the game's bounds."""

from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from vgio.quake2.md2 import Md2

from followspot.arrays import Floats, Ints
from followspot.assets.md2 import NORMALS, read_md2
from followspot.errors import UsageError
from followspot.levelbuilder.md2_writer import Md2Skin, gl_commands, md2_bytes

TRIANGLES = np.array([[0, 1, 2], [0, 2, 3], [3, 2, 1]])
SKIN = Md2Skin(
    image="models/test/skin.png",
    size=(64, 32),
    texels=np.array([[0, 0], [63, 0], [63, 31], [0, 31], [7, 9]]),
    triangles=np.array([[0, 1, 2], [0, 2, 3], [4, 2, 1]]),
)


def moves(frames: int, seed: int = 0) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(seed)
    normals = rng.standard_normal((frames, 4, 3))
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return rng.uniform(-30, 30, (frames, 4, 3)), normals


def drawn(words: NDArray[np.int32]) -> list[list[tuple[float, float, int]]]:
    """The triangles that GL commands of fans draw."""
    triangles, at = [], 0
    while (count := -int(words[at])) != 0:
        assert count >= 3
        fan = words[at + 1 : at + 1 + 3 * count].reshape(-1, 3)
        st = np.ascontiguousarray(fan[:, :2]).view("<f4").tolist()
        corners = [(s, t, int(v)) for (s, t), v in zip(st, fan[:, 2], strict=True)]
        triangles += [[corners[0], *corners[i : i + 2]] for i in range(1, count - 1)]
        at += 1 + 3 * count
    assert at == len(words) - 1
    return triangles


def in_full(triangles: Ints, skin: Md2Skin) -> list[list[tuple[float, float, int]]]:
    st = ((skin.texels + 0.5) / skin.size).astype(np.float32)[skin.triangles].tolist()
    return [
        [(s, t, v) for (s, t), v in zip(places, corners, strict=True)]
        for places, corners in zip(st, triangles.tolist(), strict=True)
    ]


def test_what_is_written_is_read_back() -> None:
    animations = {"stand": moves(3), "run": moves(11, 1)}
    data = md2_bytes(animations, TRIANGLES, SKIN)
    assert data == md2_bytes(animations, TRIANGLES, SKIN)
    model = read_md2(data, "test.md2")
    assert model.skins == (SKIN.image,)
    assert model.frame_names[:4] == ("stand01", "stand02", "stand03", "run01")
    assert {n: (a.first, a.count) for n, a in model.animations.items()} == {
        "stand": (0, 3),
        "run": (3, 11),
    }
    corners = model.indices
    assert np.array_equal(
        model.texcoords[corners],
        ((SKIN.texels + 0.5) / SKIN.size).astype(np.float32)[SKIN.triangles.ravel()],
    )
    for name, (positions, normals) in animations.items():
        a = model.animations[name]
        frames = slice(a.first, a.first + a.count)
        wanted = positions[:, TRIANGLES.ravel()]
        half_step = np.ptp(positions, axis=(0, 1)) / 255 / 2
        assert (np.abs(model.positions[frames][:, corners] - wanted) <= half_step + 1e-5).all()
        nearest = (normals[:, TRIANGLES.ravel()] @ NORMALS.T).max(axis=2)
        found = (model.normals[frames][:, corners] * normals[:, TRIANGLES.ravel()]).sum(axis=2)
        np.testing.assert_allclose(found, nearest, atol=1e-6)


def test_what_stands_still_does_not_tremble() -> None:
    positions, normals = moves(9)
    positions[:, 1:] = positions[0, 1:]
    model = read_md2(md2_bytes({"nod": (positions, normals)}, TRIANGLES, SKIN), "test.md2")
    still = (model.positions == model.positions[0]).all(axis=(0, 2))
    assert still[model.indices.reshape(-1, 3)[2]].all() and not still.all()


def test_a_flat_model_stays_flat() -> None:
    positions, normals = moves(2)
    positions[..., 1] = 5.25
    model = read_md2(md2_bytes({"lie": (positions, normals)}, TRIANGLES, SKIN), "test.md2")
    assert (model.positions[..., 1] == 5.25).all()


def test_vgio_reads_the_same(tmp_path: Path) -> None:
    path = tmp_path / "test.md2"
    path.write_bytes(md2_bytes({"run": moves(4)}, TRIANGLES, SKIN))
    with closing(Md2.open(str(path))) as file:
        assert (file.skin_width, file.skin_height) == SKIN.size
        assert [frame.name for frame in file.frames] == ["run01", "run02", "run03", "run04"]
        assert np.array_equal([t.vertexes for t in file.triangles], TRIANGLES)
        assert np.array_equal([t.st_vertexes for t in file.triangles], SKIN.triangles)
        assert np.array_equal([(v.s, v.t) for v in file.st_vertexes], SKIN.texels)
        fan, single = file.gl_commands[:2]
        assert [v.vertex for v in fan.vertexes] == [0, 1, 2, 3]
        assert [v.vertex for v in single.vertexes] == [3, 2, 1]


CORNERS = st.lists(st.lists(st.integers(0, 4), min_size=3, max_size=3), min_size=1, max_size=20)


@given(CORNERS)
def test_fans_draw_the_triangles_in_their_order(corners: list[list[int]]) -> None:
    triangles = np.array(corners)
    skin = Md2Skin(SKIN.image, SKIN.size, SKIN.texels, triangles)
    assert drawn(gl_commands(triangles, skin)) == in_full(triangles, skin)


def test_a_ring_of_triangles_is_one_fan() -> None:
    triangles = np.array([[0, i, i + 1] for i in range(1, 6)])
    skin = Md2Skin(SKIN.image, SKIN.size, np.arange(14).reshape(7, 2), triangles)
    words = gl_commands(triangles, skin)
    assert words[0] == -7 and len(words) == 1 + 3 * 7 + 1
    assert drawn(words) == in_full(triangles, skin)


def test_beyond_the_games_bounds_is_refused() -> None:
    positions, normals = moves(1)
    for animations, triangles, message in (
        ({"a": (np.zeros((1, 2049, 3)),) * 2}, TRIANGLES, "2048 vertices, not 2049"),
        ({"a": (positions, normals)}, np.zeros((4097, 3), int), "4096 triangles, not 4097"),
        ({f"{c}{d}": moves(99) for c in "ab" for d in "xyz"}, TRIANGLES, "512 frames, not 594"),
        ({"a": moves(100)}, TRIANGLES, "at most 99 frames"),
        ({"run2": moves(2)}, TRIANGLES, "no digit last"),
        ({"a" * 14: moves(2)}, TRIANGLES, "13 letters"),
    ):
        with pytest.raises(UsageError, match=message):
            md2_bytes(animations, triangles, SKIN)
    skin = Md2Skin("x" * 64, SKIN.size, SKIN.texels, SKIN.triangles)
    with pytest.raises(UsageError, match="63 letters"):
        md2_bytes({"a": moves(2)}, TRIANGLES, skin)
