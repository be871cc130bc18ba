"""Flights look at the level, not into the sky nor at walls near by, and turn slowly."""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.scene import auto_path, bsp_tree, gaze
from followspot.scene.gaze import Lookout
from followspot.scene.load import load
from followspot.scene.path import CameraPath
from followspot.scene.scene import Scene
from followspot.scene.triangle_tree import TriangleTree
from synthetic import Piece, floor, make_scene, quad, rays

SECONDS = 20.0
STEP = 0.05
REACH = 8192.0


@dataclass(frozen=True)
class Bounds:
    """Shares of a flight's moments at which most of the picture may be sky, or a wall near by."""

    sky: float = 0.0
    wall: float = 0.0


LEVELS = {
    "courtyard": Bounds(),
    "oa_dm1": Bounds(wall=0.12),
    "oa_dm5": Bounds(wall=0.12),
    "oa_dm7": Bounds(wall=0.04),
    "ctf_inyard": Bounds(wall=0.04),
    "islanddm": Bounds(),
    "oa_ctf2": Bounds(sky=0.04),
    "suspended": Bounds(wall=0.04),
    "delta": Bounds(sky=0.2),  # platforms in space, with ends
    "oa_dm4": Bounds(wall=0.5),  # narrow ways
}
EVERY = [
    pytest.param(name, marks=[pytest.mark.openarena] if name != "courtyard" else [])
    for name in LEVELS
]


@cache
def found(name: str) -> tuple[Scene, CameraPath]:
    scene = load(name)
    scene.archive.close()
    return scene, auto_path.find(scene, SECONDS)


def seen(scene: Scene, path: CameraPath) -> Floats:
    """(moments, rays) how far away is what a picture of 12 x 9 pixels shows; the sky is at inf."""
    opaque = np.array([m.blend is None for m in scene.materials])[scene.mesh.faces["material"]]
    tree = TriangleTree(scene.mesh, np.repeat(opaque, scene.mesh.faces["index_count"] // 3))
    cameras = [path.camera(time) for time in np.arange(0, path.seconds, 0.25)]
    ways = np.array([rays(camera, (12, 9)).reshape(-1, 3) for camera in cameras])
    ways *= REACH / np.linalg.norm(ways, axis=2, keepdims=True)
    start = np.repeat([camera.position for camera in cameras], ways.shape[1], axis=0)
    end = start + ways.reshape(-1, 3)
    wall = bsp_tree.trace(scene.level.bsp, start, end)
    surface = tree.first_hits(start, end)
    is_sky = (surface == 1) | (surface > wall + 16 / REACH)
    distance = np.where(is_sky, np.inf, np.minimum(surface, wall) * REACH)
    return distance.reshape(ways.shape[:2])


def angles(path: CameraPath) -> NDArray[np.float64]:
    """(moments, 2) yaw and pitch, STEP apart."""
    return path.angles(np.arange(0, path.seconds, STEP))[:, :2]


@pytest.mark.parametrize("name", EVERY)
def test_flights_show_the_level(name: str) -> None:
    scene, path = found(name)
    distance = seen(scene, path)
    sky = np.isinf(distance).mean(axis=1)
    assert (sky > 0.7).mean() <= LEVELS[name].sky
    assert (np.median(distance, axis=1) < 128).mean() <= LEVELS[name].wall
    assert sky[0] < 0.7 and np.median(distance[0]) > 128  # films are known by how they begin


@pytest.mark.parametrize("name", EVERY)
def test_flights_turn_slowly_and_without_jerks(name: str) -> None:
    _, path = found(name)
    turning = np.diff(angles(path), axis=0) / STEP
    assert np.abs(turning).max() < 1.1 * gaze.MAX_TURN
    assert np.abs(turning[2:] - turning[:-2]).max() / (2 * STEP) < 100
    low, high = gaze.PITCHES
    assert angles(path)[:, 1].min() >= low - 1 and angles(path)[:, 1].max() <= high + 1


@pytest.mark.parametrize("name", EVERY)
def test_flights_mostly_look_where_they_go(name: str) -> None:
    _, path = found(name)
    way = np.diff(path.positions(np.arange(0, path.seconds, STEP)), axis=0)
    yaw = np.radians(angles(path)[:-1, 0])
    ahead = np.cos(np.arctan2(way[:, 1], way[:, 0]) - yaw)
    assert np.median(ahead) > 0.7 and (ahead > 0).mean() > 0.8


def lookout(*pieces: Piece) -> Lookout:
    """In a level without walls, where whatever is not drawn is sky."""
    level = make_scene(pieces).level
    level.bsp.leafs["cluster"] = 0
    return Lookout(level)


def along_x(seconds: float = 10.0) -> tuple[Floats, Floats]:
    """Places of a camera that flies along x, and which way it goes."""
    eyes = np.linspace((-800.0, 0, 60), (800, 0, 60), round(seconds / STEP))
    return eyes, np.tile((1.0, 0, 0), (len(eyes), 1))


def test_over_a_wide_floor_it_looks_ahead() -> None:
    yaw, pitch = lookout(floor(4000)).directed(*along_x(), STEP).T
    assert np.abs(yaw).max() < 1e-9 and (pitch > 0).all()


@pytest.mark.parametrize("side", [1, -1])
def test_it_looks_to_the_side_where_there_is_something(side: int) -> None:
    """Along the edge of a floor, whose other side is space."""
    half = quad((0, side * 1000, 0), (4000, 0, 0), (0, 1000, 0))
    yaw = np.radians(lookout(half).directed(*along_x(), STEP)[:, 0])
    assert (side * np.sin(yaw) > 0.2).all() and (np.cos(yaw) > 0).all()


def test_a_wall_near_by_is_no_sight() -> None:
    """Beside a wall the camera looks away from it."""
    near = quad((0, 24, 0), (4000, 0, 0), (0, 0, 4000))
    yaw = np.radians(lookout(near, floor(4000)).directed(*along_x(), STEP)[:, 0])
    assert (np.sin(yaw) < -0.2).all() and (np.cos(yaw) > 0).all()


def test_what_is_seen_decides_between_places() -> None:
    view = lookout(floor(500), quad((3000, 0, 0), (50, 0, 0), (0, 50, 0)))
    best = view.best_view(np.array([(-400.0, 0, 100), (3000, 0, 100), (0, 3000, 100)]))
    assert best[0] > best[1] > best[2] > 0


def test_who_goes_nowhere_looks_around() -> None:
    eyes = np.zeros((100, 3))
    yaw, pitch = lookout(floor()).directed(eyes, np.zeros_like(eyes), STEP).T
    assert np.allclose(np.diff(yaw), gaze.MAX_TURN / 2 * STEP) and not pitch.any()


@pytest.mark.parametrize("seconds", [0.1, 0.7, 400.0])
def test_short_and_long_ways(seconds: float) -> None:
    found = lookout(floor()).directed(*along_x(seconds), STEP)
    assert found.shape == (round(seconds / STEP), 2) and np.isfinite(found).all()
