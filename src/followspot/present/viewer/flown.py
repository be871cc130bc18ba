"""A flight as a path: of all its moments, the few through which a path's curve follows it."""

import numpy as np

from followspot.arrays import Floats
from followspot.scene.camera import Camera
from followspot.scene.path import CameraPath, Key
from followspot.spaces import vec3

UNITS, DEGREES = 1.0, 0.5
"""How far the path may be from the flight, in place and in each angle."""

SHORTEST = 0.002
"""Seconds between two keys: more than a scene file asks for."""

_PLACE_DECIMALS, _TIME_DECIMALS = 3, 4


class Flown:
    """The cameras of a flight, gathered frame by frame.

    Attributes:
        seconds: Since the first frame.
    """

    def __init__(self) -> None:
        self._moments: list[tuple[float, ...]] = []
        self.seconds = 0.0

    def add(self, seconds: float, camera: Camera) -> None:
        """Remember a camera, so many seconds after the one before."""
        self.seconds += seconds if self._moments else 0.0
        if not self._moments or self.seconds >= self._moments[-1][0] + SHORTEST:
            place = camera.position.tolist()
            self._moments.append((self.seconds, *place, camera.yaw, camera.pitch, camera.fov))

    def path(self) -> CameraPath | None:
        """A path that follows the flight; none if that had no length."""
        return thinned(np.array(self._moments)) if len(self._moments) > 1 else None


def thinned(moments: Floats) -> CameraPath:
    """A path of few keys that is at every moment where a flight was.

    Keys are put where the path is farthest off, one a gap, until it is nowhere farther off than
    `UNITS` and `DEGREES` (as Douglas and Peucker, Algorithms for the Reduction of the Number of
    Points Required to Represent a Digitized Line, 1973, do with straight lines).

    Args:
        moments: (n, 7) time in seconds, x, y, z in units, yaw, pitch and angle of view in degrees;
            two or more, each at least `SHORTEST` later than the one before.
    """
    moments = moments.copy()
    moments[:, 0] = np.round(moments[:, 0] - moments[0, 0], _TIME_DECIMALS)
    moments[:, 1:] = np.round(moments[:, 1:], _PLACE_DECIMALS)
    chosen = np.array([0, len(moments) - 1])
    while True:
        path = CameraPath(tuple(_key(row) for row in moments[chosen].tolist()))
        off = _distance(path, moments)
        off[chosen] = 0.0
        gaps = np.split(off, chosen[1:-1])
        farthest = np.array([gap.argmax() for gap in gaps]) + chosen[:-1]
        new = farthest[off[farthest] > 1]
        if not len(new):
            return path
        chosen = np.union1d(chosen, new)


def _key(moment: list[float]) -> Key:
    time, x, y, z, yaw, pitch, fov = moment
    return Key(time, vec3((x, y, z)), yaw, pitch, fov)


def _distance(path: CameraPath, moments: Floats) -> Floats:
    """(n,) how far the path is off at each moment, as a share of what is allowed."""
    times = moments[:, 0]
    units = np.linalg.norm(path.positions(times) - moments[:, 1:4], axis=1)
    turned = path.angles(times) - moments[:, 4:]
    turned[:, 0] = (turned[:, 0] + 180) % 360 - 180
    return np.asarray(np.maximum(units / UNITS, np.abs(turned).max(axis=1) / DEGREES))
