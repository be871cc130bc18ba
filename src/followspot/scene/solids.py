"""Convex solids as runs of planes, for boxes to be moved against.

A box and a convex solid overlap where the box's centre lies in their Minkowski sum, which is convex
too. Its planes are the solid's own, moved out by the box's extent along their normals, and some
more that touch both at an edge or a corner: the six along the axes, and one for each pair of an
edge of the solid and an edge of the box. Level compilers write the additional ones into their
brushes as further sides ("bevels"). Triangles get them here: by the separating axes of a triangle
and a box they are 26 planes (T. Akenine-Möller, "Fast 3D Triangle-Box Overlap Testing", Journal of
Graphics Tools 6, 2001; the game's ``CM_AddFacetBevels`` has the same).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats, Ints
from followspot.assets.binary import run_members
from followspot.assets.bsp import WORLD_LIMIT, BspFile

_SHORTEST = 1e-3
"""Sine of the angle below which two edges count as parallel and span no plane."""


@dataclass(frozen=True, eq=False)
class Solids:
    """Some convex solids, world space, Quake units.

    Attributes:
        mins: (n, 3) least corners of their boxes.
        maxs: (n, 3) greatest corners.
        first: (n,) where a solid's planes begin.
        count: (n,) how many it has, at least 1.
        normal: (p, 3) unit normals that point outwards.
        distance: (p,) inside are the points with ``normal . point <= distance`` for all planes.
    """

    mins: Floats
    maxs: Floats
    first: Ints
    count: Ints
    normal: Floats
    distance: Floats

    def __len__(self) -> int:
        return len(self.first)


def of_brushes(bsp: BspFile, brushes: Ints, offsets: Floats) -> Solids:
    """Some of a level's brushes.

    The planes are the file's. Compilers give every brush the six of its box, and slanted ones the
    bevels; without those a solid's sharp edges would stop a box a little too early.

    Args:
        bsp: The level.
        brushes: (n,) their numbers; those without sides are left out.
        offsets: (n, 3) units by which each is moved: a brush model's entity's origin.
    """
    count = bsp.brushes["side_count"][brushes].astype(np.int64)
    brushes, offsets, count = brushes[count > 0], offsets[count > 0], count[count > 0]
    solid = np.repeat(np.arange(len(brushes)), count)
    planes = bsp.planes[
        bsp.brush_sides["plane"][run_members(bsp.brushes["first_side"][brushes], count)]
    ]
    normal = planes["normal"].astype(np.float64)
    distance = planes["distance"] + (normal * offsets[solid]).sum(axis=1)
    mins = np.full((len(brushes), 3), -WORLD_LIMIT)
    maxs = np.full((len(brushes), 3), WORLD_LIMIT)
    for axis in range(3):
        low, high = normal[:, axis] == -1, normal[:, axis] == 1
        np.maximum.at(mins[:, axis], solid[low], -distance[low])
        np.minimum.at(maxs[:, axis], solid[high], distance[high])
    return Solids(mins, maxs, np.cumsum(count) - count, count, normal, distance)


def of_triangles(corners: Floats) -> Solids:
    """Triangles as solids without thickness.

    Args:
        corners: (t, 3, 3) their corners; none without area.
    """
    edges = np.roll(corners, -1, axis=1) - corners
    edges /= np.linalg.norm(edges, axis=2, keepdims=True)
    box = np.eye(3)
    axes = np.concatenate(
        [
            np.cross(edges[:, 0], edges[:, 1])[:, np.newaxis],
            np.broadcast_to(box, (len(corners), 3, 3)),
            np.cross(edges[:, :, np.newaxis], box).reshape(-1, 9, 3),
        ],
        axis=1,
    )
    length = np.linalg.norm(axes, axis=2, keepdims=True)
    real = length[:, :, 0] > _SHORTEST
    axes /= np.where(length > 0, length, 1)
    reach = axes @ corners.swapaxes(1, 2)  # (t, 13 axes, 3 corners)
    normal = np.concatenate([axes[real], -axes[real]])
    distance = np.concatenate([reach.max(axis=2)[real], -reach.min(axis=2)[real]])
    triangle = np.tile(np.nonzero(real)[0], 2)
    order = np.argsort(triangle, kind="stable")
    count = 2 * real.sum(axis=1)
    return Solids(
        corners.min(axis=1),
        corners.max(axis=1),
        np.cumsum(count) - count,
        count,
        normal[order],
        distance[order],
    )


def joined(parts: Sequence[Solids]) -> Solids:
    """All of several, in their order."""
    shift = np.cumsum([0, *(len(part.normal) for part in parts)])
    return Solids(
        np.concatenate([part.mins for part in parts]),
        np.concatenate([part.maxs for part in parts]),
        np.concatenate([part.first + s for part, s in zip(parts, shift, strict=False)]),
        np.concatenate([part.count for part in parts]),
        np.concatenate([part.normal for part in parts]),
        np.concatenate([part.distance for part in parts]),
    )
