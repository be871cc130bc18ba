"""A scene file's text, changed key by key: comments, order, and all that is not named stay.

Keys change where they stand; new tables come at the end, but for lights, which stay together.
"""

import enum
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import tomlkit
from tomlkit.exceptions import TOMLKitError
from tomlkit.items import AoT, InlineTable, Table

from followspot import spaces
from followspot.errors import AssetError
from followspot.scene.camera import Camera
from followspot.scene.light import Light, SpotLight
from followspot.scene.path import CameraPath
from followspot.scene.settings import Settings

DIGITS = 7
"""That numbers are written with: what a float32 holds, which is what widgets and GPU work with."""


def new(level: str) -> str:
    """The text of a scene file that names a level, and nothing else yet."""
    return tomlkit.dumps({"level": level})


class Document:
    """A scene file's text.

    What the methods are told of as before is what the text says; where that is the same as now,
    the text stays as it is, byte for byte.

    Args:
        text: It is a valid scene file.
        source: Names it in errors.

    Raises:
        AssetError: it cannot be taken apart.
    """

    def __init__(self, text: str, source: str) -> None:
        try:
            self._toml: Any = tomlkit.parse(text)
        except TOMLKitError as error:
            raise AssetError(source, expected="TOML to edit", found=str(error)) from None
        self._before = text
        self._is_changed = False
        self._new: list[tuple[str, Table]] = []  # with their headers

    @property
    def text(self) -> str:
        """The text as it has become."""
        if not self._is_changed:
            return self._before
        parts = [tomlkit.dumps(self._toml)]
        parts += [f"{header}\n{table.as_string()}" for header, table in self._new]
        return "\n".join(part.rstrip("\n") + "\n" for part in parts)

    def put_number(self, key: str, value: float, before: float) -> None:
        """A number that stands outside of all tables."""
        if value != before:
            self._put(self._toml, key, value)

    def put_settings(self, settings: Settings, before: Settings) -> None:
        """Those settings that have changed; none is no key."""
        values = {name: getattr(settings, name) for name in Settings.__struct_fields__}
        changed = {n: value for n, value in values.items() if value != getattr(before, n)}
        if not changed:
            return
        if "settings" in self._toml:
            table = self._toml["settings"]
        else:
            table = self._new_table("[settings]")
        for name, value in changed.items():
            if value is not None:
                self._put(table, name, value)
            else:
                del table[name]
                self._is_changed = True

    def put_camera(self, name: str, camera: Camera, before: Camera | None) -> None:
        """A named view."""
        keys = [k for k in ("position", "yaw", "pitch", "fov") if _differs(camera, before, k)]
        if keys:
            table = self._named("cameras", name)
            for key in keys:
                self._put(table, key, getattr(camera, key))

    def put_path(self, name: str, path: CameraPath) -> None:
        """A new path, by its keys, as they are: they have been rounded."""
        keys = tomlkit.array()
        for key in path.keys:
            entry = tomlkit.inline_table()
            for part in ("time", "position", "yaw", "pitch", "fov"):
                entry[part] = _plain(getattr(key, part), digits=15)
            keys.append(entry)
        self._put(self._named("paths", name), "keys", keys.multiline(True))

    def put_lights(self, lights: Sequence[tuple[Light, int | None]], before: list[Light]) -> None:
        """All lights.

        Args:
            lights: Each with its number among those before, or none if it is new. Those that were
                there before come first, in their old order.
            before: What the text says.
        """
        old = [number for _, number in lights if number is not None]
        for gone in sorted(set(range(len(before))) - set(old), reverse=True):
            del self._toml["lights"][gone]
            self._is_changed = True
        if not lights:
            self._put(self._toml, "lights", [])
        for at, (light, number) in enumerate(lights):
            if number is None:
                self._put_light(self._new_light(), light, None)
            else:
                self._put_light(self._toml["lights"][at], light, before[number])

    def _new_light(self) -> Any:
        """The table of one more light."""
        entries = self._toml.get("lights")
        if isinstance(entries, AoT) and not entries:  # which an empty one is no place for
            entries = None
            del self._toml["lights"]
        if entries is None:
            return self._new_table("[[lights]]")
        if not isinstance(entries, AoT):
            entries.append(tomlkit.inline_table())
            return entries[-1]
        if not entries[-1].as_string().endswith("\n\n"):
            entries[-1].add(tomlkit.nl())
        entries.append(tomlkit.table().add(tomlkit.nl()))
        return entries[-1]

    def _put_light(self, table: Any, light: Light, before: Light | None) -> None:
        is_new = before is None
        if _differs(light, before, "name") and (light.name or not is_new):
            self._put(table, "name", light.name)
        if is_new:
            self._put(table, "type", "spot" if isinstance(light, SpotLight) else "point")
        is_moved = _differs(light, before, "position")
        if is_moved:
            self._put(table, "position", light.position)
        if isinstance(light, SpotLight):
            is_turned = _differs(light, before, "direction")
            if before is None or ("target" not in table and is_turned):
                self._put(table, "direction", light.direction)
            elif "target" in table and (is_moved or is_turned):  # which is as far off as it was
                old = spaces.vec3([float(number) for number in table["target"]])
                distance = np.linalg.norm(old - before.position)
                self._put(table, "target", light.position + light.direction * distance)
            if _differs(light, before, "half_angle"):
                self._put(table, "half_angle_degrees", np.degrees(light.half_angle))
            if _differs(light, before, "softness") and (light.softness > 0 or not is_new):
                self._put(table, "softness", light.softness)
        if _differs(light, before, "casts_shadow") and not (light.casts_shadow and is_new):
            self._put(table, "casts_shadow", light.casts_shadow)
        if _differs(light, before, "power"):
            is_grey = (light.power == light.power[0]).all()
            self._put(table, "power", light.power[0] if is_grey else light.power)

    def _named(self, section: str, name: str) -> Any:
        """The table of a view or path, which may be a new one."""
        tables = self._toml.get(section, {})
        if name in tables:
            return tables[name]
        if isinstance(tables, InlineTable):
            tables[name] = tomlkit.inline_table()
            return tables[name]
        return self._new_table(f"[{section}.{tomlkit.key(name).as_string()}]")

    def _new_table(self, header: str) -> Table:
        self._new.append((header, tomlkit.table()))
        return self._new[-1][1]

    def _put(self, table: Any, key: str, value: Any) -> None:
        """Set a key; a new one comes right after the others, not after what parts it from the
        next table.
        """
        self._is_changed = True
        behind: list[Any] = []
        if isinstance(table, Table) and key not in table:
            while table.value.body and table.value.body[-1][0] is None:
                behind.insert(0, table.value.body.pop()[1])
        table[key] = _plain(value)
        for each in behind:
            table.add(each)


def _differs(now: object, before: object, name: str) -> bool:
    return before is None or not np.array_equal(getattr(now, name), getattr(before, name))


def _plain(value: Any, digits: int = DIGITS) -> Any:
    """A value as TOML has it, numbers rounded; those of a vector as its largest one."""
    if isinstance(value, enum.Enum):
        return value.value
    if isinstance(value, np.ndarray):
        before_point = math.floor(math.log10(np.abs(value).max() or 1.0)) + 1
        return [_plain(number, 15) for number in np.round(value, digits - before_point).tolist()]
    if not isinstance(value, float):
        return value
    rounded = float(f"{value:.{digits}g}")
    return int(rounded) if rounded.is_integer() else rounded
