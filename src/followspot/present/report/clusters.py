"""The camera's frustum cut into clusters, and which lamps reach into each.

Tiles of the picture, cut in depth where each slice is a fixed factor deeper than the one before,
so that clusters are about as deep as they are wide (Olsson, Billeter and Assarsson, "Clustered
Deferred and Forward Shading", 2012).
"""

import math
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats, Ints, Mask
from followspot.scene.camera import Camera
from followspot.spaces import vertical_fov

TILES = (16, 12)
"""Clusters across and down the picture."""

SLICES = 24
"""Clusters in depth."""

FIRST_SLICE = 16.0
"""Units of depth in which the first slice ends."""


@dataclass(frozen=True, eq=False)
class Clusters:
    """The clusters of one picture; SLICES x TILES down x TILES across of them, in this order.

    Attributes:
        camera: Whose frustum is cut.
        size: (width, height) of the picture in pixels.
        far: Units of depth where the last slice ends.
    """

    camera: Camera
    size: tuple[int, int]
    far: float

    def of_pixels(self, pixel: Ints, depth: Floats) -> Ints:
        """(n,) clusters of pixels, row by row from the top, at depths in units."""
        width, height = self.size
        across = pixel % width * TILES[0] // width
        down = pixel // width * TILES[1] // height
        deep = np.clip(np.searchsorted(self._edges, depth) - 1, 0, SLICES - 1)
        return np.asarray((deep * TILES[1] + down) * TILES[0] + across)

    def in_spheres(self, centres: Floats, radius: float) -> Mask:
        """(n, clusters) which clusters spheres about (n, 3) world places meet."""
        view_from_world = self.camera.view_from_world
        view = centres @ view_from_world[:3, :3].T + view_from_world[:3, 3]
        corners = self._corners()
        gap = _outside(view[:, np.newaxis], corners.min(axis=1), corners.max(axis=1))
        return np.asarray(np.linalg.norm(gap, axis=2) < radius)

    def in_boxes(self, mins: Floats, maxs: Floats) -> Mask:
        """(n, clusters) which clusters' world boxes meet boxes (n, 3) to (n, 3)."""
        world = self._corners() @ self.camera.view_from_world[:3, :3] + self.camera.position
        low, high = world.min(axis=1), world.max(axis=1)
        meets = (low <= maxs[:, np.newaxis]) & (high >= mins[:, np.newaxis])
        return np.asarray(meets.all(axis=2))

    @property
    def _edges(self) -> Floats:
        """(SLICES + 1,) depths at which slices begin and end."""
        far = max(self.far, FIRST_SLICE * 2)
        return np.concatenate([[0.0], np.geomspace(FIRST_SLICE, far, SLICES)])

    def _corners(self) -> Floats:
        """(clusters, 8, 3) in view space."""
        aspect = self.size[0] / self.size[1]
        fovs = self.camera.fov, vertical_fov(self.camera.fov, aspect)
        half = [math.radians(fov) / 2 for fov in fovs]
        x, y = (math.tan(h) * np.linspace(-1, 1, n + 1) for h, n in zip(half, TILES, strict=True))
        z, y, x = np.meshgrid(self._edges, y[::-1], x, indexing="ij")
        grid = np.stack([x * z, y * z, -z], axis=-1)
        ends = slice(None, -1), slice(1, None)
        corners = [grid[a, b, c] for a in ends for b in ends for c in ends]
        return np.stack(corners, axis=3).reshape(-1, 8, 3)


def _outside(points: Floats, mins: Floats, maxs: Floats) -> Floats:
    """How far points lie outside of boxes along each axis."""
    return np.asarray(np.maximum(mins - points, 0) + np.maximum(points - maxs, 0))
