"""A level's surfaces as few small ones, and what straight lines meet first among those.

Space is cut into cubes, the cells. All surface in a cell that faces the same one of six ways most
is one surfel, a surface element with a place and a normal. A line goes from cell to cell; where no
surface is near, it leaps as far as that is away at least (Hart, "Sphere Tracing", 1996).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints, Mask
from followspot.scene.voxels import spread

SKY, NOTHING = -1, -2
"""What a line may meet instead of a surfel."""

EDGE = 16.0
"""Units along a cell's edge, at least."""

_MAX_SURFELS = 30_000
"""About how many there are at most: cells are larger where there is more surface."""
_MAX_CELLS = 12_000_000
_GAP = 0.3
"""Cells' edges between the points by which surfaces are found."""
_MARGIN = 0.3
"""Edges by which a surfel is wider than its points: as much as the gap between those."""
_LIFT = 0.1
"""Edges above their surfaces between which neighbours see each other."""
_ALIKE = 0.9
"""Cosine from which on neighbours are of one surface."""
_ASIDE = 0.37
"""Edges by which cells begin beside whole numbers, on which walls stand: those would be on the
border of two cells."""
_TOUCHING = 0.01
"""Edges behind a surface at which a line may begin and still meet it."""
_FARTHEST = 31
"""Cells of a leap, at most."""
_AT_ONCE = 1 << 16
"""Lines that are marched at a time: they fit into caches."""


