"""Fly-throughs that are found in levels: free of walls, smooth, and the same every time."""

import gc
import weakref
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import cast

import numpy as np
import pytest
from numpy.typing import NDArray

from followspot.assets.bsp import LUMPS
from followspot.errors import UsageError
from followspot.levelbuilder import (
    Level,
    Material,
    compile_level,
    material_files,
    room,
    write_pk3,
)
from followspot.scene import auto_path, bsp_tree, fog, gaze, smooth_way
from followspot.scene.fog import Fog
from followspot.scene.load import load, load_figure
from followspot.scene.open_space import OpenSpace
from followspot.scene.path import CameraPath
from followspot.scene.scene import Scene, spawn_cameras
from followspot.spaces import vec3
from synthetic import make_scene

SECONDS = 12.0
LEVELS = [
    "courtyard",
    *(
        pytest.param(name, marks=pytest.mark.openarena)
        for name in ("oa_dm5", "aggressor", "oa_rpg3dm2", "am_spacecont", "am_thornish")
    ),
]


@cache
def found(name: str) -> tuple[Scene, CameraPath]:
    scene = load(name)
    scene.archive.close()
    return scene, auto_path.find(scene, SECONDS)


def every(path: CameraPath, units: float) -> NDArray[np.float64]:
    """Places of the eye so near to each other."""
    times = np.linspace(0, path.seconds, 4000)
    positions = path.positions(times)
    assert np.linalg.norm(np.diff(positions, axis=0), axis=1).max() < units
    return positions


@pytest.mark.parametrize("name", LEVELS)
def test_no_wall_is_nearer_than_the_margin(name: str) -> None:
    """By lines from the eye to a cage around it, which neither end nor pass through a wall."""
    scene, path = found(name)
    eyes = every(path, 2.0)
    steps = np.linspace(-1, 1, 5) * auto_path.MARGIN * 0.999
    cage = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    cage = cage[np.abs(cage).max(axis=1) > auto_path.MARGIN * 0.9]
    start = np.repeat(eyes[::8], len(cage), axis=0)
    end = start + np.tile(cage, (len(eyes[::8]), 1))
    assert (bsp_tree.trace(scene.level.bsp, start, end) == 1).all()
    assert not bsp_tree.leaf_is_solid(scene.level.bsp)[
        bsp_tree.point_leafs(scene.level.bsp, eyes)
    ].any()


def touching(triangles: NDArray[np.float64], half: float) -> NDArray[np.bool_]:
    """(n,) whether triangles (n, 3, 3) reach into the cube of a half-size around the origin.

    They do unless a plane is between them, of which these are all that can be (Akenine-Moller,
    Fast 3D Triangle-Box Overlap Testing, 2001).
    """
    edges = np.roll(triangles, -1, axis=1) - triangles
    axes = np.concatenate(
        [
            np.broadcast_to(np.eye(3), triangles.shape),
            np.cross(edges[:, :1], edges[:, 1:2]),
            *(np.cross(edges, axis) for axis in np.eye(3)),
        ],
        axis=1,
    )
    along = axes @ triangles.transpose(0, 2, 1)
    reach = half * np.abs(axes).sum(axis=2)
    apart = (along.min(axis=2) > reach) | (along.max(axis=2) < -reach)
    return np.asarray(~apart.any(axis=1))


def test_touching_is_what_points_of_triangles_say() -> None:
    random = np.random.default_rng(4)
    triangles = random.uniform(-3, 3, (300, 3, 3))
    weights = random.dirichlet((0.5, 0.5, 0.5), 20_000)
    nearest = np.array([np.abs(weights @ each).max(axis=1).min() for each in triangles])
    clear = np.abs(nearest - 1) > 0.05  # points are as near to each other
    assert 0.2 < (nearest < 1).mean() < 0.8
    np.testing.assert_array_equal(touching(triangles, 1.0)[clear], (nearest < 1)[clear])


@pytest.mark.parametrize("name", LEVELS)
def test_nothing_drawn_is_at_the_eye(name: str) -> None:
    """Every opaque triangle keeps away, of patches, models and doors, too."""
    scene, path = found(name)
    mesh = scene.mesh
    opaque = np.array([m.blend is None for m in scene.materials])[mesh.faces["material"]]
    corners = np.repeat(opaque, mesh.faces["index_count"])
    points = mesh.vertices["position"][mesh.indices[corners]].astype(np.float64)
    triangles = points.reshape(-1, 3, 3)
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    for eye in every(path, 2.0)[::8]:
        near = ((low < eye + 12) & (high > eye - 12)).all(axis=1)
        assert not touching(triangles[near] - eye, 12).any()


