"""The camera: where it stands, where it looks, how wide."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from followspot import spaces
from followspot.errors import UsageError
from followspot.spaces import Mat4, Vec3

STEEPEST = 90.0
"""Degrees from level that a camera may look up or down."""

_ROUNDING = 1e-6  # degrees that angles between such angles may come out steeper


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera in the game's own terms.

    Attributes:
        position: (3,) eye in world space, Quake units; any three numbers are taken.
        yaw: Degrees, counter-clockwise from +X, as the game's ``viewpos`` prints it.
        pitch: Degrees from -90 to 90, positive looks down.
        fov: Horizontal angle of view in degrees, between 0 and 180.
        near: Distance of the near plane in units (the game's 4 clips no wall at arm's length).

    Raises:
        UsageError: nothing can be seen so, or a number is none.
    """

    position: Vec3
    yaw: float = 0.0
    pitch: float = 0.0
    fov: float = 90.0
    near: float = 4.0
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", spaces.vec3(self.position))
        if not (0 < self.fov < 180 and 0 < self.near < math.inf):
            raise UsageError(
                "a camera: expected a fov between 0 and 180 degrees and a near plane in front of "
                f"it, found {self.fov} and {self.near}"
            )
        numbers = (*self.position.tolist(), self.yaw, self.pitch)
        if not all(map(math.isfinite, numbers)):
            raise UsageError(f"a camera: expected finite numbers, found {numbers}")
        pitch = min(max(self.pitch, -STEEPEST), STEEPEST)
        if abs(self.pitch - pitch) > _ROUNDING:
            raise UsageError(
                f"a camera: expected a pitch of -90 to 90 degrees, found {self.pitch:g}"
            )
        object.__setattr__(self, "pitch", pitch)

    @property
    def forward(self) -> Vec3:
        """(3,) unit world direction that the camera looks along."""
        return spaces.forward_from_angles(self.yaw, self.pitch)

    @cached_property
    def view_from_world(self) -> Mat4:
        """World space to OpenGL's view space."""
        return spaces.view_from_world(self.position, self.yaw, self.pitch)

    def clip_from_view(self, aspect: float, far: float) -> Mat4:
        """Perspective for a picture of width/height `aspect` and a far plane in units."""
        fov_y = spaces.vertical_fov(self.fov, aspect)
        return spaces.clip_from_view(self.fov, fov_y, self.near, far)

    def far_for(self, mins: NDArray[np.float32], maxs: NDArray[np.float32]) -> float:
        """Distance that holds the whole box (world units) whichever way the camera turns."""
        farthest = np.maximum(np.abs(mins - self.position), np.abs(maxs - self.position))
        reach = math.sqrt(farthest @ farthest)
        return max(reach, self.near * 2) * 1.01
