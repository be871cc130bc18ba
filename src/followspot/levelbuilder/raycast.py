"""Shadows for the bake: which rays get past the level's triangles.

All rays of one call share a direction or an end point. Seen along that direction, or from that
point, every ray is a dot and every triangle flat, so a plain grid of bins pairs them up; only
the pairs are then tested in space, after Moller and Trumbore, "Fast, Minimum Storage
Ray/Triangle Intersection" (1997).
"""

from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats, Ints

BINS = 128
"""Bins along each side of the grid."""

_NEAR = 1.0  # units; what is nearer to a point light than this is binned everywhere


@dataclass(frozen=True)
class Occluders:
    """Triangles that stop light.

    Attributes:
        corners: (n, 3, 3) float64 world units.
        opacity: (n,) share of light that each stops, 0 to 1.
    """

    corners: Floats
    opacity: Floats


def passed_along(occluders: Occluders, points: Floats, direction: Floats) -> Floats:
    """Return the share of light, (n,), that reaches points, (n, 3), from afar.

    Args:
        occluders: What casts shadows.
        points: Where the rays begin.
        direction: Unit vector towards the light, (3,).
    """
    if not len(points):
        return np.ones(0)
    helper = np.eye(3)[np.abs(direction).argmin()]
    u = np.cross(direction, helper)
    u /= np.linalg.norm(u)
    frame = np.stack([u, np.cross(direction, u)])
    flat = occluders.corners @ frame.T
    rays, triangles = _pairs(flat.min(axis=1), flat.max(axis=1), points @ frame.T)
    directions = np.broadcast_to(direction, points.shape)
    return _passed(occluders, points, directions, np.inf, rays, triangles)


def passed_to(occluders: Occluders, points: Floats, light: Floats) -> Floats:
    """Return the share of light, (n,), that reaches points, (n, 3), from a point, (3,)."""
    passed = np.ones(len(points))
    to_points = points - light
    local = occluders.corners - light
    axis = np.abs(to_points).argmax(axis=1)
    sign = np.sign(to_points[np.arange(len(points)), axis])
    for side in range(6):
        forward, way = side // 2, (-1.0, 1.0)[side % 2]
        chosen = np.flatnonzero((axis == forward) & (sign == way))
        if not len(chosen):
            continue
        others = [k for k in range(3) if k != forward]
        depth, aside = local[..., forward] * way, local[..., others]
        reach = np.abs(to_points[chosen]).max()
        beside = np.abs(aside) - depth[..., None]  # beyond one of the pyramid's four sides?
        signed = np.where(beside > 0, np.sign(aside), 0.0).sum(axis=1)
        ahead = (depth.max(axis=1) > 0) & (depth.min(axis=1) < reach)
        kept = np.flatnonzero(ahead & (np.abs(signed) < 3).all(axis=1))
        depth, aside = depth[kept], aside[kept]
        close = depth.min(axis=1) < _NEAR
        flat = aside / np.maximum(depth, _NEAR)[..., None]
        low = np.where(close[:, None], -1.0, flat.min(axis=1))
        high = np.where(close[:, None], 1.0, flat.max(axis=1))
        seen = to_points[chosen]
        rays, triangles = _pairs(low, high, seen[:, others] / np.abs(seen[:, [forward]]))
        some = Occluders(occluders.corners[kept], occluders.opacity[kept])
        passed[chosen] = _passed(some, points[chosen], -seen, 1.0, rays, triangles)
    return passed


def _pairs(low: Floats, high: Floats, dots: Floats) -> tuple[Ints, Ints]:
    """Return (dot, box) index pairs that share a bin, for flat boxes and dots, (n, 2) each."""
    origin = dots.min(axis=0)
    scale = BINS / np.maximum(np.ptp(dots, axis=0), 1e-6) * (1 - 1e-9)
    first = np.floor((low - origin) * scale).astype(np.int64)
    last = np.floor((high - origin) * scale).astype(np.int64)
    touches = np.flatnonzero((last >= 0).all(axis=1) & (first < BINS).all(axis=1))
    first, last = np.clip(first[touches], 0, BINS - 1), np.clip(last[touches], 0, BINS - 1)
    span = last - first + 1
    which, place = _expand(span.prod(axis=1))
    bins = (first[which, 0] + place % span[which, 0]) * BINS
    bins += first[which, 1] + place // span[which, 0]
    bins = bins.astype(np.uint16)  # sorted by radix, unlike longer numbers
    order = np.argsort(bins, kind="stable")
    boxes = touches[which[order]]
    starts = np.searchsorted(bins[order], np.arange(BINS * BINS + 1))
    cell = np.floor((dots - origin) * scale).astype(np.int64)
    cell_id = np.clip(cell[:, 0], 0, BINS - 1) * BINS + np.clip(cell[:, 1], 0, BINS - 1)
    dot, place = _expand(starts[cell_id + 1] - starts[cell_id])
    box = boxes[starts[cell_id[dot]] + place]
    for axis in range(2):
        at = dots[:, axis][dot]
        held = (at >= low[:, axis][box]) & (at <= high[:, axis][box])
        dot, box = dot[held], box[held]
    return dot, box


def _expand(counts: Ints) -> tuple[Ints, Ints]:
    """Return for each of sum(counts) items whose it is, and which of the owner's it is."""
    owner = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]
    return owner, place


def _passed(
    occluders: Occluders,
    origins: Floats,
    directions: Floats,
    limit: float,
    rays: Ints,
    triangles: Ints,
) -> Floats:
    """Return the share of light, (n,), that rays keep over their paired triangles."""
    a = occluders.corners[:, 0]
    edge_1, edge_2 = occluders.corners[:, 1] - a, occluders.corners[:, 2] - a
    passed = np.ones(len(origins))
    for start in range(0, len(rays), 1 << 18):
        ray, triangle = rays[start : start + (1 << 18)], triangles[start : start + (1 << 18)]
        d, e1, e2 = directions[ray], edge_1[triangle], edge_2[triangle]
        p = np.cross(d, e2)
        determinant = _dots(e1, p)
        with np.errstate(divide="ignore", invalid="ignore"):
            inverse = 1 / determinant
            offset = origins[ray] - a[triangle]
            u = _dots(offset, p) * inverse
            q = np.cross(offset, e1)
            v = _dots(d, q) * inverse
            t = _dots(e2, q) * inverse
            hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-9) & (t < limit)
        np.multiply.at(passed, ray[hit], 1 - occluders.opacity[triangle[hit]])
    return passed


def _dots(a: Floats, b: Floats) -> Floats:
    """Return the dot products of the rows of two (n, 3) arrays."""
    products: Floats = np.einsum("ij,ij->i", a, b)
    return products
