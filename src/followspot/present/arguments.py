"""What is typed on the command line, as cameras, lights, sizes and settings."""

import math
from collections.abc import Sequence

import numpy as np

from followspot import spaces
from followspot.errors import UsageError
from followspot.scene.camera import Camera
from followspot.scene.light import Light, PointLight, SpotLight
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings, with_changes

SPOT_FORM = "spot:x,y,z:dx,dy,dz:half_angle_radians:power"
POINT_FORM = "point:x,y,z:power"
CAMERA_FORM = "x,y,z,yaw,pitch"
LARGEST_EDGE = 16384
"""Pixels along an edge of a picture."""
LARGEST = 1e15
"""Largest number that is taken: float32 arithmetic on it stays finite."""


def parse_size(text: str) -> tuple[int, int]:
    """``640x480`` as (width, height) in pixels."""
    width, _, height = text.lower().partition("x")
    if not (width.isascii() and height.isascii() and width.isdigit() and height.isdigit()):
        raise UsageError(f"--size: expected WIDTHxHEIGHT as in 640x480, found {text!r}")
    size = int(width), int(height)
    if not all(1 <= edge <= LARGEST_EDGE for edge in size):
        raise UsageError(f"--size: expected edges of 1 to {LARGEST_EDGE} pixels, found {text!r}")
    return size


def require_drawable(size: tuple[int, int], supersample: int) -> None:
    """See that a picture with so many pixels drawn along an edge of each is not too large.

    Raises:
        UsageError: it is.
    """
    if max(size) * supersample > LARGEST_EDGE:
        raise UsageError(
            f"--supersample: expected at most {LARGEST_EDGE} pixels drawn along an edge, "
            f"found {max(size)} x {supersample}"
        )


def parse_camera(
    text: str | None, fov: float | None, scene: Scene, option: str = "--camera"
) -> Camera:
    """A camera's name or ``x,y,z,yaw,pitch`` (units, degrees), with another angle of view."""
    is_typed = text is not None and "," in text and text not in scene.cameras
    camera = _typed_camera(text, option) if text and is_typed else scene.camera(text)
    if fov is None:
        return camera
    if not 1 <= fov <= 170:
        raise UsageError(f"--fov: expected 1 to 170 degrees, found {fov}")
    return Camera(camera.position, camera.yaw, camera.pitch, fov, camera.near, camera.name)


def _typed_camera(text: str, option: str) -> Camera:
    numbers = _numbers(text, option, CAMERA_FORM, 5)
    if abs(numbers[4]) > 90:
        raise UsageError(f"{option}: expected a pitch of -90 to 90 degrees, found {numbers[4]}")
    return Camera(spaces.vec3(numbers[:3]), numbers[3], numbers[4])


def parse_light(text: str) -> Light:
    """A light as in SPOT_FORM or POINT_FORM; power is one number or red,green,blue."""
    kind, *parts = text.split(":")
    if kind == "spot" and len(parts) == 4:
        position, direction = (_numbers(p, "--light", SPOT_FORM, 3) for p in parts[:2])
        half_angle = _numbers(parts[2], "--light", SPOT_FORM, 1)[0]
        if not 1e-4 <= half_angle < math.pi / 2:
            raise UsageError(
                f"--light: expected a half-angle of 0.0001 to pi/2 radians, found {parts[2]!r}"
            )
        if not np.linalg.norm(direction) > 0:
            raise UsageError(f"--light: expected a direction, found {parts[1]}")
        return SpotLight(
            spaces.vec3(position),
            spaces.normalised(spaces.vec3(direction)),
            half_angle,
            _power(parts[3]),
        )
    if kind == "point" and len(parts) == 2:
        position = _numbers(parts[0], "--light", POINT_FORM, 3)
        return PointLight(spaces.vec3(position), _power(parts[1]))
    raise UsageError(f"--light: expected {SPOT_FORM} or {POINT_FORM}, found {text!r}")


def _power(text: str) -> spaces.Vec3:
    count = 3 if "," in text else 1
    numbers = _numbers(text, "--light", "a power in watts, or red,green,blue", count)
    if min(numbers) < 0:
        raise UsageError(f"--light: expected a power of 0 or more, found {text!r}")
    return spaces.vec3(numbers * (3 // count))


def _numbers(text: str, option: str, form: str, count: int) -> list[float]:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(abs(n) <= LARGEST for n in numbers):
        raise UsageError(f"{option}: expected {form}, found {text!r}")
    return numbers


def parse_settings(
    scene: Scene,
    changes: Sequence[str],
    *,
    albedo: float | None = None,
    shadows: bool = True,
    sky_light: bool = True,
) -> Settings:
    """A scene's settings with what the command line changes of them."""
    pairs = {}
    for change in changes:
        name, equals, value = change.partition("=")
        if not equals:
            raise UsageError(f"--set: expected KEY=VALUE, found {change!r}")
        pairs[name.strip()] = value.strip()
    if albedo is not None:
        if not 0 <= albedo <= 1:
            raise UsageError(f"--albedo: expected 0 to 1, found {albedo}")
        pairs["albedo"] = str(albedo)
    if not shadows:
        pairs["shadows"] = "false"
    if not sky_light:
        pairs["sky_light"] = "false"
    return with_changes(scene.settings, pairs)
