"""The robot's surface laid out on its skin: islands packed, and what lies under each texel."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints
from followspot.builtin.robot_model import Part

WIDTH, HEIGHT = 512, 256
"""Size of the skin in texels."""

_GUTTER = 3
"""Texels between islands, so that coarser mip levels mix no two of them at once."""


@dataclass(frozen=True, eq=False)
class Surface:
    """What the robot's surface is under each texel of the skin, in the pose at rest.

    Attributes:
        part: (h, w) index of the part; -1 in the corners that nothing wears.
        place: (h, w, 3) units.
        normal: (h, w, 3) smooth normal.
        edge: (h, w) units to the next sharp edge.
    """

    part: Ints
    place: Floats
    normal: Floats
    edge: Floats


def pack(parts: Sequence[Part]) -> Ints:
    """Lay the islands out as large as they fit, each part's by its `detail`.

    Returns:
        (k, 2) texels, column and row, of the `st` of all parts one after the other.
    """
    part = np.repeat(np.arange(len(parts)), [len(p.shape.st) for p in parts])
    islands = np.concatenate([p.shape.islands for p in parts])
    _, island = np.unique(np.stack([part, islands]), axis=1, return_inverse=True)
    st = np.concatenate([p.shape.st for p in parts])
    detail = np.array([p.detail for p in parts])[part]
    order = np.argsort(island, kind="stable")
    starts = np.searchsorted(island[order], np.arange(island.max() + 1))
    low = np.minimum.reduceat(st[order], starts)
    extent = np.maximum.reduceat(st[order], starts) - low
    for density in np.arange(12.0, 1.0, -0.05):
        size = np.ceil(extent * density * detail[order][starts][:, None]).astype(np.int64)
        corners = _shelves(size + 1 + _GUTTER)
        if corners is not None:
            share = (st - low[island]) / np.maximum(extent, 1e-9)[island]
            texels: Ints = corners[island] + np.rint(share * size[island]).astype(np.int64)
            return texels
    raise AssertionError("the islands do not fit")


def _shelves(sizes: Ints) -> Ints | None:
    """(n, 2) corners of boxes put in rows, the tallest first, or None where they do not fit."""
    corners = np.zeros_like(sizes)
    x, y, shelf = _GUTTER, _GUTTER, 0
    for i in np.lexsort([-sizes[:, 0], -sizes[:, 1]]):
        width, height = sizes[i]
        if x + width > WIDTH:
            x, y, shelf = _GUTTER, y + shelf, 0
        corners[i] = x, y
        x, shelf = x + width, max(shelf, height)
        if x > WIDTH or y + height > HEIGHT:
            return None
    return corners


def bake(parts: Sequence[Part], texels: Ints) -> Surface:
    """Find what lies under each texel: every triangle rasterised into the skin.

    Texels between islands are given what lies beside them.

    Args:
        parts: All parts.
        texels: (k, 2) of `pack`.
    """
    starts = np.cumsum([0, *(len(p.shape.st) for p in parts)])[:-1]
    corners = np.concatenate(
        [texels[start + p.shape.st_triangles] for p, start in zip(parts, starts, strict=True)]
    )
    values = np.concatenate([_corner_values(i, p) for i, p in enumerate(parts)])
    low, high = corners.min(axis=1), corners.max(axis=1)
    boxes = high - low + 1
    counts = boxes.prod(axis=1)
    triangle = np.repeat(np.arange(len(corners)), counts)
    k = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    width = boxes[triangle, 0]
    texel = low[triangle] + np.stack([k % width, k // width], axis=1)
    a, b, c = corners[triangle].transpose(1, 0, 2)
    area = _cross(b - a, c - a)
    opposite = np.stack([_cross(b - texel, c - texel), _cross(c - texel, a - texel)], axis=1)
    first_two = opposite / np.where(area == 0, np.nan, area)[:, None]
    weights = np.concatenate([first_two, 1 - first_two.sum(axis=1, keepdims=True)], axis=1)
    inside = (weights >= -1e-9).all(axis=1)
    found = np.einsum("nc,ncv->nv", weights[inside], values[triangle[inside]])
    layers = np.full((HEIGHT, WIDTH, values.shape[2]), np.nan)
    layers[texel[inside, 1], texel[inside, 0]] = found
    layers = _spread(layers)
    part = np.where(np.isnan(layers[..., 0]), -1, np.rint(np.nan_to_num(layers[..., 0])))
    layers = np.nan_to_num(layers)
    normal = layers[..., 4:7]
    normal = normal / np.maximum(np.linalg.norm(normal, axis=2, keepdims=True), 1e-9)
    depths = np.sort(layers[..., 7:], axis=2)
    edge = depths[..., 1] - depths[..., 0]
    return Surface(part.astype(np.int64), layers[..., 1:4], normal, edge)


def _corner_values(index: int, part: Part) -> Floats:
    """(m, 3, 10): number of the part, place, normal and depths at each corner."""
    shape = part.shape
    number = np.full((*shape.triangles.shape, 1), float(index))
    return np.concatenate(
        [
            number,
            shape.points[shape.triangles],
            shape.normals[shape.triangles],
            shape.depths[shape.st_triangles],
        ],
        axis=2,
    )


def _cross(u: NDArray[Any], v: NDArray[Any]) -> Ints:
    product: Ints = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    return product


def _spread(layers: Floats) -> Floats:
    """Fill empty texels from their neighbours, a ring at a time."""
    for _ in range(_GUTTER + 1):
        for step, axis in ((1, 0), (-1, 0), (1, 1), (-1, 1)):
            beside = np.roll(layers, step, axis)
            layers = np.where(np.isnan(layers[..., :1]), beside, layers)
    return layers
