"""Bezier patches: curved things by parameters.

A patch is an odd by odd grid of control points made of biquadratic pieces that share their
edges. It is seen from the side that cross(towards the next column, towards the next row) points
to: from there columns run rightwards and rows upwards. Circles are approximated: a quadratic
piece over 45 degrees is off by 0.3 % of the radius at most.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from followspot.arrays import Floats
from followspot.levelbuilder.material import Material
from followspot.levelbuilder.projection import apply, world_aligned


@dataclass(frozen=True)
class Patch:
    """A grid of control points.

    Attributes:
        material: Its material.
        points: (rows, columns, 3) float64 world units, both counts odd and at least 3.
        st: (rows, columns, 2) float64 texture coordinates.
    """

    material: Material
    points: Floats
    st: Floats


def flipped(patch: Patch) -> Patch:
    """Return the patch as seen from its other side; texture goes with it unmirrored."""
    st = patch.st[:, ::-1].copy()
    st[..., 0] = patch.st[:, ::-1, 0].max() + patch.st[:, ::-1, 0].min() - st[..., 0]
    return Patch(patch.material, patch.points[:, ::-1].copy(), st)


def arc(start: float, end: float, pieces: int | None = None) -> Floats:
    """Return control points, (2 n + 1, 2), of an arc of the unit circle.

    Args:
        start: First angle in degrees, anticlockwise from +x.
        end: Last angle in degrees.
        pieces: Number n of quadratic pieces; one for every 45 degrees by default.
    """
    count = pieces or max(1, round(abs(end - start) / 45))
    angles = np.radians(np.linspace(start, end, 2 * count + 1))
    half = np.radians((end - start) / (2 * count))
    radii = np.where(np.arange(2 * count + 1) % 2, 1 / np.cos(half), 1.0)
    return np.column_stack([np.cos(angles), np.sin(angles)]) * radii[:, None]


def polyline(points: ArrayLike) -> Floats:
    """Return a broken line, (n, k), as control points, (2 n - 1, k), with its bends sharp."""
    corners = np.asarray(points, dtype=np.float64)
    controls = np.empty((2 * len(corners) - 1, corners.shape[1]))
    controls[::2] = corners
    controls[1::2] = (corners[1:] + corners[:-1]) / 2
    return controls


def evaluate(controls: Floats, rows: Floats, columns: Floats) -> Floats:
    """Evaluate a grid of controls, (h, w, k), at parameters.

    Args:
        controls: Odd by odd grid.
        rows: (m,) parameters from 0 to (h - 1) / 2: whole numbers are piece borders.
        columns: (n,) parameters from 0 to (w - 1) / 2.

    Returns:
        (m, n, k) float64.
    """
    across = _basis(rows, controls.shape[0])
    along = _basis(columns, controls.shape[1])
    points: Floats = np.einsum("mi,nj,ijk->mnk", across, along, controls)
    return points


def _basis(parameters: Floats, count: int) -> Floats:
    """Return the weights, (m, count), of a row of controls at each parameter."""
    piece = np.clip(np.floor(parameters).astype(int), 0, (count - 1) // 2 - 1)
    t = parameters - piece
    weights = np.zeros((len(parameters), count))
    row = np.arange(len(parameters))
    weights[row, 2 * piece] = (1 - t) ** 2
    weights[row, 2 * piece + 1] = 2 * t * (1 - t)
    weights[row, 2 * piece + 2] = t**2
    return weights


def lengths(controls: Floats) -> Floats:
    """Return the arc length, (n,), from a curve's start to each of its controls, (n, k)."""
    fine = np.linspace(0, (len(controls) - 1) / 2, 8 * (len(controls) - 1) + 1)
    points = evaluate(controls[None].repeat(3, axis=0), np.zeros(1), fine)[0]
    run = np.concatenate([[0], np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()])
    total: Floats = run[::8]
    return total


def ruled(material: Material, bottom: Floats, top: Floats, *, turned: bool = False) -> Patch:
    """Stretch straight lines between two control curves, (n, 3) each.

    Seen from the front the curves run rightwards. Texture goes by length along and up, or with
    ``turned`` its rows stand along the straight lines.
    """
    along = (lengths(top) + lengths(bottom)) / 2
    up = np.linalg.norm(top - bottom, axis=1).mean() * np.array([0.0, 0.5, 1.0])
    points = np.stack([bottom, (top + bottom) / 2, top])
    st = np.stack(np.broadcast_arrays(along[None, :], -up[:, None]), axis=2)
    if turned:
        st = np.stack([st[..., 1], -st[..., 0]], axis=2)
    return Patch(material, points, st / _texture_units(material))


