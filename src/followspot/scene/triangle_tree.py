"""Straight lines against a level's triangles: a tree of boxes, searched for all lines at once.

Triangles are put in the order of their centres along a curve that fills space (Morton's; Lauterbach
et al., "Fast BVH Construction on GPUs", 2009). Boxes of eight neighbours are the leaves, boxes of
two boxes make the levels above. A search takes pairs of line and box down one level after the
other; what is left in the leaves is tested exactly (Moller and Trumbore, "Fast, Minimum Storage
Ray/Triangle Intersection", 1997).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats, Ints, Mask
from followspot.scene.mesh import Mesh

_LEAF = 8
_AT_ONCE = 4096  # lines; their pairs stay within the processor's cache
_GRID_BITS = 10
_EDGE = 1e-9
"""Share of a triangle that it is larger for the test: lines do not slip between neighbours."""
_MARGIN = 1e-6
"""Units by which boxes are larger: lines that lie in one of their sides are not outside."""


@dataclass(frozen=True, eq=False)
class Hits:
    """Where lines cross triangles, in no order; n crossings.

    Attributes:
        line: (n,) numbers of lines.
        triangle: (n,) numbers of the mesh's triangles.
        fraction: (n,) of the line, between its start and its end.
        weights: (n, 3) of the triangle's corners in the mesh's order.
        from_front: (n,) whether the line comes from the triangle's front.
    """

    line: Ints
    triangle: Ints
    fraction: Floats
    weights: Floats
    from_front: Mask

    def chosen(self, which: Mask) -> "Hits":
        """Some of them."""
        return Hits(*(each[which] for each in vars(self).values()))


class TriangleTree:
    """Some of a mesh's triangles, to be met by lines.

    Args:
        mesh: Front faces clockwise.
        chosen: (triangles,) which of them are in the tree.
    """

    def __init__(self, mesh: Mesh, chosen: Mask) -> None:
        numbers = np.flatnonzero(chosen)
        corners = mesh.vertices["position"].astype(np.float64)[mesh.indices.reshape(-1, 3)[numbers]]
        order = np.argsort(_morton(corners.mean(axis=1)), kind="stable")
        self._numbers, corners = numbers[order], corners[order]
        self._corner = corners[:, 0]
        self._edges = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        self._levels = _levels(corners)

    def crossings(self, start: Floats, end: Floats) -> Iterator[Hits]:
        """All places where lines (n, 3) to (n, 3), in world units, cross triangles.

        They come in several parts; all hits of a line are in one of them.
        """
        for first in range(0, len(start), _AT_ONCE):
            some = slice(first, first + _AT_ONCE)
            hits = self._cross(start[some], end[some] - start[some])
            hits.line[:] += first
            yield hits

    def first_hits(self, start: Floats, end: Floats) -> Floats:
        """(n,) fractions of lines at which they meet the first triangle, 1 if none."""
        found = np.ones(len(start))
        for hits in self.crossings(start, end):
            np.minimum.at(found, hits.line, hits.fraction)
        return found

    def _cross(self, start: Floats, way: Floats) -> Hits:
        line, triangle = self._candidates(start, way)
        d, origin = way[line], start[line] - self._corner[triangle]
        edge_1, edge_2 = (edge[triangle] for edge in self._edges)
        p, q = np.cross(d, edge_2), np.cross(origin, edge_1)
        determinant = _dot(edge_1, p)
        with np.errstate(divide="ignore", invalid="ignore"):  # edge-on is not met
            u, v, t = (_dot(*pair) / determinant for pair in ((origin, p), (d, q), (edge_2, q)))
            met = (u >= -_EDGE) & (v >= -_EDGE) & (u + v <= 1 + _EDGE) & (t > 0) & (t < 1)
        u, v = u[met], v[met]
        return Hits(
            line[met],
            self._numbers[triangle[met]],
            t[met],
            np.stack([1 - u - v, u, v], axis=1),
            determinant[met] < 0,  # clockwise
        )

    def _candidates(self, start: Floats, way: Floats) -> tuple[Ints, Ints]:
        """Pairs of line and place in the tree's order whose leaf's box the line meets."""
        way = np.where(way == 0, 1e-30, way)  # so that nothing is 0 / 0
        line, box = np.arange(len(start)), np.zeros(len(start), np.int64)
        for depth, (mins, maxs) in enumerate(self._levels):
            if depth:
                line = np.repeat(line, 2)
                box = np.repeat(box * 2, 2)
                box[1::2] += 1
            per_way, origin = 1 / way[line], start[line]
            a, b = (mins[box] - origin) * per_way, (maxs[box] - origin) * per_way
            enter, leave = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
            met = (enter <= leave) & (leave >= 0) & (enter <= 1)
            line, box = line[met], box[met]
        place = (box[:, np.newaxis] * _LEAF + np.arange(_LEAF)).ravel()
        line = np.repeat(line, _LEAF)
        real = place < len(self._numbers)
        return line[real], place[real]


def _levels(corners: Floats) -> list[tuple[Floats, Floats]]:
    """Boxes (mins, maxs) of each level from the root down, each level twice as many.

    Places without a triangle have a box that no line meets.
    """
    leaves = 1 << max(0, (-(-len(corners) // _LEAF) - 1)).bit_length()
    mins, maxs = np.full((leaves * _LEAF, 3), np.inf), np.full((leaves * _LEAF, 3), -np.inf)
    mins[: len(corners)] = corners.min(axis=1) - _MARGIN
    maxs[: len(corners)] = corners.max(axis=1) + _MARGIN
    mins, maxs = mins.reshape(-1, _LEAF, 3).min(axis=1), maxs.reshape(-1, _LEAF, 3).max(axis=1)
    levels = [(mins, maxs)]
    while len(mins) > 1:
        mins, maxs = mins.reshape(-1, 2, 3).min(axis=1), maxs.reshape(-1, 2, 3).max(axis=1)
        levels.append((mins, maxs))
    for mins, maxs in levels:
        maxs[mins[:, 0] > maxs[:, 0]] = np.inf  # empty ones, whose mins are that, too
    return levels[::-1]


def _morton(points: Floats) -> Ints:
    """(n,) places along a curve through a grid, for (n, 3): the bits of x, y and z in turn."""
    if not len(points):
        return np.zeros(0, np.int64)
    low = points.min(axis=0)
    size = max(float(np.ptp(points, axis=0).max()), 1e-9)
    cell = ((points - low) / size * ((1 << _GRID_BITS) - 1)).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(_GRID_BITS):
        for axis in range(3):
            code |= ((cell[:, axis] >> bit) & 1) << (3 * bit + axis)
    return code


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", a, b))
