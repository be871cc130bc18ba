"""Exact Bezier surfaces, and distances to triangles by brute force."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def bezier(control: Array, parameter: Array) -> Array:
    """(t, ...) by de Casteljau's corner cutting of (3, ...) control points."""
    t = parameter.reshape(-1, *[1] * (control.ndim - 1))
    first = control[0] + t * (control[1] - control[0])
    second = control[1] + t * (control[2] - control[1])
    points: Array = first + t * (second - first)
    return points


def surface(control: Array, u: Array, v: Array) -> Array:
    """(v, u, k) points of one piece of (3, 3, k) control values."""
    return bezier(bezier(control.astype(np.float64), v).swapaxes(0, 1), u).swapaxes(0, 1)


def samples(grid: Array, count: int) -> Array:
    """(s, 3) points all over the patch of a (h, w) grid of VERTEX."""
    t = np.linspace(0, 1, count)
    height, width = grid.shape
    pieces = [
        surface(grid["position"][row : row + 3, column : column + 3], t, t).reshape(-1, 3)
        for row in range(0, height - 1, 2)
        for column in range(0, width - 1, 2)
    ]
    return np.concatenate(pieces)


def distance_to_segments(points: Array, start: Array, end: Array) -> Array:
    """(s, t) distances."""
    along = end - start
    length2 = np.sum(along * along, axis=-1)
    offset = points[:, None] - start
    reach = np.sum(offset * along, axis=-1) / np.where(length2 > 0, length2, 1)
    rest = offset - np.clip(reach, 0, 1)[..., None] * along
    return np.asarray(np.linalg.norm(rest, axis=-1))


def distance(points: Array, triangles: Array) -> Array:
    """(s,) distances of points to the nearest triangle, by brute force."""
    a, b, c = triangles.swapaxes(0, 1)
    best = np.minimum(distance_to_segments(points, a, b), distance_to_segments(points, b, c))
    best = np.minimum(best, distance_to_segments(points, c, a))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=-1)
    unit = normal / np.where(length > 0, length, 1)[:, None]
    inside = np.broadcast_to(length > 0, best.shape)
    for start, end in ((a, b), (b, c), (c, a)):
        inward = np.cross(unit, end - start)
        inside = inside & (np.sum((points[:, None] - start) * inward, axis=-1) >= 0)
    height = np.abs(np.sum((points[:, None] - a) * unit, axis=-1))
    return np.asarray(np.where(inside, np.minimum(best, height), best).min(axis=1))


def all_triangles(grid: Array) -> Array:
    """(t, 3, 3) float64 corners of both triangles of all cells, even those without area."""
    points = grid["position"].astype(np.float64)
    here, right = points[:-1, :-1], points[:-1, 1:]
    below, across = points[1:, :-1], points[1:, 1:]
    corners = np.stack([here, below, right, right, below, across], axis=2)
    return corners.reshape(-1, 3, 3)


def point_set(points: Array) -> set[bytes]:
    """The bits of (..., 3) float32 points."""
    assert points.dtype == np.float32
    return {point.tobytes() for point in np.ascontiguousarray(points).reshape(-1, 3)}
