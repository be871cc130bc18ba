"""What the tables of a scene file have in common."""

from typing import Annotated

from msgspec import Meta, Struct

FARTHEST = 1e7
"""Units that a coordinate may be from the origin."""

Coordinate = Annotated[float, Meta(ge=-FARTHEST, le=FARTHEST)]
Point = tuple[Coordinate, Coordinate, Coordinate]


class Entry(Struct, forbid_unknown_fields=True, kw_only=True, frozen=True):
    """A table without keys that nobody reads."""


def require_one(**choices: object) -> None:
    """Require that exactly one of two keys is given; a ValueError tells which are."""
    given = [name for name, value in choices.items() if value is not None]
    if len(given) != 1:
        names, found = " and ".join(f"`{name}`" for name in choices), "both" if given else "neither"
        raise ValueError(f"Expected one of {names}, got {found}")
