"""The shadow matrix before and after interpolation, over the triangles that a camera sees.

A triangle's corners have camera coordinates c_k = (x, y, w). Where a pixel's ray meets the
triangle's plane, the point is the sum of b_k P_k with weights b that add up to one, and its (x, y,
w) is the sum of b_k c_k; so b is proportional to the pixel's (x, y, 1) times the inverse of the
matrix of the c_k. That needs no clipping (Olano and Greer, Triangle Scan Conversion using 2D
Homogeneous Coordinates, 1997).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints, Mask
from followspot.spaces import Mat4

_PAIRS = 1_000_000  # of triangles and pixels that are looked at together
_TO_EDGE = 1e-12  # weights of points on a triangle's edge may come out so far below zero


@dataclass(frozen=True, eq=False)
class Seen:
    """What a camera sees through the middles of pixels, row by row from the top.

    Attributes:
        triangle: (n,) number of the nearest triangle, -1 where there is none.
        weights: (n, 3) of its corners, perspective-correct: they give the point in space.
        w: (n, 3) clip w of its corners: distances along the view axis.
    """

    triangle: Ints
    weights: Floats
    w: Floats


def rasterise(corners: Floats, clip_from_world: Mat4, size: tuple[int, int]) -> Seen:
    """Find the nearest triangle behind every pixel, exactly and without clipping.

    Args:
        corners: (triangles, 3, 3) world positions.
        clip_from_world: Of the camera, perspective.
        size: (width, height) in pixels.
    """
    width, height = size
    clip = corners @ clip_from_world[:, :3].T + clip_from_world[:, 3]
    xyw = clip[..., [0, 1, 3]]
    volume = np.linalg.det(xyw)
    low, high = _pixel_boxes(clip, size)
    wide = (high - low).prod(axis=1) * (np.abs(volume) > 0)
    seen = np.flatnonzero(wide)
    inverse = np.zeros_like(xyw)
    inverse[seen] = np.linalg.inv(xyw[seen])
    nearest = np.zeros(width * height)  # 1 / w, which is what grows towards the eye
    found = np.full(width * height, -1)
    near_plane = clip[..., 2] + clip[..., 3]
    for chosen, column, row in _pairs(seen, low, high):
        ndc = _middles(column, row, size)
        weights = np.einsum("ni,nik->nk", ndc, inverse[chosen])  # times w
        per_w = weights.sum(axis=1)
        in_front = np.einsum("nk,nk->n", weights, near_plane[chosen]) > 0
        edge = -_TO_EDGE * np.abs(weights).max(axis=1)
        inside = (per_w > 0) & in_front & (weights >= edge[:, np.newaxis]).all(axis=1)
        pixel = (row * width + column)[inside]
        order = np.argsort(per_w[inside], kind="stable")  # the nearest is written last
        pixel, value, number = pixel[order], per_w[inside][order], chosen[inside][order]
        last = np.zeros(width * height)
        owner = np.full(width * height, -1)
        last[pixel], owner[pixel] = value, number
        nearer = np.flatnonzero(last > nearest)
        nearest[nearer], found[nearer] = last[nearer], owner[nearer]
    row, column = np.divmod(np.arange(width * height), width)
    ndc = _middles(column, row, size)
    weights = np.einsum("ni,nik->nk", ndc, inverse[found])
    hit = found >= 0
    weights[hit] /= weights[hit].sum(axis=1, keepdims=True)
    return Seen(found, weights, np.asarray(xyw[found][..., 2]))


def _middles(column: Ints, row: Ints, size: tuple[int, int]) -> Floats:
    """(n, 3) x and y in [-1, 1] of pixels' middles, and 1."""
    x, y = (column + 0.5) * 2 / size[0] - 1, 1 - (row + 0.5) * 2 / size[1]
    return np.column_stack([x, y, np.ones(len(row))])


def _pixel_boxes(clip: Floats, size: tuple[int, int]) -> tuple[Ints, Ints]:
    """(triangles, 2) first pixel and the one behind the last that a triangle may cover."""
    w = clip[..., 3]
    beyond = np.stack([clip[..., :3] > w[..., np.newaxis], clip[..., :3] < -w[..., np.newaxis]])
    outside: Mask = np.any(np.all(beyond, axis=2), axis=(0, 2))
    # The outline of what reaches behind the eye is not that of its corners on the screen.
    crosses: Mask = np.any(w <= 1e-6, axis=1)
    ndc = clip[..., :2] / np.where(w > 1e-6, w, 1)[..., np.newaxis]
    scale = np.array(size)
    places = np.clip((ndc * [1, -1] * 0.5 + 0.5) * scale, 0, scale)
    low = np.where(crosses[:, np.newaxis], 0, np.floor(places.min(axis=1))).astype(np.int64)
    high = np.where(crosses[:, np.newaxis], scale, np.ceil(places.max(axis=1))).astype(np.int64)
    return low, np.where(outside[:, np.newaxis], low, np.maximum(high, low))


def _pairs(triangles: Ints, low: Ints, high: Ints) -> Iterator[tuple[Ints, Ints, Ints]]:
    """Triangles with the columns and rows of every pixel of their boxes, many at a time."""
    extent = high[triangles] - low[triangles]
    count = extent.prod(axis=1)
    group = (np.cumsum(count) - count) // _PAIRS
    for number in np.unique(group):
        members = group == number
        each = np.repeat(np.flatnonzero(members), count[members])
        start = np.cumsum(count[members]) - count[members]
        k = np.arange(len(each)) - np.repeat(start, count[members])
        row, column = np.divmod(k, extent[each, 0])
        chosen = triangles[each]
        yield chosen, low[chosen, 0] + column, low[chosen, 1] + row


