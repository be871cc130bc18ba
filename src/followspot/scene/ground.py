"""Where the floor is: what a thing that is let go falls on."""

import numpy as np

from followspot.arrays import Floats
from followspot.scene import bsp_tree
from followspot.scene.level import Level
from followspot.scene.triangle_tree import TriangleTree

FALL = 4096.0
"""Units that anything falls at most."""

_STEEPEST = 0.3
"""Smallest height of the unit normal of what counts as a floor."""

_TOUCH = 1e-6
"""Units: what lies on a floor is that much above it."""


class Ground:
    """The floors of a level: its walls' tops, and the triangles that are drawn.

    The tree of planes knows what is solid but no detail and no patches; the triangles have all
    that, but not what is invisible.
    """

    def __init__(self, level: Level) -> None:
        self._bsp, mesh = level.bsp, level.mesh
        opaque = np.array([m.blend is None for m in level.materials], bool)
        corners = mesh.vertices["position"][mesh.indices.reshape(-1, 3)].astype(np.float64)
        self._heights = corners[:, :, 2]
        a, b, c = corners.transpose(1, 0, 2)
        normal = np.cross(c - a, b - a)
        level_enough = np.abs(normal[:, 2]) > _STEEPEST * np.linalg.norm(normal, axis=1)
        self._floors = TriangleTree(mesh, level_enough & opaque[mesh.material_of_triangle])

    def below(self, points: Floats) -> Floats:
        """Find the floor below points.

        Args:
            points: (n, 3) world space, Quake units.

        Returns:
            (n,) heights; a point's own where there is none within `FALL` below it.
        """
        height, up = points[:, 2], np.array([0.0, 0.0, 1.0])
        start, end = points + _TOUCH * up, points - FALL * up
        fraction = bsp_tree.trace(self._bsp, points, end)
        floor = np.where((fraction > 0) & (fraction < 1), height - fraction * FALL, -np.inf)
        for hits in self._floors.crossings(start, end):
            found = np.einsum("nk,nk->n", hits.weights, self._heights[hits.triangle])
            np.maximum.at(floor, hits.line, np.minimum(found, height[hits.line]))
        return np.where(np.isfinite(floor), floor, height)
