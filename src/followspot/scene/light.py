"""Lights as physics has them: power in watts, intensity in watts per steradian.

A light of radiant intensity I (W/sr) gives a surface at r metres under the angle theta
the irradiance E = I cos(theta) / r^2 (W/m^2); a Lambertian surface of reflectance rho
then shows the radiance L = rho E / pi. See Pharr, Jakob, Humphreys, Physically Based
Rendering, 4th ed., 4.1 (radiometry) and 12.1-12.2 (point and spot lights).
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from followspot import spaces
from followspot.errors import UsageError
from followspot.spaces import Vec3


@dataclass(frozen=True, eq=False)
class PointLight:
    """Shines alike in all directions.

    Attributes:
        position: (3,) world space, Quake units.
        power: (3,) radiant power per RGB channel in W, over the whole sphere.
        casts_shadow: Whether the light has shadow maps.

    Both vectors may be given as any sequence of three numbers.

    Raises:
        UsageError: a number is none, or no power.
    """

    position: Vec3
    power: Vec3
    casts_shadow: bool = True
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", spaces.vec3(self.position))
        object.__setattr__(self, "power", spaces.vec3(self.power))
        _check(self.position, self.power)

    @cached_property
    def sides(self) -> tuple["CubeSide", ...]:
        """What its shadow maps look into: +X, -X, +Y, -Y, +Z, -Z, the same objects every time."""
        return tuple(
            CubeSide(
                self.position,
                axis * sign + 0.0,  # no -0, which would turn the lower side round
                math.pi / 4,
                self.power / 6,
                name=self.name,
            )
            for axis in np.eye(3)
            for sign in (1, -1)
        )

    @property
    def intensity(self) -> Vec3:
        """(3,) W/sr: power over the sphere's 4 pi steradians."""
        return self.power / (4 * math.pi)


@dataclass(frozen=True, eq=False)
class SpotLight:
    """Shines into a cone, evenly but for a soft rim.

    Attributes:
        position: (3,) apex in world space, Quake units.
        direction: (3,) unit axis in world space, pointing away from the light.
        half_angle: Radians between axis and rim, in (0, pi/2).
        power: (3,) radiant power per RGB channel in W, all of it inside the cone.
        softness: Share in [0, 1] of the half-angle over which the rim fades to nothing; 0 is
            a hard rim.
        casts_shadow: Whether the light has a shadow map.

    The vectors may be given as any sequences of three numbers; the direction, which must not be
    zero, is normalised.

    Raises:
        UsageError: a number is none or outside of what it can be.
    """

    position: Vec3
    direction: Vec3
    half_angle: float
    power: Vec3
    softness: float = 0.0
    casts_shadow: bool = True
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", spaces.vec3(self.position))
        object.__setattr__(self, "power", spaces.vec3(self.power))
        _check(self.position, self.power)
        direction = spaces.vec3(self.direction)
        if not 0 < np.linalg.norm(direction) < math.inf:
            raise UsageError(f"a light: expected a direction, found {direction.tolist()}")
        object.__setattr__(self, "direction", spaces.normalised(direction))
        if not 0 < self.half_angle < math.pi / 2:
            expected = "a half-angle between 0 and pi/2 radians"
            raise UsageError(f"a light: expected {expected}, found {self.half_angle}")
        if not 0 <= self.softness <= 1:
            raise UsageError(f"a light: expected a softness of 0 to 1, found {self.softness}")

    @property
    def cos_rim(self) -> float:
        """Cosine of the angle at which the light ends."""
        return math.cos(self.half_angle)

    @property
    def cos_full(self) -> float:
        """Cosine of the angle up to which the light has its full intensity."""
        return math.cos(self.half_angle * (1 - self.softness))

    @property
    def intensity(self) -> Vec3:
        """(3,) W/sr inside the full part, so that the cone holds exactly `power`.

        The rim is smoothstep over the cosine, whose mean is 1/2, so the cone's effective solid
        angle is 2 pi (1 - (cos_full + cos_rim) / 2).
        """
        return self.power / (2 * math.pi * (1 - (self.cos_full + self.cos_rim) / 2))


class CubeSide(SpotLight):
    """A sixth of what a point light sees: its cone is a square one, the side of a cube around it.

    Only shadow maps know of it; what a surface receives is the point light's.
    """


def _check(position: Vec3, power: Vec3) -> None:
    if not np.isfinite(position).all():
        raise UsageError(f"a light: expected a finite position, found {position.tolist()}")
    if not (np.isfinite(power) & (power >= 0)).all():
        raise UsageError(f"a light: expected watts of 0 or more, found {power.tolist()}")


Light = PointLight | SpotLight


def casting(lights: Iterable[Light]) -> tuple[SpotLight, ...]:
    """Spot lights that have a shadow map, in their order; the first one is the key light."""
    return tuple(x for x in lights if isinstance(x, SpotLight) and x.casts_shadow)


def casting_around(lights: Iterable[Light]) -> tuple[PointLight, ...]:
    """Point lights that have shadow maps, in their order."""
    return tuple(x for x in lights if isinstance(x, PointLight) and x.casts_shadow)
