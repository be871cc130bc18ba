"""The frame's lights and environment: which have shadows, and what the shaders are told."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.errors import UsageError
from followspot.gpu import blocks
from followspot.passes import shadow_fit, shadow_tiles
from followspot.scene.light import Light, PointLight, SpotLight, casting, casting_around
from followspot.scene.scene import Scene
from followspot.scene.settings import CullFace, Settings
from followspot.spaces import Mat4

_HARDEST_RIM = 1e-6
"""Cosine that the rim takes at least; a float32 cosine near 1 has steps of 6e-8."""

_SIDES = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")
_AXES = ("POS_X", "NEG_X", "POS_Y", "NEG_Y", "POS_Z", "NEG_Z")


def in_order(lights: tuple[Light, ...]) -> tuple[Light, ...]:
    """Spot lights with a shadow map, point lights with some, then those without any.

    The first one is the key light.

    Raises:
        UsageError: more lights, or spot lights with shadows, than a frame holds.
    """
    spots = casting(lights)
    if len(lights) > blocks.MAX_LIGHTS or len(spots) > blocks.MAX_SHADOWS:
        raise UsageError(
            f"at most {blocks.MAX_LIGHTS} lights, {blocks.MAX_SHADOWS} of them spot lights with "
            f"shadows, can be drawn at once; there are {len(lights)}, {len(spots)} spot lights "
            "with shadows"
        )
    first: tuple[Light, ...] = (*spots, *casting_around(lights))
    return (*first, *(light for light in lights if light not in first))


def shadowed(lights: tuple[Light, ...], settings: Settings) -> tuple[SpotLight, ...]:
    """What shadow maps of a frame look into: spot lights, then the sides of point lights' cubes."""
    if not settings.shadows:
        return ()
    sides = [side for light in casting_around(lights) for side in light.sides]
    return (*casting(lights), *sides)


def names(shadowed: Sequence[SpotLight]) -> list[str]:
    """What to call each of what shadow maps look into, by number if its light has no name."""
    spots = shadow_tiles.spot_count(shadowed)
    found = [light.name or f"spot {number}" for number, light in enumerate(shadowed[:spots])]
    for number, side in enumerate(shadowed[spots:]):
        point, axis = divmod(number, blocks.SIDES)
        found.append(f"{side.name or f'point {point}'} {_SIDES[axis]}")
    return found


def counts(
    lights: Sequence[Light], shadowed: Sequence[SpotLight], settings: Settings
) -> dict[str, int | str]:
    """Macros of surface.frag that tell how many lights there are.

    Args:
        lights: In the order of `in_order`.
        shadowed: What shadow maps look into.
        settings: Of them those of shadow maps are read.
    """
    spots = shadow_tiles.spot_count(shadowed)
    columns, rows = shadow_tiles.shape(shadowed, settings)
    return {
        "LIGHTS": len(lights),
        "SHADOWS": spots,
        "POINT_SHADOWS": (len(shadowed) - spots) // blocks.SIDES,
        "SHADOW_COLUMNS": columns,
        "SHADOW_ROWS": rows,
    }


def write_lights(
    block: NDArray[np.void],
    lights: tuple[Light, ...],
    metres_per_unit: float,
) -> None:
    """Fill in a frame block's lights. Distances in the shader are units, intensities per m^2.

    Args:
        block: One of `blocks.FRAME`.
        lights: In the order of `in_order`.
        metres_per_unit: Length of a unit.
    """
    for k, light in enumerate(lights):
        block["light_position"][k, :3] = light.position
        block["light_radiance"][k, :3] = light.intensity / math.pi / metres_per_unit**2
        if isinstance(light, PointLight):
            block["light_axis"][k] = 0.0, 0.0, 0.0, 1.0
        else:
            width = max(light.cos_full - light.cos_rim, _HARDEST_RIM)
            block["light_axis"][k] = *(-light.direction / width), -light.cos_rim / width


def baked_unit(scene: Scene, settings: Settings) -> float:
    """Radiance in W/(m^2 sr) of a white surface by a light of 1 among what was baked, or traced, in
    the environment's place; 0 where nothing was.
    """
    if scene.level.traced is not None:
        return scene.level.traced.unit
    return 0.0 if scene.mesh.baked is None else settings.baked_light


def constants(scene: Scene, settings: Settings) -> dict[str, int | str]:
    """Macros of surface.frag that stay while scene and settings do."""
    macros: dict[str, int | str] = {
        "SHADOW_TAPS": settings.shadow_taps,
        "NEAR_REACH": f"{shadow_tiles.near_reach(settings):.9g}",
        "SHADOW_BIAS": f"{settings.shadow_bias:.9g}",
        "NORMAL_OFFSET": f"{settings.shadow_normal_offset:.9g}",
        "LIT_SIDE": f"{shadow_tiles.LIT_SIDE:.9g}",
        "GRAZING": f"{shadow_tiles.GRAZING:.9g}",
        "STEEP": f"{shadow_tiles.STEEP:.9g}",
        "TILE_SIZE": f"{shadow_tiles.tile_size(settings):.1f}",
        "SIDE_SCALE": f"{shadow_tiles.side_scale(settings):.9g}",
        "SIDE_NEAR": f"{shadow_fit.PLANES_AROUND[0]:.1f}",
        "SIDE_FAR": f"{shadow_fit.PLANES_AROUND[1]:.1f}",
    }
    if settings.shadow_fit:
        macros["SHADOW_FIT"] = 1
    if settings.shadow_cull is not CullFace.FRONT:
        macros["LIT_SIDES_CAST"] = 1
    if settings.albedo is not None:
        macros["ALBEDO"] = f"{settings.albedo:.9g}"
    baked = baked_unit(scene, settings)
    if settings.sky_light and baked > 0:
        macros["BAKED"] = f"{baked:.9g}"
    elif settings.sky_light:
        macros["SKY_LIGHT"] = 1
        for axis, radiance in zip(_AXES, _towards_axes(scene, settings), strict=True):
            macros[f"SKY_{axis}"] = "vec3({:.9g}, {:.9g}, {:.9g})".format(*radiance)
    return macros


def _towards_axes(scene: Scene, settings: Settings) -> Floats:
    """(6, 3) radiance of the environment in W/(m^2 sr)."""
    towards = scene.sky.towards_axes(settings.environment_mip)
    return np.asarray(towards * scene.environment_constant + scene.ambient)


def mean_from_around(scene: Scene, settings: Settings) -> Floats:
    """(3,) mean radiance in W/(m^2 sr) of what takes the environment's place, from all around.

    Of what was baked it is that of a white surface that the level's compiler has lit well, of what
    was traced the mean.
    """
    if not settings.sky_light:
        return np.zeros(3)
    if baked := baked_unit(scene, settings):
        return np.full(3, baked)
    return np.asarray(_towards_axes(scene, settings).mean(axis=0))


def direction_from_clip(clip_from_view: Mat4, view_from_world: Mat4) -> Mat4:
    """Clip x, y (and 1) to the world direction that a pixel looks along, not normalised."""
    right, up, back = view_from_world[:3, :3]
    direction = np.zeros((4, 4))
    direction[:3, 0] = right / clip_from_view[0, 0]
    direction[:3, 1] = up / clip_from_view[1, 1]
    direction[:3, 3] = -back
    return direction
