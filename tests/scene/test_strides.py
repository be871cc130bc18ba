"""Speeds that fit figures' steps: what touches the floor stays where it is while they go on."""

from functools import cache

import numpy as np
import pytest

from figures import figure
from followspot.assets.animation import Animation
from followspot.assets.archive import Archive
from followspot.assets.locate import search_path
from followspot.assets.player import list_players, load_player
from followspot.builtin import robot_animation
from followspot.game import RUN_SPEED
from followspot.scene import walk
from followspot.scene.character import Character, Crowd
from followspot.scene.figure import STILL, Figure, Tracks, from_player
from followspot.scene.load import load_figure
from followspot.scene.material import Material
from synthetic import Piece, box, turned

NONE = {"player:kyonshi", "player:merman"}
"""One hops on both feet, the other one floats on its tail."""

ROUGH = {
    "walk": {"player:arachna", "player:liz"},
    "run": {"player:arachna", "player:assassin", "player:ayumi"},
}
"""Whose feet do not all go at one speed: of eight legs, some are never lifted while they swing."""

CONTACT = 2.0  # units above the lowest vertex


def feet(*places: tuple[float, float, float]) -> list[Piece]:
    """Two feet, or however many, as boxes that stand at these places."""
    sole = box((-2, -2, 0), (2, 2, 4))
    return [piece for place in places for piece in turned(sole, np.eye(3), place)]


def gait(speed: float, lift: float = 12.0, fps: float = 10.0, lead_in: int = 0) -> Figure:
    """Two feet in turn: half of eight frames each goes back on the floor, then forward above it."""
    step = speed / fps
    x = np.array([2, 1, 0, -1, -2, -1, 0, 1]) * step
    z = np.array([0, 0, 0, 0, 0, 1, 1, 1]) * lift
    frames = [feet((90, 0, 0), (-90, 0, 0))] * lead_in
    for k in range(8):
        other = (k + 4) % 8
        frames.append(feet((x[k], 10, z[k]), (x[other], -10, z[other])))
    return figure(frames, {"walk": Animation(0, 8 + lead_in, 8, fps)})


def slide(of: Figure, tracks: Tracks, speed: float) -> float:
    """What touches the floor moves by this share of the way that the figure makes.

    From key frame to key frame of one loop of somebody who goes straight on, in the world: the
    stiller half of what is next to the floor both before and after, in the median step.
    """
    way = walk.along([(0, 0, 0), (4000, 0, 0)], speed)
    crowd = Crowd([Character(of, way, ((tracks, 0.0),))])
    legs = tracks.legs
    times = (np.arange(legs.count, 2 * legs.count + 1) + 1e-6) / legs.fps
    places = np.stack([crowd.places(time)[0, :3] for time in times.tolist()])
    assert np.allclose(crowd.places(1.0)[0, 3], 0)
    world = of.parts[0].positions[legs.pose(times).frame] + places[:, np.newaxis]
    height = np.maximum(world[1:, :, 2], world[:-1, :, 2])
    moved = np.linalg.norm(np.diff(world[..., :2], axis=0), axis=2)
    lowest = height.min(axis=1)
    on_floor = np.flatnonzero(lowest <= np.quantile(lowest, 0.25) + CONTACT)
    steps = [np.quantile(moved[k][height[k] <= lowest[k] + CONTACT], 0.25) for k in on_floor]
    return float(np.median(steps)) * legs.fps / speed


@cache
def players() -> tuple[Figure, ...]:
    with Archive.open(search_path(())) as archive:
        return tuple(from_player(load_player(archive, n), Material) for n in list_players(archive))


@pytest.mark.parametrize("speed", [12.0, 40.0, 200.0, 400.0])
@pytest.mark.parametrize("lead_in", [0, 1])
def test_speed_is_that_of_the_standing_foot(speed: float, lead_in: int) -> None:
    """Also over the step from the last frame to the first, and whatever comes before the loop."""
    walker = gait(speed, lead_in=lead_in)
    tracks = walker.tracks("walk")
    assert walk.stride_speed(walker, tracks.legs) == pytest.approx(speed)
    assert slide(walker, tracks, speed) < 1e-3