@pytest.mark.parametrize("name", LEVELS)
def test_it_is_smooth(name: str) -> None:
    _, path = found(name)
    rate = 240
    times = np.linspace(0, SECONDS, int(SECONDS * rate) + 1)
    velocity = np.diff(path.positions(times), axis=0) * rate
    speed = np.linalg.norm(velocity, axis=1)
    assert speed.max() < auto_path.SPEED * 1.25
    turning = np.abs(np.diff(path.angles(times), axis=0)) * rate
    assert turning[:, :2].max() < gaze.MAX_TURN * 1.25
    assert np.allclose(path.angles(times)[:, 2], 90, atol=1e-9)
    assert path.seconds == SECONDS


@pytest.mark.parametrize("name", LEVELS)
def test_it_keeps_off_walls_where_it_can(name: str) -> None:
    """It comes near to them for moments, which narrow doors take."""
    scene, path = found(name)
    eyes = path.positions(np.linspace(0, SECONDS, 700))
    assert OpenSpace(scene.level, 32.0).is_free(eyes).mean() > 0.85


@pytest.mark.openarena
@pytest.mark.parametrize("name", ["oacmpdm9", "hydronex", "oa_koth1"])
def test_it_keeps_out_of_fog(name: str) -> None:
    """Those are pits, a pond and a sea of fog, with room in it for a flight."""
    scene, path = found(name)
    places = every(path, 8.0)
    assert len(scene.level.fogs) > 0
    for each in scene.level.fogs:
        assert not fog.holds(each, places).any()
    unaware = auto_path.find(replace(scene, level=replace(scene.level, fogs=())), SECONDS)
    assert name != "oacmpdm9" or fog.holds(scene.level.fogs[0], every(unaware, 8.0)).any()


def test_fog_that_players_begin_in_is_flown_through() -> None:
    scene, path = found("courtyard")
    mins, maxs = map(vec3, scene.bounds)
    everywhere = Fog(mins, maxs, np.ones(3), 0.001)
    level = replace(scene.level, fogs=(everywhere,))
    again = auto_path.find(replace(scene, level=level), SECONDS)
    assert again.keys[5].position.tolist() == path.keys[5].position.tolist()


@pytest.mark.parametrize("name", LEVELS)
def test_it_hardly_accelerates(name: str) -> None:
    """Over tenths of a second; where the way turns back, the camera does so at one moment."""
    scene, path = found(name)
    for tried in (path, auto_path.find(scene, 60.0)) if name == "aggressor" else (path,):
        times = np.arange(0, tried.seconds, 0.01)
        velocity = np.diff(tried.positions(times), axis=0) / 0.01
        acceleration = np.linalg.norm(velocity[10:] - velocity[:-10], axis=1) / 0.1
        assert acceleration.max() < 2 * auto_path.ACCELERATION
        assert np.quantile(acceleration, 0.95) < 1.5 * auto_path.ACCELERATION


@pytest.mark.parametrize("name", LEVELS)
def test_it_goes_somewhere(name: str) -> None:
    scene, path = found(name)
    positions = path.positions(np.linspace(0, SECONDS, 500))
    length = np.linalg.norm(np.diff(positions, axis=0), axis=1).sum()
    assert length > 60 * SECONDS
    eyes = np.array([c.position for c in spawn_cameras(scene.level.bsp).values()])
    nearest = np.linalg.norm(eyes[:, np.newaxis] - positions, axis=2).min(axis=1)
    assert (nearest < 250).sum() >= 1


def test_it_is_the_same_every_time() -> None:
    scene, path = found("courtyard")
    again = auto_path.find(scene, SECONDS)
    times = np.linspace(0, SECONDS, 100)
    assert np.array_equal(path.positions(times), again.positions(times))
    assert np.array_equal(path.angles(times), again.angles(times))


@pytest.mark.parametrize("seconds", [0.5, 300.0])
def test_short_and_long_films(seconds: float) -> None:
    scene, _ = found("courtyard")
    path = auto_path.find(scene, seconds)
    assert path.seconds == seconds
    times = np.linspace(0, seconds, 3000)
    assert OpenSpace(scene.level, auto_path.MARGIN - 0.1).is_free(path.positions(times)).all()


