"""Fog as the shaders are told of it: the boxes in view and how bright they are."""

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Ints
from followspot.gpu import blocks
from followspot.passes import lighting
from followspot.passes.drawlist import boxes_in_frustum, frustum_planes
from followspot.scene import bsp_tree
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.spaces import Mat4, Vec3

NO_FOG: Ints = np.zeros(0, np.int64)
"""Numbers of no volumes."""


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
        # What nothing but fog shines with, W/(m^2 sr), and 1, each times the extinction per unit.
        glow = [np.append(fog.albedo * around, 1.0) * fog.extinction for fog in fogs]
        self._glow = np.reshape(glow, (-1, 4))
        self._leafs = bsp_tree.box_leafs_to_see(scene.visibility.bsp, self._mins, self._maxs)

    def in_view(self, eye: Vec3, clip_from_world: Mat4) -> Ints:
        """Numbers of the volumes that may be seen; of too many for a frame, the nearest.

        Args:
            eye: (3,) world units.
            clip_from_world: The camera's.
        """
        if not len(self._glow):
            return NO_FOG
        seen = boxes_in_frustum(frustum_planes(clip_from_world), self._mins, self._maxs)
        if seen.any():
            fog, leaf = self._leafs
            seen &= np.isin(np.arange(len(seen)), fog[self._visibility.leafs_from(eye)[leaf]])
        chosen = np.flatnonzero(seen)
        if len(chosen) > blocks.MAX_FOGS:
            away = np.maximum(self._mins - eye, eye - self._maxs)[chosen].max(axis=1)
            chosen = chosen[np.argsort(away, kind="stable")[: blocks.MAX_FOGS]]
        return chosen

    def write(self, block: NDArray[np.void], chosen: Ints, eye: Vec3, scale: float) -> None:
        """Fill in the volumes of a frame block.

        Args:
            block: One of `blocks.FRAME`.
            chosen: Their numbers, as from `in_view`.
            eye: (3,) world units.
            scale: What light is multiplied by for output.
        """
        count = len(chosen)
        block["fog_mins"][:count, :3] = self._mins[chosen] - eye
        block["fog_maxs"][:count, :3] = self._maxs[chosen] - eye
        block["fog_glow"][:count] = self._glow[chosen] * (scale, scale, scale, 1.0)
