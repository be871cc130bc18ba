"""Where the floor is: what a thing that is let go falls on."""

import numpy as np
from numpy.typing import NDArray

from followspot.assets.binary import run_members
from followspot.scene import bsp_tree
from followspot.scene.level import Level

FALL = 4096.0
"""Units that anything falls at most."""

_STEEPEST = 0.3
"""Smallest height of the unit normal of what counts as a floor."""

_CHUNK = 256
"""Points looked at together."""


class Ground:
    """The floors of a level: its walls' tops, and the triangles that are drawn.

    The tree of planes knows what is solid but no detail and no patches; the triangles have all
    that, but neither what is invisible nor, where they overlap, which is first.
    """

    def __init__(self, level: Level) -> None:
        self._level = level
        mesh = level.mesh
        solid = np.array([m.blend is None for m in level.materials], bool)
        faces = mesh.faces[solid[mesh.faces["material"]]] if len(mesh.faces) else mesh.faces
        members = run_members(faces["first_index"] // 3, faces["index_count"] // 3)
        corners = mesh.vertices["position"][mesh.indices.reshape(-1, 3)[members]]
        corners = corners.astype(np.float64)
        normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 1] - corners[:, 0])
        length = np.linalg.norm(normal, axis=1)
        # Floors are known by their triangles: the side that is in front, or either of patches.
        floor = np.abs(normal[:, 2]) > _STEEPEST * length
        self._corners = corners[floor]
        self._mins, self._maxs = self._corners.min(axis=1), self._corners.max(axis=1)

    def below(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Find the floor below points.

        Args:
            points: (n, 3) world space, Quake units.

        Returns:
            (n,) heights; a point's own where there is none within `FALL` below it.
        """
        ends = points - (0.0, 0.0, FALL)
        fraction = bsp_tree.trace(self._level.bsp, points, ends)
        height = points[:, 2] - fraction * FALL
        hit = (fraction > 0) & (fraction < 1)
        floor = np.where(hit, height, -np.inf)
        for start in range(0, len(points), _CHUNK):
            chunk = slice(start, start + _CHUNK)
            floor[chunk] = np.maximum(floor[chunk], self._triangles_below(points[chunk]))
        return np.where(floor >= points[:, 2] - FALL, floor, points[:, 2])

    def _triangles_below(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n,) height of the highest triangle below each point, or minus infinity."""
        x, y, z = points[:, np.newaxis].transpose(2, 0, 1)
        lowest, highest = self._mins.T, self._maxs.T
        over = (x >= lowest[0]) & (x <= highest[0]) & (y >= lowest[1]) & (y <= highest[1])
        point, triangle = np.nonzero(over & (z >= lowest[2]) & (lowest[2] >= z - FALL))
        a, b, c = self._corners[triangle].transpose(1, 0, 2)
        p = points[point]
        ab, ac, ap = b - a, c - a, p - a
        area = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            v = (ap[:, 0] * ac[:, 1] - ap[:, 1] * ac[:, 0]) / area
            w = (ab[:, 0] * ap[:, 1] - ab[:, 1] * ap[:, 0]) / area
        height = a[:, 2] + v * ab[:, 2] + w * ac[:, 2]
        edge = 1e-6
        inside = (v >= -edge) & (w >= -edge) & (v + w <= 1 + edge) & (height <= p[:, 2])
        found = np.full(len(points), -np.inf)
        np.maximum.at(found, point[inside], height[inside])
        return found
