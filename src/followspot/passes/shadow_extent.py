"""Which part of a tile boxes may be seen in, so that no more of it is drawn anew."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from followspot.passes.shadow_fit import ShadowFrustum


class Extent(NamedTuple):
    """A rectangle in a map, whose edges are at 0 and 1."""

    left: float
    bottom: float
    right: float
    top: float


WHOLE = Extent(0.0, 0.0, 1.0, 1.0)
NONE = Extent(1.0, 1.0, 0.0, 0.0)


def union(a: Extent, b: Extent) -> Extent:
    """The smallest one that holds two."""
    left, bottom = min(a.left, b.left), min(a.bottom, b.bottom)
    return Extent(left, bottom, max(a.right, b.right), max(a.top, b.top))


def covered(frustum: ShadowFrustum, mins: NDArray[np.float32], maxs: NDArray[np.float32]) -> Extent:
    """Where in a tile (n, 3) boxes may be seen."""
    if not len(mins):
        return NONE
    low, high = _extents(frustum, mins, maxs)
    ends = np.concatenate([low.min(axis=0), high.max(axis=0)])
    return Extent(*np.clip(ends, 0, 1).tolist())


def within(
    frustum: ShadowFrustum, mins: NDArray[np.float32], maxs: NDArray[np.float32], margin: float
) -> NDArray[np.bool_]:
    """(n,) which of (n, 3) boxes are seen in a tile alone, a share of it away from its edges."""
    low, high = _extents(frustum, mins, maxs)
    return np.asarray(((low > margin) & (high < 1 - margin)).all(axis=1))


def _extents(
    frustum: ShadowFrustum, mins: NDArray[np.float32], maxs: NDArray[np.float32]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n, 2) lowest and highest places of boxes, if the tile's edges are at 0 and 1.

    Infinite where a box reaches behind the light.
    """
    rows = frustum.clip_from_world[[0, 1, 3]]
    middle = (mins + maxs) @ (rows[:, :3].T / 2) + rows[:, 3]
    reach = (maxs - mins) @ (np.abs(rows[:, :3]).T / 2)
    least, most = middle - reach, middle + reach
    near, far = np.maximum(least[:, 2:], 1e-6), most[:, 2:]
    behind = least[:, 2:] <= 0
    low = np.minimum(least[:, :2] / near, least[:, :2] / far) * 0.5 + 0.5
    high = np.maximum(most[:, :2] / near, most[:, :2] / far) * 0.5 + 0.5
    return np.where(behind, -np.inf, low), np.where(behind, np.inf, high)
