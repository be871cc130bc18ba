"""Where in a level there is room: for boxes, as a player or a camera with a margin needs it.

Three things take room: solid leafs of the level's tree (structural walls), solid brushes that lie
in its open leafs (detail), and what is drawn but is no brush of the world: curved patches,
models, doors and the like.
"""

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.assets.binary import run_members
from followspot.assets.bsp import FaceType
from followspot.scene import bsp_tree
from followspot.scene.level import Level

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

CONTENTS_SOLID = 1
"""Content flag of brushes that stop everything (the game's surfaceflags.h)."""

VOXEL = 8.0
"""Units: drawn surfaces are known to this resolution."""

_CHUNK = 20000  # boxes at a time, so that memory stays small


class OpenSpace:
    """Tells which boxes of one half-size are free of walls.

    Args:
        level: Where.
        half: Half of the edge of every box, in units.
    """

    def __init__(self, level: Level, half: float) -> None:
        self.half = half
        self._bsp, self._level = level.bsp, level
        brushes = level.bsp.brushes
        contents = level.bsp.shaders["content_flags"][brushes["shader"]]
        self._solid_brush = ((contents & CONTENTS_SOLID) != 0) & (brushes["side_count"] > 0)
        self._solid_leaf = bsp_tree.leaf_is_solid(level.bsp)
        normals = level.bsp.planes["normal"].astype(np.float64)
        self._reach = np.abs(normals).sum(axis=1) * half

    def is_free(self, centres: NDArray[np.floating[Any]]) -> Mask:
        """(n,) whether the box around each of (n, 3) world places holds no wall."""
        free = ~self._near_drawn(centres)
        for start in range(0, len(centres), _CHUNK):
            part = slice(start, start + _CHUNK)
            chosen = np.flatnonzero(free[part])
            free[start + chosen] = self._free_of_brushes(centres[part][chosen])
        return free

    def _free_of_brushes(self, centres: NDArray[np.floating[Any]]) -> Mask:
        """Take all boxes down the tree at once, into both children where a plane cuts them."""
        bsp = self._bsp
        free = np.ones(len(centres), bool)
        box, node = np.arange(len(centres)), np.zeros(len(centres), np.int64)
        boxes, leafs = [box[:0]], [node[:0]]
        while box.size:
            at = bsp.nodes[node]
            height = self._heights(at["plane"], centres[box])
            front = height > -self._reach[at["plane"]]
            back = height < self._reach[at["plane"]]
            box = np.concatenate([box[front], box[back]])
            children = at["children"].astype(np.int64)
            node = np.concatenate([children[front, 0], children[back, 1]])
            in_leaf = node < 0
            solid = in_leaf.copy()
            solid[in_leaf] = self._solid_leaf[~node[in_leaf]]
            free[box[solid]] = False
            boxes.append(box[in_leaf])
            leafs.append(~node[in_leaf])
            going = ~in_leaf & free[box]
            box, node = box[going], node[going]
        box, leaf = np.concatenate(boxes), np.concatenate(leafs)
        box, leaf = box[free[box]], leaf[free[box]]
        free[self._in_brush(centres, box, leaf)] = False
        return free

    def _in_brush(
        self, centres: NDArray[np.floating[Any]], box: NDArray[np.int64], leaf: NDArray[np.int64]
    ) -> NDArray[np.int64]:
        """Those of `box` that meet a solid brush listed in the leaf given with them.

        A box is outside of a brush if it is all in front of one of its sides.
        """
        bsp = self._bsp
        count = bsp.leafs["leaf_brush_count"][leaf].astype(np.int64)
        brush = bsp.leaf_brushes[run_members(bsp.leafs["first_leaf_brush"][leaf], count)]
        box = np.repeat(box, count)
        mins, maxs = self._brush_boxes
        centre = centres[box]
        meets = self._solid_brush[brush]
        meets &= (centre > mins[brush]).all(axis=1) & (centre < maxs[brush]).all(axis=1)
        box, brush = box[meets], brush[meets]
        if not len(box):
            return box
        sides = bsp.brushes["side_count"][brush].astype(np.int64)
        plane = bsp.brush_sides["plane"][run_members(bsp.brushes["first_side"][brush], sides)]
        outside = self._heights(plane, centres[np.repeat(box, sides)]) >= self._reach[plane]
        starts = np.cumsum(sides) - sides
        return np.asarray(box[~np.logical_or.reduceat(outside, starts)])

    @cached_property
    def _brush_boxes(self) -> tuple[Array, Array]:
        """(brushes, 3) mins and maxs that the middles of boxes which meet a brush lie between.

        They come from the sides that look along an axis; compilers give six to every brush.
        """
        bsp = self._bsp
        count = bsp.brushes["side_count"].astype(np.int64)
        brush = np.repeat(np.arange(len(count)), count)
        side = bsp.brush_sides["plane"][run_members(bsp.brushes["first_side"], count)]
        normal, distance = bsp.planes["normal"][side], bsp.planes["distance"][side]
        mins, maxs = np.full((len(count), 3), -np.inf), np.full((len(count), 3), np.inf)
        for axis in range(3):
            low, high = normal[:, axis] == -1, normal[:, axis] == 1
            np.maximum.at(mins[:, axis], brush[low], -distance[low] - self.half)
            np.minimum.at(maxs[:, axis], brush[high], distance[high] + self.half)
        return mins, maxs

    def _heights(self, plane: NDArray[np.integer[Any]], points: NDArray[np.floating[Any]]) -> Array:
        """(n,) of points above planes."""
        planes = self._bsp.planes[plane]
        dots = np.einsum("ij,ij->i", planes["normal"], points, dtype=np.float64)
        return np.asarray(dots - planes["distance"])

    def _near_drawn(self, centres: NDArray[np.floating[Any]]) -> Mask:
        if not len(self._drawn):
            return np.zeros(len(centres), bool)
        keys = _keys(np.floor(centres / VOXEL).astype(np.int64))
        place = np.minimum(np.searchsorted(self._drawn, keys), len(self._drawn) - 1)
        return np.asarray(self._drawn[place] == keys)

    @cached_property
    def _drawn(self) -> NDArray[np.int64]:
        """Keys of the voxels whose middle is nearer than `half` to a drawn surface's."""
        voxels = np.unique(np.floor(self._drawn_points() / VOXEL).astype(np.int64), axis=0)
        reach = int(np.ceil(self.half / VOXEL))
        shifts = np.arange(-reach, reach + 1)
        keys = _keys(voxels)
        for axis in np.eye(3, dtype=np.int64):
            keys = np.unique(keys[:, np.newaxis] + shifts * _keys(axis, origin=0))
        return keys

    def _drawn_points(self) -> Array:
        """(n, 3) points on the opaque surfaces that are no brushes of the world, VOXEL apart."""
        bsp, mesh, materials = self._bsp, self._level.mesh, self._level.materials
        number = self._level.visibility.level_face
        faces = bsp.faces[number]
        of_world = number < bsp.models["first_face"][0] + bsp.models["face_count"][0]
        solid = (bsp.shaders["content_flags"][faces["shader"]] & CONTENTS_SOLID) != 0
        is_brush = of_world & solid & (faces["type"] == FaceType.POLYGON)
        opaque = np.array([m.blend is None for m in materials], bool)[mesh.faces["material"]]
        wanted = mesh.faces[opaque & ~is_brush]
        corners = mesh.vertices["position"][
            mesh.indices[run_members(wanted["first_index"], wanted["index_count"])]
        ].astype(np.float64).reshape(-1, 3, 3)  # fmt: skip
        return _spread(corners)


