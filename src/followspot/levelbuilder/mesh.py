"""From polygons to triangles: T-junctions closed, windings fanned, loose meshes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats, Ints
from followspot.levelbuilder.material import Material

T_DISTANCE = 0.05
"""A corner nearer than this, in units, to another polygon's edge is put into that edge."""

_CHUNK = 256


@dataclass(frozen=True)
class Mesh:
    """Loose triangles: leaves, flames, ropes. Drawn from the side where they wind clockwise.

    Attributes:
        material: Its ``surface`` flags should say NONSOLID; the engine never collides with it.
        points: (n, 3) float64 world units.
        st: (n, 2) float64 texture coordinates.
        normals: (n, 3) float64 unit normals.
        triangles: (m, 3) indices into the points, clockwise from the front.
    """

    material: Material
    points: Floats
    st: Floats
    normals: Floats
    triangles: Ints


def quads(material: Material, corners: Floats, st: Floats | None = None) -> Mesh:
    """Return a mesh of flat quads.

    Args:
        material: Its material.
        corners: (n, 4, 3) corners: top left, top right, bottom right, bottom left from the front.
        st: (n, 4, 2) texture coordinates; the whole texture on each by default.
    """
    count = len(corners)
    if st is None:
        st = np.tile(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), (count, 1, 1))
    normals = np.cross(corners[:, 3] - corners[:, 0], corners[:, 1] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    triangles = np.array([[0, 1, 2], [0, 2, 3]]) + 4 * np.arange(count)[:, None, None]
    return Mesh(
        material,
        corners.reshape(-1, 3),
        st.reshape(-1, 2),
        np.repeat(normals, 4, axis=0),
        triangles.reshape(-1, 3),
    )


def weld_t_junctions(windings: Sequence[Floats]) -> list[Floats]:
    """Put every polygon's corners into the edges of others that they lie on.

    Without this a rasteriser leaves pin holes where a corner meets the middle of an edge.
    Corners are first rounded to 1/64 unit, so that equal corners are equal to the bit.
    """
    counts = np.array([len(winding) for winding in windings])
    corners = np.round(np.concatenate(windings) * 64) / 64
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    following = np.arange(len(corners)) + 1
    following[starts + counts - 1] = starts
    ends = corners[following]
    points = np.unique(corners, axis=0)
    edge_ids, point_ids, along = _points_on_edges(corners, ends, points)
    # sorting (edge, place along it) strings old corners (place 0) and new ones in their order
    edges = np.concatenate([np.arange(len(corners)), edge_ids])
    place = np.concatenate([np.zeros(len(corners)), along])
    everything = np.concatenate([corners, points[point_ids]])
    order = np.lexsort([place, edges])
    polygon = np.repeat(np.arange(len(windings)), counts)[edges[order]]
    cuts = np.flatnonzero(np.diff(polygon)) + 1
    return np.split(everything[order], cuts)


def _points_on_edges(starts: Floats, ends: Floats, points: Floats) -> tuple[Ints, Ints, Floats]:
    """Return (edge, point, share of the edge's length) of points strictly inside edges."""
    edge_ids, point_ids, shares = [], [], []
    order = np.argsort(np.minimum(starts[:, 0], ends[:, 0]))  # points are sorted by x, too
    for chunk in np.array_split(order, max(1, len(order) // _CHUNK)):
        a, b = starts[chunk], ends[chunk]
        low, high = np.minimum(a, b) - T_DISTANCE, np.maximum(a, b) + T_DISTANCE
        first = np.searchsorted(points[:, 0], low[:, 0].min())
        last = np.searchsorted(points[:, 0], high[:, 0].max(), "right")
        near = points[first:last]
        boxed = (near[None] >= low[:, None]).all(axis=2) & (near[None] <= high[:, None]).all(axis=2)
        i, j = np.nonzero(boxed)
        edge = b[i] - a[i]
        length = np.linalg.norm(edge, axis=1)
        offset = near[j] - a[i]
        share = (offset * edge).sum(axis=1) / length**2
        distance = np.linalg.norm(offset - share[:, None] * edge, axis=1)
        margin = T_DISTANCE / length
        hit = (distance < T_DISTANCE) & (share > margin) & (share < 1 - margin)
        edge_ids.append(chunk[i[hit]])
        point_ids.append(first + j[hit])
        shares.append(share[hit])
    return np.concatenate(edge_ids), np.concatenate(point_ids), np.concatenate(shares)


def triangulate(winding: Floats) -> Ints:
    """Return triangles, (m, 3), of a convex polygon that may have straight corners.

    The smallest ear that is not empty is cut off each time, so that what is left never is.
    """
    left = list(range(len(winding)))
    triangles = []
    while len(left) > 3:
        here = winding[left]
        before, after = np.roll(here, 1, axis=0), np.roll(here, -1, axis=0)
        doubled = np.linalg.norm(np.cross(before - here, after - here), axis=1)
        k = int(np.where(doubled > 1e-6 * doubled.max(), doubled, np.inf).argmin())
        triangles.append([left[k - 1], left[k], left[(k + 1) % len(left)]])
        del left[k]
    triangles.append(left)
    return np.array(triangles)
