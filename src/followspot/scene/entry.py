"""What the tables of a scene file have in common."""

from typing import Annotated

from msgspec import Meta, Struct

FARTHEST = 1e7
"""Units that a coordinate may be from the origin."""

Coordinate = Annotated[float, Meta(ge=-FARTHEST, le=FARTHEST)]
Point = tuple[Coordinate, Coordinate, Coordinate]


class Entry(Struct, forbid_unknown_fields=True, kw_only=True, frozen=True):
    """A table without keys that nobody reads."""
