"""How finely a biquadratic piece of a Bezier patch must be cut to keep to an error bound.

Let A and B be a piece's largest second differences |p0 - 2 p1 + p2| of control points along u and
along v, and T its largest twist |p00 - p01 - p10 + p11| over four neighbouring control points. In a
grid of n by m cells of two triangles each, the point of the surface at (u, v) and the triangles'
point at the same (u, v) are never farther apart than

    A / (4 n^2)  +  T / (n m)  +  B / (4 m^2)                                            (1)

which is the bound of D. Filip, R. Magedson and R. Markot, "Surface algorithms using bounds on
derivatives", Computer Aided Geometric Design 3 (1986), with a biquadratic's derivatives put in.

The bound adds up what may be large at different places and point different ways. So it only says
where to begin: cuts are taken away as long as the distance between points of equal (u, v), looked
at in every triangle, stays within the tolerance. That takes two fifths of the triangles away.

In a flat piece most of that is points sliding within the plane, which nobody sees: it needs cuts
for its outline alone. Three in ten pieces of OpenArena's levels are flat, mostly caps of arches,
and would take three quarters of all triangles.
"""

import numpy as np

from followspot.arrays import Floats, Ints, Mask

FLAT_THICKNESS = 1 / 8
"""Part of the tolerance up to which a piece's control points may leave a plane."""
FOLD_SLACK = 1e-5
"""Part of a flat piece's largest area element by which rounding may turn another one over."""
SAMPLED = 15 / 16
"""Least part of a triangle's largest distance that shows at the middles of its edges and of itself,
where the surface is quadratic."""


def needed(points: Floats, tolerance: float, max_segments: int) -> Ints:
    """Find how many segments pieces need for themselves.

    Args:
        points: (m, 3, 3, 3) control points by row and column, in units.
        tolerance: Largest distance, in units, of a point of the surface from the triangles.
        max_segments: No number is greater.

    Returns:
        (m, 2) along u and along v, at least 1. More do no harm in either direction.
    """
    thickness, folded = _fit_plane(points)
    flat = (thickness <= FLAT_THICKNESS * tolerance) & ~folded
    # What the plane leaves of the tolerance is for the outline within it.
    left = np.where(flat, tolerance - thickness, tolerance)
    segments = np.where(
        flat[:, None], _outline_segments(points, left), _inner_segments(points, left)
    )
    enough = np.clip(np.ceil(segments), 1, max_segments).astype(np.int64)
    enough[~flat] = _fewest(points[~flat], enough[~flat], tolerance * SAMPLED)
    return enough


def _inner_segments(points: Floats, tolerance: Floats) -> Floats:
    """(m, 2) segments along u and v by which pieces keep to bound (1).

    With the mean of squares above the product, T / (n m) is at most T / 2 (1 / n^2 + 1 / m^2), so
    that a^2 / n^2 + b^2 / m^2 bounds (1), where a^2 = A / 4 + T / 2 and b^2 = B / 4 + T / 2. With
    n^2 = a (a + b) / tolerance and m^2 = b (a + b) / tolerance the sum is just the tolerance, and a
    piece that is straight in one direction spends nothing there.
    """
    along_u = _bend(*np.moveaxis(points, 2, 0)).max(axis=1)
    along_v = _bend(*np.moveaxis(points, 1, 0)).max(axis=1)
    twist = np.linalg.norm(np.diff(np.diff(points, axis=1), axis=2), axis=-1).max(axis=(1, 2))
    needs = np.sqrt(np.stack([along_u, along_v], axis=1) / 4 + twist[:, None] / 2)
    total = needs.sum(axis=1, keepdims=True)
    return np.asarray(np.sqrt(needs * total / tolerance[:, None]))


def _fewest(points: Floats, enough: Ints, tolerance: float) -> Ints:
    """(m, 2) segments from which none can be taken without missing a distance at the samples."""
    # The distance falls with the square of the segments: about so many will do.
    ratio = np.sqrt(_distance(points, enough) / tolerance)[:, None]
    guess = np.clip(np.ceil(enough * ratio), 1, enough).astype(np.int64)
    found = np.where((_distance(points, guess) <= tolerance)[:, None], guess, enough)
    for axis in range(2):
        going = np.flatnonzero(found[:, axis] > 1)
        while len(going):
            fewer = found[going]
            fewer[:, axis] -= 1
            good = _distance(points[going], fewer) <= tolerance
            found[going[good]] = fewer[good]
            going = going[good & (fewer[:, axis] > 1)]
    return found


