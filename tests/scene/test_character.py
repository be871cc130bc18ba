"""Figures, their names for what they do, their ways, and what the GPU is told of a crowd."""

import numpy as np
import pytest
from numpy.typing import NDArray

from figures import at, figure, key, puppet
from followspot.assets.animation import Animation
from followspot.errors import AssetError, UsageError
from followspot.scene import walk
from followspot.scene.character import SLOTS, Character, Crowd
from followspot.scene.figure import STILL, Figure, FigurePart, Tracks
from followspot.scene.material import Material
from synthetic import box, rotation

BODY = box((-4, -4, -8), (4, 4, 8))


def doll(turns: int = 3) -> Figure:
    torso = np.stack([key((0, 0, 8), rotation((0, 0, 1), 30.0 * k)) for k in range(turns)])
    head = np.stack([key((0, 1, 8), rotation((1, 0, 0), 20.0 * k)) for k in range(turns)])
    return puppet([[BODY] * turns, [BODY] * turns, [BODY]], torso, head)


def test_surfaces_of_one_material_are_one_run() -> None:
    red, blue = Material("red", "r.png"), Material("blue", "b.png")
    pieces = [p for k, p in enumerate(box((0, 0, 0), (1, 1, 1)))]
    mixed_up = [type(p)(p.vertices, p.indices, (red, blue)[k % 2]) for k, p in enumerate(pieces)]
    part = figure([mixed_up, mixed_up]).parts[0]
    assert [(run.material.name, run.first, run.count) for run in part.runs] == [
        ("blue", 0, 18),
        ("red", 18, 18),
    ]
    assert part.positions.shape == (2, 24, 3) and sorted(set(part.indices)) == list(range(24))


def test_names_of_a_figures_animations() -> None:
    run, wave = Animation(0, 1, 1, 10.0), Animation(1, 1, 0, 10.0)
    single = figure([BODY, BODY], {"run": run, "wave": wave})
    assert single.tracks("WAVE") == Tracks(wave, wave)
    assert single.tracks() == Tracks(run, run)
    assert figure([BODY, BODY], {"run": run, "stand": wave}).tracks() == Tracks(wave, wave)
    assert not single.is_player
    with pytest.raises(AssetError, match=r"test: animation: expected one of run, wave, found fly"):
        single.tracks("fly")
    bare = Figure("bare", single.parts)
    assert bare.tracks() == Tracks(STILL, STILL)
    with pytest.raises(AssetError, match="expected none, found run"):
        bare.tracks("run")


def test_names_of_a_players_animations() -> None:
    of = {
        name: Animation(k, 1, 1, 10.0)
        for k, name in enumerate(
            ("both_death1", "torso_attack", "torso_stand", "legs_run", "legs_idle", "legs_turn")
        )
    }
    still = np.broadcast_to(np.eye(4), (6, 4, 4))
    player = Figure("player:x", (), of, still, still)
    idle, stand = of["legs_idle"], of["torso_stand"]
    for name, legs, torso in [
        (None, idle, stand),
        ("stand", idle, stand),
        ("run", of["legs_run"], stand),
        ("legs_run", of["legs_run"], stand),
        ("attack", idle, of["torso_attack"]),
        ("torso_attack", idle, of["torso_attack"]),
        ("Run+Attack", of["legs_run"], of["torso_attack"]),
        ("death1", of["both_death1"], of["both_death1"]),
        ("both_death1", of["both_death1"], of["both_death1"]),
        ("run+stand", of["legs_run"], stand),
    ]:
        assert player.tracks(name) == Tracks(legs, torso), name
    for wrong in ("fly", "run+fly", "attack+run", "+", "torso_run"):
        with pytest.raises(AssetError, match="expected one of both_death1, torso_attack"):
            player.tracks(wrong)


