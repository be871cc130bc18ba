"""Which faces to draw, in which order: culling and sorting, pure NumPy.

What is left after culling is drawn as one run of indices a material, near materials first.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints, Mask
from followspot.assets.binary import run_members
from followspot.scene.mesh import Mesh
from followspot.spaces import Mat4, Vec3


@dataclass(frozen=True)
class Batch:
    """One draw call: `count` indices from `first` on, all of one material."""

    material: int
    first: int
    count: int


@dataclass(frozen=True, eq=False)
class DrawList:
    """Indices of everything to draw and the draws that they are cut into, in order."""

    indices: NDArray[np.uint32]
    batches: tuple[Batch, ...]

    @property
    def triangle_count(self) -> int:
        """Number of triangles."""
        return len(self.indices) // 3


_SNAPPED = 1 / 16
"""Texels by which GL may move a vertex: it has at least 4 bits below the pixel, in practice 8."""

NOTHING = DrawList(np.empty(0, np.uint32), ())


def frustum_planes(clip_from_world: Mat4) -> Floats:
    """(6, 4) planes whose ``normal . p + d >= 0`` is the inside, in world space.

    Gribb and Hartmann, Fast Extraction of Viewing Frustum Planes (2001).
    """
    w = clip_from_world[3]
    return np.concatenate([w + clip_from_world[:3], w - clip_from_world[:3]])


def boxes_in_frustum(planes: Floats, mins: NDArray[np.float32], maxs: NDArray[np.float32]) -> Mask:
    """(n,) whether a box is not wholly outside one of the planes: keeps all that is visible.

    Args:
        planes: (p, 4) as from `frustum_planes`.
        mins: (n, 3) in the planes' space.
        maxs: (n, 3) in the planes' space.
    """
    normals = planes[:, :3].astype(np.float32)
    # The farthest corner along each normal, for all boxes and planes in two products.
    reach = np.maximum(normals, 0) @ maxs.T + np.minimum(normals, 0) @ mins.T
    shift = planes[:, 3:].astype(np.float32)
    return np.asarray((reach + shift >= -1e-3 * np.abs(shift)).all(axis=0))


def cubes_in_frustum(planes: Floats, centres: Floats, reach: Floats) -> Mask:
    """(n,) `boxes_in_frustum` of cubes: (n, 3) centres, (n,) from there to a side."""
    normals = planes[:, :3]
    farthest = normals @ centres.T + np.multiply.outer(np.abs(normals).sum(axis=1), reach)
    return np.asarray((farthest + planes[:, 3:] >= 0).all(axis=0))


def height_above(faces: NDArray[np.void], point: Vec3) -> Floats:
    """(faces,) units that a point lies in front of each face's plane; 0 for faces not flat."""
    return np.asarray(faces["normal"] @ point - faces["distance"])


@dataclass(frozen=True, eq=False)
class Projected:
    """Triangles of a mesh as a light sees them: worth keeping as long as the light.

    Attributes:
        indices: (t, 3) of vertices, in the order of the mesh's faces.
        face: (t,) number of the face.
        low: (2, t) least normalised device coordinates x and y; minus infinity where a triangle
            reaches behind the light.
        high: (2, t) largest ones, likewise.
        facing: (t,) positive where the front faces the light, negative where the back does; not a
            number where all of a triangle is behind the light.
        behind: (k,) numbers of those that reach behind the light with a part.
        corners: (3, 3, k) clip coordinates x, y, w of their three corners.
    """

    indices: NDArray[np.uint32]
    face: NDArray[np.intp]
    low: NDArray[np.float32]
    high: NDArray[np.float32]
    facing: NDArray[np.float32]
    behind: NDArray[np.intp]
    corners: Floats


