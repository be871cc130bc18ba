"""The part of a scene file that lights the level.

[[lights]]
name = "sun"                  # which the window lists it by
type = "spot"                 # or "point", which has neither direction nor angle
position = [0, 0, 400]        # Quake units
target = [0, 0, 0]            # or direction = [x, y, z]
half_angle_degrees = 30
power = 5000                  # W, or [red, green, blue]
softness = 0.2
casts_shadow = true
"""

import math
from typing import Annotated

import numpy as np
from msgspec import Meta

from followspot import spaces
from followspot.scene.entry import Entry, Point, require_one
from followspot.scene.light import Light, PointLight, SpotLight
from followspot.spaces import Vec3

MAX_POWER = 1e15
"""Watts of a channel."""


class PointEntry(Entry, tag="point", frozen=True, kw_only=True):
    """A light without direction."""

    position: Point
    power: float | list[float]
    casts_shadow: bool = True
    name: str = ""

    def __post_init__(self) -> None:
        _per_channel(self.power)

    def light(self) -> Light:
        """The light itself."""
        return PointLight(
            spaces.vec3(self.position),
            _per_channel(self.power),
            casts_shadow=self.casts_shadow,
            name=self.name,
        )


class SpotEntry(Entry, tag="spot", frozen=True, kw_only=True):
    """A light with a cone; exactly one of `direction` and `target` is given."""

    position: Point
    power: float | list[float]
    half_angle_degrees: Annotated[float, Meta(ge=0.01, lt=90)]
    direction: Point | None = None
    target: Point | None = None
    softness: Annotated[float, Meta(ge=0, le=1)] = 0.0
    casts_shadow: bool = True
    name: str = ""

    def __post_init__(self) -> None:
        _per_channel(self.power)
        require_one(direction=self.direction, target=self.target)
        if not np.linalg.norm(self._axis()) > 0:
            raise ValueError("Expected a direction or target that tells a direction, got none")

    def _axis(self) -> Vec3:
        if self.direction is not None:
            return spaces.vec3(self.direction)
        return spaces.vec3(np.subtract(self.target or (0, 0, 0), self.position))

    def light(self) -> Light:
        """The light itself."""
        return SpotLight(
            spaces.vec3(self.position),
            spaces.normalised(self._axis()),
            math.radians(self.half_angle_degrees),
            _per_channel(self.power),
            softness=self.softness,
            casts_shadow=self.casts_shadow,
            name=self.name,
        )


def _per_channel(power: float | list[float]) -> Vec3:
    """Watts per RGB channel from one number or three; a ValueError tells what is wrong."""
    channels = power if isinstance(power, list) else [power] * 3
    if len(channels) != 3 or not all(0 <= channel <= MAX_POWER for channel in channels):
        raise ValueError(
            f"power: Expected one number or three, in watts, each from 0 to {MAX_POWER:g}"
        )
    return spaces.vec3(channels)
