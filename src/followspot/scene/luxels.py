"""Light from surfels to where it is shown: to a level's lightmaps, and to vertices without any."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints
from followspot.assets.binary import run_members
from followspot.scene.baked import PAGE, BakedLight, LightGrid
from followspot.scene.level import Level
from followspot.scene.surfels import Surfels

_AT_ONCE = 1 << 17
"""Luxels that are worked out at a time, about."""

_BEYOND = 1.0
"""Luxels by which triangles are wider there: what is mixed in at their edges is theirs, too."""


@dataclass(frozen=True, eq=False)
class SurfelLight:
    """What lights surfels.

    Attributes:
        surfels: They.
        light: (s, 3) of each.
        grid: What there is where none are near.
    """

    surfels: Surfels
    light: Floats
    grid: LightGrid

    def at(self, places: Floats, normals: Floats) -> NDArray[np.float32]:
        """(n, 3) light on surfaces at (n, 3) world places with (n, 3) unit normals.

        Mixed from surfels of the eight cells around: of those that face the three ways that the
        normal has a part in, by its squares.
        """
        total, sums = np.zeros(len(places)), np.zeros((len(places), 3))
        squares = normals**2
        self._add(places, squares, 2 * np.arange(3) + (normals < 0), total, sums)
        lacking = np.flatnonzero(total < 1e-6)
        total[lacking], sums[lacking] = 1.0, self.grid.around(places[lacking])
        return (sums / np.maximum(total, 1e-9)[:, np.newaxis]).astype(np.float32)

    def times(self, factor: float) -> "SurfelLight":
        """All of it so many times as bright."""
        grid = replace(self.grid, light=self.grid.light * np.float32(factor))
        return SurfelLight(self.surfels, self.light * factor, grid)

    def _add(
        self, places: Floats, weights: Floats, ways: Ints, total: Floats, sums: Floats
    ) -> None:
        of = self.surfels
        place = places / of.edge - of.origin - 0.5
        low = np.floor(place).astype(np.int64)
        share = place - low
        for corner in np.ndindex(2, 2, 2):
            x, y, z = np.clip(low + corner, 0, np.array(of.row.shape) - 1).T
            near = np.where(corner, share, 1 - share).prod(axis=1)
            row = of.row[x, y, z]
            for weight, way in zip(weights.T, ways.T, strict=True):
                surfel = of.in_cell[row, way]
                counts = near * weight * (surfel >= 0)
                total += counts
                sums += counts[:, np.newaxis] * self.light[surfel]


def image(level: Level, own: BakedLight, light: SurfelLight) -> NDArray[np.float32]:
    """(h, w, 3) in the layout of `BakedLight.image`; luxels of no surface are 0."""
    mesh = level.mesh
    assert mesh.baked is not None
    size = np.array([own.columns, own.rows]) * PAGE
    made = np.zeros((size[1], size[0], 3), np.float32)
    white = len(own.bsp.lightmaps)
    _page(made, own, white)[:] = 1.0
    inner = np.zeros(made.shape[:2], bool)
    corners, page = _mapped(level, own)
    place = mesh.baked[:, :2].astype(np.float64)[corners] * size  # luxels
    position = mesh.vertices["position"].astype(np.float64)
    normal = mesh.vertices["normal"].astype(np.float64)
    first_of_page = np.stack([page % own.columns, page // own.columns], axis=1) * PAGE
    low = np.maximum(np.floor(place.min(axis=1) - _BEYOND).astype(np.int64), first_of_page)
    high = np.minimum(np.ceil(place.max(axis=1) + _BEYOND).astype(np.int64), first_of_page + PAGE)
    count = np.maximum(high - low, 0)
    parts = np.searchsorted(
        np.cumsum(count.prod(axis=1)), np.arange(_AT_ONCE, count.prod(axis=1).sum(), _AT_ONCE)
    )
    for some in np.split(np.arange(len(corners)), parts):
        number = count[some].prod(axis=1)
        which = np.repeat(some, number)
        k = run_members(np.zeros(len(some), np.int64), number)
        x = low[which, 0] + k % count[which, 0]
        y = low[which, 1] + k // count[which, 0]
        weights, outside = _weights(place[which], np.stack([x, y], axis=1) + 0.5)
        near = outside < _BEYOND
        x, y, which, weights, is_inner = (
            x[near],
            y[near],
            which[near],
            weights[near],
            outside[near] <= 0,
        )
        at = np.einsum("nk,nkj->nj", weights, position[corners[which]])
        n = np.einsum("nk,nkj->nj", weights, normal[corners[which]])
        n /= np.maximum(np.linalg.norm(n, axis=1, keepdims=True), 1e-9)
        found = light.at(at, n)
        border = ~is_inner & ~inner[y, x]
        made[y[border], x[border]] = found[border]
        made[y[is_inner], x[is_inner]] = found[is_inner]
        inner[y[is_inner], x[is_inner]] = True
    return made


def at_vertices(level: Level, own: BakedLight, light: SurfelLight) -> NDArray[np.float32]:
    """(v, 5) as of `BakedLight.at_vertices`, for all of the level's mesh and its props."""
    mesh = level.mesh
    assert mesh.baked is not None
    found = mesh.baked.copy()
    found[:, 2:] = 1.0
    corners, _ = _mapped(level, own)
    apart = np.ones(len(found), bool)
    apart[corners] = False
    vertices = mesh.vertices[apart]
    found[apart, :2] = own.white
    places, normals = (vertices[name].astype(np.float64) for name in ("position", "normal"))
    found[apart, 2:] = light.at(places, normals)
    return found


def _mapped(level: Level, own: BakedLight) -> tuple[Ints, Ints]:
    """(t, 3) vertices and (t,) lightmap of the triangles that have one."""
    faces = level.mesh.faces
    number = level.visibility.level_face
    page = np.where(number >= 0, own.bsp.faces["lightmap"][number], -1).astype(np.int64)
    of = np.repeat(page, faces["index_count"] // 3)
    has = (of >= 0) & (of < len(own.bsp.lightmaps))
    return level.mesh.indices.reshape(-1, 3)[has].astype(np.int64), of[has]


def _page(made: NDArray[np.float32], own: BakedLight, number: int) -> NDArray[np.float32]:
    x, y = number % own.columns * PAGE, number // own.columns * PAGE
    return made[y : y + PAGE, x : x + PAGE]


def _weights(corners: Floats, points: Floats) -> tuple[Floats, Floats]:
    """(n, 3) of triangles' (n, 3, 2) corners at (n, 2) points, and how far outside those are."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    area = _cross(b - a, c - a)
    area = np.where(np.abs(area) < 1e-9, 1e-9, area)
    edges = (c - b, a - c, b - a)
    starts = (b, c, a)
    weights = np.stack(
        [_cross(edge, points - start) / area for edge, start in zip(edges, starts, strict=True)],
        axis=1,
    )
    heights = np.stack(
        [np.abs(area) / np.maximum(np.linalg.norm(e, axis=1), 1e-9) for e in edges], axis=1
    )
    return weights, (-weights * heights).max(axis=1)


def _cross(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
