"""Quake 3's curved surfaces: Bezier patches cut into triangles, by error bound and without cracks.

A patch is an odd by odd grid of control points, made of *pieces*: biquadratic surfaces of three by
three control points that share their borders. u runs along a row of control points, v from row to
row, both from 0 to 1 over a piece. A *strip* is one column or one row of a patch's pieces; the
pieces of a strip are all cut into equally many segments across it, so that the vertices of a patch
form a plain grid.

How finely a piece has to be cut for an error bound is the matter of `patch_segments`. This module
makes neighbours agree on it, and places vertices and triangles.

Cracks: borders with equal control points, read in either direction, are cut alike wherever they
occur, and computed alike to the last bit. Those that are equal but for a compiler's rounding are
cut alike too. Borders that run along each other with different control points (one piece against
two, or against a polygon's edge) meet in T-junctions, as in the game.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints
from followspot.errors import UsageError
from followspot.scene import patch_segments

SAME_PLACE = 1 / 16
"""Units: control points in one cell of this size count as one when borders are compared. Level
compilers leave up to 0.001 between neighbours. The cells are centred on the points of editors'
grids, so that rounding seldom parts neighbours."""
SHORTEST_NORMAL = 1e-4
"""An interpolated normal below this length tells no direction."""


@dataclass(frozen=True, eq=False)
class Tessellation:
    """Patches as triangles, front faces clockwise like those of a level's polygons.

    Attributes:
        vertices: (v,) with the control points' fields; each patch has its own, a grid row by row.
        indices: (i,) uint32 into `vertices`, three a triangle, none of them without area.
        first_vertex: (p,) where a patch's vertices begin; patches lie in the order given.
        grid_size: (p, 2) width and height of a patch's grid of vertices.
        first_index: (p,) where a patch's indices begin.
        index_count: (p,) a multiple of 3; 0 for a patch without area.
    """

    vertices: NDArray[np.void]
    indices: NDArray[np.uint32]
    first_vertex: Ints
    grid_size: Ints
    first_index: Ints
    index_count: Ints


def tessellate(
    control: NDArray[np.void],
    first_control: NDArray[np.integer[Any]],
    size: NDArray[np.integer[Any]],
    tolerance: float,
    max_segments: int = 32,
) -> Tessellation:
    """Cut patches into triangles.

    No point of a patch is farther from the patch's triangles than `tolerance`, as long as no piece
    needs more than `max_segments`. The vertices lie on the patch; their normals and texture
    coordinates are interpolated as positions are. Over a flat piece a texture that is stretched
    unevenly is no smoother than the cuts of its outline make it, again as in the game.

    Args:
        control: (n,) control points with the fields of VERTEX; positions in units, all finite.
            Normals need not be unit; where they vanish, those of the triangles take their place.
            Vectors of other fields are interpolated as well.
        first_control: (p,) int, where each patch's control points begin, row by row.
        size: (p, 2) int, width and height of its grid, odd and at least 3, all within `control`.
        tolerance: Largest distance in units, above 0.
        max_segments: Most segments to cut one piece into along u or v, at least 1.

    Raises:
        UsageError: `tolerance` or `max_segments` is out of range.
    """
    if not 0 < tolerance < np.inf:
        raise UsageError(f"a patch's tolerance is above 0 units, found {tolerance:g}")
    if max_segments < 1:
        raise UsageError(f"a patch's pieces have at least 1 segment, found {max_segments}")
    pieces = _find_pieces(first_control, size)
    points = control["position"][pieces.control].astype(np.float64)
    needed = patch_segments.needed(points, tolerance, max_segments)
    segments = _cut_alike(points, pieces.strips, needed)

    # How many segments lie before a strip gives the strip's place in the grid of vertices.
    before = np.append(0, np.cumsum(segments))
    edges = before[pieces.first_strips]
    grid_size = np.diff(edges, axis=1) + 1
    first_vertex = _starts(grid_size.prod(axis=1))
    column, row = (before[pieces.strips] - edges[pieces.patch, :2]).T
    width = grid_size[pieces.patch, 0]
    corner = first_vertex[pieces.patch] + row * width + column

    vertices = np.empty(grid_size.prod(axis=1).sum(), control.dtype)
    _evaluate(vertices, control, pieces.control, segments[pieces.strips], corner, width)
    triangles, patch = _triangles(vertices["position"], first_vertex, grid_size)
    _make_unit(vertices, triangles)
    index_count = 3 * np.bincount(patch, minlength=len(size))
    return Tessellation(
        vertices, triangles.ravel(), first_vertex, grid_size, _starts(index_count), index_count
    )


@dataclass(frozen=True, eq=False)
class _Pieces:
    """All pieces of all patches, patch by patch, and row by row within a patch.

    Attributes:
        control: (m, 3, 3) numbers of their control points, by row and column.
        patch: (m,) the patch of each.
        strips: (m, 2) its column, which is cut along u, and its row, which is cut along v. Strips
            are numbered patch by patch, the columns of a patch before its rows.
        first_strips: (p, 3) a patch's first column, its first row, and the next patch's first.
    """

    control: Ints
    patch: Ints
    strips: Ints
    first_strips: Ints


def _find_pieces(
    first_control: NDArray[np.integer[Any]], size: NDArray[np.integer[Any]]
) -> _Pieces:
    counts = (size.astype(np.int64) - 1) // 2
    first_column = _starts(counts.sum(axis=1))
    first_strips = first_column[:, None] + np.pad(np.cumsum(counts, axis=1), ((0, 0), (1, 0)))
    patch, number = _runs(counts.prod(axis=1))
    row, column = np.divmod(number, counts[patch, 0])
    width = size[patch, 0].astype(np.int64)
    corner = first_control[patch] + 2 * (row * width + column)
    three = np.arange(3)
    return _Pieces(
        corner[:, None, None] + width[:, None, None] * three[:, None] + three,
        patch,
        first_strips[patch, :2] + np.stack([column, row], axis=1),
        first_strips,
    )


def _starts(counts: Ints) -> Ints:
    """Return where runs begin that lie one after another."""
    return np.cumsum(counts) - counts


def _runs(counts: Ints) -> tuple[Ints, Ints]:
    """Return every member's run, and its number within that run, over all runs."""
    run = np.repeat(np.arange(len(counts)), counts)
    return run, np.arange(len(run)) - _starts(counts)[run]


