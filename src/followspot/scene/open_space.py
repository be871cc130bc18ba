"""Where in a level there is room: for boxes, as a player or a camera with a margin needs it.

Three things take room: solid leafs of the level's tree (structural walls), solid brushes that lie
in its open leafs (detail), and what is drawn but is no brush of the world: curved patches,
models, doors and the like.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints, Mask
from followspot.assets.binary import run_members
from followspot.assets.bsp import FaceType
from followspot.assets.surface_flags import Contents
from followspot.scene import bsp_tree
from followspot.scene.level import Level
from followspot.scene.mesh import Mesh
from followspot.scene.voxels import Voxels

VOXEL = 8.0
"""Units: drawn surfaces are known to this resolution, or less where there are very many."""

LARGE = 256.0
_BEHIND = 0.5  # units behind a brush's side: inside of the brush

_CHUNK = 20_000  # boxes, or pairs of box and brush, at a time: it fits into caches
_MAX_PAIRS = 4_000_000


class OpenSpace:
    """Tells which boxes of one half-size are free of walls.

    Args:
        level: Where.
        half: Half of the edge of every box, in units.
        source: Another one of this level, for what holds whatever the half-size.
    """

    def __init__(self, level: Level, half: float, source: "OpenSpace | None" = None) -> None:
        self.half = half
        self._source = source or self
        self._bsp, self._level = level.bsp, level
        self._solid_leaf = bsp_tree.leaf_is_solid(level.bsp)
        normals = level.bsp.planes["normal"].astype(np.float64)
        self._reach = np.abs(normals).sum(axis=1) * half

    def sized(self, half: float) -> "OpenSpace":
        """For boxes of another half-size in the same level; what is drawn is not looked at anew."""
        return OpenSpace(self._level, half, self._source)

    def is_free(self, centres: NDArray[np.floating[Any]]) -> Mask:
        """(n,) whether the box around each of (n, 3) world places holds no wall."""
        free = ~self._near_surfaces.hold(centres)
        for start in range(0, len(centres), _CHUNK):
            part = slice(start, start + _CHUNK)
            chosen = np.flatnonzero(free[part])
            free[start + chosen] = self._free_of_leafs(centres[part][chosen])
        chosen = np.flatnonzero(free)
        free[chosen] = self._free_of_brushes(centres[chosen])
        return free

    def _free_of_leafs(self, centres: NDArray[np.floating[Any]]) -> Mask:
        """Take all boxes down the tree at once, into both children where a plane cuts them."""
        tree = self._tree
        free = np.ones(len(centres), bool)
        box, node = np.arange(len(centres)), np.zeros(len(centres), np.int64)
        while box.size:
            height = np.einsum("ij,ij->i", tree.normal[node], centres[box]) - tree.distance[node]
            reach = tree.reach[node]
            front, back = height > -reach, height < reach
            box = np.concatenate([box[front], box[back]])
            node = np.concatenate([tree.front[node[front]], tree.back[node[back]]])
            in_leaf = node < 0
            free[box[in_leaf][self._solid_leaf[~node[in_leaf]]]] = False
            going = ~in_leaf & free[box]
            box, node = box[going], node[going]
        return free

    def _free_of_brushes(self, centres: NDArray[np.floating[Any]]) -> Mask:
        """A box is outside of a brush if it is all in front of one of its sides."""
        bsp, grid = self._bsp, self._brushes
        free = np.ones(len(centres), bool)
        cell = grid.cells(centres)
        pairs = np.cumsum(grid.count[cell])
        for part in np.split(np.arange(len(cell)), np.flatnonzero(np.diff(pairs // _CHUNK)) + 1):
            box = np.repeat(part, grid.count[cell[part]])
            brush = grid.brushes[run_members(grid.first[cell[part]], grid.count[cell[part]])]
            centre = centres[box]
            meets = (centre > grid.mins[brush]).all(axis=1) & (centre < grid.maxs[brush]).all(
                axis=1
            )
            box, brush = box[meets], brush[meets]
            sides = bsp.brushes["side_count"][brush].astype(np.int64)
            plane = bsp.brush_sides["plane"][run_members(bsp.brushes["first_side"][brush], sides)]
            outside = self._heights(plane, centres[np.repeat(box, sides)]) >= self._reach[plane]
            if len(box):
                inside = ~np.logical_or.reduceat(outside, np.cumsum(sides) - sides)
                free[box[inside]] = False
        return free

    @cached_property
    def _tree(self) -> "_Tree":
        nodes, planes = self._bsp.nodes, self._bsp.planes
        children = nodes["children"].astype(np.int64)
        return _Tree(
            planes["normal"][nodes["plane"]].astype(np.float64),
            planes["distance"][nodes["plane"]].astype(np.float64),
            self._reach[nodes["plane"]],
            children[:, 0].copy(),
            children[:, 1].copy(),
        )

    @cached_property
    def _brushes(self) -> "_BrushGrid":
        """The world's solid brushes, by where the middles of boxes are that may meet them.

        Their boxes come from the sides that look along an axis; compilers give every brush six.
        """
        bsp, world = self._bsp, self._bsp.models[0]
        count = bsp.brushes["side_count"].astype(np.int64)
        number = np.repeat(np.arange(len(count)), count)
        side = bsp.brush_sides["plane"][run_members(bsp.brushes["first_side"], count)]
        normal, distance = bsp.planes["normal"][side], bsp.planes["distance"][side]
        mins = np.repeat(world["mins"][np.newaxis].astype(np.float64), len(count), axis=0)
        maxs = np.repeat(world["maxs"][np.newaxis].astype(np.float64), len(count), axis=0)
        for axis in range(3):
            low, high = normal[:, axis] == -1, normal[:, axis] == 1
            np.maximum.at(mins[:, axis], number[low], -distance[low] - self.half)
            np.minimum.at(maxs[:, axis], number[high], distance[high] + self.half)
        solid = bsp.shaders["content_flags"][bsp.brushes["shader"]] & Contents.SOLID
        wanted = (solid != 0) & (count > 0) & (mins < maxs).all(axis=1)
        wanted[: world["first_brush"]] = False
        wanted[world["first_brush"] + world["brush_count"] :] = False
        return _BrushGrid.of(np.flatnonzero(wanted), mins, maxs)

    def _heights(
        self, plane: NDArray[np.integer[Any]], points: NDArray[np.floating[Any]]
    ) -> Floats:
        """(n,) of points above planes."""
        planes = self._bsp.planes[plane]
        dots = np.einsum("ij,ij->i", planes["normal"], points, dtype=np.float64)
        return np.asarray(dots - planes["distance"])

    @cached_property
    def _near_surfaces(self) -> Voxels:
        """Cubes nearer than `half` to what is drawn and is no brush."""
        return self._source._surfaces.grown(self.half)

    @cached_property
    def _surfaces(self) -> Voxels:
        """Cubes that it goes through: the same for all half-sizes, so the source has them."""
        return Voxels.of(corners_within(self._level, _loose(self._level)), VOXEL)


def opaque(level: Level) -> Mask:
    """(triangles,) of the level's mesh, which of them nothing is seen through but for holes."""
    faces = level.mesh.faces
    is_opaque = np.array([material.blend is None for material in level.materials], bool)
    return np.repeat(is_opaque[faces["material"]], faces["index_count"] // 3)


def corners_within(level: Level, chosen: Mask) -> Floats:
    """(t, 3, 3) corners of chosen triangles in the level's box, in pieces of at most LARGE units.

    Levels may have a landscape around them, whose triangles reach far out of the box.
    """
    mesh, world = level.mesh, level.bsp.models[0]
    triangles = _corners(mesh, chosen)
    done = [triangles[:0]]
    while len(triangles):
        inside = (triangles.max(axis=1) >= world["mins"]) & (triangles.min(axis=1) <= world["maxs"])
        triangles = triangles[inside.all(axis=1)]
        large = np.ptp(triangles, axis=1).max(axis=1, initial=0) > LARGE
        done.append(triangles[~large])
        triangles = _quartered(triangles[large])
    return np.concatenate(done)


def _corners(mesh: Mesh, chosen: Mask | Ints) -> Floats:
    corners = mesh.indices.reshape(-1, 3)[chosen]
    return np.asarray(mesh.vertices["position"][corners], np.float64)


def _loose(level: Level) -> Mask:
    """(triangles,) the opaque ones that are no brush of the world."""
    bsp, mesh = level.bsp, level.mesh
    number = level.visibility.level_face
    faces, world = bsp.faces[number], bsp.models[0]
    of_world = number < world["first_face"] + world["face_count"]
    solid = (bsp.shaders["content_flags"][faces["shader"]] & Contents.SOLID) != 0
    is_brush = (number >= 0) & of_world & solid & (faces["type"] == FaceType.POLYGON)
    loose = opaque(level)
    maybe = np.flatnonzero(loose & np.repeat(is_brush, mesh.faces["index_count"] // 3))
    loose[maybe] = ~_has_solid_behind(level, _corners(mesh, maybe))
    return loose


def _has_solid_behind(level: Level, triangles: Floats) -> Mask:
    """(t,) whether (t, 3, 3) triangles are sides of something solid, behind their middles.

    Compilers write flat patches and models as they write brushes, and brushes may be drawn in solid
    shaders without being solid themselves.
    """
    a, b, c = np.moveaxis(triangles, 1, 0)
    normal = np.cross(c - a, b - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-9)
    within = OpenSpace(level, _BEHIND / 2)
    middle = triangles.mean(axis=1) - _BEHIND * normal
    return ~(within._free_of_leafs(middle) & within._free_of_brushes(middle))


class _Tree(NamedTuple):
    """The level's nodes, each array by itself: they are asked many thousand times.

    Attributes:
        normal: (nodes, 3) of their planes.
        distance: (nodes,) units from the origin.
        reach: (nodes,) units from a plane at which boxes begin to touch it.
        front: (nodes,) children in front; leafs as in the file, below 0.
        back: Likewise.
    """

    normal: Floats
    distance: Floats
    reach: Floats
    front: Ints
    back: Ints


@dataclass(frozen=True, eq=False)
class _BrushGrid:
    """Which boxes (of brushes, in world units) reach into which cells of a coarse grid.

    Attributes:
        origin: (3,) the grid's corner.
        edge: Units along an edge of a cell.
        shape: (3,) cells along the axes.
        first: (cells,) where a cell's brushes begin in `brushes`.
        count: (cells,) how many it has.
        brushes: Their numbers, cell after cell.
        mins: (all brushes, 3) corners of the boxes.
        maxs: Likewise.
    """

    origin: Floats
    edge: float
    shape: NDArray[np.int64]
    first: NDArray[np.int64]
    count: NDArray[np.int64]
    brushes: NDArray[np.int64]
    mins: Floats
    maxs: Floats

    @classmethod
    def of(cls, brushes: NDArray[np.int64], mins: Floats, maxs: Floats) -> "_BrushGrid":
        """The grid of some of the brushes, with cells as small as they can well be."""
        low, high = mins[brushes], maxs[brushes]
        origin = low.min(axis=0, initial=np.inf)
        origin = np.where(np.isfinite(origin), origin, 0.0)
        extent = np.maximum(high.max(axis=0, initial=-np.inf) - origin, 1.0)
        edge = 64.0
        while True:
            shape = np.floor(extent / edge).astype(np.int64) + 1
            start = np.floor((low - origin) / edge).astype(np.int64)
            across = np.floor((high - origin) / edge).astype(np.int64) - start + 1
            pairs = across.astype(np.float64).prod(axis=1).sum()
            if max(pairs, shape.astype(np.float64).prod()) <= _MAX_PAIRS:
                break
            edge *= 2
        total = across.prod(axis=1)
        brush = np.repeat(np.arange(len(brushes)), total)
        k = run_members(np.zeros(len(total), np.int64), total)
        width, depth = across[brush, 2], across[brush, 1]
        index = start[brush] + np.stack(
            [k // width // depth, k // width % depth, k % width], axis=1
        )
        cell = np.ravel_multi_index(tuple(index.T), tuple(shape))
        count = np.bincount(cell, minlength=int(shape.prod()))
        order = np.argsort(cell, kind="stable")
        return cls(
            origin, edge, shape, np.cumsum(count) - count, count, brushes[brush[order]], mins, maxs
        )

    def cells(self, points: NDArray[np.floating[Any]]) -> NDArray[np.int64]:
        """(n,) numbers of the cells that points lie in; the nearest one for those outside."""
        index = np.floor((points - self.origin) / self.edge).astype(np.int64)
        index = np.clip(index, 0, self.shape - 1)
        return np.asarray(np.ravel_multi_index(tuple(index.T), tuple(self.shape)))


def _quartered(triangles: Floats) -> Floats:
    """(4t, 3, 3) the triangles between the corners and the edges' middles."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    pieces = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(piece, axis=1) for piece in pieces])
