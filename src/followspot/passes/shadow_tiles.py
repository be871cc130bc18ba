"""What the lights' maps cover and what casts into them, kept while they hold: pure NumPy."""

import numpy as np

from followspot import spaces
from followspot.passes import drawlist, shadow_fit
from followspot.passes.drawlist import DrawList
from followspot.passes.shadow_fit import Boxes, Outlines, ShadowFrustum
from followspot.scene.light import SpotLight
from followspot.scene.scene import Scene
from followspot.scene.settings import CullFace, Settings
from followspot.spaces import Mat4

_SIDE = {CullFace.FRONT: -1, CullFace.BACK: 1, CullFace.NONE: 0}


class ShadowTiles:
    """The frusta that are in an atlas, a tile each, and the level's casters in them.

    Attributes:
        frusta: In the lights' order.
        casters: The level's in each of them.
    """

    def __init__(self, scene: Scene) -> None:
        self._mesh = scene.mesh
        self._everything = Boxes(
            np.concatenate([scene.mesh.faces["mins"], scene.crowd.mins]),
            np.concatenate([scene.mesh.faces["maxs"], scene.crowd.maxs]),
        )
        materials = scene.materials
        self._casts = np.array([m.blend is None for m in materials], bool)
        self._one_sided = np.array([not m.is_two_sided for m in materials], bool)
        # Solid casters of one state need not be told apart: each draws as the first of its state.
        first: dict[object, int] = {}
        self._key = np.array(
            [
                number if m.alpha_test else first.setdefault(m.sides, number)
                for number, m in enumerate(materials)
            ],
            np.int32,
        )
        self._lights: tuple[SpotLight, ...] = ()
        self._fitted: tuple[object, object] = (None, None)
        self._outlines: dict[SpotLight, Outlines] = {}
        self.frusta: tuple[ShadowFrustum, ...] = ()
        self.casters: tuple[DrawList, ...] = ()

    def fit(
        self, lights: tuple[SpotLight, ...], settings: Settings, receivers: Boxes | None
    ) -> bool:
        """Fit the frusta, keeping each that comes out as it was, with its casters.

        Args:
            lights: Those with a shadow map.
            settings: Of them the maps' size and the culled faces are read.
            receivers: Boxes of what the camera sees, the same object while they are the same;
                none covers the lights' whole cones.

        Returns:
            Whether any of them, or their order, is new.
        """
        size, cull = settings.shadow_map_size, settings.shadow_cull
        wanted = ((size, cull), receivers)
        if lights == self._lights and wanted == self._fitted:
            return False
        alike = self._fitted[0] == wanted[0]
        tiles = zip(self.frusta, self.casters, strict=True)
        before = dict(zip(self._lights, tiles, strict=True)) if alike else {}
        self._outlines = {
            light: self._outlines.get(light) or shadow_fit.outlines(light, self._everything)
            for light in lights
        }
        frusta: list[ShadowFrustum] = []
        casters: list[DrawList] = []
        for light in lights:
            frustum = shadow_fit.fit(light, self._outlines[light], receivers, size)
            kept = before.get(light)
            if kept is None or not kept[0].covers_the_same(frustum):
                kept = frustum, self._find_casters(light, frustum, cull, size)
            frusta.append(kept[0])
            casters.append(kept[1])
        is_new = self.frusta != tuple(frusta)
        self.frusta, self.casters = tuple(frusta), tuple(casters)
        self._lights, self._fitted = lights, wanted
        return is_new

    def _find_casters(
        self, light: SpotLight, frustum: ShadowFrustum, cull: CullFace, size: int
    ) -> DrawList:
        """All that may cast within a frustum, wherever the camera is."""
        mesh, matrix = self._mesh, frustum.clip_from_world
        planes = drawlist.frustum_planes(matrix)
        inside = drawlist.boxes_in_frustum(planes, mesh.faces["mins"], mesh.faces["maxs"])
        chosen = inside & self._casts[mesh.faces["material"]]
        side = np.where(self._one_sided, _SIDE[cull], 0).astype(np.float32)
        return drawlist.casters(mesh, chosen, self._key, matrix, side, light.position, size)

    def shadow_from_world(self, number: int) -> Mat4:
        """World to tile `number` of the atlas."""
        place = np.eye(4)
        place[0, 0], place[0, 3] = 1 / len(self.frusta), number / len(self.frusta)
        return place @ spaces.SHADOW_FROM_CLIP @ self.frusta[number].clip_from_world
