"""Where a light's map is spent: its frusta fitted to what camera and light both see.

A tile of fixed size is as sharp as the window is small that it covers. The window is laid in
the plane at distance 1 before the light and measured in tangents there. It follows from the
camera's and the light's place alone, never from earlier frames, and is snapped to a coarse grid:
while the camera moves a little, the window stays and so does every texel; windows of one
size have their texels at the same places, so shadow edges do not swim.

A light has two tiles: the wide one holds all that the camera sees, the near one what is near the
camera, where a texel covers most pixels (as in Zhang, Sun, Xu and Lu 2006, "Parallel-split shadow
maps"). Both have the same planes, so that one depth is compared with either. The sides of the cube
around a point light are always covered whole.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from followspot import spaces
from followspot.arrays import Floats, Mask
from followspot.scene.light import CubeSide, SpotLight
from followspot.spaces import Mat4

MARGIN = 3.0
"""Texels around the window for the filter and for receivers that are moved along their normals."""

STEPS = 16
"""A window begins at multiples of its size over this."""

NEAR_STEPS = 8
"""The same for the near tile's, which moves with the camera and would be drawn more often."""

SIZES = 8
"""Sizes of windows from one to twice as wide."""

FINER = 1.2
"""How much smaller texels have to look, in the mean, for a near tile to be drawn."""

NEAREST_SHARE = 1 / 256
"""Smallest near plane as a share of the far one. Depths are compared in float32, whose steps near
1 leave a distance d uncertain by d^2 / near / 2^24; nearer casters are clamped to the plane."""

PLANES_AROUND = (2.0, 131072.0)
"""Near and far plane of point lights, which stand among what they light, in units. All of a level
is before the far one; a distance d is uncertain by d / 93000 of a texel, in tiles of 724."""


Window = tuple[float, float, float, float]
"""Tangents: left, right, bottom, top."""


@dataclass(frozen=True, eq=False)
class Boxes:
    """Axis-aligned boxes: (n, 3) mins and (n, 3) maxs in world units. Equal only to itself."""

    mins: NDArray[np.float32]
    maxs: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Receivers(Boxes):
    """Boxes of what a camera sees, each within a cell of its frustum.

    Attributes:
        corners: (n, 8, 3) the cells', in world units.
        start: (n,) distances at which they begin along the camera's axis, in units.
        end: (n,) those at which they end.
    """

    corners: Floats
    start: Floats
    end: Floats


@dataclass(frozen=True, eq=False)
class ShadowFrustum:
    """The pyramid that one tile covers. Equal only to itself.

    Attributes:
        clip_from_world: World to the light's clip space.
        near: Distance of the near plane along the axis, in units.
        far: Distance of the far plane along the axis, in units.
        texels: (2,) edges of a texel in the plane at distance 1 from the light.
        window: Tangents (left, right, bottom, top), the cone's axis at 0, 0.
    """

    clip_from_world: Mat4
    near: float
    far: float
    texels: Floats
    window: Window

    @property
    def texel(self) -> float:
        """Longer edge of a texel in the plane at distance 1 from the light."""
        return float(self.texels.max())

    @property
    def edges(self) -> Floats:
        """(2, 2) lowest and highest tangents of the window."""
        return np.array(self.window).reshape(2, 2).T

    def covers_the_same(self, other: "ShadowFrustum") -> bool:
        """Whether another frustum of the same light is as good as this one."""
        mine = (*self.window, self.near, self.far)
        return mine == (*other.window, other.near, other.far)

    def distances(self, depths: NDArray[np.float32] | Floats) -> Floats:
        """Depths in [0, 1] as units along the axis, infinite where they are 1."""
        ndc = depths.astype(np.float64) * 2 - 1
        near, far = self.near, self.far
        return np.where(ndc < 1, 2 * near * far / (far + near - ndc * (far - near)), np.inf)


Part = tuple[Floats, Floats]
"""(2,) lowest and (2,) highest tangents."""


