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

Characters are told of in `cast_file`.
"""

import math
import re
import tomllib
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec
import numpy as np
from msgspec import Meta, Struct

from followspot import spaces
from followspot.errors import AssetError
from followspot.scene.camera import Camera
from followspot.scene.cast_file import Actors, CharacterEntry, Items
from followspot.scene.light import Light, PointLight, SpotLight
from followspot.scene.settings import CullFace, Settings
from followspot.spaces import Vec3

Coordinate = Annotated[float, Meta(ge=-1e7, le=1e7)]
Number3 = tuple[Coordinate, Coordinate, Coordinate]
MAX_POWER = 1e15
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
    half_angle_degrees: Annotated[float, Meta(ge=0.01, lt=90)]
    direction: Number3 | None = None
    target: Number3 | None = None
    softness: Annotated[float, Meta(ge=0, le=1)] = 0.0
    casts_shadow: bool = True
    name: str = ""

    def __post_init__(self) -> None:
        _per_channel(self.power)
        if (self.direction is None) == (self.target is None):
            raise ValueError("Expected one of `direction` and `target`, got both or neither")
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
    lights: tuple[PointEntry | SpotEntry, ...] | None = None
    cameras: dict[str, CameraEntry] = {}
    characters: tuple[CharacterEntry, ...] = ()
    actors: Actors = Actors.NONE
    items: Items = Items.NONE
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
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        reason, _, place = str(error).rstrip(")").partition(" (at ")
        raise AssetError(source, place=place, expected="TOML", found=reason) from None
    except RecursionError:
        raise AssetError(source, expected="TOML", found="tables or lists too deep") from None
    _require_finite(document, source, "")
    cameras = document.pop("cameras", {})
    if not isinstance(cameras, dict):
        raise AssetError(source, place="cameras", expected="a table", found=_short(cameras))
    views = {
        name: _convert(table, CameraEntry, source, f"cameras.{name}")
        for name, table in cameras.items()
    }
    return msgspec.structs.replace(_convert(document, SceneFile, source, ""), cameras=views)


T = TypeVar("T")


def _convert(value: object, kind: type[T], source: str, key: str) -> T:
    """A checked record from plain values; msgspec's complaints become AssetErrors."""
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        text, _, path = str(error).partition(" - at ")
        path = path.strip("`").removeprefix("$").removeprefix(".")
        place = ".".join(part for part in (key, path) if part)
        found = _value_at(value, path)
        if match := re.match(r"Object contains unknown field `(.*)`", text):
            raise AssetError(
                source, place=place, expected="known keys only", found=match[1]
            ) from None
        if match := re.match(r"Object missing required field `(.*)`", text):
            raise AssetError(
                source, place=place, expected=f"the key {match[1]}", found="none"
            ) from None
        if text.startswith("Invalid enum value"):
            kind_of = {"actors": Actors, "items": Items}.get(path, CullFace)
            text = "Expected " + ", ".join(value.value for value in kind_of)
        elif text.startswith("Invalid value"):
            text = "Expected spot or point"
        elif not text.startswith("Expected "):
            text = f"Expected a valid value ({text})"
        expected, got, reason = text.removeprefix("Expected ").partition(", got ")
        is_ours = got and not reason.startswith("`")  # from a __post_init__
        raise AssetError(
            source,
            place=place,
            expected=expected if is_ours else expected.replace("`", ""),
            found=reason if is_ours else f"{reason} {found}".replace("`", "").strip(),
        ) from None


def _value_at(value: Any, path: str) -> str:
    """The value that a path like ``lights[0].power`` leads to, for a message."""
    for name, index in re.findall(r"([^.\[\]]+)|\[(\d+)\]", path):
        try:
            value = value[int(index)] if index else value[name]
        except (KeyError, IndexError, TypeError):
            return "nothing"
    return _short(value)


def _short(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def _require_finite(value: object, source: str, key: str) -> None:
    """Refuse TOML's inf and nan, which no key of ours can mean."""
    if isinstance(value, dict):
        for name, inner in value.items():
            _require_finite(inner, source, f"{key}.{name}".lstrip("."))
    elif isinstance(value, list):
        for number, inner in enumerate(value):
            _require_finite(inner, source, f"{key}[{number}]")
    elif isinstance(value, float) and not math.isfinite(value):
        raise AssetError(source, place=key, expected="a finite number", found=str(value))


def _per_channel(power: float | list[float]) -> Vec3:
    """Watts per RGB channel from one number or three; a ValueError tells what is wrong."""
    channels = power if isinstance(power, list) else [power] * 3
    if len(channels) != 3 or not all(0 <= channel <= MAX_POWER for channel in channels):
        raise ValueError(
            f"Expected `power` as one or three numbers, 0 or more, to {MAX_POWER:g}, got others"
        )
    return spaces.vec3(channels)
