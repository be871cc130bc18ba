"""Where in a level there is room: for boxes, as a player or a camera with a margin needs it.

Three things take room: solid leafs of the level's tree (structural walls), solid brushes that lie
in its open leafs (detail), and what is drawn but is no brush of the world: curved patches,
models, doors and the like.
"""

import math
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
"""Units: drawn surfaces are known to this resolution, or less where there are very many."""

MAX_VOXELS = 300_000
LARGE = 256.0

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
        voxel, drawn = self._drawn
        if not len(drawn):
            return np.zeros(len(centres), bool)
        keys = _keys(np.floor(centres / voxel).astype(np.int64))
        place = np.minimum(np.searchsorted(drawn, keys), len(drawn) - 1)
        return np.asarray(drawn[place] == keys)

    @cached_property
    def _drawn(self) -> tuple[float, NDArray[np.int64]]:
        """Edge of a voxel, and keys of all those nearer than `half` to a drawn surface."""
        triangles = self._drawn_triangles()
        across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        area = float(np.linalg.norm(across, axis=1).sum()) / 2
        voxel = max(VOXEL, math.sqrt(area / MAX_VOXELS))
        keys = _distinct(_keys(np.floor(_spread(triangles, voxel) / voxel).astype(np.int64)))
        reach = math.ceil(self.half / voxel)
        for axis in np.eye(3, dtype=np.int64):
            shifts = np.arange(-reach, reach + 1) * _keys(axis, origin=0)
            keys = _distinct((keys[:, np.newaxis] + shifts).ravel())
        return voxel, keys

    def _drawn_triangles(self) -> Array:
        """(t, 3, 3) corners of opaque triangles in the level's box that are no brush of the world.

        They are cut into pieces of at most LARGE units; levels may have a landscape around them.
        """
        bsp, mesh, materials = self._bsp, self._level.mesh, self._level.materials
        number = self._level.visibility.level_face
        faces, world = bsp.faces[number], bsp.models[0]
        of_world = number < world["first_face"] + world["face_count"]
        solid = (bsp.shaders["content_flags"][faces["shader"]] & CONTENTS_SOLID) != 0
        is_brush = of_world & solid & (faces["type"] == FaceType.POLYGON)
        opaque = np.array([m.blend is None for m in materials], bool)[mesh.faces["material"]]
        wanted = mesh.faces[opaque & ~is_brush]
        corners = mesh.indices[run_members(wanted["first_index"], wanted["index_count"])]
        triangles = mesh.vertices["position"][corners].astype(np.float64).reshape(-1, 3, 3)
        done = [triangles[:0]]
        while len(triangles):
            inside = (triangles.max(axis=1) >= world["mins"]) & (
                triangles.min(axis=1) <= world["maxs"]
            )
            triangles = triangles[inside.all(axis=1)]
            large = np.ptp(triangles, axis=1).max(axis=1, initial=0) > LARGE
            done.append(triangles[~large])
            triangles = _quartered(triangles[large])
        return np.concatenate(done)


def _quartered(triangles: Array) -> Array:
    """(4t, 3, 3) the triangles between the corners and the edges' middles."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    pieces = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(piece, axis=1) for piece in pieces])


def _spread(triangles: Array, gap: float) -> Array:
    """(n, 3) points on (t, 3, 3) triangles, at most `gap` apart along their edges."""
    a, ab, ac = (
        triangles[:, 0],
        triangles[:, 1] - triangles[:, 0],
        triangles[:, 2] - triangles[:, 0],
    )
    u_count = np.ceil(np.linalg.norm(ab, axis=1) / gap).astype(np.int64) + 1
    v_count = np.ceil(np.linalg.norm(ac, axis=1) / gap).astype(np.int64) + 1
    count = u_count * v_count
    triangle = np.repeat(np.arange(len(triangles)), count)
    k = run_members(np.zeros(len(count), np.int64), count)
    u = (k % u_count[triangle]) / np.maximum(u_count - 1, 1)[triangle]
    v = (k // u_count[triangle]) / np.maximum(v_count - 1, 1)[triangle]
    inside = u + v <= 1 + 1e-9
    triangle, u, v = triangle[inside], u[inside, np.newaxis], v[inside, np.newaxis]
    return np.asarray(a[triangle] + u * ab[triangle] + v * ac[triangle])


def _distinct(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Every key once, in order; np.unique's hashing is many times slower for such keys."""
    keys = np.sort(keys)
    return np.asarray(keys[np.diff(keys, prepend=-1) != 0])


def _keys(voxels: NDArray[np.int64], origin: int = 1 << 19) -> NDArray[np.int64]:
    """(..., 3) voxel numbers, each within 2^19 of 0, as one number."""
    x, y, z = np.moveaxis(voxels + origin, -1, 0)
    return np.asarray((x << 40) + (y << 20) + z)