def _distance(points: Floats, segments: Ints) -> Floats:
    """(m,) largest distances of points of pieces from the triangles' points at the same (u, v).

    On a triangle of a quadratic surface the difference of the two is
    4 (l2 l3 e1 + l3 l1 e2 + l1 l2 e3), with barycentric coordinates l and the differences e at the
    middles of the edges. Looked at are these and the centroid, where it is 4/9 of their sum.
    """
    squares = np.zeros(len(points))
    cuts, kind = np.unique(segments, axis=0, return_inverse=True)
    for number, (along_u, along_v) in enumerate(cuts.tolist()):
        member = np.flatnonzero(kind == number)
        # (u, v, 3, pieces): NumPy loops over the many. Every second place is a vertex.
        curves = on_curves(points[member].transpose(1, 2, 3, 0), 2 * along_v)
        places = on_curves(curves.swapaxes(0, 1), 2 * along_u)
        vertex = places[::2, ::2]
        on_u = places[1::2, ::2] - (vertex[:-1] + vertex[1:]) / 2
        on_v = places[::2, 1::2] - (vertex[:, :-1] + vertex[:, 1:]) / 2
        diagonal = places[1::2, 1::2] - (vertex[1:, :-1] + vertex[:-1, 1:]) / 2
        before = (on_u[:, :-1] + on_v[:-1] + diagonal) * (4 / 9)
        behind = (on_u[:, 1:] + on_v[1:] + diagonal) * (4 / 9)
        for difference in (on_u, on_v, diagonal, before, behind):
            longest = np.square(difference).sum(axis=2).max(axis=(0, 1))
            squares[member] = np.maximum(squares[member], longest)
    return np.sqrt(squares)


def _outline_segments(points: Floats, tolerance: Floats) -> Floats:
    """(m, 2) segments along u and v by which flat pieces keep to their outline.

    If the four borders stay within the tolerance, so does the area they enclose, wherever the
    cuts within it lie: a point that the triangles fail to cover has been swept over by the border
    on its way from the curve to the chords.
    """
    needs = []
    for borders in (points[:, ::2], points[:, :, ::2].swapaxes(1, 2)):  # along u, along v
        start, middle, end = np.moveaxis(borders, 2, 0)
        chord = end - start
        length2 = np.sum(chord * chord, axis=-1)
        reach = np.sum((middle - start) * chord, axis=-1) / np.where(length2 > 0, length2, 1)
        nearest = start + np.clip(reach, 0, 1)[..., None] * chord
        # A curve leaves its chord by half of what its middle control point does. One that does
        # not needs no cuts, at whatever pace it runs along.
        straight = np.linalg.norm(middle - nearest, axis=-1) / 2 <= tolerance[:, None]
        bend = np.where(straight, 0, _bend(start, middle, end))
        needs.append(np.sqrt(bend.max(axis=1) / (4 * tolerance)))
    return np.stack(needs, axis=1)


def _fit_plane(points: Floats) -> tuple[Floats, Mask]:
    """Find the planes that lie closest to pieces.

    Returns:
        thickness: (m,) in units, between the planes that are parallel to it and enclose the piece.
        folded: (m,) whether a piece may turn over, seen at right angles to the plane, or has no
            area, so that the outline does not tell where it lies.
    """
    offsets = (points - points.mean(axis=(1, 2), keepdims=True)).reshape(-1, 9, 3)
    axes = np.linalg.eigh(offsets.swapaxes(1, 2) @ offsets).eigenvectors
    normal = axes[:, :, :1]  # (m, 3, 1), of the least spread
    thickness = np.ptp(offsets @ normal, axis=(1, 2))
    along_u = np.diff(points, axis=2).reshape(-1, 6, 3)
    along_v = np.diff(points, axis=1).reshape(-1, 6, 3)
    # The area element is a sum of these 36 products with positive weights.
    turns = np.cross(normal.swapaxes(1, 2), along_u) @ along_v.swapaxes(1, 2)
    up, down = np.maximum(turns, 0).max(axis=(1, 2)), np.maximum(-turns, 0).max(axis=(1, 2))
    return thickness, np.minimum(up, down) >= FOLD_SLACK * np.maximum(up, down)


def _bend(start: Floats, middle: Floats, end: Floats) -> Floats:
    """(...,) second differences |p0 - 2 p1 + p2| of (..., 3) control points."""
    return np.asarray(np.linalg.norm(start - 2 * middle + end, axis=-1))


def on_curves(control: Floats, segments: int) -> Floats:
    """Points of quadratic Bezier curves at equal steps of their parameter.

    Exact at the ends, and equal bit by bit for a curve and its reverse, since rounding does not
    see the order of two summands. On a border the other direction's blend is therefore exact, and
    it makes no difference which comes first.

    Args:
        control: (3, ...) control points.
        segments: Number n of steps.

    Returns:
        (n + 1, ...) points.
    """
    after = np.arange(segments + 1).reshape(-1, *[1] * (control.ndim - 1))
    before = segments - after
    start, middle, end = control
    ends = start * (before * before / segments**2) + end * (after * after / segments**2)
    points: Floats = ends + middle * (2 * before * after / segments**2)
    return points