def test_instances_say_what_the_tags_and_clocks_do() -> None:
    """By hand for one character of a crowd in mixed order, in double precision."""
    of, single = doll(), figure([BODY, BODY, BODY])
    plays = ((of.tracks("run+attack"), 0.0),)
    place = walk.standing((10, 20, 30), 90.0)
    crowd = Crowd(
        [
            at(single, (1, 2, 3), clock=0.5),
            Character(of, place, plays),
            at(single, (4, 5, 6), yaw=180.0),
            Character(of, place, plays, clock=1.25),
        ]
    )
    assert crowd.figures == (single, of)
    assert crowd.figure_of.tolist() == [0, 0, 1, 1]
    seconds = 1.0
    places = crowd.places(seconds)
    rows = crowd.instances(seconds, places, np.array([3, 0]))
    assert rows.shape == (2, SLOTS, 4, 4) and rows.dtype == np.float32
    world = key((10, 20, 30), rotation((0, 0, 1), 90))
    # 2.25 s: frame 2 of 3 on its way to frame 0, a quarter of it.
    assert of.torso_keys is not None and of.head_keys is not None
    turn = rotation((0, 0, 1), np.degrees(np.arctan2(0.75 * np.sin(np.pi / 3), 0.75 * 0.5 + 0.25)))
    upper = world @ key((0, 0, 8), turn)
    np.testing.assert_allclose(rows[0, 0, :3], world[:3], atol=1e-6)
    np.testing.assert_allclose(rows[0, 1, :3], upper[:3], atol=1e-5)
    np.testing.assert_allclose(rows[0, 2, :3, 3], (upper @ (0, 1, 8, 1))[:3], atol=1e-5)
    count = of.parts[0].vertex_count
    np.testing.assert_allclose(rows[0, :2, 3], [[2 * count, 0, 0.25, 0]] * 2, atol=1e-6)
    np.testing.assert_array_equal(rows[0, 2, 3], 0)
    np.testing.assert_allclose(rows[1, 0, :3], key((1, 2, 3))[:3], atol=1e-6)
    np.testing.assert_allclose(rows[1, 0, 3], [count, 2 * count, 0.5, 0], atol=1e-6)
    axes = rows[0, :, :3, :3].astype(np.float64)
    np.testing.assert_allclose(axes @ axes.swapaxes(1, 2), [np.eye(3)] * 3, atol=1e-6)


def test_no_pose_leaves_a_figures_radius() -> None:
    of = doll()
    crowd = Crowd([Character(of, walk.standing((5, 6, 7)), ((of.tracks("run+attack"), 0.0),))])
    for seconds in np.linspace(0, 3, 31).tolist():
        rows = crowd.instances(seconds, crowd.places(seconds), np.array([0]))[0]
        for part in of.parts:
            corners = part.positions[0].astype(np.float64)
            world = corners @ rows[part.slot, :3, :3].T + rows[part.slot, :3, 3]
            assert np.linalg.norm(world - (5, 6, 7), axis=1).max() <= of.radius + 1e-4
    np.testing.assert_allclose(crowd.mins, [np.array([5, 6, 7]) - of.radius], rtol=1e-6)
    np.testing.assert_allclose(crowd.maxs, [np.array([5, 6, 7]) + of.radius], rtol=1e-6)


def test_boxes_are_those_of_the_pose() -> None:
    """They hold every vertex between key poses, and touch it at them if nothing is turned."""
    of = doll()
    run = ((of.tracks("run+attack"), 0.0),)
    crowd = Crowd(
        [
            Character(of, walk.standing((5, 6, 7), 30), run),
            Character(of, walk.standing((9, 0, 0)), run),
        ]
    )
    both = np.array([1, 0])
    for seconds in np.linspace(0, 3, 31).tolist():
        rows = crowd.instances(seconds, crowd.places(seconds), both)
        mins, maxs = crowd.boxes(rows, both)
        for row, low, high in zip(rows, mins, maxs, strict=True):
            world = np.concatenate([_vertices(part, row[part.slot]) for part in of.parts])
            assert (world >= low - 1e-4).all() and (world <= high + 1e-4).all()
            assert (high - low <= np.ptp(world, axis=0) * 1.6 + 1e-4).all()
    box = Crowd([Character(figure([BODY]), walk.standing((1, 2, 3)))])
    only = np.array([0])
    mins, maxs = box.boxes(box.instances(0.0, box.places(0.0), only), only)
    corners = figure([BODY]).parts[0].positions[0] + (1, 2, 3)
    np.testing.assert_allclose([mins[0], maxs[0]], [corners.min(axis=0), corners.max(axis=0)])


