"""Players as they are drawn: torsos on legs, heads on torsos, by the tags of their frames."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from followspot.assets.animation import Animation
from followspot.assets.archive import Archive
from followspot.assets.player import Player, list_players, load_player
from followspot.scene.character import Character, Crowd
from followspot.scene.figure import Tracks, from_player
from followspot.scene.material import Material
from followspot.scene.walk import standing
from model_fixtures import OPENARENA, write_player

EVEN = Animation(0, 1, 1, 1.0)
ODD = Animation(1, 2, 2, 1.0)
"""From frame 1 to 2 in a second: at 0 s an odd frame, at 0.5 s half of one."""


def load(game: Path, name: str = "bot") -> Player:
    with Archive.open([game]) as archive:
        return load_player(archive, name)


def drawn(
    player: Player, tracks: Tracks, times: list[float], origin: ArrayLike = (0, 0, 0)
) -> NDArray[np.float64]:
    """(times, 3, 3, 4) ``world_from_part`` of legs, torso and head."""
    character = Character(from_player(player, Material), standing(origin), ((tracks, 0.0),))
    crowd, only = Crowd([character]), np.array([0])
    rows = [crowd.instances(time, crowd.places(time), only)[0, :, :3] for time in times]
    return np.asarray(rows, np.float64)


def require_rigid(matrices: NDArray[np.float64]) -> None:
    rotations = matrices[..., :3, :3]
    eye = np.broadcast_to(np.eye(3), rotations.shape)
    np.testing.assert_allclose(rotations.swapaxes(-1, -2) @ rotations, eye, atol=1e-6)
    np.testing.assert_allclose(np.linalg.det(rotations), 1, atol=1e-6)


def test_parts_are_joined_by_the_tags_of_their_frames(tmp_path: Path) -> None:
    """In odd frames tag 0 is at (0, 2, 8) and a quarter turn to the left, else at (0, 0, 8)."""
    write_player(tmp_path)
    player = load(tmp_path)
    (still,) = drawn(player, Tracks(EVEN, EVEN), [0.0], (100, 0, 24))
    assert still[:, :, 3].tolist() == [[100, 0, 24], [100, 0, 32], [100, 0, 40]]
    moved = drawn(player, Tracks(ODD, ODD), [0.0, 0.5], (100, 0, 24))
    np.testing.assert_allclose(moved[0, 1, :, 3], [100, 2, 32], atol=1e-5)
    np.testing.assert_allclose(moved[0, 1, :, 0], [0, 1, 0], atol=1e-6)  # forward is to the left
    np.testing.assert_allclose(moved[0, 2, :, 3], [98, 2, 40], atol=1e-5)
    np.testing.assert_allclose(moved[0, 2, :, 0], [-1, 0, 0], atol=1e-6)
    np.testing.assert_allclose(moved[1, 1, :, 3], [100, 1, 32], atol=1e-5)
    require_rigid(moved)
    (mixed,) = drawn(player, Tracks(EVEN, ODD), [0.0])
    np.testing.assert_allclose(mixed[:, :, 3], [(0, 0, 0), (0, 0, 8), (0, 2, 16)], atol=1e-5)


def test_where_a_part_is_missing_the_next_stands_in_its_place(tmp_path: Path) -> None:
    (write_player(tmp_path) / "upper.md3").unlink()
    player = load(tmp_path)
    (placed,) = drawn(player, Tracks(EVEN, EVEN), [0.0])
    assert {part.slot for part in from_player(player, Material).parts} == {0, 2}
    assert placed[2, :, 3].tolist() == [0, 0, 8]


def test_many_players_are_joined_as_each_alone(tmp_path: Path) -> None:
    write_player(tmp_path)
    figure = from_player(load(tmp_path), Material)
    plays = ((Tracks(Animation(0, 25, 25, 10), Animation(3, 9, 9, 7)), 0.0),)
    each = [Character(figure, standing((k, 0, 0)), plays, clock=0.7 * k) for k in range(5)]
    crowd = Crowd(each)
    together = crowd.instances(1.0, crowd.places(1.0), np.arange(5))
    for k, character in enumerate(each):
        alone = Crowd([character])
        rows = alone.instances(1.0, alone.places(1.0), np.array([0]))
        assert np.array_equal(together[k], rows[0])


@pytest.fixture(scope="module")
def openarena() -> Iterator[list[Player]]:
    assert OPENARENA.is_dir(), f"OpenArena's data is not installed in {OPENARENA}"
    with Archive.open([OPENARENA]) as archive:
        yield [load_player(archive, name) for name in list_players(archive)]


@pytest.mark.openarena
def test_openarenas_players_stay_whole_in_all_their_frames(openarena: list[Player]) -> None:
    for player in openarena:
        lower, upper = (len(player.parts[part].model.frames) for part in ("lower", "upper"))
        every = Tracks(Animation(0, lower, lower, 10.0), Animation(0, upper, upper, 10.0))
        times = (np.arange(2 * max(lower, upper)) / 20).tolist()
        matrices = drawn(player, every, times)
        require_rigid(matrices)
        assert np.abs(matrices[..., 3]).max() < 100, player.name


@pytest.mark.openarena
def test_openarenas_players_stand_on_their_feet(openarena: list[Player]) -> None:
    """The floor is 24 units below the origin, a head above it."""
    for player in openarena:
        legs, torso = (player.config.animations[k] for k in ("legs_idle", "torso_stand"))
        (placed,) = drawn(player, Tracks(legs, torso), [0.0])
        soles = min(
            surface.positions[legs.first, :, 2].min(initial=np.inf)
            for surface in player.parts["lower"].model.surfaces
        )
        assert -34 < soles < -14, player.name
        assert placed[2, 2, 3] >= placed[1, 2, 3] > soles + 10, player.name
