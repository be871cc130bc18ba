"""Which faces to draw, in which order: culling and sorting, pure NumPy.

What is left after culling is drawn as one run of indices a material, near materials first.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from followspot.assets.binary import run_members
from followspot.scene.mesh import Mesh
from followspot.spaces import Mat4, Vec3

Mask = NDArray[np.bool_]


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


def frustum_planes(clip_from_world: Mat4) -> NDArray[np.float64]:
    """(6, 4) planes whose ``normal . p + d >= 0`` is the inside, in world space.

    Gribb and Hartmann, Fast Extraction of Viewing Frustum Planes (2001).
    """
    w = clip_from_world[3]
    return np.concatenate([w + clip_from_world[:3], w - clip_from_world[:3]])


def boxes_in_frustum(
    planes: NDArray[np.float64], mins: NDArray[np.float32], maxs: NDArray[np.float32]
) -> Mask:
    """(n,) whether a box is not wholly outside one of the planes: keeps all that is visible.

    Args:
        planes: (p, 4) as from `frustum_planes`.
        mins: (n, 3) in the planes' space.
        maxs: (n, 3) in the planes' space.
    """
    normals = planes[:, :3].astype(np.float32)
    # The farthest corner along each normal, for all boxes and planes in two products.
    reach = maxs @ np.maximum(normals, 0).T + mins @ np.minimum(normals, 0).T
    inside = reach + planes[:, 3].astype(np.float32) >= -1e-3 * np.abs(planes[:, 3])
    return np.asarray(inside.all(axis=1))


def cubes_in_frustum(
    planes: NDArray[np.float64], centres: NDArray[np.float64], reach: NDArray[np.float64]
) -> Mask:
    """(n,) `boxes_in_frustum` of cubes: (n, 3) centres, (n,) from there to a side."""
    normals = planes[:, :3]
    farthest = centres @ normals.T + np.multiply.outer(reach, np.abs(normals).sum(axis=1))
    return np.asarray((farthest + planes[:, 3] >= 0).all(axis=1))


def height_above(faces: NDArray[np.void], point: Vec3) -> NDArray[np.float64]:
    """(faces,) units that a point lies in front of each face's plane; 0 for faces not flat."""
    return np.asarray(faces["normal"] @ point - faces["distance"])


@dataclass(frozen=True, eq=False)
class Projected:
    """All triangles of a mesh as a light sees them: worth keeping as long as the light.

    Attributes:
        indices: (t, 3) of vertices, in the order of the mesh's faces.
        face: (t,) number of the face.
        low: (t, 2) least normalised device coordinates; minus infinity where one reaches behind
            the light.
        high: (t, 2) largest ones, likewise.
        facing: (t,) positive where the front faces the light, negative where the back does.
        behind: (k,) numbers of those that reach behind the light.
        corners: (k, 3, 3) theirs in clip coordinates x, y, w.
    """

    indices: NDArray[np.uint32]
    face: NDArray[np.intp]
    low: NDArray[np.float32]
    high: NDArray[np.float32]
    facing: NDArray[np.float32]
    behind: NDArray[np.intp]
    corners: NDArray[np.float64]


def projected(mesh: Mesh, clip_from_world: Mat4, eye: Vec3) -> Projected:
    """Project all of a mesh.

    Args:
        mesh: Its faces are sorted by material.
        clip_from_world: The light's.
        eye: (3,) its world position in units.
    """
    faces = mesh.faces
    runs = run_members(faces["first_index"], faces["index_count"])
    indices = mesh.indices[runs].reshape(-1, 3)
    positions = mesh.vertices["position"]
    corners = positions[indices].astype(np.float64) - eye
    # Six times the volume of triangle and eye: positive where the (clockwise) front faces it.
    facing = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    clip = positions @ clip_from_world[[0, 1, 3], :3].T + clip_from_world[[0, 1, 3], 3]
    w = clip[:, 2:]
    divided = (clip[:, :2] / np.where(w > 0, w, np.inf))[indices]
    behind = w[indices].min(axis=1) <= 0
    numbers = np.flatnonzero(behind)
    return Projected(
        indices,
        np.repeat(np.arange(len(faces)), faces["index_count"] // 3),
        np.where(behind, -np.inf, divided.min(axis=1)).astype(np.float32),
        np.where(behind, np.inf, divided.max(axis=1)).astype(np.float32),
        np.sign(facing).astype(np.float32),
        numbers,
        clip[indices[numbers]],
    )


def casters(
    mesh: Mesh,
    seen: Projected,
    chosen: Mask,
    key: NDArray[np.int32],
    keep_side: NDArray[np.float32],
    size: int,
    window: tuple[NDArray[np.float64], NDArray[np.float64]] = (np.ones(2), np.zeros(2)),
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
    wanted = chosen[seen.face] & (seen.facing * keep_side[material][seen.face] >= 0)
    w = seen.corners[..., 2:]
    x_y = seen.corners[..., :2] * scale + w * shift
    beyond = np.all(x_y > w, axis=1) | np.all(x_y < -w, axis=1)
    wanted[seen.behind[np.any(beyond, axis=1)]] = False
    kept = np.flatnonzero(wanted)
    low, high = seen.low[kept] * scale + shift, seen.high[kept] * scale + shift
    inside = ((low <= 1) & (high >= -1)).all(axis=1)
    low, high = ((end * 0.5 + 0.5) * size - 0.5 for end in (low, high))  # whole in the middles
    reaches = (np.ceil(low - _SNAPPED) <= high + _SNAPPED).all(axis=1)
    kept = kept[inside & reaches]
    keys = key[material[seen.face[kept]]]
    starts = np.flatnonzero(np.diff(keys, prepend=-1))
    counts = np.diff(starts, append=len(keys))
    batches = zip(keys[starts].tolist(), (3 * starts).tolist(), (3 * counts).tolist(), strict=True)
    return DrawList(seen.indices[kept].ravel(), tuple(Batch(*batch) for batch in batches))


def front_to_back(mesh: Mesh, chosen: Mask, eye: Vec3, last: Mask) -> DrawList:
    """The chosen faces, one batch a material, roughly near ones first: fewer pixels shaded twice.

    Materials come by the median distance of their boxes from the eye, the faces of each by their
    own.

    Args:
        mesh: What to draw from.
        chosen: (faces,) which to draw.
        eye: (3,) world position in units.
        last: (materials,) those that come behind all others: cut-out ones, which cannot be
            rejected before they are shaded.
    """
    faces = mesh.faces[chosen]
    if not len(faces):
        return NOTHING
    material = faces["material"]
    gap = np.maximum(faces["mins"] - eye, 0) + np.maximum(eye - faces["maxs"], 0)
    distance = np.linalg.norm(gap, axis=1)
    order = np.lexsort((distance, material))
    starts = np.flatnonzero(np.diff(material[order], prepend=-1))
    middle = (starts + np.append(starts[1:], len(order))) // 2
    median = np.zeros(len(last))
    median[material[order[starts]]] = distance[order[middle]]
    order = np.lexsort((distance, material, median[material], last[material]))
    return _cut(mesh, faces[order], material[order])


def back_to_front(mesh: Mesh, chosen: Mask, eye: Vec3) -> DrawList:
    """The chosen faces sorted by the distance of their boxes' centres from the eye, far first."""
    faces = mesh.faces[chosen]
    centres = (faces["mins"].astype(np.float64) + faces["maxs"]) / 2
    faces = faces[np.argsort(-np.linalg.norm(centres - eye, axis=1), kind="stable")]
    return _cut(mesh, faces, faces["material"])


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
