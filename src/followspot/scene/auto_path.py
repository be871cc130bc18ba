"""A fly-through that is found in the level alone.

Open space is looked at on a lattice of points with room around them. A tour goes from stop to stop,
which are spawn points and open places, through the lattice's largest part: always on to the nearest
stop that has not been passed, preferably by ways not yet gone. Its zigzag is then made smooth, as
far as the walls permit and away from them, and the camera looks ahead along it, turning slowly.
"""

import math

import numpy as np

from followspot.arrays import Floats
from followspot.errors import UsageError
from followspot.scene.lattice import Lattice
from followspot.scene.open_space import OpenSpace
from followspot.scene.path import CameraPath, Key
from followspot.scene.scene import Scene, spawn_cameras
from followspot.scene.smooth_way import STEP, arc_lengths, at_arc, smoothed

MARGIN = 16.0
"""Units that the camera keeps from every wall, along each axis; from most, more (`smooth_way`)."""

SPEED = 256.0
"""Units a second: the game's players run at 320. Small levels are flown through more slowly."""

MAX_TURN = 50.0
"""Degrees a second that the camera turns at most, as long as its path lets it."""

LONGEST = 120.0
"""Seconds of flight that are looked for; longer films fly more slowly."""

ACCELERATION = 250.0
"""Units per second squared that bends and braking before them are planned with, each by itself.
From one tenth of a second to the next it is at most twice as much, where the way turns back."""

_LOOK_AHEAD = 220.0  # units
_RATE = 120  # looks a second at where the camera is
_FINER_AND_FINER = ((0.25, 0.1), (0.15, 0.1), (0.1, 0.1), (0.03, 0.1), (0.01, 0.05))
"""Seconds that a place is blurred over, and from key to key: the first that keeps the margin."""


def find(scene: Scene, seconds: float) -> CameraPath:
    """A path of a given duration; always the same for the same level.

    Raises:
        UsageError: the level has no room for a camera, or the scene has no level.
    """
    if not len(scene.level.bsp.models):
        raise UsageError(f"{scene.name}: expected a level to fly through, found a model alone")
    space = OpenSpace(scene.level, MARGIN)
    lattice = Lattice.of(scene.level, space)
    curve = smoothed(space, _tour(lattice, *_stops(scene, lattice), seconds))
    return _with_camera(space, curve, seconds, _speed(lattice))


def _speed(lattice: Lattice) -> float:
    extent = np.cbrt(np.count_nonzero(lattice.open)) * lattice.spacing
    return min(SPEED, float(extent) / 2)


def _passed_from(lattice: Lattice) -> float:
    """Units from which a stop counts as passed."""
    return 200.0 * _speed(lattice) / SPEED


def _stops(scene: Scene, lattice: Lattice) -> tuple[list[int], int]:
    """Lattice points to pass, spawn points and open places far from all others; where to begin.

    Raises:
        UsageError: there is not one.
    """
    eyes = [camera.position for camera in spawn_cameras(scene.level.bsp).values()]
    snapped = [lattice.nearest(eye, 160.0) for eye in eyes]
    stops = list(dict.fromkeys(cell for cell in snapped if cell is not None))
    clearance = lattice.clearance(4)
    low = lattice.grown(lattice.open & ~np.roll(lattice.open, -lattice.steps[5]), 4)
    candidates = np.flatnonzero((clearance >= min(3, clearance.max(initial=0))) & low)
    if not stops and not len(candidates):
        raise UsageError(f"{scene.name}: no room for a camera to fly through; give it a path")
    spawns = len(stops)
    stops = stops or [int(candidates[0])]
    places = lattice.points(candidates)
    distance = np.full(len(candidates), np.inf)
    for stop in stops:
        near = np.linalg.norm(places - lattice.points(np.array([stop])), axis=1)
        distance = np.minimum(distance, near)
    for _ in range(12):
        if not len(candidates) or distance.max() < 2 * _passed_from(lattice):
            break
        farthest = int(distance.argmax())
        stops.append(int(candidates[farthest]))
        distance = np.minimum(distance, np.linalg.norm(places - places[farthest], axis=1))
    return stops, max(stops[: max(spawns, 1)], key=lambda cell: clearance[cell])


