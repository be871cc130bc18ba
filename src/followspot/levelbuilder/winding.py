"""Convex polygons in space, and cutting them by planes.

A winding is an (n, 3) float64 array of corners in world units, clockwise as seen from the side
that its plane's normal points to, which is how the format winds its faces. A plane is a unit
normal n and a distance d: n . x = d, with the front where n . x > d.
"""

import numpy as np

from followspot.arrays import Floats

EPSILON = 0.01
"""Points nearer to a plane than this, in units, lie on it."""

MIN_AREA = 0.05
"""Polygons smaller than this, in square units, are dust from cutting and are dropped."""


def plane_axes(normal: Floats) -> tuple[Floats, Floats]:
    """Return two unit vectors of a plane: rightwards and downwards as seen from its front.

    The first axis is horizontal, save on floors and ceilings, where it runs along +X.
    """
    if abs(normal[2]) > 0.999:
        right = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
    else:
        right = np.array([-normal[1], normal[0], 0.0])
    right /= np.linalg.norm(right)
    return right, np.cross(right, normal)


def base_winding(normal: Floats, dist: float, extent: float) -> Floats:
    """Return a square of half side ``extent`` on a plane, centred at the foot of the origin."""
    right, down = plane_axes(normal)
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * extent
    return normal * dist + corners @ np.stack([right, down])


def area_vector(winding: Floats) -> Floats:
    """Return the polygon's area times its normal, (3,), in square units."""
    fan = winding[1:] - winding[0]
    total: Floats = np.cross(fan[1:], fan[:-1]).sum(axis=0) / 2
    return total


def area(winding: Floats) -> float:
    """Return the polygon's area in square units."""
    return float(np.linalg.norm(area_vector(winding)))


def split(winding: Floats, normal: Floats, dist: float) -> tuple[Floats | None, Floats | None]:
    """Cut a winding by a plane and return its parts in front and behind; None where empty.

    A winding that lies on the plane counts as behind. The cut point of an edge is always worked
    out from its front end, so that polygons which share the edge get the very same point.
    """
    side = winding @ normal - dist
    if side.max() <= EPSILON:
        return None, winding
    if side.min() >= -EPSILON:
        return winding, None
    front: list[Floats] = []
    back: list[Floats] = []
    count = len(winding)
    for i in range(count):
        here, there = winding[i], winding[(i + 1) % count]
        a, b = side[i], side[(i + 1) % count]
        if a >= -EPSILON:
            front.append(here)
        if a <= EPSILON:
            back.append(here)
        if (a > EPSILON and b < -EPSILON) or (a < -EPSILON and b > EPSILON):
            cut = (
                here + (there - here) * (a / (a - b))
                if a > 0
                else (there + (here - there) * (b / (b - a)))
            )
            front.append(cut)
            back.append(cut)
    return np.array(front), np.array(back)


def merge(first: Floats, second: Floats) -> Floats | None:
    """Join two windings of one plane that share an edge, if the result is convex; else None."""
    gap = np.abs(first[:, None, :] - second[None, :, :]).max(axis=2) < EPSILON
    rows, columns = np.nonzero(gap)
    for i, j in zip(rows, columns, strict=True):
        n, m = len(first), len(second)
        if not gap[(i + 1) % n, (j - 1) % m]:
            continue
        # first runs i -> i+1 along the edge, second runs j-1 -> j back along it
        whole = np.roll(first, -(i + 1), axis=0)
        added = np.roll(second, -j, axis=0)[1:-1]
        return _without_straight_corners(np.concatenate([whole, added]))
    return None


def _without_straight_corners(winding: Floats) -> Floats | None:
    before = winding - np.roll(winding, 1, axis=0)
    after = np.roll(winding, -1, axis=0) - winding
    turn = np.cross(after, before) @ area_vector(winding)
    scale = np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1) * area(winding)
    bend = turn / np.maximum(scale, 1e-12)
    if bend.min() < -1e-4:
        return None
    kept = winding[bend > 1e-4]
    return kept if len(kept) >= 3 else None