def _texture_units(material: Material) -> Floats:
    units: Floats = np.array(material.size) * material.units_per_texel
    return units


def lathe(
    material: Material,
    centre: ArrayLike,
    profile: Floats,
    *,
    start: float = 0.0,
    end: float = 360.0,
    repeats: int | None = None,
    pieces: int | None = None,
) -> Patch:
    """Turn a profile round an upright axis: columns, balusters, basins; seen from outside.

    Args:
        material: Its material.
        centre: Foot of the axis, (3,).
        profile: Control curve, (n, 2): radius and height above the centre, from the bottom up.
        start: First angle in degrees, anticlockwise from +x.
        end: Last angle.
        repeats: Whole textures round the turn, so that the seam fits; by length by default.
        pieces: Quadratic pieces round the turn; one for every 45 degrees by default.
    """
    circle = arc(start, end, pieces)
    rings = profile[:, None, :1] * circle[None]
    heights = np.broadcast_to(profile[:, None, 1:], (*rings.shape[:2], 1))
    points = np.concatenate([rings, heights], axis=2) + np.asarray(centre, dtype=np.float64)
    round_length = np.radians(abs(end - start)) * profile[:, 0].mean()
    texture = _texture_units(material)
    turns = repeats or max(1, round(round_length / texture[0]))
    s = np.linspace(0, turns, len(circle))
    t = -lengths(profile) / texture[1]
    st = np.stack(np.broadcast_arrays(s[None, :], t[:, None]), axis=2)
    return Patch(material, points, st)


def arch(
    spring: ArrayLike,
    across: ArrayLike,
    through: ArrayLike,
    rise: float,
    material: Material,
    *,
    spandrel: Material | None = None,
    top: float | None = None,
) -> list[Patch]:
    """Return the soffit of a half-round or flatter arch and, with ``top``, its flat fronts.

    Args:
        spring: Where the arch begins at the front: the left springing point, (3,).
        across: Vector to the right springing point, level.
        through: Vector through the wall from front to back, level.
        rise: Height of the crown over the springing points.
        material: Material of the soffit.
        spandrel: Material of the fronts, the soffit's by default.
        top: Height of the level top edge of the fronts; no fronts without it.
    """
    foot, width, depth = (np.asarray(v, dtype=np.float64) for v in (spring, across, through))
    up = np.array([0.0, 0.0, 1.0])
    half = arc(180, 0)
    front = foot + (half[:, :1] + 1) / 2 * width + half[:, 1:] * rise * up
    back = front + depth
    patches = [ruled(material, back, front)]
    if np.dot(np.cross(width, depth), up) < 0:
        patches = [flipped(patch) for patch in patches]
    if top is not None:
        for curve, facing in ((front, -depth), (back, depth)):
            edge = curve.copy()
            edge[:, 2] = top
            patches.append(flat(spandrel or material, edge, curve, facing))
    return patches


def flat(material: Material, top: Floats, bottom: Floats, facing: Floats) -> Patch:
    """Fill between two control curves of one plane; the texture is laid as on a brush there."""
    normal = facing / np.linalg.norm(facing)
    points = np.stack([bottom, (top + bottom) / 2, top])
    turn = np.cross(np.diff(points[:2], axis=1), np.diff(points, axis=0)[:2, :-1])
    if (turn @ normal).sum() < 0:
        points = points[:, ::-1].copy()
    matrix = world_aligned()(normal, points.reshape(-1, 3), material)
    return Patch(material, points, apply(matrix, points))


def groin_vault(
    mins: Sequence[float], maxs: Sequence[float], rise: float, material: Material
) -> list[Patch]:
    """Return the four webs of a cross vault over a bay.

    Args:
        mins: Corner (x, y) of the bay with its springing height z.
        maxs: Opposite corner (x, y).
        rise: Height of the crown over the springing.
        material: Its material.
    """
    low = np.array(mins[:2], dtype=np.float64)
    centre, half = (low + np.array(maxs[:2])) / 2, (np.array(maxs[:2]) - low) / 2
    webs = []
    curve = arc(180, 0)
    for quarter in range(4):
        # in a frame that looks outwards from the centre along +y: the wall arch is at y = 1,
        # the diagonals at y = |x|
        x, height = -curve[:, 0], mins[2] + rise * curve[:, 1]
        cos, sin = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarter]

        def place(
            x: Floats, y: Floats, height: Floats = height, c: int = cos, s: int = sin
        ) -> Floats:
            flat = np.column_stack([c * x - s * y, s * x + c * y])
            return np.column_stack([centre + flat * half, height])

        wall, groin = place(x, np.ones_like(x)), place(x, np.abs(x))
        webs.append(ruled(material, groin, wall))
    return webs
