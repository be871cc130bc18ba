"""Mitsuba 3 itself, and cameras and lights in its terms: lengths are metres there."""

import math
from typing import Any

import numpy as np

from followspot.arrays import Floats
from followspot.errors import UsageError
from followspot.scene.camera import Camera
from followspot.scene.light import Light, PointLight

_VARIANT = "llvm_ad_rgb"
"""Whole pictures at a time on the CPU; the scalar variants trace one ray a call from Python."""


def load_mitsuba() -> Any:
    """The package, set to a variant that traces arrays of rays.

    Raises:
        UsageError: it is not installed, or LLVM, which it compiles with, is not.
    """
    try:
        import mitsuba
    except ImportError:
        raise UsageError("validation needs Mitsuba 3: pip install followspot[validate]") from None
    try:
        mitsuba.set_variant(_VARIANT)
        mitsuba.Float(0.0)
    except (ImportError, RuntimeError) as error:
        raise UsageError(
            f"Mitsuba cannot use LLVM here ({error}); on Debian: apt-get install libllvm15"
        ) from None
    return mitsuba


def emitter(mi: Any, light: Light, metres_per_unit: float) -> dict[str, Any]:
    """Mitsuba's point or spot light. That one fades in the angle; a hard rim is a narrow fade."""
    intensity = {"type": "rgb", "value": light.intensity.tolist()}
    if isinstance(light, PointLight):
        position = (light.position * metres_per_unit).tolist()
        return {"type": "point", "position": position, "intensity": intensity}
    rim, full = light.half_angle, light.half_angle * (1 - light.softness)
    start = light.position * metres_per_unit
    end = (light.position + light.direction) * metres_per_unit
    across = np.eye(3)[np.abs(light.direction).argmin()]  # any direction but the light's
    return {
        "type": "spot",
        "to_world": _look(mi, start, end, across),
        "intensity": intensity,
        "cutoff_angle": math.degrees(rim),
        "beam_width": math.degrees(min(full, rim * (1 - 1e-5))),
    }


def sensor(
    mi: Any, camera: Camera, size: tuple[int, int], sampler: dict[str, Any], metres_per_unit: float
) -> Any:
    """A camera's pictures of (width, height) pixels, with one of Mitsuba's samplers."""
    yaw, pitch = math.radians(camera.yaw), math.radians(camera.pitch)
    up = np.array(
        [math.sin(pitch) * math.cos(yaw), math.sin(pitch) * math.sin(yaw), math.cos(pitch)]
    )
    start = camera.position * metres_per_unit
    end = (camera.position + camera.forward) * metres_per_unit
    film = {"width": size[0], "height": size[1], "rfilter": {"type": "box"}}
    return mi.load_dict(
        {
            "type": "perspective",
            "fov": camera.fov,
            "fov_axis": "x",
            "near_clip": camera.near * metres_per_unit,
            "far_clip": 1e6,
            "to_world": _look(mi, start, end, up),
            "film": {"type": "hdrfilm", "pixel_format": "rgb", **film},
            "sampler": sampler,
        }
    )


def _look(mi: Any, start: Floats, end: Floats, up: Floats) -> Any:
    """From one place in metres to another."""
    return mi.ScalarTransform4f().look_at(start.tolist(), end.tolist(), up.tolist())
