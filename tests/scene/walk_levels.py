"""Levels to walk through, built of brushes, and what is solid worked out a second time."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from patch_geometry import surface

from followspot.arrays import Floats
from followspot.assets.bsp import BspFile, FaceType
from followspot.assets.bsp_reader import read_bsp
from followspot.assets.surface_flags import Contents, Surface
from followspot.levelbuilder.brush import Brush, hull, room
from followspot.levelbuilder.brush import box as box_brush
from followspot.levelbuilder.compiler import compile_level
from followspot.levelbuilder.level import Level
from followspot.levelbuilder.material import Material
from followspot.levelbuilder.patches import Patch
from followspot.scene import bsp_tree
from followspot.scene.collision import Box

STONE = Material("textures/test/stone")
CLIP = Material("clip", surface=Surface.NODRAW, contents=Contents.PLAYERCLIP, opacity=0.0)
MIST = Material("mist", contents=Contents(0), opacity=0.0)

STOPS_PLAYERS = 0x1 | 0x10000 | 0x2000000
SIZE, HEIGHT = 512.0, 1024.0


def hall(*parts: Brush | Patch) -> Level:
    """A room of 2 SIZE by 2 SIZE by HEIGHT units with its floor at 0, and what stands in it."""
    level = Level()
    level.add(room((-SIZE, -SIZE, 0), (SIZE, SIZE, HEIGHT), STONE), parts)
    level.spawn(0, 0, 0)
    return level


def compiled(level: Level) -> BspFile:
    return read_bsp(compile_level(level), "synthetic")


def block(mins: Sequence[float], maxs: Sequence[float], material: Material = STONE) -> Brush:
    """A box-shaped brush that does not split the level's tree."""
    return box_brush(mins, maxs, material, detail=True)


def ramp(normal_z: float, start: float = 64.0, length: float = 200.0) -> Brush:
    """A wedge that rises from x = `start` on, with a unit normal of that height."""
    rise = length * np.sqrt(1 - normal_z**2) / normal_z
    outline = [(start, 0.0), (start + length, 0.0), (start + length, rise)]
    points = [(x, y, z) for x, z in outline for y in (-100.0, 100.0)]
    return hull(points, STONE, detail=True)


class Obstacles:
    """What stops players in the world, looked up the slow and simple way.

    Brushes are asked point by point, straight from the file's planes; curved patches are points
    of the exact surfaces.
    """

    def __init__(self, bsp: BspFile, spacing: int = 9) -> None:
        self._bsp = bsp
        world = bsp.models[0]
        planes = bsp.planes["normal"].astype(np.float64), bsp.planes["distance"].astype(np.float64)
        stops = (bsp.shaders["content_flags"] & STOPS_PLAYERS) != 0
        self._sides = []
        for brush in bsp.brushes[world["first_brush"] :][: world["brush_count"]]:
            side = bsp.brush_sides["plane"][brush["first_side"] :][: brush["side_count"]]
            if stops[brush["shader"]]:
                self._sides.append((planes[0][side], planes[1][side]))
        self._mins = np.array([-d[[0, 2, 4]] for _, d in self._sides]).reshape(-1, 3)
        self._maxs = np.array([d[[1, 3, 5]] for _, d in self._sides]).reshape(-1, 3)
        self._curves = np.concatenate([np.empty((0, 3)), *self._surfaces(stops, spacing)])

    def _surfaces(self, stops: NDArray[np.bool_], count: int) -> list[Floats]:
        bsp, t = self._bsp, np.linspace(0, 1, count)
        found = []
        for face in bsp.faces[: bsp.models[0]["face_count"]]:
            if face["type"] == FaceType.PATCH and stops[face["shader"]]:
                width, height = face["patch_size"]
                grid = bsp.vertices["position"][face["first_vertex"] :][: width * height]
                grid = grid.reshape(height, width, 3)
                found += [
                    surface(grid[row : row + 3, column : column + 3], t, t).reshape(-1, 3)
                    for row in range(0, height - 1, 2)
                    for column in range(0, width - 1, 2)
                ]
        return found

    def brush_in(self, position: Floats, box: Box) -> bool:
        """Whether a point of a lattice that fills the box is deeper than 0.01 in a brush."""
        low, high = position + box.mins, position + box.maxs
        axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, (7, 7, 12), strict=True)]
        points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
        near = ((self._mins < high) & (self._maxs > low)).all(axis=1)
        return any(
            (points @ normal.T < distance - 0.01).all(axis=1).any()
            for normal, distance in (self._sides[n] for n in np.flatnonzero(near))
        )

    def curve_in(self, position: Floats, box: Box, depth: float) -> bool:
        """Whether a point of a curved patch is deeper than `depth` in the box."""
        low, high = position + box.mins + depth, position + box.maxs - depth
        return bool(((self._curves > low) & (self._curves < high)).all(axis=1).any())

    def is_outside(self, position: Floats) -> bool:
        """Whether a place is in no cluster, or not in the level's box at all."""
        leaf = bsp_tree.point_leafs(self._bsp, position[np.newaxis])[0]
        world = self._bsp.models[0]
        in_box = ((position > world["mins"]) & (position < world["maxs"])).all()
        return bool(self._bsp.leafs["cluster"][leaf] < 0 or not in_box)
