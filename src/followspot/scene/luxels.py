"""Light from surfels to where it is shown: to a level's lightmaps, and to vertices without any."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints, Mask
from followspot.assets.binary import run_members
from followspot.scene.baked import PAGE, BakedLight, LightGrid
from followspot.scene.level import Level
from followspot.scene.surfels import Surfels, with_beyond

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
        of, light = self.surfels, with_beyond(self.light)
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
                sums += counts[:, np.newaxis] * light[surfel]


def image(level: Level, own: BakedLight, light: SurfelLight) -> NDArray[np.float32]:
    """(h, w, 3) in the layout of `BakedLight.image`; luxels of no surface are 0."""
    made = np.zeros((own.rows * PAGE, own.columns * PAGE, 3), np.float32)
    x, y = np.rint(own.white * made.shape[1::-1]).astype(int)
    made[y - 1 : y + 1, x - 1 : x + 1] = 1.0  # the place is between four luxels
    inner = np.zeros(made.shape[:2], bool)
    for near in _near_luxels(level, own):
        found = light.at(near.places, near.normals)
        border = ~near.is_inner & ~inner[near.y, near.x]
        for some in (border, near.is_inner):
            made[near.y[some], near.x[some]] = found[some]
        inner[near.y[near.is_inner], near.x[near.is_inner]] = True
    return made


class _Near(NamedTuple):
    """Luxels in a triangle or just beside it, n of them.

    Of each its column and row, whether it is inside, and the (n, 3) place and normal there.
    """

    x: Ints
    y: Ints
    is_inner: Mask
    places: Floats
    normals: Floats


def _near_luxels(level: Level, own: BakedLight) -> Iterator[_Near]:
    """Those of all triangles, _AT_ONCE or so at a time."""
    mesh = level.mesh
    assert mesh.baked is not None
    corners, page = _mapped(level, own)
    place = mesh.baked[:, :2].astype(np.float64)[corners]
    place *= np.array([own.columns, own.rows]) * PAGE  # in luxels
    first = np.stack([page % own.columns, page // own.columns], axis=1) * PAGE
    low = np.maximum(np.floor(place.min(axis=1) - _BEYOND).astype(np.int64), first)
    high = np.minimum(np.ceil(place.max(axis=1) + _BEYOND).astype(np.int64), first + PAGE)
    width, height = np.maximum(high - low, 0).T
    count = width * height
    ends = np.searchsorted(np.cumsum(count), np.arange(_AT_ONCE, count.sum(), _AT_ONCE))
    for some in np.split(np.arange(len(corners)), ends):
        which = np.repeat(some, count[some])
        k = run_members(np.zeros(len(some), np.int64), count[some])
        x, y = low[which, 0] + k % width[which], low[which, 1] + k // width[which]
        weights, outside = _weights(place[which], np.stack([x, y], axis=1) + 0.5)
        near = outside < _BEYOND
        of, weights = corners[which[near]], weights[near]
        places, normals = (
            np.einsum("nk,nkj->nj", weights, mesh.vertices[name][of].astype(np.float64))
            for name in ("position", "normal")
        )
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
        yield _Near(x[near], y[near], outside[near] <= 0, places, normals)


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
