"""Triangles of a whole scene in two arrays, with a table of faces to cull and sort by."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Mask

VERTEX = np.dtype([("position", "<f4", 3), ("normal", "<f4", 3), ("texcoord", "<f4", 2)])
"""One vertex: world position in units, unit world normal, texture coordinates (v down)."""

FACE = np.dtype(
    [
        ("first_index", "<i4"),
        ("index_count", "<i4"),
        ("material", "<i4"),
        ("mins", "<f4", 3),
        ("maxs", "<f4", 3),
        ("normal", "<f4", 3),
        ("distance", "<f4"),
    ]
)
"""One face: a contiguous run of indices, one material, its box in world units. If it is flat, the
plane ``dot(normal, p) == distance`` that it lies in, front side outwards; else both are 0."""

FLAT = 0.05
"""Units that a face may stray from its plane and still be flat."""


SMOOTHED_COSINE = math.cos(math.radians(15))
"""Of the angle from which on a normal is far from a triangle's own."""

SMOOTHED_SHARE, SMOOTHED_LEAST = 0.1, 0.005
"""Of a material's area, and of the whole mesh's, from which on such triangles count."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Indexed triangles, front faces clockwise as in Quake's files.

    Attributes:
        vertices: (v,) of VERTEX.
        indices: (i,) uint32 into `vertices`, three a triangle, faces in the table's order.
        faces: (f,) of FACE, sorted by material, so that a material is one run of indices.
        tints: (v, 4) float32 RGBA, linear, that texels of tinted materials are multiplied by, or
            those of a layer, and whose alpha lays the layers of others over; none where no material
            has any of that.
        sprites: (v, 8) float32 of vertices that turn to the camera: the place in units that they
            turn about, units from there, and the axis that they turn about, or none for those that
            keep to the picture's plane; 0 of all others. None where there are none.
        baked: (v, 5) float32 as of `BakedLight.at_vertices`; none of a mesh that nobody has lit.
    """

    vertices: NDArray[np.void]
    indices: NDArray[np.uint32]
    faces: NDArray[np.void]
    tints: NDArray[np.float32] | None = None
    sprites: NDArray[np.float32] | None = None
    baked: NDArray[np.float32] | None = None

    @property
    def triangle_count(self) -> int:
        """Number of triangles."""
        return len(self.indices) // 3

    @property
    def material_of_triangle(self) -> NDArray[np.int32]:
        """(t,) number of each triangle's material."""
        return np.repeat(self.faces["material"], self.faces["index_count"] // 3)

    def is_smoothed(self, materials: int) -> Mask:
        """(materials,) those of many triangles that normals at their corners are far from.

        Args:
            materials: How many there are.
        """
        corners = np.ascontiguousarray(self.indices.reshape(-1, 3).T, np.intp)
        a, b, c = self.vertices["position"][corners]
        across = np.cross(c - a, b - a)  # clockwise front
        area = np.linalg.norm(across, axis=1)
        along = np.einsum("ctk,tk->ct", self.vertices["normal"][corners], across).min(axis=0)
        is_bent = along < area * SMOOTHED_COSINE
        of = self.material_of_triangle
        whole, bent = (np.bincount(of, a, materials) for a in (area, area * is_bent))
        return np.asarray((bent > SMOOTHED_SHARE * whole) & (bent > SMOOTHED_LEAST * area.sum()))

    @cached_property
    def bounds(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(3,) mins and (3,) maxs over all faces, in units; a unit box where there are none."""
        if not len(self.faces):
            return np.zeros(3, np.float32), np.ones(3, np.float32)
        return self.faces["mins"].min(axis=0), self.faces["maxs"].max(axis=0)


def face_boxes(
    positions: NDArray[np.float32],
    indices: NDArray[np.uint32],
    first: NDArray[np.int32],
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Boxes of runs of triangles.

    Args:
        positions: (v, 3) in units.
        indices: (i,) into `positions`, cut into runs without gaps.
        first: (f,) start of every run, ascending, none empty.

    Returns:
        (f, 3) mins and (f, 3) maxs.
    """
    corners = positions[indices]
    return np.minimum.reduceat(corners, first, axis=0), np.maximum.reduceat(corners, first, axis=0)


def face_planes(
    positions: NDArray[np.float32],
    indices: NDArray[np.uint32],
    first: NDArray[np.int32],
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Planes of runs of triangles that lie in one.

    Args:
        positions: (v, 3) in units.
        indices: (i,) into `positions`, clockwise triangles, cut into runs without gaps.
        first: (f,) start of every run, ascending, none empty.

    Returns:
        (f, 3) unit normals on the front side and (f,) distances, both 0 for runs that are not
        flat or have triangles on both sides.
    """
    corners = positions[indices].astype(np.float64).reshape(-1, 3, 3)
    triangle = np.cross(corners[:, 2] - corners[:, 0], corners[:, 1] - corners[:, 0])
    starts = first // 3
    normal = np.add.reduceat(triangle, starts, axis=0)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    count = np.diff(starts, append=len(triangle))
    own = np.repeat(normal, count, axis=0)
    height = np.einsum("tcj,tj->tc", corners, own)
    lowest = np.minimum.reduceat(height.min(axis=1), starts)
    highest = np.maximum.reduceat(height.max(axis=1), starts)
    turned = np.minimum.reduceat(np.einsum("tj,tj->t", triangle, own), starts)
    flat = (highest - lowest <= 2 * FLAT) & (turned >= -1e-6) & normal.any(axis=1)
    distance = np.where(flat, (lowest + highest) / 2, 0)
    return np.where(flat[:, np.newaxis], normal, 0).astype(np.float32), distance.astype(np.float32)
