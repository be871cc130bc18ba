"""The part of a scene file that puts characters into the level.

actors = "spawns"             # players at the level's spawn points, each in its turn
items = "entities"            # the level's pick-ups, turning and bobbing

[[characters]]
model = "player:sarge"        # or a file in the archive: models/robot/robot.md2
position = [0, 64, 40]        # dropped to the floor below, unless on_ground = false
yaw = 90
animation = "run+attack"      # names as `inspect` lists them; a player's legs+torso
then = [{ at = 2.5, animation = "gesture" }]
skin = "red"
clock = 0.3                   # seconds by which it is ahead of the others

[[characters]]
model = "player:penguin"
path = [[0, 0, 40], [200, 0, 40], [200, 300, 40]]
closed = true                 # and back to the first point; else it stops at the last
speed = 200                   # units a second, else what fits its steps; of what has none (it
                              # hops or floats) the game's: 320, walking 160, crouched 80
"""

from collections.abc import Sequence
from enum import Enum
from typing import Annotated

from msgspec import Meta

from followspot.scene.entry import Coordinate, Entry, Point, require_one

Seconds = Annotated[float, Meta(ge=-1e6, le=1e6)]


class Actors(Enum):
    """Characters that a scene has without naming them."""

    NONE = "none"
    SPAWNS = "spawns"


class Items(Enum):
    """Pick-ups that a scene shows."""

    NONE = "none"
    ENTITIES = "entities"


class ThenEntry(Entry, kw_only=True, frozen=True):
    """What a character does next, and from which of its seconds on."""

    at: Seconds
    animation: str


class CharacterEntry(Entry, kw_only=True, frozen=True):
    """One character; exactly one of `position` and `path` is given."""

    model: str
    position: Point | None = None
    path: Annotated[tuple[Point, ...], Meta(max_length=1000)] | None = None
    yaw: Coordinate = 0.0
    on_ground: bool = True
    animation: str | None = None
    then: tuple[ThenEntry, ...] = ()
    skin: Annotated[str, Meta(min_length=1)] | None = None
    closed: bool = True
    speed: Annotated[float, Meta(gt=0, le=1e5)] | None = None
    clock: Seconds = 0.0

    def __post_init__(self) -> None:
        require_one(position=self.position, path=self.path)
        _require_order(self.then)


def _require_order(then: Sequence[ThenEntry]) -> None:
    times = [entry.at for entry in then]
    if times != sorted(times):
        raise ValueError(f"Expected times in rising order in `then`, got {times}")
