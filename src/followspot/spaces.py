"""Spaces, units and the matrices between them.

World space is the level's own: Quake units, right-handed, Z up. A camera's *eye* axes
are Quake's (looks down +X, +Y to the left, +Z up); *view* space is OpenGL's (looks down
-Z, +X to the right, +Y up). ``VIEW_FROM_EYE`` is the only place where an axis flips.

Matrices are float64, act on column vectors and are named ``to_from_from``:
``clip_from_world = clip_from_view @ view_from_world``.
"""

import math

import numpy as np

from followspot.arrays import Floats

Vec3 = Floats
"""(3,) float64."""
Mat4 = Floats
"""(4, 4) float64, acting on column vectors."""

METRES_PER_UNIT = 0.03
"""Default length of a Quake unit: a 56-unit player is 1.7 m tall."""

VIEW_FROM_EYE: Mat4 = np.array(
    [[0, -1, 0, 0], [0, 0, 1, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], dtype=np.float64
)
"""Quake's looking-down-+X eye axes to OpenGL's looking-down--Z view axes."""

SHADOW_FROM_CLIP: Mat4 = np.array(
    [[0.5, 0, 0, 0.5], [0, 0.5, 0, 0.5], [0, 0, 0.5, 0.5], [0, 0, 0, 1]], dtype=np.float64
)
"""[-1, 1] clip cube to the [0, 1] texture and depth range (Williams 1978's bias matrix)."""


def vec3(values: object) -> Vec3:
    """Anything of three numbers as a read-only (3,) float64 array."""
    vector = np.array(values, dtype=np.float64).reshape(3)
    vector.flags.writeable = False
    return vector


def normalised(vector: Vec3) -> Vec3:
    """The (3,) unit vector along `vector`.

    Raises:
        ValueError: the vector has no direction.
    """
    length = float(np.linalg.norm(vector))
    if not (math.isfinite(length) and length > 0):
        raise ValueError(f"{vector} has no direction")
    return vec3(vector / length)


def forward_from_angles(yaw: float, pitch: float) -> Vec3:
    """World direction of Quake view angles in degrees; positive pitch looks down."""
    y, p = math.radians(yaw), math.radians(pitch)
    return vec3([math.cos(p) * math.cos(y), math.cos(p) * math.sin(y), -math.sin(p)])


def angles_from_forward(forward: Vec3) -> tuple[float, float]:
    """Quake (yaw, pitch) in degrees that look along a world direction."""
    x, y, z = forward
    aside = math.hypot(x, y)
    # Straight up or down any yaw will do, but not that of what rounding has left.
    yaw = math.atan2(y, x) if aside > 1e-9 * abs(z) else 0.0
    return math.degrees(yaw), -math.degrees(math.atan2(z, aside))


def view_from_world(position: Vec3, yaw: float, pitch: float) -> Mat4:
    """World to view for an eye in units and Quake angles in degrees (no roll)."""
    y, p = math.radians(yaw), math.radians(pitch)
    cos_y, sin_y, cos_p, sin_p = math.cos(y), math.sin(y), math.cos(p), math.sin(p)
    eye_from_world = np.array(
        [
            [cos_p * cos_y, cos_p * sin_y, -sin_p, 0],  # forward
            [-sin_y, cos_y, 0, 0],  # left
            [sin_p * cos_y, sin_p * sin_y, cos_p, 0],  # up
            [0, 0, 0, 1],
        ]
    )
    eye_from_world[:3, 3] = -eye_from_world[:3, :3] @ position
    return np.asarray(VIEW_FROM_EYE @ eye_from_world)


def clip_from_view(fov_x: float, fov_y: float, near: float, far: float) -> Mat4:
    """Perspective with full angles of view in degrees and planes in units."""
    x, y = 1 / math.tan(math.radians(fov_x) / 2), 1 / math.tan(math.radians(fov_y) / 2)
    depth, shift = (near + far) / (near - far), 2 * near * far / (near - far)
    return np.array([[x, 0, 0, 0], [0, y, 0, 0], [0, 0, depth, shift], [0, 0, -1, 0]])


def vertical_fov(horizontal: float, aspect: float) -> float:
    """Vertical angle of view in degrees for a horizontal one and width/height."""
    return math.degrees(2 * math.atan(math.tan(math.radians(horizontal) / 2) / aspect))


def directions_around(count: int) -> Floats:
    """(count, 3) unit vectors spread evenly over the sphere (a Fibonacci lattice)."""
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    angle, radius = math.pi * (1 + math.sqrt(5)) * k, np.sqrt(1 - z * z)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)


def box_corners(mins: Vec3, maxs: Vec3) -> Floats:
    """The (8, 3) corners of a box, same space and units."""
    choose = np.array(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij")).reshape(3, 8).T
    return np.where(choose == 0, mins, maxs).astype(np.float64)
