"""Light that a level's compiler baked: lightmaps, colours at vertices, the light grid.

Values are light on display, as the game multiplies them with textures: four times what the file
has, but twice full brightness at most, beyond which colours keep their hue (ioquake3's
``R_ColorShiftLightingBytes``, and its gamma, which doubles). Here they are linear: 1 lights a
surface so that its texture looks as it was painted.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints
from followspot.assets.bsp import BspFile
from followspot.assets.entities import entity_vector
from followspot.assets.image import srgb_to_linear

PAGE = 128
"""Luxels along an edge of a lightmap."""

CELL = (64.0, 64.0, 128.0)
"""Units from point to point of the light grid, where the level does not say."""

BRIGHTEST = 2.0
"""On display."""

_WHITE = -2
"""Number of the lightmap of faces that are fully lit."""


def decoded(values: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(..., 3) bytes of a file as linear light."""
    shown = values.astype(np.float32) * np.float32(4 / 255)
    excess = shown.max(axis=-1, keepdims=True) / np.float32(BRIGHTEST)
    return srgb_to_linear(shown / np.maximum(excess, 1))


@dataclass(frozen=True, eq=False)
class LightGrid:
    """Light at points in rows.

    Attributes:
        first: (3,) the first point, world units.
        cell: (3,) units from one to the next.
        count: (3,) how many there are along each axis.
        light: (points, 3) linear, x running fastest; black in walls. May be empty.
    """

    first: Floats
    cell: Floats
    count: Ints
    light: NDArray[np.float32]

    def around(self, points: Floats) -> Floats:
        """(n, 3) light at (n, 3) world points, 0 where there is no grid.

        Between the eight points of the grid around, without those in walls.
        """
        count, light = self.count, self.light
        if not len(light):
            return np.zeros((len(points), 3))
        place = np.clip((points - self.first) / self.cell, 0, count - 1)
        low = np.minimum(place.astype(np.int64), np.maximum(count - 2, 0))
        share = place - low
        total, sums = np.zeros(len(points)), np.zeros((len(points), 3))
        for corner in np.ndindex(2, 2, 2):
            x, y, z = np.minimum(low + corner, count - 1).T
            found = light[x + count[0] * (y + count[1] * z)]
            weight = np.where(corner, share, 1 - share).prod(axis=1) * found.any(axis=1)
            total += weight
            sums += weight[:, np.newaxis] * found
        return sums / np.maximum(total, 1e-9)[:, np.newaxis]


@dataclass(frozen=True, eq=False)
class TracedLight:
    """What takes a level's baked light's place once it is traced anew; see `scene.bounce`.

    Attributes:
        luxels: (h, w, 3) linear light as of `BakedLight.image`.
        grid: What there is in the open.
        unit: Radiance in W/(m^2 sr) of a white surface under a light of 1.
    """

    luxels: NDArray[np.float32]
    grid: LightGrid
    unit: float

    def image(self) -> NDArray[np.float32]:
        """(h, w, 3) as `BakedLight.image`."""
        return self.luxels

    def around(self, points: Floats) -> Floats:
        """(n, 3) as `BakedLight.around`."""
        return self.grid.around(points)


@dataclass(frozen=True, eq=False)
class BakedLight:
    """A level's.

    Attributes:
        bsp: Where it comes from.
    """

    bsp: BspFile

    @property
    def columns(self) -> int:
        """Lightmaps next to each other in `image`, which ends with a white one."""
        return math.ceil(math.sqrt(len(self.bsp.lightmaps) + 1))

    @property
    def rows(self) -> int:
        """Lightmaps above each other in `image`."""
        return -(-(len(self.bsp.lightmaps) + 1) // self.columns)

    def image(self) -> NDArray[np.float32]:
        """(h, w, 3) linear light of all lightmaps, row 0 at texture coordinate 0."""
        pages = np.ones((self.rows * self.columns, PAGE, PAGE, 3), np.float32)
        for page, luxels in zip(pages, self.bsp.lightmaps, strict=False):
            page[:] = decoded(luxels)
        rows = pages.reshape(self.rows, self.columns, PAGE, PAGE, 3).swapaxes(1, 2)
        return rows.reshape(self.rows * PAGE, self.columns * PAGE, 3)

    def at_vertices(self, vertices: Ints, faces: Ints) -> NDArray[np.float32]:
        """What lights a level's vertices: the product of a luxel and a colour.

        Args:
            vertices: (v,) their numbers.
            faces: (v,) the face that each is drawn with.

        Returns:
            (v, 5) place in `image`, from 0 to 1; linear light that luxels there are multiplied by.
        """
        page = self.bsp.faces["lightmap"][faces]
        is_mapped = (page >= 0) & (page < len(self.bsp.lightmaps))
        found = np.ones((len(vertices), 5), np.float32)
        found[:, :2] = self._place(np.full(len(vertices), len(self.bsp.lightmaps)), 0.5)
        place = self.bsp.vertices["lightmap_texcoord"][vertices[is_mapped]]
        edge = 0.5 / PAGE  # beyond it, luxels of the next page would be mixed in
        place = np.clip(np.nan_to_num(place), edge, 1 - edge)
        found[is_mapped, :2] = self._place(page[is_mapped], place)
        by_color = ~is_mapped & (page != _WHITE)
        found[by_color, 2:] = decoded(self.bsp.vertices["color"][vertices[by_color], :3])
        return found

    def at_points(self, points: Floats) -> NDArray[np.float32]:
        """What lights things that are not the level's, in the form of `at_vertices`.

        Args:
            points: (n, 3) in world units.
        """
        found = np.empty((len(points), 5), np.float32)
        found[:, :2] = self._place(np.full(len(points), len(self.bsp.lightmaps)), 0.5)
        found[:, 2:] = self.around(points)
        return found

    def _place(self, page: Ints, within: NDArray[np.float32] | float) -> NDArray[np.float32]:
        corner = np.stack([page % self.columns, page // self.columns], axis=1)
        place = (corner + within) / (self.columns, self.rows)
        return place.astype(np.float32)

    @property
    def white(self) -> NDArray[np.float32]:
        """(2,) place in `image` of a white luxel."""
        return self._place(np.array([len(self.bsp.lightmaps)]), 0.5).ravel()

    def grid_points(self, limit: int | None = None) -> tuple[Floats, Floats, Ints]:
        """Where the light grid is: (3,) first point, (3,) units between points, (3,) how many.

        Args:
            limit: So many are enough: they are farther apart than in the level's own grid then.
        """
        world = self.bsp.models[0]
        given = entity_vector(self.bsp.entities[0], "gridsize") if self.bsp.entities else None
        cell = np.array(CELL) if given is None or not (given > 0).all() else given
        while True:
            first = np.asarray(cell * np.ceil(world["mins"] / cell))
            count = np.asarray(np.floor((world["maxs"] - first) / cell) + 1, np.int64)
            if limit is None or count.prod() <= limit:
                return first, cell, count
            cell = cell * 1.25

    @cached_property
    def _grid(self) -> LightGrid:
        first, cell, count = self.grid_points()
        grid = self.bsp.light_grid
        if (count < 1).any() or len(grid) != count.prod():
            return LightGrid(first, cell, count, np.zeros((0, 3), np.float32))
        # A surface that may face any way has a quarter of what one has that faces the light.
        light = decoded(grid["ambient"]) + decoded(grid["directed"]) / np.float32(4)
        return LightGrid(first, cell, count, light)

    def around(self, points: Floats) -> Floats:
        """(n, 3) linear light at (n, 3) world points, in the mean over all ways to face."""
        return self._grid.around(points)
