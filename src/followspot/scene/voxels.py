"""Which small cubes of space surfaces go through, a bit each, and what is near to those.

A column of 64 cubes is one word: to let them grow by some cubes along an axis takes a handful of
shifts for a whole level, and to look one up takes one word.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints, Mask
from followspot.assets.binary import run_members

MAX_POINTS = 400_000
"""About how many points on surfaces are looked at: cubes are larger where there is more of them."""
MAX_WORDS = 1 << 22
_BITS = 64


@dataclass(frozen=True, eq=False)
class Voxels:
    """Cubes of a grid, some of which are taken.

    Attributes:
        edge: Units along an edge of a cube.
        origin: (3,) number of the first cube along each axis; cube 0 begins at the world's 0.
        words: (x, y, z / 64) uint64, the lowest cube in the lowest bit.
    """

    edge: float
    origin: NDArray[np.int64]
    words: NDArray[np.uint64]

    @classmethod
    def of(cls, triangles: Floats, edge: float) -> "Voxels":
        """Those that triangles go through.

        Args:
            triangles: (t, 3, 3) corners, world units.
            edge: Of a cube, in units, at least.
        """
        across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        area = float(np.linalg.norm(across, axis=1).sum()) / 2
        edge = max(edge, math.sqrt(2 * area / MAX_POINTS))
        corners = triangles.reshape(-1, 3) if len(triangles) else np.zeros((1, 3))
        while True:
            first, last = (np.floor(c / edge).astype(np.int64) for c in _box(corners))
            shape = last - first + 1
            shape[2] = -(-shape[2] // _BITS)
            if shape.astype(np.float64).prod() <= MAX_WORDS:
                break
            edge *= 1.25
        words = np.zeros(shape, np.uint64)
        x, y, z = (np.floor(spread(triangles, edge)[0] / edge).astype(np.int64) - first).T
        bits = np.left_shift(np.uint64(1), (z % _BITS).astype(np.uint64))
        np.bitwise_or.at(words, (x, y, z // _BITS), bits)
        return cls(edge, first, words)

    def grown(self, distance: float) -> "Voxels":
        """With all cubes that are nearer than so many units to a taken one, along every axis."""
        reach = math.ceil(distance / self.edge)
        width = 2 * reach + 1
        more = -(-2 * reach // _BITS)
        words = np.pad(self.words, ((0, 2 * reach), (0, 2 * reach), (0, more)))
        # A cube is to be taken if one of those up to 2 * reach below it is; numbered anew, that is
        # up to reach on either side. Twice as many each time.
        done = 1
        while done < width:
            step = min(done, width - done, _BITS - 1)
            words[step:] |= words[:-step].copy()
            words[:, step:] |= words[:, :-step].copy()
            carried = words[..., :-1] >> np.uint64(_BITS - step)
            words |= words << np.uint64(step)
            words[..., 1:] |= carried
            done += step
        return Voxels(self.edge, self.origin - reach, words)

    def hold(self, points: NDArray[np.floating[Any]]) -> Mask:
        """(n,) whether (n, 3) world places lie in taken cubes."""
        cube = np.floor(points / self.edge).astype(np.int64) - self.origin
        shape = np.array(self.words.shape) * (1, 1, _BITS)
        inside = ((cube >= 0) & (cube < shape)).all(axis=1)
        x, y, z = np.where(inside[:, np.newaxis], cube, 0).T
        bit = self.words[x, y, z // _BITS] >> (z % _BITS).astype(np.uint64)
        return np.asarray(inside & ((bit & np.uint64(1)) == 1))


def _box(points: Floats) -> tuple[Floats, Floats]:
    return points.min(axis=0), points.max(axis=0)


def spread(triangles: Floats, gap: float) -> tuple[Floats, Ints]:
    """(n, 3) points on (t, 3, 3) triangles in rows along their longest edges, `gap` apart at most.

    Rows along another edge would be many times as many in a long and narrow triangle.

    Returns:
        The points, and (n,) the triangle of each.
    """
    edges = np.linalg.norm(np.roll(triangles, -1, axis=1) - triangles, axis=2)
    order = (edges.argmax(axis=1)[:, np.newaxis] + np.arange(3)) % 3
    a, b, c = np.moveaxis(np.take_along_axis(triangles, order[..., np.newaxis], axis=1), 1, 0)
    ab, ac = b - a, c - a
    length = np.linalg.norm(ab, axis=1)
    height = np.linalg.norm(np.cross(ab, ac), axis=1) / np.maximum(length, 1e-9)
    u_count = np.ceil(length / gap).astype(np.int64) + 1
    v_count = np.ceil(height / gap).astype(np.int64) + 1
    count = u_count * v_count
    triangle = np.repeat(np.arange(len(triangles)), count)
    k = run_members(np.zeros(len(count), np.int64), count)
    u = (k % u_count[triangle]) / np.maximum(u_count - 1, 1)[triangle]
    v = (k // u_count[triangle]) / np.maximum(v_count - 1, 1)[triangle]
    inside = u + v <= 1 + 1e-9
    triangle, u, v = triangle[inside], u[inside, np.newaxis], v[inside, np.newaxis]
    return a[triangle] + u * ab[triangle] + v * ac[triangle], triangle
