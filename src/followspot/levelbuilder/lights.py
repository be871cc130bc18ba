"""Light for the bake: a sun, the sky and lamps, in the units of Quake 3's own compiler.

Brightness counts in byte values: a surface square to a sun of intensity 100 gets 100. A lamp of
value n gives 7500 n / r^2, with r in units. The game multiplies what the lightmap holds by two
or four when it draws, so some 64 is neutral.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats
from followspot.assets.shader_values import number, read_sun
from followspot.assets.surface_flags import Surface
from followspot.errors import UsageError
from followspot.levelbuilder.entities import Entity
from followspot.levelbuilder.material import Material
from followspot.levelbuilder.raycast import Occluders, passed_along, passed_to

SKY_DIRECTIONS = 24
_POINT_SCALE = 7500.0
_FAINT = 1.5  # byte values; lamps are not followed further than where they give this


@dataclass(frozen=True)
class Lights:
    """All light of a level.

    Attributes:
        ambient: (3,) byte values that every point gets.
        directions: (n, 3) unit vectors towards parallel lights: the sun, then bits of sky.
        colors: (n, 3) byte values that a surface square to each gets.
        suns: How many of them are suns.
        lamps: (m, 3) positions.
        lamp_colors: (m, 3) byte values at one unit's distance.
    """

    ambient: Floats
    directions: Floats
    colors: Floats
    suns: int
    lamps: Floats
    lamp_colors: Floats


def find_lights(
    entities: Sequence[Entity], materials: Sequence[Material], ambient: Floats
) -> Lights:
    """Gather the lights that a level names.

    ``q3map_sun r g b intensity yaw pitch`` (or ``q3map_sunExt``, whose further numbers are not
    read) and ``q3map_skyLight value iterations`` in the scripts of sky materials, and ``light``
    entities with ``light`` and ``_color``.

    Raises:
        UsageError: The value of a ``q3map_skyLight`` is no number.
    """
    skies = [material.shader for material in materials if material.surface & Surface.SKY]
    named = [sun for sky in skies for sun in sky.all("q3map_sun", "q3map_sunext", "sun")]
    found = [sun for sun in (read_sun(directive, []) for directive in named) if sun]
    directions = np.array([sun.direction_to_sun for sun in found]).reshape(-1, 3)
    colors = np.array([sun.color * sun.intensity for sun in found]).reshape(-1, 3)
    for sky_light in (light for sky in skies for light in sky.all("q3map_skylight")):
        value = number(sky_light.word)
        if value is None:
            raise UsageError(f"the value of a sky's light is no number: {str(sky_light)!r}")
        bits = sky_directions(SKY_DIRECTIONS)
        directions = np.concatenate([directions, bits])
        # a level surface under the open sky shall get the value
        share = value / bits[:, 2].sum()
        colors = np.concatenate(
            [colors, np.tile([0.8 * share, 0.95 * share, 1.25 * share], (len(bits), 1))]
        )
    lights = [item.keys for item in entities if item.keys["classname"] == "light"]
    lamps = [keys for keys in lights if "origin" in keys]
    origins = [[float(v) for v in keys["origin"].split()] for keys in lamps]
    strength = [
        np.array([float(v) for v in keys.get("_color", "1 1 1").split()])
        * float(keys.get("light", 300))
        * _POINT_SCALE
        for keys in lamps
    ]
    return Lights(
        ambient,
        directions,
        colors,
        len(found),
        np.array(origins).reshape(-1, 3),
        np.array(strength).reshape(-1, 3),
    )


def sky_directions(count: int) -> Floats:
    """Return unit vectors, (count, 3), spread evenly over the upper half (a Fibonacci spiral)."""
    k = np.arange(count) + 0.5
    z = k / count
    angle = np.pi * (3 - np.sqrt(5)) * k
    r = np.sqrt(1 - z**2)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), z])


def lit(lights: Lights, occluders: Occluders, points: Floats, normals: Floats) -> Floats:
    """Return the light, (n, 3) byte values, at points, (n, 3), of surfaces with unit normals."""
    light = np.tile(lights.ambient, (len(points), 1))
    for direction, color in zip(lights.directions, lights.colors, strict=True):
        cosine = normals @ direction
        facing = np.flatnonzero(cosine > 0)
        passed = passed_along(occluders, points[facing], direction)
        light[facing] += (passed * cosine[facing])[:, None] * color
    for position, color in zip(lights.lamps, lights.lamp_colors, strict=True):
        towards = position - points
        square = (towards**2).sum(axis=1)
        strength = np.maximum((towards * normals).sum(axis=1), 0) / square**1.5
        reached = np.flatnonzero(strength * color.max() > _FAINT)
        passed = passed_to(occluders, points[reached], position)
        light[reached] += (passed * strength[reached])[:, None] * color
    return light


def lit_volume(
    lights: Lights, occluders: Occluders, points: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return the light in free air at points, (n, 3).

    Returns:
        Ambient light, (n, 3) byte values; directed light, (n, 3); the unit vector towards where
        most of the directed light comes from, (n, 3).
    """
    ambient = np.tile(lights.ambient, (len(points), 1))
    directed, towards = np.zeros_like(points), np.zeros_like(points)
    for i, (direction, color) in enumerate(zip(lights.directions, lights.colors, strict=True)):
        passed = passed_along(occluders, points, direction)[:, None]
        if i < lights.suns:
            directed += passed * color
            towards += passed * direction * color.sum()
        else:
            ambient += passed * color / 2  # on average half of it is behind the surface
    for position, color in zip(lights.lamps, lights.lamp_colors, strict=True):
        offset = position - points
        square = (offset**2).sum(axis=1, keepdims=True)
        reached = np.flatnonzero(color.max() / square[:, 0] > _FAINT)
        passed = passed_to(occluders, points[reached], position)[:, None]
        light = passed * color / square[reached]
        directed[reached] += light
        unit = offset[reached] / np.sqrt(square[reached])
        towards[reached] += unit * light.sum(axis=1, keepdims=True)
    length = np.linalg.norm(towards, axis=1, keepdims=True)
    up = np.array([0.0, 0.0, 1.0])
    return ambient, directed, np.where(length > 0, towards / np.maximum(length, 1e-9), up)