@dataclass(frozen=True, eq=False)
class Ways:
    """Shadow coordinates of points on triangles, in the map's texels and in units of distance.

    All (n, 3): x and y in texels, distance along the light's axis in units.

    Attributes:
        exact: The matrix applied to the point itself, in float64.
        by_vertex: The matrix applied to the corners, interpolated, divided; float32.
        by_pixel: The corners interpolated, the matrix applied, divided; float32.
        divided_early: Divided at the corners and interpolated after that; float64.
        screen_linear: Interpolated linearly on the screen, then divided; float64.
        offset_by_vertex: As the shader moves points off their surfaces: `by_vertex`, float64.
        offset_by_pixel: The same with point and normal interpolated first; float64.
    """

    exact: Floats
    by_vertex: Floats
    by_pixel: Floats
    divided_early: Floats
    screen_linear: Floats
    offset_by_vertex: Floats
    offset_by_pixel: Floats


@dataclass(frozen=True, eq=False)
class Map:
    """A light's shadow map.

    Attributes:
        shadow_from_world: World to [0, 1]^3 and w.
        light_from_world: World to the light's view space.
        size: Texels along an edge.
        near: Distance of the near plane along the axis, in units.
        far: Distance of the far plane.
        offset: Texels that receivers are moved off their surfaces.
    """

    shadow_from_world: Mat4
    light_from_world: Mat4
    size: int
    near: float
    far: float
    offset: float = 0.0

    def moved(self, points: Floats, normals: Floats) -> Floats:
        """(..., 4) homogeneous coordinates of (..., 3) points moved off their surfaces.

        As surface.vert moves one-sided ones: across the map as unit normals (..., 3) point.
        """
        matrix, axes = self.shadow_from_world, self.light_from_world[:2, :3]
        s = points @ matrix[:, :3].T + matrix[:, 3]
        s[..., :2] += normals @ axes.T * (self.offset / self.size) * s[..., 3:]
        return np.asarray(s)

    def measured(self, homogeneous: Floats) -> Floats:
        """(n, 3) texels, texels and units of what is (n, 4) before the division."""
        return self.in_units(homogeneous[:, :3] / homogeneous[:, 3:])

    def in_units(self, divided: Floats) -> Floats:
        """(n, 3) texels, texels and units of coordinates in [0, 1]."""
        divided = divided.astype(np.float64)
        ndc = divided[:, 2] * 2 - 1
        away = self.far + self.near - ndc * (self.far - self.near)
        distance = 2 * self.near * self.far / np.where(np.abs(away) > 1e-9, away, np.nan)
        return np.column_stack([divided[:, :2] * self.size, distance])


def compare(corners: Floats, normals: Floats, weights: Floats, w: Floats, map_: Map) -> Ways:
    """Every way of getting from corners to coordinates in the map.

    Args:
        corners: (n, 3, 3) world positions of each point's triangle.
        normals: (n, 3, 3) unit normals there.
        weights: (n, 3) of the corners, perspective-correct.
        w: (n, 3) the camera's clip w at the corners.
        map_: Whose coordinates are wanted.
    """
    matrix = map_.shadow_from_world
    points = np.concatenate([corners, np.ones((*corners.shape[:2], 1))], axis=2)
    at_corners = points @ matrix.T
    interpolated = _mix(weights, points)
    exact = interpolated @ matrix.T

    # float32 as on the GPU: every input and every result is rounded.
    single, points32, weights32 = (a.astype(np.float32) for a in (matrix, points, weights))
    by_vertex = _mix(weights32, points32 @ single.T)
    by_pixel = _mix(weights32, points32) @ single.T

    on_screen = weights * w
    on_screen /= on_screen.sum(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        early = _mix(weights, at_corners[..., :3] / at_corners[..., 3:])

    normal = _mix(weights, normals)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    return Ways(
        exact=map_.measured(exact),
        by_vertex=map_.measured(by_vertex),
        by_pixel=map_.measured(by_pixel),
        divided_early=map_.in_units(early),
        screen_linear=map_.measured(_mix(on_screen, at_corners)),
        offset_by_vertex=map_.measured(_mix(weights, map_.moved(corners, normals))),
        offset_by_pixel=map_.measured(map_.moved(interpolated[:, :3], normal)),
    )


def _mix(weights: NDArray[np.floating], values: NDArray[np.floating]) -> Floats:
    """(n, c) sums over corners of weights (n, 3) times values (n, 3, c), in their own precision."""
    result: Floats = (weights[..., np.newaxis] * values).sum(axis=1)
    return result


def lit(corners: Floats, weights: Floats, map_: Map) -> Mask:
    """(n,) points in front of the light and inside its map."""
    points = np.column_stack([_mix(weights, corners), np.ones(len(corners))])
    s = points @ map_.shadow_from_world.T
    inside = (s[:, :3] >= 0) & (s[:, :3] <= s[:, 3:])
    return np.asarray(inside.all(axis=1) & (s[:, 3] > 0))


def edge_error(w0: float, w1: float) -> float:
    """Largest error of dividing too early along an edge, as a share of the edge's image.

    Args:
        w0: Distance of one end along the light's axis.
        w1: Distance of the other end; both positive.
    """
    a, b = math.sqrt(w0), math.sqrt(w1)
    return abs(b - a) / (b + a)
