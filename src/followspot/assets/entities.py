"""The entities of a Quake III level: ``{ "key" "value" ... }``, again and again.

Strings know no escapes and may run over lines. Words without quotes and comments of both C kinds
are taken, as the engine's own tokenizer takes them (`COM_Parse` in ioquake3's `q_shared.c`).
"""

import math
import re

import numpy as np

from followspot.arrays import Floats
from followspot.assets.bsp import BspFile
from followspot.errors import AssetError

_TOKEN = re.compile(
    r"""(?P<comment> //[^\n]* | /\*.*?(?:\*/|\Z) )
      | (?P<brace> [{}] )
      | "(?P<string> [^"]* )"
      | (?P<open_string> "[^\n]* )
      | (?P<word> [^\s{}"]+ )""",
    re.VERBOSE | re.DOTALL,
)
_FLAGS = re.compile(r"\s*([+-]?[0-9]{1,8})", re.ASCII)


def parse_entities(text: str, source: str) -> tuple[dict[str, str], ...]:
    """Parse the text of a level's entities.

    Args:
        text: The lump, up to its NUL.
        source: The file's name for errors.

    Returns:
        One dict an entity, in file order: keys in lower case, since the engine compares them so;
        values as written. Of equal keys the last one counts.

    Raises:
        AssetError: A brace, a value or a closing quote is missing; with the line.
    """
    entities: list[dict[str, str]] = []
    entity: dict[str, str] | None = None
    key: str | None = None

    def error(position: int, expected: str, found: str) -> AssetError:
        line = text.count("\n", 0, position) + 1
        return AssetError(source, place=f"entities line {line}", expected=expected, found=found)

    for match in _TOKEN.finditer(text):
        token, start = match[0], match.start()
        if match["comment"] is not None:
            continue
        if match["open_string"] is not None:
            raise error(start, "a closing quote", f"none after {token[:40]}")
        word = match["word"] if match["string"] is None else match["string"]
        if entity is None:
            if token != "{":
                raise error(start, "{", token[:40])
            entity = {}
        elif key is None:
            if word is not None:
                key = word.lower()
            elif token == "}":
                entities.append(entity)
                entity = None
            else:
                raise error(start, "a key or }", token)
        elif word is not None:
            entity[key] = word
            key = None
        else:
            raise error(start, f"a value for key {key[:40]!r}", token)
    if entity is not None:
        raise error(len(text), "}", "the end of the text")
    return tuple(entities)


def model_number(bsp: BspFile, entity: dict[str, str]) -> int | None:
    """Which brush model an entity places, if it does; never the world, which stands by itself."""
    name = entity.get("model", "")
    if not (name.startswith("*") and name[1:].isdecimal() and len(name) < 9):
        return None
    number = int(name[1:])
    return number if 0 < number < len(bsp.models) else None


def entity_vector(entity: dict[str, str], key: str) -> Floats | None:
    """Three finite numbers of an entity's key, or none where they are missing or malformed."""
    try:
        vector = np.array([float(word) for word in entity[key].split()], np.float64)
    except (KeyError, ValueError):
        return None
    return vector if vector.shape == (3,) and np.isfinite(vector).all() else None


def entity_angles(entity: dict[str, str]) -> tuple[float, float]:
    """(yaw, pitch) in degrees of an entity's ``angles`` or ``angle``; 0 if malformed."""
    angles = entity_vector(entity, "angles")
    if angles is not None:
        return float(angles[1]), float(angles[0])
    try:
        yaw = float(entity.get("angle", "0"))
    except ValueError:
        return 0.0, 0.0
    return (yaw if math.isfinite(yaw) else 0.0), 0.0


def target_of(bsp: BspFile, entity: dict[str, str]) -> dict[str, str]:
    """The first entity that another one names as its target, in any case; empty where none is.

    Of several the game takes any.
    """
    name = entity.get("target", "").lower()
    named = (e for e in bsp.entities if name and e.get("targetname", "").lower() == name)
    return next(named, {})


def entity_flags(entity: dict[str, str]) -> int:
    """An entity's ``spawnflags`` as C's ``atoi`` reads them, but no more than eight digits."""
    match = _FLAGS.match(entity.get("spawnflags", ""))
    return int(match.group(1)) if match else 0