def test_a_level_without_room() -> None:
    """All of it is solid; there is nothing to fly through."""
    scene = make_scene([])
    world = np.zeros(1, LUMPS["models"])
    world["mins"], world["maxs"] = -200, 200
    level = replace(scene.level, bsp=replace(scene.level.bsp, models=world))
    with pytest.raises(UsageError, match="no room"):
        auto_path.find(replace(scene, level=level), 5.0)
    with pytest.raises(UsageError, match="a model alone"):
        auto_path.find(load_figure("models/robot/robot.md2"), 5.0)


def test_open_space_agrees_with_lines_through_it() -> None:
    """Where a box is free, lines from its middle to its corners and sides are."""
    scene, _ = found("courtyard")
    bsp = scene.level.bsp
    generator = np.random.default_rng(1)
    low, high = bsp.models["mins"][0], bsp.models["maxs"][0]
    places = generator.uniform(low, high, (4000, 3))
    half = 20.0
    free = OpenSpace(scene.level, half).is_free(places)
    assert 0.1 < free.mean() < 0.9
    ways = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]) * half
    start = np.repeat(places[free], len(ways), axis=0)
    end = start + np.tile(ways * 0.999, (int(free.sum()), 1))
    assert (bsp_tree.trace(bsp, start, end) == 1).all()
    in_wall = bsp_tree.leaf_is_solid(bsp)[bsp_tree.point_leafs(bsp, places)]
    assert not (free & in_wall).any()


@pytest.mark.parametrize(
    "name",
    [
        "courtyard",
        *(pytest.param(n, marks=pytest.mark.openarena) for n in ("suspended", "am_underworks2")),
    ],
)
def test_nothing_drawn_is_in_the_open(name: str) -> None:
    """Some levels draw floors on brushes that are not solid, and barrels that are no brushes."""
    level = load(name).level
    opaque = np.array([m.blend is None for m in level.materials])[level.mesh.faces["material"]]
    corners = level.mesh.indices[np.repeat(opaque, level.mesh.faces["index_count"])]
    triangles = level.mesh.vertices["position"][corners].reshape(-1, 3, 3)
    edges = np.linalg.norm(np.diff(triangles, axis=1, append=triangles[:, :1]), axis=2)
    world = level.bsp.models[0]
    inside = (triangles >= world["mins"]).all(axis=(1, 2)) & (triangles <= world["maxs"]).all(
        axis=(1, 2)
    )
    middles = triangles[inside & (edges.min(axis=1) > 8)].mean(axis=1)
    assert len(middles) > 1000
    assert not OpenSpace(level, 4.0).is_free(middles).any()


def small_room(folder: Path, half: int) -> Scene:
    """A room with one place to start from, and nothing else to fly to."""
    stone = Material("textures/x/stone", (8, 8), 1.0, image=np.full((8, 8, 3), 150, np.uint8))
    level = Level("small")
    level.add(room((-half, -half, 0), (half, half, 128), stone))
    level.spawn(0, 0, floor=0, angle=90)
    files = material_files("small", [stone]) | {"maps/small.bsp": compile_level(level)}
    write_pk3(folder / "small.pk3", files)
    return load(str(folder / "small.pk3"))


@pytest.mark.parametrize("half", [96, 112, 128])
def test_in_a_small_room_the_camera_looks_around(tmp_path: Path, half: int) -> None:
    scene = small_room(tmp_path, half)
    path = auto_path.find(scene, 5.0)
    scene.archive.close()
    room_ = OpenSpace(scene.level, auto_path.MARGIN)
    assert path.seconds == 5.0 and room_.is_free(path.positions(np.linspace(0, 5, 50))).all()


class Blocked:
    """Stands for open space: all of a line but one point of it and what is near to that."""

    def sized(self, _half: float) -> "Blocked":
        return self

    def is_free(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        return np.abs(points[:, 0] - 24) > 1


def test_a_way_that_is_blocked_near_its_end_is_smoothed_all_the_same() -> None:
    """A blur that turns its sign about the end does not count that point; it never ended."""
    line = np.array([(x, 0.0, 0.0) for x in np.arange(0, 400, 16.0)])
    found = smooth_way.smoothed(cast(OpenSpace, Blocked()), line)
    assert np.isfinite(found).all() and np.allclose(found[[0, -1]], line[[0, -1]], atol=24)


def test_a_level_that_was_flown_through_is_not_kept() -> None:
    scene = load("courtyard")
    scene.archive.close()
    auto_path.find(scene, 2.0)
    level = weakref.ref(scene.level)
    del scene
    gc.collect()
    assert level() is None
