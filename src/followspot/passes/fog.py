"""Fog as the shaders are told of it: the boxes in view and how bright they are."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Mask
from followspot.gpu import blocks
from followspot.passes import lighting
from followspot.passes.drawlist import boxes_in_frustum, frustum_planes
from followspot.scene import bsp_tree
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.spaces import Mat4, Vec3


@dataclass(frozen=True, eq=False)
class FogInView:
    """The volumes of fog that a frame may show, under their light.

    Attributes:
        mins: (n, 3) corners in world units.
        maxs: (n, 3) the opposite ones.
        glow: (n, 4) what nothing but fog shines with, W/(m^2 sr), and 1, both times the
            extinction per unit.
    """

    mins: NDArray[np.float32]
    maxs: NDArray[np.float32]
    glow: Floats

    def __len__(self) -> int:
        return len(self.glow)

    @property
    def key(self) -> object:
        """Equal for fog that looks the same."""
        return self.mins.tobytes(), self.maxs.tobytes(), self.glow.tobytes()

    def may_cover(self, eye: Vec3, mins: NDArray[np.float32], maxs: NDArray[np.float32]) -> Mask:
        """(m,) whether some of it may be before a box as an eye sees it, or in it.

        Args:
            eye: (3,) world units.
            mins: (m, 3) corners of the boxes, likewise.
            maxs: (m, 3) the opposite ones.
        """
        # A ray from the eye into a box stays within the box that holds both.
        lows, highs = np.minimum(mins, eye), np.maximum(maxs, eye)
        covered = np.zeros(len(lows), bool)
        for fog_mins, fog_maxs in zip(self.mins, self.maxs, strict=True):
            covered |= ((lows <= fog_maxs) & (highs >= fog_mins)).all(axis=1)
        return covered

    def write(self, block: NDArray[np.void], eye: Vec3, scale: float) -> None:
        """Fill in the volumes of a frame block.

        Args:
            block: One of `blocks.FRAME`.
            eye: (3,) world units.
            scale: What light is multiplied by for output.
        """
        count = len(self)
        block["fog_mins"][:count, :3] = self.mins - eye
        block["fog_maxs"][:count, :3] = self.maxs - eye
        block["fog_glow"][:count] = self.glow * (scale, scale, scale, 1.0)


NO_FOG = FogInView(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.float32), np.zeros((0, 4)))
"""That of most levels."""


class LitFog:
    """The fog of a scene under its light.

    The mean of the environment lights it, or what was baked; lights do not.

    Args:
        scene: Has the volumes.
        settings: Tell what lights them.
    """

    def __init__(self, scene: Scene, settings: Settings) -> None:
        fogs = scene.level.fogs if settings.fog else ()
        around = lighting.mean_from_around(scene, settings)
        self._visibility = scene.visibility
        self._mins = np.array([fog.mins for fog in fogs], np.float32).reshape(-1, 3)
        self._maxs = np.array([fog.maxs for fog in fogs], np.float32).reshape(-1, 3)
        glow = [np.append(fog.albedo * around, 1.0) * fog.extinction for fog in fogs]
        self._glow = np.reshape(glow, (-1, 4))
        self._leafs = bsp_tree.box_leafs_to_see(scene.visibility.bsp, self._mins, self._maxs)

    def in_view(self, eye: Vec3, clip_from_world: Mat4) -> FogInView:
        """The volumes that may be seen; of too many for a frame, the nearest.

        Args:
            eye: (3,) world units.
            clip_from_world: The camera's.
        """
        if not len(self._glow):
            return NO_FOG
        seen = boxes_in_frustum(frustum_planes(clip_from_world), self._mins, self._maxs)
        if seen.any():
            fog, leaf = self._leafs
            in_sight = np.zeros(len(seen), bool)
            in_sight[fog[self._visibility.leafs_from(eye)[leaf]]] = True
            seen &= in_sight
        chosen = np.flatnonzero(seen)
        if len(chosen) > blocks.MAX_FOGS:
            away = np.maximum(self._mins - eye, eye - self._maxs)[chosen].max(axis=1)
            chosen = chosen[np.argsort(away, kind="stable")[: blocks.MAX_FOGS]]
        return FogInView(self._mins[chosen], self._maxs[chosen], self._glow[chosen])
