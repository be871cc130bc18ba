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

[paths.tour]                  # a camera in motion, for films
keys = [                      # each with yaw and pitch as above, or with look_at = [x, y, z]
    {time = 0, position = [0, -200, 60], yaw = 90},
    {time = 5, position = [200, 0, 60], look_at = [0, 0, 80], fov = 70},
]                             # without any time: at one speed, in this path's `seconds`

[paths.fly]
auto = true                   # found in the level
seconds = 20

[settings]
shadow_map_size = 2048

Characters are told of in `cast_file`, things that never move in `prop_file`.
"""

import itertools
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
from followspot.scene.cast_file import Actors, CharacterEntry, Items, ThenEntry
from followspot.scene.light import Light, PointLight, SpotLight
from followspot.scene.path import AutoPath, CameraPath, Key
from followspot.scene.prop_file import PropEntry, Up
from followspot.scene.settings import CullFace, Settings
from followspot.spaces import Vec3

FARTHEST = 1e7
"""Units that a coordinate may be from the origin."""
Coordinate = Annotated[float, Meta(ge=-FARTHEST, le=FARTHEST)]
Number3 = tuple[Coordinate, Coordinate, Coordinate]
MAX_POWER = 1e15
Unit = Annotated[float, Meta(ge=1e-6, le=1e6)]
Radiance = Annotated[float, Meta(ge=0, le=1e6)]


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
    yaw: Coordinate = 0.0
    pitch: Annotated[float, Meta(ge=-90, le=90)] = 0.0
    fov: Annotated[float, Meta(ge=1, le=170)] = 90.0

    def camera(self, name: str) -> Camera:
        """The view itself."""
        return Camera(spaces.vec3(self.position), self.yaw, self.pitch, self.fov, name=name)


Seconds = Annotated[float, Meta(ge=0, le=36000)]
_SHORTEST = 0.001
"""Seconds from one key to the next at least; for keys without times, units."""


class KeyEntry(_Entry, frozen=True, kw_only=True):
    """Where the camera of a path is at a time: with angles, or with a point that it looks at."""

    position: Number3
    time: Seconds | None = None
    yaw: Coordinate | None = None
    pitch: Annotated[float, Meta(ge=-90, le=90)] | None = None
    look_at: Number3 | None = None
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


class PathEntry(_Entry, frozen=True, kw_only=True):
    """A named path: either keys or one that is found in the level."""

    keys: tuple[KeyEntry, ...] = ()
    auto: bool = False
    seconds: Annotated[float, Meta(ge=0.1, le=36000)] | None = None

    def __post_init__(self) -> None:
        if self.auto == bool(self.keys):
            raise ValueError("Expected either `keys` or `auto = true`, got both or neither")
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


class SceneFile(_Entry, frozen=True, kw_only=True):
    """A scene file's contents, checked."""

    level: str
    sky: str | None = None
    metres_per_unit: Unit = spaces.METRES_PER_UNIT
    environment_constant: Radiance = 1.0
    ambient: Radiance = 0.0
    lights: tuple[PointEntry | SpotEntry, ...] | None = None
    cameras: dict[str, CameraEntry] = {}
    paths: dict[str, PathEntry] = {}
    characters: tuple[CharacterEntry, ...] = ()
    actors: Actors = Actors.NONE
    items: Items = Items.NONE
    props: tuple[PropEntry, ...] = ()
    settings: Settings = Settings()


def read(path: Path) -> SceneFile:
    """Read and check a scene file.

    Raises:
        AssetError: names the file, the key, and what was expected there.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")  # some editors begin with a byte order mark
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
        _require_finite(document, source, "")
    except tomllib.TOMLDecodeError as error:
        reason, _, place = str(error).rstrip(")").partition(" (at ")
        raise AssetError(source, place=place, expected="TOML", found=reason) from None
    except ValueError:  # the one thing that Python itself has against a number
        found = "an integer of thousands of digits"
        raise AssetError(source, expected="TOML", found=found) from None
    except RecursionError:
        raise AssetError(source, expected="TOML", found="tables or lists too deep") from None
    cameras = _named(document, "cameras", CameraEntry, source)
    paths = _named(document, "paths", PathEntry, source)
    file = _convert(document, SceneFile, source, "")
    return msgspec.structs.replace(file, cameras=cameras, paths=paths)


T = TypeVar("T")


def _named(document: dict[str, Any], key: str, kind: type[T], source: str) -> dict[str, T]:
    """Take the tables of one kind out of a document, so that their errors tell their names."""
    tables = document.pop(key, {})
    if not isinstance(tables, dict):
        raise AssetError(source, place=key, expected="a table", found=_short(tables))
    return {name: _convert(table, kind, source, f"{key}.{name}") for name, table in tables.items()}


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
            known = ", ".join(_known_keys(value, kind, path))
            raise AssetError(
                source, place=place, expected=f"known keys only ({known})", found=match[1]
            ) from None
        if match := re.match(r"Object missing required field `(.*)`", text):
            raise AssetError(
                source, place=place, expected=f"the key {match[1]}", found="none"
            ) from None
        if text.startswith("Invalid enum value"):
            kinds = {"actors": Actors, "items": Items, "up": Up}
            kind_of = kinds.get(path.rpartition(".")[2], CullFace)
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


def _known_keys(document: object, kind: type[Any], path: str) -> list[str]:
    """Keys of the table that a path like ``lights[0]`` leads to."""
    tables: dict[str, type[Struct]] = {
        "characters": CharacterEntry,
        "keys": KeyEntry,
        "props": PropEntry,
        "settings": Settings,
        "then": ThenEntry,
    }
    name = re.sub(r"\[\d+\]$", "", path).rpartition(".")[2]
    if name != "lights":
        return list(tables.get(name, kind).__struct_fields__)
    is_spot = _at(document, f"{path}.type") == "spot"
    return ["type", *(SpotEntry if is_spot else PointEntry).__struct_fields__]


def _value_at(value: Any, path: str) -> str:
    """The value that a path like ``lights[0].power`` leads to, for a message."""
    try:
        return _short(_at(value, path))
    except (KeyError, IndexError, TypeError):
        return "nothing"


def _at(value: Any, path: str) -> Any:
    for name, index in re.findall(r"([^.\[\]]+)|\[(\d+)\]", path):
        value = value[int(index)] if index else value[name]
    return value


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