def _cut_alike(points: Floats, strips: Ints, needed: Ints) -> Ints:
    """Choose the segments of strips so that whatever touches is cut alike.

    Args:
        points: (m, 3, 3, 3) control points of the pieces, in units.
        strips: (m, 2) their strips along u and v.
        needed: (m, 2) the segments they need for themselves.

    Returns:
        (s,) the least numbers of segments with which every piece has what it needs, and equal
        borders have equal numbers.
    """
    borders = np.concatenate([points[:, 0], points[:, 2], points[:, :, 0], points[:, :, 2]])
    strip = strips.T.repeat(2, axis=0).ravel()
    places = np.rint(borders.reshape(-1, 3) / SAME_PLACE)
    _, control = np.unique(places, axis=0, return_inverse=True)
    control = control.reshape(-1, 3)
    backward = control[:, 0] > control[:, 2]
    control[backward] = control[backward, ::-1]
    _, curve = np.unique(control, axis=0, return_inverse=True)

    segments = np.ones(strips.max(initial=-1) + 1, np.int64)
    np.maximum.at(segments, strips, needed)
    of_curve = np.ones(curve.max(initial=-1) + 1, np.int64)
    while True:  # each turn takes the greater numbers one strip further
        np.maximum.at(of_curve, curve, segments[strip])
        if np.array_equal(of_curve[curve], segments[strip]):
            return segments
        np.maximum.at(segments, strip, of_curve[curve])


def _evaluate(
    vertices: NDArray[np.void],
    control: NDArray[np.void],
    pieces: Ints,
    segments: Ints,
    corner: Ints,
    width: Ints,
) -> None:
    """Fill in the vertices of all pieces; those on common borders are written twice, alike.

    Args:
        vertices: (v,) written.
        control: (n,) control points.
        pieces: (m, 3, 3) numbers of their control points.
        segments: (m, 2) along u and v.
        corner: (m,) the vertex at u = v = 0.
        width: (m,) of the grid of vertices.
    """
    cuts, kind = np.unique(segments, axis=0, return_inverse=True)
    for number, (along_u, along_v) in enumerate(cuts.tolist()):
        member = np.flatnonzero(kind == number)
        target = corner[member, None, None] + np.arange(along_u + 1)
        target = target + width[member, None, None] * np.arange(along_v + 1)[:, None]
        for name in control.dtype.names or ():
            # Adding 0 turns -0 into 0: the same place, but not the same bits.
            values = control[name][pieces[member]].astype(np.float64) + 0.0
            curves = patch_segments.on_curves(values.swapaxes(0, 1), along_v)  # (v, m, 3, k)
            points = patch_segments.on_curves(curves.transpose(2, 1, 0, 3), along_u)  # (u, m, v, k)
            vertices[name][target] = points.transpose(1, 2, 0, 3)


def _triangles(
    positions: NDArray[np.float32], first_vertex: Ints, grid_size: Ints
) -> tuple[NDArray[np.uint32], Ints]:
    """Cut the cells of all grids in two, and leave out triangles without area.

    The front of a patch is where cross(along a row, from row to row) points: the engine
    (R_SubdividePatchToGrid, RB_SurfaceGrid of ioquake3) fixes it by the order of the control
    points, whatever their normals say. Every patch of OpenArena's levels has normals that agree.

    Returns:
        triangles: (t, 3) uint32 vertices, clockwise as seen from the front, patch by patch.
        patch: (t,) the patch of each.
    """
    cells = grid_size - 1
    patch, number = _runs(cells.prod(axis=1))
    row, column = np.divmod(number, cells[patch, 0])
    width = grid_size[patch, 0]
    corner = first_vertex[patch] + row * width + column
    below = corner + width
    quads = np.stack([corner, below, corner + 1, corner + 1, below, below + 1], axis=1)
    triangles = quads.astype(np.uint32).reshape(-1, 3)
    has_area = _front(positions, triangles).any(axis=1)
    return triangles[has_area], patch.repeat(2)[has_area]


def _front(positions: NDArray[np.float32], triangles: NDArray[np.uint32]) -> Floats:
    """(t, 3) normals of clockwise triangles, as long as twice their areas."""
    first, second, third = positions[triangles.T].astype(np.float64)
    return np.cross(third - first, second - first)


def _make_unit(vertices: NDArray[np.void], triangles: NDArray[np.uint32]) -> None:
    """Make normals unit in place; where they vanish, take the triangles' mean, or else up."""
    normals = vertices["normal"].astype(np.float64)
    lacking = np.linalg.norm(normals, axis=1) < SHORTEST_NORMAL
    if lacking.any():
        around = triangles[lacking[triangles].any(axis=1)]
        sums = np.zeros_like(normals)
        np.add.at(sums, around, _front(vertices["position"], around)[:, None])
        normals[lacking] = sums[lacking]
        normals[~normals.any(axis=1)] = (0, 0, 1)
    vertices["normal"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
