"""The frame's lights and environment: which have shadows, and what the shaders are told."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from followspot.errors import UsageError
from followspot.gpu import blocks
from followspot.scene.light import Light, PointLight, SpotLight
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.scene.sky import CubeMap
from followspot.spaces import Mat4


def in_order(lights: tuple[Light, ...]) -> tuple[Light, ...]:
    """Lights with a shadow map before those without; the first one is the key light.

    Raises:
        UsageError: more lights, or lights with shadows, than a frame holds.
    """
    casting = [light for light in lights if isinstance(light, SpotLight) and light.casts_shadow]
    if len(lights) > blocks.MAX_LIGHTS or len(casting) > blocks.MAX_SHADOWS:
        raise UsageError(
            f"at most {blocks.MAX_LIGHTS} lights, {blocks.MAX_SHADOWS} of them with shadows, can "
            f"be drawn at once; there are {len(lights)}, {len(casting)} with shadows"
        )
    return (*casting, *(light for light in lights if light not in casting))


def shadowed(lights: tuple[Light, ...], settings: Settings) -> tuple[SpotLight, ...]:
    """Those of `lights` (in the order of `in_order`) that have a shadow map in a frame."""
    if not settings.shadows:
        return ()
    return tuple(light for light in lights if isinstance(light, SpotLight) and light.casts_shadow)


def write_lights(
    block: NDArray[np.void],
    lights: tuple[Light, ...],
    metres_per_unit: float,
    normal_offsets: list[float],
) -> None:
    """Fill in a frame block's lights. Distances in the shader are units, intensities per m^2.

    Args:
        block: One of `blocks.FRAME`.
        lights: In the order of `in_order`.
        metres_per_unit: Length of a unit.
        normal_offsets: For each light with a shadow map, units per unit of distance.
    """
    block["light_position"][: len(normal_offsets), 3] = normal_offsets
    for k, light in enumerate(lights):
        block["light_position"][k, :3] = light.position
        block["light_intensity"][k, :3] = light.intensity / metres_per_unit**2
        if isinstance(light, PointLight):  # a cone beyond the whole sphere
            block["light_direction"][k] = 0.0, 0.0, 1.0, -3.0
            block["light_intensity"][k, 3] = -2.0
        else:
            block["light_direction"][k] = *light.direction, light.cos_rim
            block["light_intensity"][k, 3] = max(light.cos_full, light.cos_rim + 1e-6)


def write_environment(block: NDArray[np.void], scene: Scene, settings: Settings) -> None:
    """Fill in a frame block's sky radiances and constants."""
    if settings.sky_light:
        towards = _towards_axes(scene.sky, settings.environment_mip)
        block["environment"][:, :3] = towards * scene.environment_constant + scene.ambient
    albedo = 1.0 if settings.albedo is None else settings.albedo
    block["tint"] = albedo, albedo, albedo, settings.emission
    block["sky_scale"][0] = scene.environment_constant


@lru_cache(maxsize=8)
def _towards_axes(sky: CubeMap, level: float | None) -> NDArray[np.float64]:
    return sky.towards_axes(level)


def direction_from_clip(clip_from_view: Mat4, view_from_world: Mat4) -> Mat4:
    """Clip x, y (and 1) to the world direction that a pixel looks along, not normalised."""
    view_from_clip = np.zeros((4, 4))
    view_from_clip[:2, :2] = np.linalg.inv(clip_from_view[:2, :2])
    view_from_clip[2, 3] = -1.0
    world_from_view = np.eye(4)
    world_from_view[:3, :3] = view_from_world[:3, :3].T
    return world_from_view @ view_from_clip
