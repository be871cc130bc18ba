"""Brushes: convex solids, the stuff that levels are carved from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike

from followspot.arrays import Floats
from followspot.errors import UsageError
from followspot.levelbuilder.material import Material
from followspot.levelbuilder.projection import Projection, world_aligned
from followspot.levelbuilder.winding import area, base_winding, split

WORLD_EXTENT = 65536.0
"""Half side, in units, of the square that a brush's sides are cut from."""

_DIRECTIONS = {
    "-x": (-1, 0, 0),
    "+x": (1, 0, 0),
    "-y": (0, -1, 0),
    "+y": (0, 1, 0),
    "-z": (0, 0, -1),
    "+z": (0, 0, 1),
}


@dataclass(frozen=True)
class Side:
    """One side of a brush.

    Attributes:
        normal: Unit normal, pointing out of the brush, (3,) float64.
        dist: Distance of its plane from the origin, in units.
        material: What it is made of.
        winding: The side's polygon, (n, 3) float64, world units.
        texture: (2, 4) matrix from (x, y, z, 1) to texture coordinates.
    """

    normal: Floats
    dist: float
    material: Material
    winding: Floats
    texture: Floats


@dataclass(frozen=True)
class Brush:
    """A convex solid.

    Attributes:
        sides: At least four sides.
        material: What it is made of inside; rules its contents.
        detail: Left out of the BSP split (small things that hide nothing); collides and draws
            as any other.
        mins: Least corner of its box, (3,) float64.
        maxs: Greatest corner of its box.
    """

    sides: tuple[Side, ...]
    material: Material
    detail: bool
    mins: Floats
    maxs: Floats

    @property
    def hides(self) -> bool:
        """Whether nothing can be seen through it or inside it."""
        return self.material.opacity == 1.0

    @property
    def structural(self) -> bool:
        """Whether it takes part in the BSP split and seals the level."""
        return self.hides and not self.detail


def brush_from_planes(
    planes: Floats,
    material: Material,
    *,
    faces: Mapping[str, Material] | None = None,
    projection: Projection | None = None,
    detail: bool = False,
) -> Brush:
    """Build a brush as the space behind all planes.

    Args:
        planes: (n, 4) float64 rows (nx, ny, nz, d) with unit normals that point outwards.
        material: Material of all sides that ``faces`` does not name.
        faces: Other materials by direction: "+z" names the sides that face up more than
            sideways, and so on.
        projection: Texture projection of all sides; world-aligned by default.
        detail: See `Brush.detail`.

    Raises:
        UsageError: The planes enclose nothing, or ``faces`` names no direction.
    """
    project = projection or world_aligned()
    named = _by_direction(material, faces)
    sides = []
    for i, plane in enumerate(planes):
        winding: Floats | None = base_winding(plane[:3], plane[3], WORLD_EXTENT)
        for j, other in enumerate(planes):
            if winding is not None and i != j:
                winding = split(winding, other[:3], other[3])[1]
        if winding is None or len(winding) < 3 or area(winding) < 1e-6:
            continue
        winding = np.round(winding, 6)
        axis = int(np.abs(plane[:3]).argmax())
        chosen = named["-+"[int(plane[axis] > 0)] + "xyz"[axis]]
        texture = project(plane[:3], winding, chosen)
        sides.append(Side(plane[:3], float(plane[3]), chosen, winding, texture))
    if len(sides) < 4:
        raise UsageError(f"a brush of {material.name} with {len(planes)} planes encloses nothing")
    corners = np.concatenate([side.winding for side in sides])
    return Brush(tuple(sides), material, detail, corners.min(axis=0), corners.max(axis=0))


def _by_direction(material: Material, faces: Mapping[str, Material] | None) -> dict[str, Material]:
    named = dict(faces or {})
    if unknown := sorted(named.keys() - _DIRECTIONS.keys()):
        known = ", ".join(_DIRECTIONS)
        raise UsageError(f"the sides of a brush are called {known}, not {unknown[0]!r}")
    return dict.fromkeys(_DIRECTIONS, material) | named


def box(
    mins: ArrayLike,
    maxs: ArrayLike,
    material: Material,
    *,
    faces: Mapping[str, Material] | None = None,
    projection: Projection | None = None,
    detail: bool = False,
) -> Brush:
    """Build an upright box between two corners; the other arguments as `brush_from_planes`."""
    low, high = np.asarray(mins, dtype=np.float64), np.asarray(maxs, dtype=np.float64)
    normals = np.array(list(_DIRECTIONS.values()), dtype=np.float64)
    dists = np.stack([-low, high], axis=1).reshape(6)
    planes = np.column_stack([normals, dists])
    return brush_from_planes(planes, material, faces=faces, projection=projection, detail=detail)


def hull(
    points: ArrayLike,
    material: Material,
    *,
    faces: Mapping[str, Material] | None = None,
    projection: Projection | None = None,
    detail: bool = False,
) -> Brush:
    """Build the convex hull of a few points, (n, 3): ramps, roofs, wedges, prisms.

    Meant for up to some twenty points: every plane through three of them is tried.
    """
    cloud = np.asarray(points, dtype=np.float64)
    if len(cloud) < 4:
        raise UsageError(f"a hull of {material.name} needs four points, not {len(cloud)}")
    triples = np.array(list(combinations(range(len(cloud)), 3)))
    a, b, c = cloud[triples].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1)
    normals, a = normals[length > 1e-6], a[length > 1e-6]
    normals /= length[length > 1e-6, None]
    planes = np.column_stack([normals, (normals * a).sum(axis=1)])
    planes = np.concatenate([planes, -planes])
    outside = (planes[:, :3] @ cloud.T - planes[:, 3:]).max(axis=1)
    planes = np.round(planes[outside < 1e-4], 9)
    _, first = np.unique(np.round(planes, 4) + 0.0, axis=0, return_index=True)
    planes = planes[np.sort(first)]
    return brush_from_planes(planes, material, faces=faces, projection=projection, detail=detail)


def prism(
    outline: Sequence[tuple[float, float]],
    bottom: float,
    top: float,
    material: Material,
    *,
    faces: Mapping[str, Material] | None = None,
    projection: Projection | None = None,
    detail: bool = False,
) -> Brush:
    """Build an upright prism over a convex outline of (x, y) points from ``bottom`` to ``top``."""
    points = [(x, y, z) for x, y in outline for z in (bottom, top)]
    return hull(points, material, faces=faces, projection=projection, detail=detail)


def room(
    mins: ArrayLike,
    maxs: ArrayLike,
    material: Material,
    *,
    thickness: float = 16.0,
    faces: Mapping[str, Material] | None = None,
) -> list[Brush]:
    """Build six brushes round a hollow box; ``faces`` names walls by where they stand.

    Args:
        mins: Least corner of the hollow.
        maxs: Its greatest corner.
        material: Of the walls, floor and ceiling that ``faces`` does not name.
        thickness: Of the walls, in units.
        faces: Other materials: "-z" is the floor, "+z" the ceiling, "+x" the wall in the east.
    """
    named = _by_direction(material, faces)
    inner = np.array([mins, maxs], dtype=np.float64)
    outer = inner + np.array([[-thickness], [thickness]])
    walls = []
    for axis in range(3):
        for end, sign in enumerate("-+"):
            corners = outer.copy()
            corners[1 - end, axis] = inner[end, axis]
            for lower in range(axis):  # walls meet without overlap
                corners[:, lower] = inner[:, lower]
            walls.append(box(corners[0], corners[1], named[sign + "xyz"[axis]]))
    return walls
