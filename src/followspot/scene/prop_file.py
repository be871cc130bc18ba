"""The part of a scene file that puts things into the level that never move.

[[props]]
file = "urn.glb"              # or .gltf, .obj, .ply, .md2, .md3: beside this file or the game's
origin = [120, 40, 30]
yaw = 45                      # or angles = [pitch, yaw, roll], in degrees, as the game has them
scale = 1.5                   # after glTF's metres have become units
up = "y"                      # the file's axis that points up; by itself "y" for glTF, else "z"
ground = true                 # dropped until its lowest point stands on the floor below
"""

from enum import Enum
from typing import Annotated

from msgspec import Meta

from followspot.scene.entry import Entry, Point

Angle = Annotated[float, Meta(ge=-1e5, le=1e5)]


class Up(Enum):
    """The axis of a file that points up."""

    Y = "y"
    Z = "z"


class PropEntry(Entry, kw_only=True, frozen=True):
    """One prop; at most one of `yaw` and `angles` is given."""

    file: str
    origin: Point
    yaw: Angle | None = None
    angles: tuple[Angle, Angle, Angle] | None = None
    scale: Annotated[float, Meta(ge=1e-6, le=1e6)] = 1.0
    up: Up | None = None
    ground: bool = False

    def __post_init__(self) -> None:
        if self.yaw is not None and self.angles is not None:
            raise ValueError("Expected `yaw` or `angles`, got both")

    @property
    def turn(self) -> tuple[float, float, float]:
        """Pitch, yaw and roll in degrees."""
        return self.angles or (0.0, self.yaw or 0.0, 0.0)
