"""Where a light's map is spent: its frustum fitted to what camera and light both see.

A map of fixed size is as sharp as the window is small that it covers. The window is laid in
the plane at distance 1 before the light and measured in tangents there. It follows from the
camera's and the light's place alone, never from earlier frames, and is snapped to a coarse grid:
while the camera moves a little, the window stays and so does every texel; windows of one
size have their texels at the same places, so shadow edges do not swim.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from followspot import spaces
from followspot.scene.light import SpotLight
from followspot.spaces import Mat4

MARGIN = 3.0
"""Texels around the window for the filter and for receivers that are moved along their normals."""

STEPS = 16
"""A window begins at multiples of its size over this."""

SIZES = 8
"""Sizes of windows from one to twice as wide."""

NEAREST_SHARE = 1 / 256
"""Smallest near plane as a share of the far one. Depths are compared in float32, whose steps near
1 leave a distance d uncertain by d^2 / near / 2^24; nearer casters are clamped to the plane."""


@dataclass(frozen=True, eq=False)
class Boxes:
    """Axis-aligned boxes: (n, 3) mins and (n, 3) maxs in world units. Equal only to itself."""

    mins: NDArray[np.float32]
    maxs: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class ShadowFrustum:
    """The pyramid that one light's map covers. Equal only to itself.

    Attributes:
        clip_from_world: World to the light's clip space.
        near: Distance of the near plane along the axis, in units.
        far: Distance of the far plane along the axis, in units.
        texel: Longer edge of a texel in the plane at distance 1 from the light.
        window: Tangents (left, right, bottom, top), the cone's axis at 0, 0.
    """

    clip_from_world: Mat4
    near: float
    far: float
    texel: float
    window: tuple[float, float, float, float]

    def covers_the_same(self, other: "ShadowFrustum") -> bool:
        """Whether another frustum of the same light is as good as this one."""
        mine = (*self.window, self.near, self.far)
        return mine == (*other.window, other.near, other.far)

    def distances(self, depths: NDArray[np.float32] | NDArray[np.float64]) -> NDArray[np.float64]:
        """Depths in [0, 1] as units along the axis, infinite where they are 1."""
        ndc = depths.astype(np.float64) * 2 - 1
        near, far = self.near, self.far
        return np.where(ndc < 1, 2 * near * far / (far + near - ndc * (far - near)), np.inf)


class Extent(NamedTuple):
    """A rectangle in a map, whose edges are at 0 and 1."""

    left: float
    bottom: float
    right: float
    top: float


WHOLE = Extent(0.0, 0.0, 1.0, 1.0)
_NONE = Extent(1.0, 1.0, 0.0, 0.0)


def union(a: Extent, b: Extent) -> Extent:
    """The smallest one that holds two."""
    left, bottom = min(a.left, b.left), min(a.bottom, b.bottom)
    return Extent(left, bottom, max(a.right, b.right), max(a.top, b.top))


def covered(tile: ShadowFrustum, mins: NDArray[np.float32], maxs: NDArray[np.float32]) -> Extent:
    """Where in a map (n, 3) boxes may be seen."""
    if not len(mins):
        return _NONE
    rows = tile.clip_from_world[[0, 1, 3]]
    middle = (mins + maxs) @ (rows[:, :3].T / 2) + rows[:, 3]
    reach = (maxs - mins) @ (np.abs(rows[:, :3]).T / 2)
    least, most = middle - reach, middle + reach
    near, far = least[:, 2:], most[:, 2:]
    if near.min() <= 0:
        return WHOLE  # a box reaches behind the light
    least, most = least[:, :2], most[:, :2]
    low = np.minimum(least / near, least / far).min(axis=0)
    high = np.maximum(most / near, most / far).max(axis=0)
    return Extent(*np.clip(np.concatenate([low, high]) * 0.5 + 0.5, 0, 1).tolist())


def view_from_world(light: SpotLight) -> Mat4:
    """World to the light's view space, which looks down -Z along the cone's axis."""
    return spaces.view_from_world(light.position, *spaces.angles_from_forward(light.direction))


@dataclass(frozen=True, eq=False)
class Outlines:
    """Boxes as a light sees them.

    Attributes:
        low: (n, 2) lowest tangents; minus infinity where a box reaches behind the light.
        high: (n, 2) highest tangents, likewise.
        near: (n,) smallest distances along the axis, in units.
        far: (n,) largest distances.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]
    near: NDArray[np.float64]
    far: NDArray[np.float64]

    def within(self, window: tuple[float, float, float, float]) -> NDArray[np.bool_]:
        """(n,) whether a box meets a window before the light."""
        left, right, bottom, top = window
        x = (self.low[:, 0] < right) & (self.high[:, 0] > left)
        y = (self.low[:, 1] < top) & (self.high[:, 1] > bottom)
        return x & y & (self.far > 0)