def _spread(triangles: Array) -> Array:
    """(n, 3) points on (t, 3, 3) triangles, at most VOXEL apart along their edges."""
    a, ab, ac = (
        triangles[:, 0],
        triangles[:, 1] - triangles[:, 0],
        triangles[:, 2] - triangles[:, 0],
    )
    u_count = np.ceil(np.linalg.norm(ab, axis=1) / VOXEL).astype(np.int64) + 1
    v_count = np.ceil(np.linalg.norm(ac, axis=1) / VOXEL).astype(np.int64) + 1
    count = u_count * v_count
    triangle = np.repeat(np.arange(len(triangles)), count)
    k = run_members(np.zeros(len(count), np.int64), count)
    u = (k % u_count[triangle]) / np.maximum(u_count - 1, 1)[triangle]
    v = (k // u_count[triangle]) / np.maximum(v_count - 1, 1)[triangle]
    inside = u + v <= 1 + 1e-9
    triangle, u, v = triangle[inside], u[inside, np.newaxis], v[inside, np.newaxis]
    return np.asarray(a[triangle] + u * ab[triangle] + v * ac[triangle])


def _keys(voxels: NDArray[np.int64], origin: int = 1 << 19) -> NDArray[np.int64]:
    """(..., 3) voxel numbers, each within 2^19 of 0, as one number."""
    x, y, z = np.moveaxis(voxels + origin, -1, 0)
    return np.asarray((x << 40) + (y << 20) + z)
