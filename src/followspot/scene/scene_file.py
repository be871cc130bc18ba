"""Scene files: TOML that names a level and says how to light it and where to stand.

level = "oa_dm5"              # a name in the search path, or a path beside this file
sky = "env/hills"             # images env/hills_rt, _lf, ...; else the level's own
metres_per_unit = 0.03
environment_constant = 1.0    # W/(m^2 sr) of a sky texel of value 1

[[lights]]
type = "spot"                 # or "point", which has neither direction nor angle
position = [0, 0, 400]        # Quake units
target = [0, 0, 0]            # or direction = [x, y, z]
half_angle_degrees = 30
power = 5000                  # W, or [red, green, blue]
softness = 0.2

[cameras.start]
position = [0, -200, 60]
yaw = 90
pitch = 5                     # positive looks down

[settings]
shadow_map_size = 2048
"""

import math
import re
import tomllib
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta, Struct

from followspot import spaces
from followspot.errors import AssetError
from followspot.scene.camera import Camera
from followspot.scene.light import Light, PointLight, SpotLight
from followspot.scene.settings import Settings
from followspot.spaces import Vec3

Number3 = tuple[float, float, float]
Positive = Annotated[float, Meta(gt=0)]
Power = Annotated[float, Meta(ge=0)]


class _Entry(Struct, forbid_unknown_fields=True, kw_only=True, frozen=True):
    """What every table of a scene file has in common: no key that nobody reads."""


class PointEntry(_Entry, tag="point", frozen=True, kw_only=True):
    """A light without direction."""

    position: Number3
    power: float | list[float]
    name: str = ""

    def __post_init__(self) -> None:
        _per_channel(self.power)

    def light(self) -> Light:
        """The light itself."""
        return PointLight(spaces.vec3(self.position), _per_channel(self.power), name=self.name)


class SpotEntry(_Entry, tag="spot", frozen=True, kw_only=True):
    """A light with a cone; exactly one of `direction` and `target` is given."""

    position: Number3
    power: float | list[float]
    half_angle_degrees: Annotated[float, Meta(gt=0, lt=90)]
    direction: Number3 | None = None
    target: Number3 | None = None
    softness: Annotated[float, Meta(ge=0, le=1)] = 0.0
    casts_shadow: bool = True
    name: str = ""

    def __post_init__(self) -> None:
        if (self.direction is None) == (self.target is None):
            raise ValueError("Expected one of `direction` and `target`, got both or neither")
        _per_channel(self.power)
        if not np.any(self._axis()):
            raise ValueError("Expected a direction, got one of no length")

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


class CameraEntry(_Entry, frozen=True, kw_only=True):
    """A named view."""

    position: Number3
    yaw: float = 0.0
    pitch: Annotated[float, Meta(ge=-90, le=90)] = 0.0
    fov: Annotated[float, Meta(ge=1, le=170)] = 90.0

    def camera(self, name: str) -> Camera:
        """The view itself."""
        return Camera(spaces.vec3(self.position), self.yaw, self.pitch, self.fov, name=name)


class SceneFile(_Entry, frozen=True, kw_only=True):
    """A scene file's contents, checked."""

    level: str
    sky: str | None = None
    metres_per_unit: Positive = spaces.METRES_PER_UNIT
    environment_constant: Power = 1.0
    ambient: Power = 0.0
    lights: tuple[PointEntry | SpotEntry, ...] = ()
    cameras: dict[str, CameraEntry] = {}
    settings: Settings = Settings()


def read(path: Path) -> SceneFile:
    """Read and check a scene file.

    Raises:
        AssetError: names the file, the key, and what was expected there.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        reason = error.strerror or "nothing"
        raise AssetError(str(path), expected="a scene file", found=reason) from None
    except UnicodeDecodeError as error:
        raise AssetError(
            str(path), place=f"byte {error.start}", expected="UTF-8 text", found="other bytes"
        ) from None
    return parse(text, str(path))


def parse(text: str, source: str) -> SceneFile:
    """Check a scene file's text; `source` names it in errors.

    Raises:
        AssetError: as `read`.
    """
    try:
        return msgspec.convert(_finite(tomllib.loads(text), source, ""), SceneFile)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        line = re.search(r"\(at (.*)\)$", message)
        raise AssetError(
            source,
            place=line[1] if line else "",
            expected="TOML",
            found=re.sub(r" \(at .*\)$", "", message),
        ) from None
    except msgspec.ValidationError as error:
        raise _told(str(error), source) from None


def _told(message: str, source: str) -> AssetError:
    """What msgspec says, "Expected X, got Y - at `$.key`" as an AssetError."""
    text, _, place = message.partition(" - at ")
    key = place.strip("`").removeprefix("$").removeprefix(".")
    if match := re.match(r"Expected (.*), got (.*)", text):
        return AssetError(source, place=key, expected=match[1], found=match[2])
    if match := re.match(r"Expected (.*)", text):
        return AssetError(source, place=key, expected=match[1], found="another value")
    if match := re.match(r"Object contains unknown field (.*)", text):
        return AssetError(source, place=key, expected="known keys only", found=match[1])
    if match := re.match(r"Object missing required field (.*)", text):
        return AssetError(source, place=key, expected=f"the key {match[1]}", found="none")
    return AssetError(source, place=key, expected="a valid value", found=text)


def _finite(value: object, source: str, key: str) -> object:
    """The value unless it is or holds TOML's inf or nan, which no key of ours can mean."""
    if isinstance(value, dict):
        return {k: _finite(v, source, f"{key}.{k}".lstrip(".")) for k, v in value.items()}
    if isinstance(value, list):
        return [_finite(v, source, f"{key}[{n}]") for n, v in enumerate(value)]
    if isinstance(value, float) and not math.isfinite(value):
        raise AssetError(source, place=key, expected="a finite number", found=str(value))
    return value


def _per_channel(power: float | list[float]) -> Vec3:
    """Watts per RGB channel from one number or three; a ValueError tells what is wrong."""
    channels = power if isinstance(power, list) else [power] * 3
    if len(channels) != 3 or min(channels) < 0:
        raise ValueError("Expected `power` of one or three numbers of 0 or more, got others")
    return spaces.vec3(channels)