def outlines(light: SpotLight, boxes: Boxes) -> Outlines:
    """How a light sees boxes. For a level's faces this is worth keeping as long as the light."""
    from_world = view_from_world(light)
    mins, maxs = boxes.mins.astype(np.float64), boxes.maxs.astype(np.float64)
    choose = spaces.box_corners(spaces.vec3([0, 0, 0]), spaces.vec3([1, 1, 1]))
    corners = mins[:, np.newaxis] + (maxs - mins)[:, np.newaxis] * choose
    corners = corners @ from_world[:3, :3].T + from_world[:3, 3]
    distance = -corners[..., 2]
    near, far = distance.min(axis=1), distance.max(axis=1)
    behind = (near <= 1e-3)[:, np.newaxis]
    tangents = corners[..., :2] / np.maximum(distance, 1e-3)[..., np.newaxis]
    low = np.where(behind, -np.inf, tangents.min(axis=1))
    high = np.where(behind, np.inf, tangents.max(axis=1))
    return Outlines(low, high, near, far)


def fit(
    light: SpotLight, everything: Outlines, receivers: Boxes | None, size: int
) -> ShadowFrustum:
    """The smallest frustum, but for snapping, that holds all receivers within a light's cone.

    Args:
        light: A spot light.
        everything: That may cast or receive; the near and far planes are fitted to it.
        receivers: Boxes of what the camera sees; none takes the whole cone.
        size: Texels along an edge of the map.
    """
    cone = math.tan(light.half_angle)
    rim = cone * (1 + 2 * MARGIN / size)
    window = (-rim, rim, -rim, rim)
    seen = None if receivers is None else outlines(light, receivers)
    if seen is not None and (lit := seen.within((-cone, cone, -cone, cone))).any():
        low = np.maximum(seen.low[lit].min(axis=0), -cone)
        high = np.minimum(seen.high[lit].max(axis=0), cone)
        window = _snapped((low, high), rim, size)
    near, far = _depths(everything, seen, window)
    left, right, bottom, top = window
    clip_from_light = np.array(
        [
            [2 / (right - left), 0, (right + left) / (right - left), 0],
            [0, 2 / (top - bottom), (top + bottom) / (top - bottom), 0],
            [0, 0, (near + far) / (near - far), 2 * near * far / (near - far)],
            [0, 0, -1, 0],
        ]
    )
    texel = max(right - left, top - bottom) / size
    return ShadowFrustum(clip_from_light @ view_from_world(light), near, far, texel, window)


def _snapped(
    wanted: tuple[NDArray[np.float64], NDArray[np.float64]], rim: float, size: int
) -> tuple[float, float, float, float]:
    """A window on the grid of its size that holds the wanted one; the rim's at most.

    Sizes, apart in both directions, are the whole cone's divided by powers of 2 to the 1/SIZES.
    """
    edges = []
    for low, high in zip(*wanted, strict=True):
        extent = float(high - low) * (1 + 2 * MARGIN / size) * STEPS / (STEPS - 1)
        steps = math.floor(SIZES * math.log2(2 * rim / max(extent, 1e-9)))
        if steps <= 0:
            edges.append((-rim, rim))
            continue
        side = 2 * rim / 2 ** min(steps / SIZES, 12)
        grid = side / STEPS
        start = round((float(low) - (side - float(high - low)) / 2) / grid) * grid
        edges.append((start, start + side))
    return (*edges[0], *edges[1])


def _depths(
    everything: Outlines, receivers: Outlines | None, window: tuple[float, float, float, float]
) -> tuple[float, float]:
    """Near and far distances: from the nearest box inside a window to the farthest receiver.

    What is farther away than all receivers casts on nothing that is seen. The far plane is
    snapped to steps of the boxes' range.
    """
    inside = everything.within(window)
    if not inside.any():
        return 1.0, 2.0
    nearest, farthest = float(everything.near[inside].min()), float(everything.far[inside].max())
    if receivers is not None:
        reach = receivers.far[receivers.within(window)].max(initial=nearest)
        share = (float(reach) - nearest) / max(farthest - nearest, 1e-6)
        farthest = nearest + (farthest - nearest) * min(math.ceil(share * STEPS) / STEPS, 1.0)
    far = max(farthest * 1.001, 1.0)
    return min(max(nearest * 0.999, far * NEAREST_SHARE), far * 0.5), far
