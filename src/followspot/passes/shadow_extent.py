"""Where in a tile boxes may be seen, so that no more of it is drawn anew."""

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Mask
from followspot.passes.shadow_fit import ShadowFrustum

Extents = Floats
"""(n, 4) left, bottom, right and top of rectangles in a tile, whose own are at 0 and 1."""

_ROUNDING = 0.01
"""Texels by which GL may put a vertex elsewhere."""

_LOW = np.array([[True], [True], [False], [False]])
_EVERYWHERE = np.array([[-np.inf], [-np.inf], [np.inf], [np.inf]])
_INWARDS = np.array([1.0, 1.0, -1.0, -1.0])

WHOLE: Extents = np.array([[0.0, 0.0, 1.0, 1.0]])


def extents(
    frustum: ShadowFrustum, mins: NDArray[np.float32], maxs: NDArray[np.float32]
) -> Extents:
    """Rectangles around (n, 3) boxes; infinite where a box reaches behind the light."""
    rows = frustum.clip_from_world[[0, 1, 3]].astype(np.float32)
    middle = (rows[:, :3] * 0.5) @ (mins + maxs).T + rows[:, 3:]
    reach = (np.abs(rows[:, :3]) * 0.5) @ (maxs - mins).T
    least, most = middle - reach, middle + reach
    near, far = least[2], most[2]
    sides = np.concatenate([least[:2], most[:2]])
    # A side is farthest out where the box is nearest, or farthest in where it is that side's own.
    is_outer = (sides < 0) == _LOW
    found = sides / np.where(is_outer, np.maximum(near, 1e-6), far) * 0.5 + 0.5
    is_behind = near <= 0
    if is_behind.any():
        found[:, is_behind] = _EVERYWHERE
    return np.asarray(found.T, np.float64)


def texels(found: Extents, size: int) -> NDArray[np.float32]:
    """(n, 4) the same in clip space, widened to whole texels of a tile, and cut to it."""
    whole = np.floor(found * (size * _INWARDS) - _ROUNDING) * _INWARDS  # ceil(x) = -floor(-x)
    return np.asarray(np.clip(whole, 0, size) * (2 / size) - 1, np.float32)


def within(found: Extents, margin: float) -> Mask:
    """(n,) which rectangles are inside of a tile, a share of its edge away from that."""
    left, bottom, right, top = found.T
    end = 1 - margin
    return np.asarray((left > margin) & (bottom > margin) & (right < end) & (top < end))


def meets(found: Extents) -> Mask:
    """(n,) which rectangles have a part of a tile in them."""
    left, bottom, right, top = found.T
    return np.asarray((left < 1) & (bottom < 1) & (right > 0) & (top > 0))