def view_from_world(light: SpotLight) -> Mat4:
    """World to the light's view space, which looks down -Z along the cone's axis."""
    return spaces.view_from_world(light.position, *spaces.angles_from_forward(light.direction))


@dataclass(frozen=True, eq=False)
class Outlines:
    """Boxes as a light sees them.

    Attributes:
        low: (n, 2) lowest tangents; minus infinity where a box reaches beside the light.
        high: (n, 2) highest tangents, likewise infinite.
        near: (n,) smallest distances along the axis, in units.
        far: (n,) largest distances.
    """

    low: Floats
    high: Floats
    near: Floats
    far: Floats

    def within(self, window: Window) -> Mask:
        """(n,) whether a box meets a window before the light."""
        left, right, bottom, top = window
        x = (self.low[:, 0] < right) & (self.high[:, 0] > left)
        y = (self.low[:, 1] < top) & (self.high[:, 1] > bottom)
        return x & y & (self.far > 0)

    def chosen(self, which: Mask) -> "Outlines":
        """Those of some boxes."""
        return Outlines(self.low[which], self.high[which], self.near[which], self.far[which])


def outlines(light: SpotLight, boxes: Boxes) -> Outlines:
    """How a light sees boxes. For a level's faces this is worth keeping as long as the light."""
    choose = spaces.box_corners(spaces.vec3([0, 0, 0]), spaces.vec3([1, 1, 1])).T[..., np.newaxis]
    mins, maxs = (x.astype(np.float64).T[:, np.newaxis] for x in (boxes.mins, boxes.maxs))
    seen = _outlines(light, np.where(choose == 0, mins, maxs))
    if not isinstance(boxes, Receivers):
        return seen
    cells = _outlines(light, boxes.corners.transpose(2, 1, 0))
    return Outlines(
        np.maximum(seen.low, cells.low),
        np.minimum(seen.high, cells.high),
        np.maximum(seen.near, cells.near),
        np.minimum(seen.far, cells.far),
    )


def _outlines(light: SpotLight, corners: Floats) -> Outlines:
    """Of convex bodies with (3, 8, n) coordinates of corners: NumPy loops over the many."""
    from_world = view_from_world(light)
    seen = from_world[:3, :3] @ corners.reshape(3, -1) + from_world[:3, 3:]
    *across, z = seen.reshape(corners.shape)
    near, far = (-z).min(axis=0), (-z).max(axis=0)
    behind = near <= 1e-3
    tangents = across / np.maximum(-z, 1e-3)
    # Of what is behind as well, the tangents before the light have one end at most, the farthest.
    least, most = np.min(across, axis=1), np.max(across, axis=1)
    farthest = np.maximum(far, 1e-3)
    least = np.where(least < 0, -np.inf, least / farthest)
    most = np.where(most > 0, np.inf, most / farthest)
    low = np.where(behind, least, tangents.min(axis=1))
    high = np.where(behind, most, tangents.max(axis=1))
    return Outlines(low.T, high.T, near, far)


def fit(
    light: SpotLight, everything: Outlines, receivers: Outlines | None, size: int
) -> ShadowFrustum:
    """The smallest frustum, but for snapping, that holds all receivers within a light's cone.

    Args:
        light: A spot light.
        everything: That may cast or receive; the near and far planes are fitted to it.
        receivers: What the camera sees; none takes the whole cone.
        size: Texels along an edge of the tile.
    """
    part = None if receivers is None else _lit_part(light, receivers)
    window = _window(light, part, size)
    return _frustum(light, window, _depths(everything, receivers, window), size)