def projected(mesh: Mesh, chosen: Mask, clip_from_world: Mat4, eye: Vec3) -> Projected:
    """Project the triangles of chosen faces.

    Args:
        mesh: Its faces are sorted by material.
        chosen: (faces,) which to project.
        clip_from_world: The light's.
        eye: (3,) its world position in units.
    """
    numbers = np.flatnonzero(chosen)
    faces = mesh.faces[numbers]
    runs = run_members(faces["first_index"], faces["index_count"])
    indices = mesh.indices[runs].reshape(-1, 3)
    # Coordinates first, then corners: NumPy is slow where the last axis is a short one.
    positions = np.ascontiguousarray(mesh.vertices["position"].T, np.float64)
    corner = np.ascontiguousarray(indices.T, np.intp)
    a, b, c = (positions - eye[:, np.newaxis]).take(corner, axis=1).swapaxes(0, 1)
    # Six times the volume of triangle and eye: positive where the (clockwise) front faces it.
    facing = sum(
        a[i] * (b[j] * c[k] - b[k] * c[j]) for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
    )
    rows = clip_from_world[[0, 1, 3]]
    clip = rows[:, :3] @ positions + rows[:, 3:]
    w = clip[2]
    x, y = clip[:2] / np.where(w > 0, w, np.inf)
    x, y, w = (each.take(corner) for each in (x, y, w))
    low, high = np.stack([x.min(axis=0), y.min(axis=0)]), np.stack([x.max(axis=0), y.max(axis=0)])
    behind, before = w.min(axis=0) <= 0, w.max(axis=0) > 0
    partly = np.flatnonzero(behind & before)
    return Projected(
        indices,
        np.repeat(numbers, faces["index_count"] // 3),
        np.where(behind, -np.inf, low).astype(np.float32),
        np.where(behind, np.inf, high).astype(np.float32),
        np.where(before, np.sign(facing), np.nan).astype(np.float32),
        partly,
        clip.take(corner[:, partly], axis=1),
    )


def casters(
    mesh: Mesh,
    seen: Projected,
    chosen: Mask,
    key: NDArray[np.int32],
    keep_side: NDArray[np.float32],
    size: int,
    window: tuple[Floats, Floats] = (np.ones(2), np.zeros(2)),
) -> DrawList:
    """The triangles of chosen faces that can leave a mark in a tile, one batch a key.

    This looks at every triangle, in bulk. It pays because a tile's casters stay the same for many
    frames: what is left out here is never set up by GL again.

    Args:
        mesh: Faces sorted by material.
        seen: The mesh as the light sees it.
        chosen: (faces,) which to look at.
        key: (materials,) material to draw each material as; ascending, so that those which need
            not be told apart are neighbours.
        keep_side: (materials,) 1 keeps triangles whose front faces the eye, -1 those whose back
            does, 0 both.
        size: Texels along an edge of the tile. Triangles that are so small or thin that they pass
            between the middles of its texels are left out, as are those outside of its sides.
        window: (2,) scale and (2,) shift from the coordinates of `seen` to the tile's.
    """
    material = mesh.faces["material"]
    scale, shift = (part.astype(np.float32) for part in window)
    side = np.where(chosen, keep_side[material], np.float32(np.nan))  # NaN is in no order
    wanted = seen.facing * side.take(seen.face) >= 0
    *x_y, w = seen.corners
    for axis, corner in enumerate(x_y):
        moved = corner * scale[axis] + w * shift[axis]
        beyond = (moved > w).all(axis=0) | (moved < -w).all(axis=0)
        wanted[seen.behind[beyond]] = False
    kept = np.flatnonzero(wanted)
    # Numbers of texels, whole in their middles; coordinates first, for NumPy to loop over the many.
    scale = scale[:, np.newaxis] * np.float32(size / 2)
    shift = shift[:, np.newaxis] * np.float32(size / 2) + np.float32(size / 2 - 0.5)
    low, high = (end.take(kept, axis=1) * scale + shift for end in (seen.low, seen.high))
    inside = (low <= size - 0.5) & (high >= -0.5)
    reaches = np.ceil(low - _SNAPPED) <= high + _SNAPPED
    kept = kept[(inside & reaches).all(axis=0)]
    keys = key[material[seen.face[kept]]]
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    counts = np.diff(starts, append=len(keys))
    batches = zip(keys[starts].tolist(), (3 * starts).tolist(), (3 * counts).tolist(), strict=True)
    return DrawList(
        seen.indices.take(kept, axis=0).ravel(), tuple(Batch(*batch) for batch in batches)
    )


class NearFirst(NamedTuple):
    """A mesh's faces by material, those of each by the distance of their boxes from a place.

    Attributes:
        order: (faces,) their numbers.
        distance: (faces,) in units, in that order.
    """

    order: Ints
    distance: Floats

    @classmethod
    def seen_from(cls, mesh: Mesh, eye: Vec3) -> "NearFirst":
        """Sort all faces by their distance from a (3,) world position in units."""
        faces = mesh.faces
        gap = np.maximum(faces["mins"] - eye, 0) + np.maximum(eye - faces["maxs"], 0)
        distance = np.linalg.norm(gap, axis=1)
        order = np.lexsort((distance, faces["material"]))
        return cls(order, distance[order])


def front_to_back(mesh: Mesh, chosen: Mask, near_first: NearFirst, last: Mask) -> DrawList:
    """The chosen faces, one batch a material, roughly near ones first: fewer pixels shaded twice.

    Materials come by the median distance of their faces, the faces of each by their own.

    Args:
        mesh: What to draw from.
        chosen: (faces,) which to draw.
        near_first: All of the mesh's faces.
        last: (materials,) those that come behind all others: cut-out ones, which cannot be
            rejected before they are shaded.
    """
    kept = np.flatnonzero(chosen[near_first.order])
    if not len(kept):
        return NOTHING
    order = near_first.order[kept]
    material = mesh.faces["material"][order]
    starts = np.flatnonzero(np.diff(material, prepend=-1))
    ends = np.append(starts[1:], len(order))
    median = near_first.distance[kept[(starts + ends) // 2]]
    runs = np.lexsort((median, last[material[starts]]))
    order = order[run_members(starts[runs], (ends - starts)[runs])]
    return _cut(mesh, mesh.faces[order], mesh.faces["material"][order])


def back_to_front(mesh: Mesh, chosen: Mask, eye: Vec3, adds: Mask) -> DrawList:
    """The chosen faces by the distance of their boxes' centres from the eye, far first.

    But sums do not depend on their order: neighbours that only add light come by their materials.

    Args:
        mesh: What to draw from.
        chosen: (faces,) which to draw.
        eye: (3,) world position in units.
        adds: (materials,) those that only add to the picture.
    """
    faces = mesh.faces[chosen]
    centres = (faces["mins"].astype(np.float64) + faces["maxs"]) / 2
    faces = faces[np.argsort(-np.linalg.norm(centres - eye, axis=1), kind="stable")]
    material = faces["material"]
    is_sum = adds[material]
    sums = np.cumsum(~is_sum | np.diff(is_sum, prepend=False))
    order = np.lexsort((np.where(is_sum, material, 0), sums))
    return _cut(mesh, faces[order], material[order])


def _cut(mesh: Mesh, faces: NDArray[np.void], material: NDArray[np.int32]) -> DrawList:
    """Neighbouring faces of one material become one batch."""
    if not len(faces):
        return NOTHING
    count = faces["index_count"]
    indices = mesh.indices[run_members(faces["first_index"], count)]
    starts = np.flatnonzero(np.diff(material, prepend=-1))
    first = (np.cumsum(count) - count)[starts]
    length = np.diff(first, append=len(indices))
    return DrawList(
        indices,
        tuple(map(Batch, material[starts].tolist(), first.tolist(), length.tolist())),
    )