@dataclass(frozen=True, eq=False)
class Surfels:
    """Those of a level.

    Attributes:
        edge: Units along a cell's edge.
        origin: (3,) where the first cell begins, in edges from the world's 0.
        row: (x, y, z) int32 which row of `in_cell` a cell has; 0 is that of empty ones.
        away: (x, y, z) uint8 cells to the nearest one that is not empty, along that axis on which
            it is farthest.
        in_cell: (rows, 6) the surfels that face +X -X +Y -Y +Z -Z most; NOTHING for none.
        is_sky: (rows,) whether the sky is seen there.
        places: (s, 3) in the middle of the surface, in front of all of it, world units.
        normals: (s, 3) unit ones.
        mins: (s, 3) of the box around the surface, world units.
        maxs: (s, 3) likewise.
        areas: (s,) of the surface, square units.
        shares: (p,) material, surfel and area of all pairs of a surfel and what it is made of.
    """

    edge: float
    origin: Floats
    row: NDArray[np.int32]
    away: NDArray[np.uint8]
    in_cell: NDArray[np.int32]
    is_sky: Mask
    places: Floats
    normals: Floats
    mins: Floats
    maxs: Floats
    areas: Floats
    shares: tuple[Ints, Ints, Floats]

    @classmethod
    def of(cls, triangles: Floats, materials: Ints, sky: Floats) -> "Surfels":
        """Those of triangles.

        Args:
            triangles: (t, 3, 3) corners in world units, front faces clockwise.
            materials: (t,) numbers, for `shares`.
            sky: (k, 3, 3) triangles through which the sky is seen.
        """
        a, b, c = (triangles[:, k] for k in range(3))
        across = np.cross(c - a, b - a)
        size = np.linalg.norm(across, axis=1)
        real = size > 1e-6
        triangles, materials, across, size = (x[real] for x in (triangles, materials, across, size))
        edge = max(EDGE, math.sqrt(size.sum() / 2 / _MAX_SURFELS))
        corners = np.concatenate([triangles, sky]).reshape(-1, 3)
        corners = corners if len(corners) else np.zeros((1, 3))  # of nothing
        reach = np.ptp(corners, axis=0)
        edge = max(edge, float(((reach + 2 * edge).prod() / _MAX_CELLS) ** (1 / 3)))
        origin = np.floor(corners.min(axis=0) / edge) - 1 - _ASIDE
        shape = np.floor(corners.max(axis=0) / edge - origin).astype(np.int64) + 2

        points, of = spread(triangles, _GAP * edge)
        area = (size / 2 / np.maximum(np.bincount(of, minlength=len(size)), 1))[of]
        normal = (across / np.maximum(size, 1e-12)[:, np.newaxis])[of]
        cell = np.ravel_multi_index(np.floor(points / edge - origin).astype(np.int64).T, shape)
        seen, _ = spread(sky, _GAP * edge)
        open_ = np.ravel_multi_index(np.floor(seen / edge - origin).astype(np.int64).T, shape)

        taken = np.unique(np.concatenate([cell, open_]))
        row = np.zeros(shape.prod(), np.int32)
        row[taken] = np.arange(1, len(taken) + 1)
        is_sky = np.zeros(len(taken) + 1, bool)
        is_sky[row[open_]] = True
        axis = np.abs(normal).argmax(axis=1)
        way = 2 * axis + (np.take_along_axis(normal, axis[:, np.newaxis], axis=1)[:, 0] < 0)
        found, surfel = np.unique(row[cell].astype(np.int64) * 6 + way, return_inverse=True)
        in_cell = np.full((len(taken) + 1) * 6, NOTHING, np.int32)
        in_cell[found] = np.arange(len(found))

        areas = np.asarray(np.bincount(surfel, area), np.float64)
        normals = _sums(surfel, normal, area)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        places = _sums(surfel, points, area) / np.maximum(areas, 1e-12)[:, np.newaxis]
        # Where surfaces lie behind each other, the front one is what is seen.
        heights = np.einsum("ij,ij->i", points - places[surfel], normals[surfel])
        front = np.zeros(len(places))
        np.maximum.at(front, surfel, heights)
        places += normals * front[:, np.newaxis]
        order = np.argsort(surfel, kind="stable")
        starts = np.searchsorted(surfel[order], np.arange(len(places)))
        mins, maxs = (each.reduceat(points[order], starts) for each in (np.minimum, np.maximum))
        kinds = materials.max(initial=0) + 1
        pair, which = np.unique(surfel * kinds + materials[of], return_inverse=True)
        share = np.asarray(np.bincount(which, area), np.float64)
        return cls(
            edge,
            origin,
            row.reshape(shape),
            _away((row > 0).reshape(shape)),
            in_cell.reshape(-1, 6),
            is_sky,
            places,
            normals,
            mins,
            maxs,
            areas,
            (pair % kinds, pair // kinds, share),
        )

    def means(self, of_material: Floats) -> Floats:
        """(s, c) means over each surfel's surface of something that materials have, (m, c)."""
        material, surfel, area = self.shares
        sums = _sums(surfel, of_material[material], area)
        return sums / np.maximum(self.areas, 1e-12)[:, np.newaxis]

    def beside(self) -> Iterator[Ints]:
        """Eight times (s,) the neighbour of each surfel that faces as it does and that it sees, in
        one of the eight cells around it that its surface may go on in; NOTHING for none.
        """
        x, y, z = np.nonzero(self.row)
        row, way = np.nonzero(self.in_cell[self.row[x, y, z]] >= 0)
        surfel = self.in_cell[self.row[x, y, z]][row, way]
        cell = np.empty((len(self.places), 3), np.int64)
        cell[surfel] = np.stack([x, y, z], axis=1)[row]
        of_way = np.empty(len(self.places), np.int64)
        of_way[surfel] = way
        lifted = self.places + self.normals * (_LIFT * self.edge)
        one, other = (of_way // 2 + 1) % 3, (of_way // 2 + 2) % 3
        for step in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)):
            there = cell.copy()
            there[np.arange(len(cell)), one] += step[0]
            there[np.arange(len(cell)), other] += step[1]
            i, j, k = np.clip(there, 0, np.array(self.row.shape) - 1).T
            found = self.in_cell[self.row[i, j, k], of_way].astype(np.int64)
            has = np.flatnonzero(found >= 0)
            to = found[has]
            alike = np.einsum("ij,ij->i", self.normals[has], self.normals[to]) > _ALIKE
            hidden = self.met(lifted[has], lifted[to] - lifted[has], ends=True) >= 0
            found[has[hidden | ~alike]] = NOTHING
            yield found

    def met(self, start: Floats, way: Floats, *, ends: bool = False) -> Ints:
        """(n,) the surfel that each line meets first, or SKY, or NOTHING.

        A surfel is met from its front alone.

        Args:
            start: (n, 3) world units.
            way: (n, 3) directions.
            ends: Whether lines end at ``start + way``.
        """
        found = np.empty(len(start), np.int64)
        for first in range(0, len(start), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            found[some] = self._march(start[some], way[some], ends)
        return found

    def _march(self, start: Floats, way: Floats, ends: bool) -> Ints:
        found = np.full(len(start), NOTHING, np.int64)
        length = np.abs(way).max(axis=1)
        along = way / length[:, np.newaxis]
        lines = _Lines(
            np.arange(len(start)),
            start / self.edge - self.origin,
            np.where(np.abs(along) < 1e-9, 1e-9, along),
            length / self.edge if ends else np.full(len(start), np.inf),
            np.zeros(len(start)),
        )
        while len(lines.number):
            cell = np.floor(lines.start + lines.along * lines.at[:, np.newaxis]).astype(np.int64)
            inside = ((cell >= 0) & (cell < self.row.shape)).all(axis=1) & (lines.at < lines.last)
            if not inside.all():
                lines, cell = lines.chosen(inside), cell[inside]
            x, y, z = cell.T
            leaving = ((cell + (lines.along > 0) - lines.start) / lines.along).min(axis=1) + 1e-6
            away = self.away[x, y, z]
            near = np.flatnonzero(away == 0)
            rows = self.row[x[near], y[near], z[near]]
            hit = self._hit(rows, lines.chosen(near))
            hit[(hit == NOTHING) & self.is_sky[rows]] = SKY
            found[lines.number[near]] = hit
            goes = np.ones(len(away), bool)
            goes[near] = hit == NOTHING
            lines = lines._replace(at=np.maximum(leaving, lines.at + away - 1.0)).chosen(goes)
        return found

    def _hit(self, rows: Ints, lines: "_Lines") -> Ints:
        """(n,) the surfel of a row that each line crosses; of several that which faces the line's
        longest axis; else NOTHING.
        """
        best, chosen = np.zeros(len(rows)), np.full(len(rows), NOTHING, np.int64)
        for axis in range(3):
            surfel = self.in_cell[rows, 2 * axis + (lines.along[:, axis] > 0)]
            there = np.flatnonzero(surfel >= 0)
            number, some = surfel[there], lines.chosen(there)
            normal, place = self.normals[number], self.places[number] / self.edge - self.origin
            facing = -np.einsum("ij,ij->i", normal, some.along)
            height = np.einsum("ij,ij->i", normal, some.start - place)
            crossing = height / np.maximum(facing, 1e-9)
            squarely = np.abs(some.along[:, axis])
            met = (facing > 0) & (crossing > -_TOUCHING) & (crossing < some.last)
            met &= squarely > best[there]
            at = (some.start + some.along * crossing[:, np.newaxis] + self.origin) * self.edge
            margin = _MARGIN * self.edge
            met &= (at > self.mins[number] - margin).all(axis=1)
            met &= (at < self.maxs[number] + margin).all(axis=1)
            best[there[met]], chosen[there[met]] = squarely[met], number[met]
        return chosen


class _Lines(NamedTuple):
    """Lines on their way, in cells from the first one's corner.

    `along` is 1 on the longest axis, `at` the place that a line has come to, `last` where it ends.
    """

    number: Ints
    start: Floats
    along: Floats
    last: Floats
    at: Floats

    def chosen(self, which: Ints | Mask) -> "_Lines":
        number, start, along, last, at = self
        return _Lines(number[which], start[which], along[which], last[which], at[which])


def with_beyond(values: Floats) -> Floats:
    """(s + 2, c) what surfels have, (s, c), and 0 for SKY and NOTHING, which count from the end."""
    return np.concatenate([values, np.zeros((2, values.shape[1]))])


def _sums(surfel: Ints, values: Floats, area: Floats) -> Floats:
    """(s, c) of (n, c) values on each of s surfels, weighted by (n,) areas."""
    sums = [np.bincount(surfel, v * area) for v in values.T]
    return np.stack(sums, axis=1).astype(np.float64)  # of nothing, they are whole numbers


def _away(taken: Mask) -> NDArray[np.uint8]:
    """Chessboard distances to the nearest taken cell, _FARTHEST at most."""
    away = np.full(taken.shape, _FARTHEST, np.uint8)
    for distance in range(_FARTHEST):
        np.minimum(away, np.where(taken, np.uint8(distance), np.uint8(_FARTHEST)), out=away)
        for axis in range(3):
            moved = np.moveaxis(taken, axis, 0)
            wider = moved.copy()
            wider[1:] |= moved[:-1]
            wider[:-1] |= moved[1:]
            taken = np.moveaxis(wider, 0, axis)
    return away