def test_feet_that_are_hardly_lifted() -> None:
    """The foot that swings touches the floor, too, but goes forward."""
    walker = gait(60.0, lift=0.5)
    assert walk.stride_speed(walker, walker.animations["walk"]) == pytest.approx(60.0)


def test_in_the_air_no_foot_tells() -> None:
    """Of a run's six frames, two are above the floor, where the feet go back more slowly."""
    x, z = (20.0, 0.0, -20.0, -24.0, 0.0, 16.0), (0, 0, 0, 6, 15, 6)
    frames = [feet((x[k], 10, z[k]), (x[k - 3], -10, z[k - 3])) for k in range(6)]
    legs = Animation(0, 6, 6, 10.0)
    assert walk.stride_speed(figure(frames, {"run": legs}), legs) == pytest.approx(200.0)


def test_what_has_no_stride() -> None:
    rate = np.arange(8) * np.pi / 4
    loop = Animation(0, 8, 8, 10.0)
    ways: dict[str, list[tuple[float, float, float]]] = {
        "hops": [((3 if k == 1 else 0), 0, 2.0 * k) for k in range(8)],
        "sways": [(0.3 * np.sin(t), 0, 0) for t in rate],
        "sweeps": [(2 * np.sin(t), 9 * np.cos(t), 0) for t in rate],
    }
    for name, places in ways.items():
        of = figure([feet((x, y, z)) for x, y, z in places], {"walk": loop})
        assert walk.stride_speed(of, loop) == 0, name
        assert walk.fitting_speed(of, loop) == 160, name
    assert walk.stride_speed(gait(60.0), STILL) == 0


def test_without_a_stride_the_games_speeds() -> None:
    names = "run", "walk", "walkcr", "swim"
    of = {f"legs_{name}": Animation(k, 1, 1, 10.0) for k, name in enumerate(names)}
    still = Figure("player:x", (), of)
    speeds = [walk.fitting_speed(still, of[f"legs_{name}"]) for name in names]
    assert speeds == [320, 160, 80, 320]
    walker = gait(60.0)
    assert walk.fitting_speed(walker, walker.animations["walk"]) == pytest.approx(60)


def test_the_robot_goes_as_its_script_wants() -> None:
    scene = load_figure("models/robot/robot.md2", animation="run")
    scene.archive.close()
    robot = scene.crowd.characters[0].figure
    wanted = {"run": robot_animation.RUN_SPEED, "walk": robot_animation.WALK_SPEED}
    for name, speed in wanted.items():
        tracks = robot.tracks(name)
        found = walk.stride_speed(robot, tracks.legs)
        assert found == pytest.approx(speed, rel=0.01), name
        assert slide(robot, tracks, found) < 0.05, name
    assert {n for n, a in robot.animations.items() if walk.stride_speed(robot, a)} == set(wanted)


@pytest.mark.openarena
@pytest.mark.parametrize(("name", "most"), [("run", 0.3), ("walk", 0.45)])
def test_openarenas_players_do_not_slide(name: str, most: float) -> None:
    """The feet of most follow the floor; nobody's slides farther than at the game's own speed."""
    speeds = {p.name: walk.stride_speed(p, p.tracks(name).legs) for p in players()}
    assert {player for player, speed in speeds.items() if not speed} == NONE
    game = RUN_SPEED * {"run": 1, "walk": 0.5}[name]
    for player in players():
        speed, tracks = speeds[player.name], player.tracks(name)
        if not speed:
            assert walk.fitting_speed(player, tracks.legs) == game
            continue
        share = slide(player, tracks, speed)
        assert 20 < speed < 250, (player.name, speed)
        assert share < most or player.name in ROUGH[name], (player.name, speed, share)
        assert share * speed < slide(player, tracks, game) * game, (player.name, speed, share)


@pytest.mark.openarena
def test_openarenas_players_walk_more_slowly_than_they_run() -> None:
    for player in players():
        if player.name not in NONE:
            walking, running = (
                walk.stride_speed(player, player.tracks(name).legs) for name in ("walk", "run")
            )
            assert walking < running, player.name


@pytest.mark.openarena
def test_openarenas_players_stand() -> None:
    """No idle loop is taken for steps."""
    for player in players():
        assert walk.stride_speed(player, player.tracks().legs) == 0, player.name
        assert 30 < player.radius < 120, player.name
