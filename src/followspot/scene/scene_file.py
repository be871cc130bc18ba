"""Scene files: TOML that names a level and says how to light it and where to stand.

level = "oa_dm5"              # a name in the search path, or a path beside this file
sky = "env/hills"             # images env/hills_rt, _lf, ...; else the level's own
metres_per_unit = 0.03
environment_constant = 1.0    # W/(m^2 sr) of a sky texel of value 1

ambient = 0.0                 # W/(m^2 sr) from all around, added to the sky's

[settings]                    # as with --set; exposure, emission, environment_mip may be "auto"
shadow_map_size = 2048

Lights are told of in `light_file`, cameras and their paths in `path_file`, characters in
`cast_file`, things that never move in `prop_file`.
"""

import math
import re
import tomllib
from pathlib import Path
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta, Struct

from followspot import spaces
from followspot.assets import complaints
from followspot.errors import AssetError
from followspot.scene.cast_file import Actors, CharacterEntry, Items, ThenEntry
from followspot.scene.entry import Entry
from followspot.scene.light_file import PointEntry, SpotEntry
from followspot.scene.path_file import CameraEntry, KeyEntry, PathEntry
from followspot.scene.prop_file import PropEntry, Up
from followspot.scene.settings import CullFace, Settings, is_left_open

Unit = Annotated[float, Meta(ge=1e-6, le=1e6)]
Radiance = Annotated[float, Meta(ge=0, le=1e6)]


class SceneFile(Entry, frozen=True, kw_only=True):
    """A scene file's contents, checked."""

    level: str
    sky: str | None = None
    metres_per_unit: Unit = spaces.METRES_PER_UNIT
    environment_constant: Radiance = 1.0
    ambient: Radiance = 0.0
    lights: tuple[PointEntry | SpotEntry, ...] | None = None
    cameras: dict[str, CameraEntry] = msgspec.field(default_factory=dict)
    paths: dict[str, PathEntry] = msgspec.field(default_factory=dict)
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
    if isinstance(given := document.get("settings"), dict):
        document["settings"] = {n: v for n, v in given.items() if not is_left_open(n, v)}
    file = _convert(document, SceneFile, source, "")
    return msgspec.structs.replace(file, cameras=cameras, paths=paths)


T = TypeVar("T")


def _named(document: dict[str, Any], key: str, kind: type[T], source: str) -> dict[str, T]:
    """Take the tables of one kind out of a document, so that their errors tell their names."""
    tables = document.pop(key, {})
    if not isinstance(tables, dict):
        raise AssetError(source, place=key, expected="a table", found=complaints.shown(tables))
    return {name: _convert(table, kind, source, f"{key}.{name}") for name, table in tables.items()}


def _convert(value: object, kind: type[T], source: str, key: str) -> T:
    """A checked record from plain values; msgspec's complaints become AssetErrors."""
    try:
        return msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        text, path = complaints.taken_apart(error)
        if match := re.match(r"(\w+): (Expected .*)", text):  # of a __post_init__, about a key
            path, text = f"{path}.{match[1]}".lstrip("."), match[2]
        place = ".".join(part for part in (key, path) if part)
        found = complaints.shown_at(value, path)
        if match := re.match(r"Object contains unknown field `(.*)`", text):
            known = ", ".join(_known_keys(value, kind, path))
            raise AssetError(
                source, place=place, expected=f"known keys ({known})", found=match[1]
            ) from None
        if (missing := complaints.missing_key(text)) is not None:
            raise AssetError(
                source, place=place, expected=f"the key {missing}", found="none"
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
        is_type = not got or reason.startswith("`")
        raise AssetError(
            source,
            place=place,
            expected=complaints.in_words(expected),
            found=found if is_type else reason,
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
    is_spot = complaints.at(document, f"{path}.type") == "spot"
    return ["type", *(SpotEntry if is_spot else PointEntry).__struct_fields__]


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
