"""Camera paths: a few keys in, a camera for every moment out.

The position follows a centripetal Catmull-Rom curve through the keys (Catmull and Rom, A Class of
Local Interpolating Splines, 1974; the centripetal parameter, which makes neither cusps nor loops
within a piece, after Lee 1989 and Yuksel et al. 2011). How far along the curve the camera is at
a time is a smooth monotone function through the keys' own times and arc lengths, so that speed
does not depend on how the curve is parametrised. Angles go the same smooth way from key to key,
yaw by the shorter turn; there is no roll.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot import spaces
from followspot.arrays import Floats
from followspot.scene.camera import Camera
from followspot.spaces import Vec3

SUBSTEPS = 64
"""Chords between two keys that its arc length is measured by."""

_NO_STEP = 1e-9  # of the curve's parameter, between keys at one place


@dataclass(frozen=True, eq=False)
class Key:
    """Where the camera is at a time.

    Attributes:
        time: Seconds since the start.
        position: (3,) eye in world space, Quake units; any three numbers are taken.
        yaw: Degrees, counter-clockwise from +X.
        pitch: Degrees, positive looks down.
        fov: Horizontal angle of view in degrees.
    """

    time: float
    position: Vec3
    yaw: float = 0.0
    pitch: float = 0.0
    fov: float = 90.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", spaces.vec3(self.position))


@dataclass(frozen=True)
class AutoPath:
    """A fly-through that is still to be found in the level; see `auto_path`.

    Attributes:
        seconds: How long it takes.
    """

    seconds: float = 20.0


@dataclass(frozen=True, eq=False)
class CameraPath:
    """A camera in motion.

    Attributes:
        keys: One or more, each later than the one before. The camera stands still before the
            first one and after the last.
    """

    keys: tuple[Key, ...]

    def __post_init__(self) -> None:
        times = [key.time for key in self.keys]
        if not times or any(after <= time for time, after in pairwise(times)):
            raise ValueError(f"a path needs keys of increasing times, not {times}")

    @property
    def seconds(self) -> float:
        """Time of the last key."""
        return self.keys[-1].time

    def lasting(self, seconds: float) -> "CameraPath":
        """The same way, faster or slower, so that its last key has this time.

        With one key, which is no way, it stays as it is.
        """
        if len(self.keys) == 1:
            return self
        scale = seconds / self.seconds
        return CameraPath(tuple(replace(key, time=key.time * scale) for key in self.keys))

    def at_one_speed(self, seconds: float) -> "CameraPath":
        """The same way in so many seconds, the keys' times being what its length makes them.

        With one key, which is no way, it stays as it is.

        Raises:
            ValueError: two neighbouring keys are at one place.
        """
        if len(self.keys) == 1:
            return self
        arc = self._arc[::SUBSTEPS] / self._arc[-1]
        pairs = zip(self.keys, arc.tolist(), strict=True)
        return CameraPath(tuple(replace(key, time=share * seconds) for key, share in pairs))

    def camera(self, time: float) -> Camera:
        """The camera at a time in seconds."""
        at = np.array([time])
        yaw, pitch, fov = self.angles(at)[0].tolist()
        return Camera(spaces.vec3(self.positions(at)[0]), yaw, pitch, fov)

    def positions(self, times: NDArray[np.floating[Any]]) -> Floats:
        """(n, 3) world places of the eye at (n,) seconds."""
        if len(self.keys) == 1:
            return np.repeat(self.keys[0].position[np.newaxis], len(times), axis=0)
        arc = _smooth(self._times, self._arc[::SUBSTEPS, np.newaxis], times)[:, 0]
        places = np.arange(len(self._arc)) / SUBSTEPS
        return self._on_curve(np.asarray(np.interp(arc, self._arc, places)))

    def angles(self, times: NDArray[np.floating[Any]]) -> Floats:
        """(n, 3) yaw, pitch and horizontal angle of view in degrees at (n,) seconds."""
        return _smooth(self._times, self._angles, times)

    @cached_property
    def _times(self) -> Floats:
        return np.array([key.time for key in self.keys], np.float64)

    @cached_property
    def _places(self) -> Floats:
        return np.array([key.position for key in self.keys])

    @cached_property
    def _angles(self) -> Floats:
        angles = np.array([(key.yaw, key.pitch, key.fov) for key in self.keys], np.float64)
        angles[:, 0] = np.unwrap(angles[:, 0], period=360)
        return angles

    @cached_property
    def _steps(self) -> Floats:
        """(keys - 1,) of the curve's parameter: square roots of the chords."""
        chords = np.linalg.norm(np.diff(self._places, axis=0), axis=1)
        return np.asarray(np.maximum(np.sqrt(chords), _NO_STEP))

    @cached_property
    def _tangents(self) -> Floats:
        """(keys, 3) by the curve's parameter; that of the chord at either end."""
        steps = self._steps[:, np.newaxis]
        slopes = np.diff(self._places, axis=0) / steps
        across = (self._places[2:] - self._places[:-2]) / (steps[:-1] + steps[1:])
        inner = slopes[:-1] - across + slopes[1:]
        return np.asarray(np.concatenate([slopes[:1], inner, slopes[-1:]]))

    def _on_curve(self, place: Floats) -> Floats:
        """(n, 3) points of the curve; place 2.5 is half the parameter from key 2 to key 3."""
        piece = np.minimum(place.astype(np.int64), len(self.keys) - 2)
        step = self._steps[piece, np.newaxis]
        return _hermite(
            (place - piece)[:, np.newaxis],
            self._places[piece],
            self._places[piece + 1],
            self._tangents[piece] * step,
            self._tangents[piece + 1] * step,
        )

    @cached_property
    def _arc(self) -> Floats:
        """(pieces * SUBSTEPS + 1,) arc length in units up to every substep."""
        pieces = len(self.keys) - 1
        points = self._on_curve(np.arange(pieces * SUBSTEPS + 1) / SUBSTEPS)
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def _hermite(
    u: Floats, start: Floats, end: Floats, start_slope: Floats, end_slope: Floats
) -> Floats:
    """Cubic with given ends and slopes at u in [0, 1]; exactly `start` at 0, `end` at 1."""
    v = 1 - u
    return (
        v * v * (1 + 2 * u) * start
        + u * u * (1 + 2 * v) * end
        + u * v * (v * start_slope - u * end_slope)
    )


def _smooth(x: Floats, y: Floats, at: NDArray[np.floating[Any]]) -> Floats:
    """(n, c) values between (k, c) given ones: C1, and monotone wherever those are.

    The slopes are weighted harmonic means of the neighbouring chords' (Fritsch and Butland, A
    Method for Constructing Local Monotone Piecewise Cubic Interpolants, 1984). Constant outside
    of `x`.
    """
    if len(x) == 1:
        return np.repeat(y, len(at), axis=0)
    width = np.diff(x)[:, np.newaxis]
    chord = np.diff(y, axis=0) / width
    before, after = chord[:-1], chord[1:]
    agree = before * after > 0
    first, second = 2 * width[1:] + width[:-1], width[1:] + 2 * width[:-1]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        mean = (first + second) / (first / before + second / after)
    slope = np.concatenate([chord[:1], np.where(agree, mean, 0.0), chord[-1:]])

    at = np.clip(np.asarray(at, np.float64), x[0], x[-1])
    piece = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    step = width[piece]
    u = (at - x[piece])[:, np.newaxis] / step
    return _hermite(u, y[piece], y[piece + 1], slope[piece] * step, slope[piece + 1] * step)
