"""A level under construction."""

from collections.abc import Iterable, Sequence

import numpy as np

from followspot.arrays import Floats
from followspot.game import FLOOR_BELOW_PLAYER
from followspot.levelbuilder.brush import Brush
from followspot.levelbuilder.entities import Entity, Value, entity
from followspot.levelbuilder.mesh import Mesh
from followspot.levelbuilder.patches import Patch

Part = Brush | Patch | Mesh


class Level:
    """A level: parts of the world, and entities with or without parts of their own.

    Args:
        message: The level's title, shown while the game loads it.
        ambient: Light that every surface gets without a source, in byte values, RGB.
    """

    def __init__(
        self, message: str = "", ambient: tuple[float, float, float] = (16.0, 16.0, 16.0)
    ) -> None:
        self.ambient = np.array(ambient)
        self.parts: list[Part] = []
        self.entities: list[Entity] = [entity("worldspawn", message=message)]

    def add(self, *parts: Part | Iterable[Part]) -> None:
        """Add brushes, patches and meshes to the world, or any nesting of them."""
        for part in parts:
            if isinstance(part, Brush | Patch | Mesh):
                self.parts.append(part)
            else:
                self.add(*part)

    def entity(self, classname: str, *brushes: Brush, **keys: Value) -> None:
        """Add an entity; with brushes it becomes a brush model, placed as they stand."""
        item = entity(classname, **keys)
        item.brushes.extend(brushes)
        self.entities.append(item)

    def spawn(self, x: float, y: float, floor: float, angle: float = 0.0) -> None:
        """Add a spawn point on a floor; players look along ``angle``, degrees from +x."""
        self.entity(
            "info_player_deathmatch", origin=(x, y, floor + FLOOR_BELOW_PLAYER), angle=angle
        )

    def light(
        self, origin: Sequence[float], value: float = 300.0, color: Sequence[float] = (1, 1, 1)
    ) -> None:
        """Add a lamp that lights a surface at r units with 7500 value / r^2, in byte values."""
        self.entity("light", origin=origin, light=value, _color=color)

    def origins(self) -> Floats:
        """Return the origins, (n, 3), of the entities that have one: all inside the level."""
        texts = [item.keys["origin"] for item in self.entities if "origin" in item.keys]
        return np.array([text.split() for text in texts], dtype=np.float64).reshape(-1, 3)
