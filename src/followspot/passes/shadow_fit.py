"""Where a light's map is spent: its frustum fitted to what camera and light both see.

A map of fixed size is as sharp as the window is small that it covers. The window is laid in
the plane at distance 1 before the light and measured in tangents there. It follows from the
camera's and the light's place alone, never from earlier frames, and is snapped to a coarse grid:
while the camera moves a little, the window stays and so does every texel; windows of one
size have their texels at the same places, so shadow edges do not swim.
"""

import math
from dataclasses import dataclass

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


def view_from_world(light: SpotLight) -> Mat4:
    """World to the light's view space, which looks down -Z along the cone's axis."""
    return spaces.view_from_world(light.position, *spaces.angles_from_forward(light.direction))


def fit(light: SpotLight, boxes: Boxes, receivers: Boxes | None, size: int) -> ShadowFrustum:
    """The smallest frustum, but for snapping, that holds all receivers within a light's cone.

    Args:
        light: A spot light.
        boxes: Of everything that may cast or receive; the near and far planes are fitted to them.
        receivers: Boxes of what the camera sees; none takes the whole cone.
        size: Texels along an edge of the map.
    """
    from_world = view_from_world(light)
    rim = math.tan(light.half_angle) * (1 + 2 * MARGIN / size)
    window = (-rim, rim, -rim, rim)
    if receivers is not None:
        wanted = _tangents(from_world, receivers, math.tan(light.half_angle))
        if wanted is not None:
            window = _snapped(wanted, rim, size)
    near, far = _depths(from_world, boxes, receivers, window)
    left, right, bottom, top = window
    clip_from_light = np.array(
        [
            [2 / (right - left), 0, (right + left) / (right - left), 0],
            [0, 2 / (top - bottom), (top + bottom) / (top - bottom), 0],
            [0, 0, (near + far) / (near - far), 2 * near * far / (near - far)],
            [0, 0, -1, 0],
        ]
    )
    return ShadowFrustum(clip_from_light @ from_world, near, far, (right - left) / size, window)


def _corners(from_world: Mat4, boxes: Boxes) -> NDArray[np.float64]:
    """(n, 8, 3) corners of boxes in the light's view space."""
    mins, maxs = boxes.mins.astype(np.float64), boxes.maxs.astype(np.float64)
    choose = spaces.box_corners(spaces.vec3([0, 0, 0]), spaces.vec3([1, 1, 1]))
    corners = mins[:, np.newaxis] + (maxs - mins)[:, np.newaxis] * choose
    return np.asarray(corners @ from_world[:3, :3].T + from_world[:3, 3])


def _tangents(
    from_world: Mat4, boxes: Boxes, rim: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """(2,) lowest and (2,) highest tangents of all boxes inside the cone's square."""
    corners = _corners(from_world, boxes)
    distance = -corners[..., 2]
    corners, distance = corners[(ahead := distance.max(axis=1) > 0)], distance[ahead]
    # A box that reaches behind the light may be seen in any direction.
    behind = distance.min(axis=1) <= 1e-3
    tangents = corners[..., :2] / np.maximum(distance, 1e-3)[..., np.newaxis]
    low = np.where(behind[:, np.newaxis], -rim, tangents.min(axis=1))
    high = np.where(behind[:, np.newaxis], rim, tangents.max(axis=1))
    meets = ((low < rim) & (high > -rim)).all(axis=1)
    if not meets.any():
        return None
    return np.maximum(low[meets].min(axis=0), -rim), np.minimum(high[meets].max(axis=0), rim)


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
    from_world: Mat4,
    boxes: Boxes,
    receivers: Boxes | None,
    window: tuple[float, float, float, float],
) -> tuple[float, float]:
    """Near and far distances: from the nearest box inside a window to the farthest receiver.

    What is farther away than all receivers casts on nothing that is seen. The far plane is
    snapped to steps of the boxes' range.
    """
    low, high = _distances(from_world, boxes, window)
    if not low.size:
        return 1.0, 2.0
    nearest, farthest = float(low.min()), float(high.max())
    if receivers is not None:
        _, reach = _distances(from_world, receivers, window)
        share = (float(reach.max(initial=nearest)) - nearest) / max(farthest - nearest, 1e-6)
        farthest = nearest + (farthest - nearest) * min(math.ceil(share * STEPS) / STEPS, 1.0)
    far = max(farthest * 1.001, 1.0)
    return min(max(nearest * 0.999, far * NEAREST_SHARE), far * 0.5), far


def _distances(
    from_world: Mat4, boxes: Boxes, window: tuple[float, float, float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(n,) smallest and (n,) largest distances of the boxes that meet a window."""
    corners = _corners(from_world, boxes)
    x, y, distance = corners[..., 0], corners[..., 1], -corners[..., 2]
    left, right, bottom, top = window
    outside = (
        (x < left * distance).all(axis=1)
        | (x > right * distance).all(axis=1)
        | (y < bottom * distance).all(axis=1)
        | (y > top * distance).all(axis=1)
        | (distance <= 0).all(axis=1)
    )
    meets = distance[~outside]
    return meets.min(axis=1), meets.max(axis=1)