def _vertices(part: FigurePart, row: NDArray[np.float32]) -> NDArray[np.float64]:
    """(v, 3) where vertices are in the world, as the vertex shader puts them there."""
    first, second = (int(at) // part.vertex_count for at in row[3, :2])
    blend = float(row[3, 2])
    posed = part.positions[first] * (1 - blend) + part.positions[second] * blend
    return np.asarray(posed.astype(np.float64) @ row[:3, :3].T + row[:3, 3])


def test_spinning_and_bobbing() -> None:
    item = Character(figure([BODY]), walk.standing((0, 0, 50)), spin=90.0, bob=4.0, bob_rate=np.pi)
    crowd = Crowd([item])
    np.testing.assert_allclose(crowd.places(0.0), [[0, 0, 58, 0]])
    np.testing.assert_allclose(crowd.places(1.0), [[0, 0, 50, 90]], atol=1e-9)
    np.testing.assert_allclose(crowd.places(2.0), [[0, 0, 58, 180]], atol=1e-9)
    assert crowd.maxs[0, 2] >= 58 + 8


def test_a_crowd_of_none() -> None:
    crowd = Crowd()
    assert len(crowd) == 0 and crowd.mins.shape == (0, 3) and crowd.places(1.0).shape == (0, 4)


def walker(way: walk.Walk) -> Crowd:
    return Crowd([Character(figure([BODY]), way)])


def test_a_closed_way_is_walked_round_and_round() -> None:
    way = walk.along([(0, 0, 0), (160, 0, 0), (160, 160, 16), (0, 160, 0)], 64.0, is_closed=True)
    crowd = walker(way)
    lap = way.length / way.speed
    assert lap == pytest.approx(10.0)
    np.testing.assert_allclose(crowd.places(1.25)[0], [80, 0, 0, 0], atol=1e-6)
    np.testing.assert_allclose(crowd.places(3.75)[0], [160, 80, 8, 90], atol=1e-6)
    for seconds in (0.0, 3.1, 9.99):
        a, b = crowd.places(seconds)[0], crowd.places(seconds + 3 * lap)[0]
        np.testing.assert_allclose(a[:3], b[:3], atol=1e-6)
        assert (a[3] - b[3] + 180) % 360 == pytest.approx(180.0)
    times = np.arange(0, 2 * lap, 0.01)
    path = np.stack([crowd.places(t)[0] for t in times])
    turn = (np.diff(path[:, 3]) + 180) % 360 - 180
    assert np.abs(turn).max() < 2.5  # 24 units of a corner in 0.4 s, not at once
    step = np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1)
    assert step.max() <= 0.64 + 1e-6


def test_an_open_way_ends() -> None:
    crowd = walker(walk.along([(0, 0, 0), (0, -80, 40)], 40.0))
    np.testing.assert_allclose(crowd.places(1.0)[0], [0, -40, 20, -90], atol=1e-6)
    np.testing.assert_allclose(crowd.places(99.0)[0], [0, -80, 40, -90], atol=1e-6)
    np.testing.assert_allclose(crowd.places(-9.0)[0], [0, 0, 0, -90], atol=1e-6)


def test_a_way_there_and_back_has_headings() -> None:
    way = walk.along([(0, 0, 0), (400, 0, 0)], 40.0, is_closed=True)
    assert np.isfinite(way.places).all()
    assert np.abs(np.diff(way.places[:, 3])).max() <= 180 + 1e-6


@pytest.mark.parametrize("points", [[(0, 0, 0), (0, 0, 90)], [(1, 2, 3)], [(0, 0, 0), (1e7, 0, 0)]])
def test_ways_that_are_none(points: list[tuple[float, float, float]]) -> None:
    with pytest.raises(UsageError, match="a path of 1 to"):
        walk.along(points, 100.0)
