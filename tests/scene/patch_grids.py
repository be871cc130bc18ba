"""Grids of control points as patches of a level, cut, and what comes out of that."""

from typing import Any

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import ArrayLike, NDArray

from followspot.scene.mesh import VERTEX
from followspot.scene.patch import Tessellation, tessellate

Array = NDArray[Any]


def control_grid(positions: ArrayLike, normal: ArrayLike = (0, 0, 1)) -> Array:
    """(h, w) of VERTEX from (h, w, 3) positions; texture coordinates are some other function."""
    points = np.asarray(positions, np.float32)
    grid = np.zeros(points.shape[:2], VERTEX)
    grid["position"] = points
    grid["normal"] = normal
    grid["texcoord"] = points[..., :2] * 0.25 + points[..., 2:] * 0.5
    return grid


def cut(*grids: Array, tolerance: float = 1.0, max_segments: int = 64) -> Tessellation:
    """Tessellate grids (h, w) of VERTEX as the patches of one level."""
    control = np.concatenate([np.empty(0, VERTEX), *(grid.ravel() for grid in grids)])
    counts = np.array([grid.size for grid in grids], np.int64)
    size = np.array([grid.shape[::-1] for grid in grids], np.int32).reshape(-1, 2)
    return tessellate(control, np.cumsum(counts) - counts, size, tolerance, max_segments)


def vertex_grid(made: Tessellation, patch: int) -> Array:
    """(height, width) of VERTEX of one patch."""
    width, height = made.grid_size[patch]
    first = made.first_vertex[patch]
    return made.vertices[first : first + width * height].reshape(height, width)


def patch_triangles(made: Tessellation, patch: int) -> Array:
    """(t, 3, 3) float64 corners of one patch's triangles."""
    first, count = made.first_index[patch], made.index_count[patch]
    indices = made.indices[first : first + count].reshape(-1, 3)
    return made.vertices["position"][indices].astype(np.float64)


def borders(grid: Array) -> list[Array]:
    """The four borders of a grid, in either direction the same places."""
    return [grid[0], grid[-1], grid[:, 0], grid[:, -1]]


def arc(radius: float, pieces: int) -> Array:
    """(2 pieces + 1, 2) control points of about a full circle, exactly closed."""
    angles = np.arange(2 * pieces + 1) % (2 * pieces) * (np.pi / pieces)
    reach = np.where(np.arange(2 * pieces + 1) % 2, 1 / np.cos(np.pi / pieces), 1.0)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.asarray(radius * reach[:, None] * circle)


def cylinder(radius: float, height: float, top_radius: float | None = None) -> Array:
    """A closed tube of 3 rows and 9 columns, seen from outside, or a cone."""
    top = radius if top_radius is None else top_radius
    rows = [
        np.column_stack([arc(size, 4), np.full(9, level)])
        for size, level in zip(
            (radius, (radius + top) / 2, top), (0, height / 2, height), strict=True
        )
    ]
    outward = np.zeros((3, 9, 3))
    outward[..., :2] = arc(1, 4)
    return control_grid(rows, outward)


def plane(width: int, height: int, step: float = 10.0) -> Array:
    """A level grid of evenly spaced control points, seen from above."""
    x, y = np.meshgrid(np.arange(width) * step, np.arange(height) * step)
    return control_grid(np.stack([x, y, np.zeros_like(x)], axis=-1))


def hill(height: float) -> Array:
    """3 by 3 control points from (0, 0) to (20, 20), curved along x only."""
    grid = plane(3, 3)
    grid["position"][:, 1, 2] = height
    return grid


coordinates = st.floats(-100, 100, width=32)
patches = st.sampled_from([(3, 3), (3, 5), (5, 3)]).flatmap(
    lambda shape: arrays(np.float32, (*shape, 3), elements=coordinates)
)
tolerances = st.sampled_from([1.0, 3.0, 10.0, 40.0])
