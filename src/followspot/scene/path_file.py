"""The part of a scene file that says where the level is looked at from.

[cameras.start]
position = [0, -200, 60]
yaw = 90
pitch = 5                     # positive looks down

[paths.tour]                  # a camera in motion, for films
keys = [                      # each with yaw and pitch as above, or with look_at = [x, y, z]
    {time = 0, position = [0, -200, 60], yaw = 90},
    {time = 5, position = [200, 0, 60], look_at = [0, 0, 80], fov = 70},
]                             # without any time: at one speed, in this path's `seconds`

[paths.fly]
auto = true                   # found in the level
seconds = 20
"""

import itertools
import math
from typing import Annotated

import numpy as np
from msgspec import Meta

from followspot import spaces
from followspot.scene.camera import Camera
from followspot.scene.entry import Coordinate, Entry, Point
from followspot.scene.path import AutoPath, CameraPath, Key

Seconds = Annotated[float, Meta(ge=0, le=36000)]
_SHORTEST = 0.001
"""Seconds from one key to the next at least; for keys without times, units."""


class CameraEntry(Entry, frozen=True, kw_only=True):
    """A named view."""

    position: Point
    yaw: Coordinate = 0.0
    pitch: Annotated[float, Meta(ge=-90, le=90)] = 0.0
    fov: Annotated[float, Meta(ge=1, le=170)] = 90.0

    def camera(self, name: str) -> Camera:
        """The view itself."""
        return Camera(spaces.vec3(self.position), self.yaw, self.pitch, self.fov, name=name)


class KeyEntry(Entry, frozen=True, kw_only=True):
    """Where the camera of a path is at a time: with angles, or with a point that it looks at."""

    position: Point
    time: Seconds | None = None
    yaw: Coordinate | None = None
    pitch: Annotated[float, Meta(ge=-90, le=90)] | None = None
    look_at: Point | None = None
    fov: Annotated[float, Meta(ge=1, le=170)] = 90.0

    def __post_init__(self) -> None:
        if self.look_at is None:
            return
        if self.yaw is not None or self.pitch is not None:
            raise ValueError("Expected `look_at` or angles, got both")
        if self.look_at == self.position:
            raise ValueError("Expected a `look_at` away from `position`, got the same point")

    def key(self, time: float) -> Key:
        """The key itself, at a time in seconds."""
        yaw, pitch = self.yaw or 0.0, self.pitch or 0.0
        if self.look_at is not None:
            towards = spaces.vec3(np.subtract(self.look_at, self.position))
            yaw, pitch = spaces.angles_from_forward(towards)
        return Key(time, spaces.vec3(self.position), yaw, pitch, self.fov)


class PathEntry(Entry, frozen=True, kw_only=True):
    """A named path: either keys or one that is found in the level."""

    keys: tuple[KeyEntry, ...] = ()
    auto: bool = False
    seconds: Annotated[float, Meta(ge=0.1, le=36000)] | None = None

    def __post_init__(self) -> None:
        if self.auto == bool(self.keys):
            found = "both" if self.auto else "neither"
            raise ValueError(f"Expected either `keys` or `auto = true`, got {found}")
        if len(self.keys) == 1:
            raise ValueError("Expected two `keys` or more, got one")
        times = [key.time for key in self.keys if key.time is not None]
        if times and self.seconds is not None:
            raise ValueError("Expected `seconds` or times in the keys, got both")
        if times and len(times) < len(self.keys):
            raise ValueError("Expected a time in all `keys` or in none, got some")
        for number, (key, after) in enumerate(itertools.pairwise(self.keys), 1):
            if times and times[number] - times[number - 1] < _SHORTEST:
                raise ValueError(
                    f"Expected `keys[{number}].time` at least {_SHORTEST} s after "
                    f"{times[number - 1]:g}, got {times[number]:g}"
                )
            if not times and math.dist(key.position, after.position) < _SHORTEST:
                raise ValueError(
                    f"Expected `keys[{number}]` without a time away from the one before, "
                    "got the same place"
                )

    def path(self) -> CameraPath | AutoPath:
        """The path itself."""
        if self.auto:
            return AutoPath() if self.seconds is None else AutoPath(self.seconds)
        timed = all(key.time is not None for key in self.keys)
        keys = (
            key.key(number if key.time is None else key.time)
            for number, key in enumerate(self.keys)
        )
        path = CameraPath(tuple(keys))
        return path if timed else path.at_one_speed(self.seconds or AutoPath().seconds)
