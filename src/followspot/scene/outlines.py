"""Boxes, frusta and cones as lines and triangles: what debugging pictures are made of.

Lines are pairs of points, triangles threes; all in world space, Quake units.
"""

import math

import numpy as np
from numpy.typing import NDArray

from followspot import spaces
from followspot.arrays import Floats, Ints
from followspot.assets.binary import run_members
from followspot.scene.light import SpotLight
from followspot.scene.scene import Scene
from followspot.spaces import Mat4, Vec3

Points = NDArray[np.float32]

SAME_CORNER = 0.5
"""Units: corners of two faces that are at most about so far apart are one."""

CIRCLE = 48
"""Lines of a circle."""

# Corners are numbered as `spaces.box_corners` does: bit 2 chooses x, bit 1 y, bit 0 z.
_EDGES = np.array([(a, a | bit) for bit in (1, 2, 4) for a in range(8) if not a & bit])
_SIDES = np.array(
    [
        (at, at | u, at | u | v, at, at | u | v, at | v)
        for side, u, v in ((1, 2, 4), (2, 4, 1), (4, 1, 2))
        for at in (0, side)
    ]
)

EDGE_POINTS = _EDGES.size
"""Points of a box's or frustum's lines."""

SIDE_POINTS = _SIDES.size
"""Points of a box's or frustum's triangles."""

CONE_POINTS = 2 * CIRCLE + 8
MARK_POINTS = 6


def box_lines(mins: NDArray[np.floating], maxs: NDArray[np.floating]) -> Points:
    """(n * EDGE_POINTS, 3) edges of boxes from (n, 3) mins and maxs."""
    choose = spaces.box_corners(spaces.vec3((0, 0, 0)), spaces.vec3((1, 1, 1)))[_EDGES.ravel()]
    corners = mins[:, np.newaxis] + (maxs - mins)[:, np.newaxis] * choose
    return np.asarray(corners.reshape(-1, 3), np.float32)


def frustum_corners(clip_from_world: Mat4) -> Floats:
    """(8, 3) corners of what a matrix maps to the clip cube, in the order of a box's."""
    cube = spaces.box_corners(spaces.vec3((-1, -1, -1)), spaces.vec3((1, 1, 1)))
    world = np.linalg.solve(clip_from_world, np.c_[cube, np.ones(8)].T).T
    return np.asarray(world[:, :3] / world[:, 3:])


def frustum_lines(clip_from_world: Mat4) -> Points:
    """(EDGE_POINTS, 3) edges of a frustum."""
    return np.asarray(frustum_corners(clip_from_world)[_EDGES.ravel()], np.float32)


def frustum_triangles(clip_from_world: Mat4) -> Points:
    """(SIDE_POINTS, 3) sides of a frustum, in no particular winding."""
    return np.asarray(frustum_corners(clip_from_world)[_SIDES.ravel()], np.float32)


def cone_lines(light: SpotLight, length: float) -> Points:
    """(CONE_POINTS, 3) a spot light's cone up to a distance along its axis: its rim, four sides."""
    light_from_world = spaces.view_from_world(
        light.position, *spaces.angles_from_forward(light.direction)
    )
    right, up = light_from_world[0, :3], light_from_world[1, :3]
    angle = np.linspace(0, 2 * np.pi, CIRCLE + 1)[:, np.newaxis]
    tangents = (np.cos(angle) * right + np.sin(angle) * up) * math.tan(light.half_angle)
    rim = light.position + length * (light.direction + tangents)
    circle = np.stack([rim[:-1], rim[1:]], axis=1)
    quarters = rim[: CIRCLE : CIRCLE // 4]
    sides = np.stack([np.broadcast_to(light.position, quarters.shape), quarters], axis=1)
    return np.concatenate([circle, sides]).reshape(-1, 3).astype(np.float32)


def mark_lines(position: Vec3, size: float) -> Points:
    """(MARK_POINTS, 3) a cross along the axes, `size` units to each side."""
    arms = np.stack([-np.eye(3), np.eye(3)], axis=1).reshape(-1, 3) * size
    return np.asarray(position + arms, np.float32)


def objects(scene: Scene) -> tuple[Points, Points]:
    """Boxes of a scene's objects that never move.

    A level's file knows no objects: an object is what hangs together here, faces of one brush
    model that share corners. A crate that stands on a floor shares none with it, since the floor is
    not cut up where it stands; the walls, floors and ceilings of connected rooms are one object.
    Props are one object each.

    Returns:
        (n, 3) mins and (n, 3) maxs.
    """
    mesh, level_face = scene.mesh, scene.visibility.level_face
    faces, level_face = mesh.faces[level_face >= 0], level_face[level_face >= 0]
    mins = [prop.bounds[0][np.newaxis] for prop in scene.props]
    maxs = [prop.bounds[1][np.newaxis] for prop in scene.props]
    if len(faces):
        model = np.searchsorted(scene.level.bsp.models["first_face"], level_face, side="right")
        count = faces["index_count"]
        corners = mesh.vertices["position"][
            mesh.indices[run_members(faces["first_index"], count)]
        ].astype(np.float64)
        owner = np.repeat(np.arange(len(faces)), count)
        place = np.c_[np.round(corners / SAME_CORNER), model[owner]]
        corner = np.unique(place, axis=0, return_inverse=True)[1].reshape(-1)
        label = _smallest_label(corner, owner, np.cumsum(count) - count)
        order = np.argsort(label, kind="stable")
        starts = np.flatnonzero(np.diff(label[order], prepend=-1))
        mins.append(np.minimum.reduceat(faces["mins"][order], starts, axis=0))
        maxs.append(np.maximum.reduceat(faces["maxs"][order], starts, axis=0))
    none = np.empty((0, 3), np.float32)
    return np.concatenate([none, *mins]), np.concatenate([none, *maxs])


def _smallest_label(corner: Ints, face: Ints, first: Ints) -> Ints:
    """(faces,) the smallest number among the faces that each is connected to by corners.

    Faces hand their number on to their corners and those to their faces, until nothing changes;
    taking a label's own label shortens long chains.
    """
    label = np.arange(len(first))
    while True:
        smallest = np.full(int(corner.max()) + 1, len(first))
        np.minimum.at(smallest, corner, label[face])
        handed_on = np.minimum.reduceat(smallest[corner], first)
        handed_on = handed_on[handed_on]
        if np.array_equal(handed_on, label):
            return label
        label = handed_on
