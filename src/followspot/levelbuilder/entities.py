"""Entities: the text lump of things that are not walls."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from followspot.errors import UsageError
from followspot.levelbuilder.brush import Brush

_NUMBERS = {"origin": 3, "_color": 3, "light": 1}  # what the compiler reads, and how many of them

Value = str | float | Sequence[float]


@dataclass
class Entity:
    """One entity: its keys and, for doors and the like, its brushes.

    Attributes:
        keys: Key to text, ``classname`` first.
        brushes: Solids of its own brush model; empty for a point entity.
    """

    keys: dict[str, str]
    brushes: list[Brush] = field(default_factory=list)


def entity(classname: str, **keys: Value) -> Entity:
    """Return an entity; numbers and sequences of numbers become the text the engine reads.

    Raises:
        UsageError: A text cannot be written, or is not the numbers that the key has to hold.
    """
    texts = {key: _text(value) for key, value in {"classname": classname, **keys}.items()}
    for key in _NUMBERS.keys() & texts.keys():
        _require_numbers(key, texts[key])
    return Entity(texts)


def _require_numbers(key: str, text: str) -> None:
    try:
        numbers = np.array(text.split(), dtype=np.float64)
    except ValueError:
        numbers = np.empty(0)
    if len(numbers) != _NUMBERS[key] or not np.isfinite(numbers).all():
        count = _NUMBERS[key]
        raise UsageError(f"an entity's {key} needs finite numbers, {count} in all, not {text!r}")


def _text(value: Value) -> str:
    if isinstance(value, str):
        text = value
    elif isinstance(value, Sequence):
        text = " ".join(f"{number:g}" for number in value)
    else:
        text = f"{value:g}"
    if '"' in text or "\n" in text:
        raise UsageError(f"an entity's text can hold no quotes or line breaks: {text!r}")
    if not all(" " <= character <= "\xff" for character in text):
        raise UsageError(f"an entity's text can hold only characters of Latin-1: {text!r}")
    return text


def entity_lump(entities: Sequence[Entity]) -> bytes:
    """Return the entity lump, with its closing NUL."""
    blocks = (
        "{\n" + "".join(f'"{key}" "{text}"\n' for key, text in item.keys.items()) + "}\n"
        for item in entities
    )
    return "".join(blocks).encode("latin-1") + b"\0"