def fit_near(
    light: SpotLight, wide: ShadowFrustum, receivers: Receivers, seen: Outlines, size: int
) -> ShadowFrustum | None:
    """A frustum for the receivers nearest to the camera, with the planes of the one for all.

    How far it reaches is chosen so that texels look as small as possible to the camera, in the mean
    over the receivers' boxes.

    Args:
        light: A spot light.
        wide: Its frustum for all receivers.
        receivers: What the camera sees.
        seen: How the light sees that.
        size: Texels along an edge of the tile.

    Returns:
        None where texels look nearly as small without it.
    """
    lit = seen.within(_cone(light))
    start, end = receivers.start[lit], receivers.end[lit]
    weight = 2 / (start + end)  # a texel looks smaller from farther away
    coarse = _mean_texel(wide)
    best, least = None, coarse * weight.sum() / FINER
    for reach in np.unique(end)[:-1].tolist():
        part = _lit_part(light, seen.chosen(receivers.end <= reach))
        window = _window(light, part, size, NEAR_STEPS)
        tile = _frustum(light, window, (wide.near, wide.far), size)
        near = end <= reach
        mean = _mean_texel(tile) * weight[near].sum() + coarse * weight[~near].sum()
        if mean < least:
            best, least = tile, mean
    return best


def side_reach(size: int) -> float:
    """Tangent up to which a tile of some size covers a side of the cube around a point light."""
    return 1 + 2 * MARGIN / size


def whole_side(side: CubeSide, size: int) -> ShadowFrustum:
    """What a tile of some size covers of a side of the cube around a point light."""
    rim = side_reach(size)
    return _frustum(side, (-rim, rim, -rim, rim), PLANES_AROUND, size)


def _cone(light: SpotLight) -> Window:
    cone = math.tan(light.half_angle)
    return -cone, cone, -cone, cone


def widest(light: SpotLight, size: int) -> Window:
    """What holds every window of a light's tiles of some size.

    None is wider than the one for the whole cone, and all have a part of the cone in them.
    """
    rim = 3 * math.tan(light.half_angle) * side_reach(size)
    return -rim, rim, -rim, rim


def _lit_part(light: SpotLight, seen: Outlines) -> Part | None:
    """Lowest and highest tangents of what is seen within the cone, if anything is."""
    cone = math.tan(light.half_angle)
    lit = seen.within(_cone(light))
    if not lit.any():
        return None
    low, high = seen.low[lit].min(axis=0), seen.high[lit].max(axis=0)
    return np.maximum(low, -cone), np.minimum(high, cone)


def _mean_texel(frustum: ShadowFrustum) -> float:
    return float(np.sqrt(frustum.texels.prod()))


def _frustum(
    light: SpotLight, window: Window, planes: tuple[float, float], size: int
) -> ShadowFrustum:
    left, right, bottom, top = window
    near, far = planes
    clip_from_light = np.array(
        [
            [2 / (right - left), 0, (right + left) / (right - left), 0],
            [0, 2 / (top - bottom), (top + bottom) / (top - bottom), 0],
            [0, 0, (near + far) / (near - far), 2 * near * far / (near - far)],
            [0, 0, -1, 0],
        ]
    )
    clip_from_world = clip_from_light @ view_from_world(light)
    texels = np.array([right - left, top - bottom]) / size
    return ShadowFrustum(clip_from_world, near, far, texels, window)


def _window(light: SpotLight, wanted: Part | None, size: int, steps: int = STEPS) -> Window:
    """A window on the grid of its size that holds the wanted one; the cone's at most.

    Sizes, apart in both directions, are the whole cone's divided by powers of 2 to the 1/SIZES.
    """
    edges = []
    margin = 1 + 2 * MARGIN / size
    rim = math.tan(light.half_angle) * margin
    for axis in range(2):
        low, high = (-rim, rim) if wanted is None else (float(end[axis]) for end in wanted)
        extent = (high - low) * margin * steps / (steps - 1)
        halvings = math.floor(SIZES * math.log2(2 * rim / max(extent, 1e-9))) / SIZES
        if halvings <= 0:
            edges.append((-rim, rim))
            continue
        side = 2 * rim / 2 ** min(halvings, 12)
        grid = side / steps
        start = round((low - (side - (high - low)) / 2) / grid) * grid
        edges.append((start, start + side))
    return (*edges[0], *edges[1])


def _depths(
    everything: Outlines, receivers: Outlines | None, window: Window
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
