"""Triangles of a whole scene in two arrays, with a table of faces to cull and sort by."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

VERTEX = np.dtype([("position", "<f4", 3), ("normal", "<f4", 3), ("texcoord", "<f4", 2)])
"""One vertex: world position in units, unit world normal, texture coordinates (v down)."""

FACE = np.dtype(
    [
        ("first_index", "<i4"),
        ("index_count", "<i4"),
        ("material", "<i4"),
        ("mins", "<f4", 3),
        ("maxs", "<f4", 3),
    ]
)
"""One face: a contiguous run of indices, one material, its box in world units."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Indexed triangles, front faces clockwise as in Quake's files.

    Attributes:
        vertices: (v,) of VERTEX.
        indices: (i,) uint32 into `vertices`, three a triangle, faces in the table's order.
        faces: (f,) of FACE, sorted by material, so that a material is one run of indices.
    """

    vertices: NDArray[np.void]
    indices: NDArray[np.uint32]
    faces: NDArray[np.void]

    @property
    def triangle_count(self) -> int:
        """Number of triangles."""
        return len(self.indices) // 3

    @property
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