def _tour(lattice: Lattice, stops: list[int], start: int, seconds: float) -> Floats:
    """(n, 3) lattice points on the way from stop to stop, long enough for the film."""
    wanted = 2 * _speed(lattice) * min(seconds, LONGEST) + 4 * _LOOK_AHEAD
    cost = np.where(lattice.open, 5 - lattice.clearance(4), 0)
    places = lattice.points(np.array(stops))
    passed = np.array(stops) == start
    route = [start]
    trodden = np.zeros_like(lattice.open)
    while len(route) * lattice.spacing < wanted and len(stops) > 1:
        if passed.all():
            passed = np.array(stops) == route[-1]
            trodden[:] = False
        leg = lattice.way(cost + 6 * trodden * lattice.open, route[-1], np.array(stops)[~passed])
        route += leg[1:]
        on_leg = np.zeros_like(lattice.open)
        on_leg[leg] = True
        trodden |= lattice.grown(on_leg, 3)
        apart = np.linalg.norm(places[:, np.newaxis] - lattice.points(np.array(leg)), axis=2)
        passed |= apart.min(axis=1) < _passed_from(lattice)
        passed[stops.index(leg[-1])] = True
    return lattice.points(np.array(route))


def _with_camera(room: OpenSpace, curve: Floats, seconds: float, speed: float) -> CameraPath:
    """A path along a curve, with keys as close as it takes to keep the margin."""
    total = float(arc_lengths(curve)[-1])
    moments = _moments(curve, speed)
    duration = min(seconds, float(moments[-1]))
    lengths = arc_lengths(curve)

    def arc(times: Floats) -> Floats:
        return np.asarray(np.interp(times / seconds * duration, moments, lengths))

    fine = np.linspace(0, seconds, max(2, math.ceil(seconds * _RATE) + 1))
    step = seconds / (len(fine) - 1)
    here, there = (at_arc(curve, arc(fine) + shift) for shift in (0.0, min(_LOOK_AHEAD, total / 4)))
    angles = _turned_slowly(there - here, step)
    for blur, gap in _FINER_AND_FINER:
        times = np.linspace(0, seconds, max(2, math.ceil(seconds / gap) + 1))
        values = np.concatenate([_blurred_flat(here, blur / step), angles], axis=1)
        x, y, z, yaw, pitch = (np.interp(times, fine, column) for column in values.T)
        keys = zip(
            times.tolist(), np.stack([x, y, z], axis=1), yaw.tolist(), pitch.tolist(), strict=True
        )
        path = CameraPath(tuple(Key(*key) for key in keys))
        if room.is_free(path.positions(fine)).all():
            break
    return path


def _moments(curve: Floats, speed: float) -> Floats:
    """(n,) seconds at which the camera is at each point of a curve: slower where it bends.

    The sideways acceleration that a bend asks for is bounded, and so is braking before it.
    """
    step = np.diff(arc_lengths(curve))
    reach = round(24 / STEP)  # points on either side that a bend is measured over
    padded = np.pad(curve, ((reach, reach), (0, 0)), mode="edge")
    bend = np.linalg.norm(padded[2 * reach :] - 2 * curve + padded[: -2 * reach], axis=1)
    bend[:reach] = bend[len(bend) - reach :] = 0
    curvature = bend / (reach * STEP) ** 2
    limit = np.minimum(speed, np.sqrt(ACCELERATION / np.maximum(curvature, 1e-9)))
    # The fastest that brakes in time for what is ahead: v^2 = u^2 + 2 a s, both ways.
    squares = limit**2 / (2 * ACCELERATION)
    along = np.concatenate([[0.0], np.cumsum(step)])
    squares = np.minimum.accumulate(squares - along) + along
    squares = (np.minimum.accumulate((squares + along)[::-1]))[::-1] - along
    pace = np.sqrt(squares * 2 * ACCELERATION)
    return np.concatenate([[0.0], np.cumsum(2 * step / (pace[1:] + pace[:-1]))])


def _turned_slowly(direction: Floats, step: float) -> Floats:
    """(n, 2) yaw and pitch in degrees that follow directions, `step` seconds apart, smoothly."""
    flat = np.hypot(direction[:, 0], direction[:, 1])
    if not flat.any():  # no way to go: the camera looks around
        yaw = MAX_TURN / 2 * step * np.arange(len(direction))
        return np.stack([yaw, np.zeros_like(yaw)], axis=1)
    yaw = np.unwrap(np.degrees(np.arctan2(direction[:, 1], direction[:, 0])), period=360)
    pitch = np.clip(-0.7 * np.degrees(np.arctan2(direction[:, 2], flat)), -25, 25)
    angles = np.stack([yaw, pitch], axis=1)
    for width in 0.5 * 1.3 ** np.arange(10):  # seconds
        turned = _blurred_flat(angles, width / step)
        if np.abs(np.diff(turned, axis=0)).max(initial=0) <= MAX_TURN * step:
            break
    return turned


def _blurred_flat(values: Floats, width: float) -> Floats:
    """(n, c) values under one Gaussian; beyond the ends they go on as they came."""
    reach = math.ceil(3 * width)
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    columns = [np.convolve(column, weight / weight.sum(), mode="valid") for column in padded.T]
    return np.stack(columns, axis=1)
