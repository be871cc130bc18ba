"""A fly-through that is found in the level alone.

Open space is looked at on a lattice of points with room around them; a tour of them passes spawn
points and open places. Its zigzag is made smooth, as far as the walls permit and away from them.
Along it the camera looks ahead, but aside where more is to be seen, and turns slowly.
"""

import math

import numpy as np

from followspot.arrays import Floats
from followspot.errors import UsageError
from followspot.scene import tour
from followspot.scene.gaze import Lookout
from followspot.scene.lattice import Lattice
from followspot.scene.open_space import OpenSpace
from followspot.scene.path import CameraPath, Key
from followspot.scene.scene import Scene
from followspot.scene.smooth_way import STEP, arc_lengths, at_arc, blurred_evenly, smoothed

MARGIN = 16.0
"""Units that the camera keeps from every wall, along each axis; from most, more (`smooth_way`)."""

SPEED = 256.0
"""Units a second: the game's players run at 320. Small levels are flown through more slowly."""

LONGEST = 120.0
"""Seconds of flight that are looked for; longer films fly more slowly."""

ACCELERATION = 250.0
"""Units per second squared that bends and braking before them are planned with, each by itself.
From one tenth of a second to the next it is at most twice as much, where the way turns back."""

_ZIGZAG = 1.6  # how much longer a tour is than the smooth way that it becomes, or more
_PASSED = 0.8  # seconds from a stop at which it counts as passed
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
    lookout, speed = Lookout(scene.level), _speed(lattice)
    length = _ZIGZAG * speed * min(seconds, LONGEST) + 4 * _LOOK_AHEAD
    curve = smoothed(space, tour.find(scene, lattice, lookout, length, speed * _PASSED))
    return _with_camera(lookout, space, curve, seconds, speed)


def _speed(lattice: Lattice) -> float:
    extent = np.cbrt(np.count_nonzero(lattice.open)) * lattice.spacing
    return min(SPEED, float(extent) / 2)


def _with_camera(
    lookout: Lookout, room: OpenSpace, curve: Floats, seconds: float, speed: float
) -> CameraPath:
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
    angles = lookout.directed(here, there - here, step)
    for blur, gap in _FINER_AND_FINER:
        times = np.linspace(0, seconds, max(2, math.ceil(seconds / gap) + 1))
        values = np.concatenate([blurred_evenly(here, blur / step), angles], axis=1)
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
