"""Shapes that the robot is made of: boxes with bevelled edges and bodies turned on a lathe.

Besides its triangles a shape has `islands`: pieces of its surface laid flat, in units, ready to be
packed into the skin.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from followspot.arrays import Floats, Ints

Outline = Sequence[tuple[float, float]] | Floats
"""(radius, height) in units, point by point."""

FAR = 99.0
"""A distance, in units, to an edge that does not exist."""

_ST_AXES = np.array([[1, 2], [0, 2], [1, 0]])
"""Which axes of a box run across and up the islands of faces that look along x, y and z."""


@dataclass(frozen=True, eq=False)
class Shape:
    """Triangles, clockwise from the front, and their surface laid flat.

    Attributes:
        points: (n, 3) units.
        normals: (n, 3) unit vectors.
        triangles: (m, 3) indices into the points.
        st: (k, 2) place on an island, units, t down.
        islands: (k,) number of the island, from 0.
        depths: (k, 3) distances, linear over a triangle, of which the two least differ by the
            distance to the next edge.
        st_triangles: (m, 3) indices into `st`.
    """

    points: Floats
    normals: Floats
    triangles: Ints
    st: Floats
    islands: Ints
    depths: Floats
    st_triangles: Ints

    def warped(self, move: Callable[[Floats], Floats]) -> "Shape":
        """Bend the shape by a smooth map of points, (n, 3) to (n, 3)."""
        step = 1e-4
        moved = move(self.points)  # and normals by the inverse transpose of its derivative
        columns = [(move(self.points + step * axis) - moved) / step for axis in np.eye(3)]
        jacobian = np.stack(columns, axis=2)
        raw = np.linalg.solve(jacobian.transpose(0, 2, 1), self.normals[..., None])[..., 0]
        normals: Floats = raw / np.linalg.norm(raw, axis=1, keepdims=True)
        return replace(self, points=moved, normals=normals)

    def mirrored(self) -> "Shape":
        """The same on the other side of y = 0; it wears the same islands."""
        flip = np.array([1.0, -1.0, 1.0])
        return replace(
            self,
            points=self.points * flip,
            normals=self.normals * flip,
            triangles=self.triangles[:, ::-1],
            st_triangles=self.st_triangles[:, ::-1],
        )

    def without(self, axis: int, sign: int) -> "Shape":
        """Leave out what lies wholly on one side of the middle: the buried back of a panel."""
        side = self.points[:, axis] - (self.points[:, axis].min() + self.points[:, axis].max()) / 2
        keep = (side[self.triangles] * sign < 0).any(axis=1)
        used, triangles = np.unique(self.triangles[keep], return_inverse=True)
        st_used, st_triangles = np.unique(self.st_triangles[keep], return_inverse=True)
        return Shape(
            points=self.points[used],
            normals=self.normals[used],
            triangles=triangles.reshape(-1, 3),
            st=self.st[st_used],
            islands=self.islands[st_used],
            depths=self.depths[st_used],
            st_triangles=st_triangles.reshape(-1, 3),
        )


def _box_polygons() -> tuple[Ints, Ints, Ints]:
    """(18, 4) quads of faces and edges, (18,) their islands, (8, 3) triangles of the corners.

    Each of the eight corners has three vertices, one for each face: vertex 3 * corner + axis.
    """
    signs = np.array(list(product((1, -1), repeat=3)))
    number = {tuple(row): 3 * i for i, row in enumerate(signs.tolist())}

    def vertex(axis: int, *places: tuple[int, int]) -> int:
        """The vertex on the face along `axis` of the corner whose (axis, sign) are given."""
        return number[tuple(sign for _, sign in sorted(places))] + axis

    quads, islands = [], []
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        for s in (1, -1):
            ring = ((1, 1), (1, -1), (-1, -1), (-1, 1))
            quads.append([vertex(a, (a, s), (b, sb), (c, sc)) for sb, sc in ring])
            islands.append(2 * a + (s < 0))
        for sb, sc in product((1, -1), repeat=2):  # the edge along a, between faces b and c
            ends = ((1, b), (-1, b), (-1, c), (1, c))
            quads.append([vertex(face, (a, s), (b, sb), (c, sc)) for s, face in ends])
            islands.append(2 * b + (sb < 0) if b < c else 2 * c + (sc < 0))
    corners = np.arange(24).reshape(8, 3)
    points = (signs[:, None] * (2 + np.eye(3))).reshape(24, 3)
    return _clockwise(np.array(quads), points), np.array(islands), _clockwise(corners, points)


def _clockwise(polygons: Ints, points: Floats) -> Ints:
    """Turn polygons of a convex body round the origin so that they wind clockwise from outside."""
    a, b, c = (points[polygons[:, i]] for i in range(3))
    inward = (np.cross(c - a, b - a) * a).sum(axis=1) < 0
    turned = np.concatenate([polygons[:, :1], polygons[:, :0:-1]], axis=1)
    return np.where(inward[:, None], turned, polygons)


_QUADS, _QUAD_ISLANDS, _CORNERS = _box_polygons()


def _fanned(quads: Ints) -> Ints:
    """(2 q, 3) triangles of (q, 4) quads, two in a row turning round the first corner."""
    return quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3)


def rounded_box(low: ArrayLike, high: ArrayLike, bevel: float) -> Shape:
    """Return a box whose edges and corners are cut off.

    Normals on the six faces are the faces' own, so that light turns smoothly over the cut edges.

    Args:
        low: (3,) least corner.
        high: (3,) greatest corner.
        bevel: How much is cut off.
    """
    least, most = np.asarray(low, np.float64), np.asarray(high, np.float64)
    signs = np.array(list(product((1, -1), repeat=3)))[:, None]
    points = (least + most) / 2 + signs * ((most - least) / 2 - bevel * (1 - np.eye(3)))
    points = points.reshape(24, 3)
    triangles = np.concatenate([_fanned(_QUADS), _CORNERS])
    x_islands = (points[_CORNERS[:, 0], 0] < points[:, 0].mean()).astype(np.int64)
    islands = np.concatenate([np.repeat(_QUAD_ISLANDS, 2), x_islands])
    # a vertex has a place on each island that a triangle of it lies on
    pairs, st_triangles = np.unique(triangles * 6 + islands[:, None], return_inverse=True)
    vertex, island = pairs // 6, pairs % 6
    axes = _ST_AXES[island // 2]
    across, up = (np.take_along_axis(points[vertex], axes, axis=1) * [1, -1]).T
    return Shape(
        points=points,
        normals=(signs * np.eye(3)).reshape(24, 3),
        triangles=triangles,
        st=np.stack([across, up], axis=1),
        islands=island,
        depths=np.minimum(points - least, most - points)[vertex],
        st_triangles=st_triangles.reshape(-1, 3),
    )


def lathe(runs: Sequence[Outline], at: ArrayLike, segments: int, axis: int = 2) -> Shape:
    """Return a body turned about an axis.

    Args:
        runs: Outlines of (radius, height) from the low end to the high one, surface on the outside;
            smooth within a run, with a sharp edge between one run and the next.
        at: (3,) where height 0 of the axis lies.
        segments: Number of sides.
        axis: 0, 1 or 2: the axis is x, y or z.
    """
    return _joined([_turned(run, np.asarray(at, np.float64), segments, axis) for run in runs])


def _turned(run: Outline, at: Floats, segments: int, axis: int) -> Shape:
    outline = np.array(run, np.float64)
    radius, height = outline.T
    steps = np.diff(outline, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    outward = np.stack([steps[:, 1], -steps[:, 0]], axis=1) / lengths[:, None]
    slopes = np.concatenate([outward[:1], outward]) + np.concatenate([outward, outward[-1:]])
    slopes /= np.linalg.norm(slopes, axis=1, keepdims=True)
    angle = 2 * np.pi * np.arange(segments) / segments
    round_axis = np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def around(out: Floats, along: Floats) -> Floats:
        flat = out[:, None, None] * round_axis
        high = np.broadcast_to(along[:, None, None], (len(out), segments, 1))
        return np.roll(np.concatenate([flat, high], axis=2).reshape(-1, 3), axis + 1, axis=1)

    def quads(columns: int) -> Ints:
        i, j = np.mgrid[0 : len(outline) - 1, 0:segments].reshape(2, -1)
        k = (j + 1) % columns
        ring = [i * columns + j, (i + 1) * columns + j, (i + 1) * columns + k, i * columns + k]
        return _fanned(np.stack(ring, axis=1))

    # at a pole one triangle of each quad is but a line
    pole = np.repeat(radius == 0, segments)
    triangles = quads(segments)
    poles = pole[triangles]
    keep = (poles.sum(axis=1) < 2) | ~poles.any(axis=1)
    t = np.concatenate([[0], np.cumsum(lengths)])
    s = 2 * np.pi * radius.max() * np.arange(segments + 1) / segments
    low = t if radius[0] > 0 else np.full_like(t, FAR)
    high = t[-1] - t if radius[-1] > 0 else np.full_like(t, FAR)
    depths = np.stack([np.zeros_like(t), low, high], axis=1)
    # a pole is one vertex, not one a segment
    ring = np.arange(pole.size)
    single = np.where(pole, ring - ring % segments, ring)
    used, triangles = np.unique(single[triangles[keep]], return_inverse=True)
    return Shape(
        points=around(radius, height)[used] + at,
        normals=around(slopes[:, 0], slopes[:, 1])[used],
        triangles=triangles.reshape(-1, 3),
        st=np.stack(np.broadcast_arrays(s, -t[:, None]), axis=2).reshape(-1, 2),
        islands=np.zeros(len(t) * (segments + 1), np.int64),
        depths=np.repeat(depths, segments + 1, axis=0),
        st_triangles=quads(segments + 1)[keep],
    )


def _joined(shapes: Sequence[Shape]) -> Shape:
    starts = np.cumsum([0, *(len(shape.points) for shape in shapes)])
    st_starts = np.cumsum([0, *(len(shape.st) for shape in shapes)])
    return Shape(
        points=np.concatenate([shape.points for shape in shapes]),
        normals=np.concatenate([shape.normals for shape in shapes]),
        triangles=np.concatenate([s.triangles + n for s, n in zip(shapes, starts, strict=False)]),
        st=np.concatenate([shape.st for shape in shapes]),
        islands=np.concatenate([shape.islands + i for i, shape in enumerate(shapes)]),
        depths=np.concatenate([shape.depths for shape in shapes]),
        st_triangles=np.concatenate(
            [s.st_triangles + n for s, n in zip(shapes, st_starts, strict=False)]
        ),
    )
