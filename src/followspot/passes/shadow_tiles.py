"""How the lights share an atlas, and what casts into their tiles, kept while they hold: pure NumPy.

The atlas has a row for each spot light, of two square tiles: the wide one for all that the camera
sees, the near one for what is near it. Together they have the texels that were asked for. Where
maps are not fitted to the camera there is only the wide one. The sides of point lights' cubes
follow in rows of three, with one tile each that stays the same wherever the camera is: it is in the
middle of what they light, so that there is nothing to fit.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from followspot import spaces
from followspot.arrays import Floats, Mask
from followspot.passes import drawlist, shadow_fit
from followspot.passes.drawlist import NOTHING, DrawList, Projected
from followspot.passes.shadow_fit import Boxes, Outlines, Receivers, ShadowFrustum
from followspot.scene.light import CubeSide, SpotLight
from followspot.scene.scene import Scene
from followspot.scene.settings import CullFace, Settings
from followspot.spaces import Mat4

_SIDE = {CullFace.FRONT: -1, CullFace.BACK: 1, CullFace.NONE: 0}


Place = tuple[int, int]
"""Column and row in the atlas, in tiles."""


LIT_SIDE, GRAZING, STEEP = 3.0, 0.1, 0.4
"""How receivers are moved whose lit side is in the map: `common/offset.glsl`."""

SIDES_IN_A_ROW = 3
"""Of point lights' cubes; few, for the atlas to be as wide as high with three of them."""


def tiles_per_spot(settings: Settings) -> int:
    """Tiles that a spot light has room for, next to each other."""
    return 2 if settings.shadow_fit else 1


def shape(lights: Sequence[SpotLight], settings: Settings) -> Place:
    """Columns and rows of the atlas in which lights, spots before sides of cubes, have room."""
    spots = spot_count(lights)
    sides = len(lights) - spots
    columns = max(tiles_per_spot(settings), SIDES_IN_A_ROW if sides else 1)
    return columns, spots + sides // SIDES_IN_A_ROW


def spot_count(lights: Sequence[SpotLight]) -> int:
    """How many of them are not sides of a cube."""
    return sum(not isinstance(light, CubeSide) for light in lights)


def tile_size(settings: Settings) -> int:
    """Texels along a tile's edge: a spot's tiles together have those of a map of the set size."""
    return round(settings.shadow_map_size / math.sqrt(tiles_per_spot(settings)))


def map_size(tile: int, settings: Settings) -> int:
    """The largest `shadow_map_size` whose tiles have at most so many texels along an edge."""
    return math.floor((tile + 0.5) * math.sqrt(tiles_per_spot(settings)) - 1e-9)


def near_reach(settings: Settings) -> float:
    """Share of a near tile's edge from its middle up to which it is looked at."""
    return 0.5 - shadow_fit.MARGIN / tile_size(settings)


def side_scale(settings: Settings) -> float:
    """Share of a tile's edge that a tangent of 1 is, on a side of a point light's cube."""
    return 0.5 / shadow_fit.side_reach(tile_size(settings))


@dataclass(frozen=True, eq=False)
class Tile:
    """A square of the atlas. Equal only to itself.

    Attributes:
        light: Number of its light, or side of a cube.
        place: Where it is in the atlas.
        is_near: Whether it is that light's near one.
        frustum: What it covers.
        finer: What the near tile covers, for a wide one that has one.
        casters: The level's.
    """

    light: int
    place: Place
    is_near: bool
    frustum: ShadowFrustum
    finer: ShadowFrustum | None = None
    casters: DrawList = NOTHING

    @cached_property
    def seam(self) -> float:
        """Width of the strip along the near tile's edges in which lookups may still read this tile,
        as a share of an edge.
        """
        assert self.finer is not None
        low, high = self.finer.edges
        reach = shadow_fit.MARGIN * (self.finer.texels + self.frustum.texels)
        return float((reach / (high - low)).max())

    @cached_property
    def finer_from_here(self) -> tuple[Floats, Floats]:
        """(2,) scale and (2,) shift to the near tile; both tiles' edges are at 0 and 1."""
        assert self.finer is not None
        (low, high), (near_low, near_high) = self.frustum.edges, self.finer.edges
        return (high - low) / (near_high - near_low), (low - near_low) / (near_high - near_low)


class ShadowTiles:
    """The tiles that are in an atlas.

    Attributes:
        tiles: The first light's wide one, its near one if it has one, then the next light's.
        lights: Whose they are: spot lights, then sides of cubes.
        shape: Columns and rows of the atlas, in tiles.
    """

    def __init__(self, scene: Scene) -> None:
        self._mesh = scene.mesh
        self._everything = Boxes(
            np.concatenate([scene.mesh.faces["mins"], scene.crowd.mins]),
            np.concatenate([scene.mesh.faces["maxs"], scene.crowd.maxs]),
        )
        materials = scene.materials
        self._casts = np.array([m.casts for m in materials], bool)
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
        self.lights: tuple[SpotLight, ...] = ()
        self._fitted: tuple[object, object] = (None, None)
        self._outlines: dict[SpotLight, Outlines] = {}
        self._projected: dict[SpotLight, Projected] = {}
        self.shape: Place = (1, 1)
        self.tiles: tuple[Tile, ...] = ()

    def forget(self) -> None:
        """Take whatever is fitted next for new."""
        self._fitted = None, None

    def fit(
        self, lights: tuple[SpotLight, ...], settings: Settings, receivers: Receivers | None
    ) -> bool:
        """Fit the frusta, keeping each that comes out as it was, with its casters.

        Args:
            lights: Those with a shadow map: spot lights, then all sides of each point light's cube.
            settings: Of them the maps' size and the culled faces are read.
            receivers: What the camera sees, the same object while that is the same; none covers
                the lights' whole cones.

        Returns:
            Whether any tile, or their order, is new.
        """
        size, self.shape = tile_size(settings), shape(lights, settings)
        wanted = ((size, settings.shadow_cull), receivers)
        if lights == self.lights and wanted == self._fitted:
            return False
        spots = spot_count(lights)
        alike = self._fitted[0] == wanted[0]
        before = {(self.lights[t.light], t.is_near): t for t in self.tiles} if alike else {}
        self._outlines = {
            light: self._outlines.get(light) or shadow_fit.outlines(light, self._everything)
            for light in lights[:spots]
        }
        projected = self._projected if alike else {}
        self._projected = {
            light: projected.get(light) or self._project_all(light, size)
            for light in lights[:spots]
        }
        tiles: list[Tile] = []
        for number, light in enumerate(lights):
            place = self._place(number, spots)
            if isinstance(light, CubeSide):
                kept = before.get((light, False))
                side = shadow_fit.whole_side(light, size) if kept is None else kept.frustum
                tiles.append(self._tile(Tile(number, place, False, side), before, light, settings))
                continue
            seen = None if receivers is None else shadow_fit.outlines(light, receivers)
            wide = shadow_fit.fit(light, self._outlines[light], seen, size)
            near = None
            if receivers is not None and seen is not None:
                near = shadow_fit.fit_near(light, wide, receivers, seen, size)
            if near is not None:
                finer = self._tile(Tile(number, (1, number), True, near), before, light, settings)
                near = finer.frustum
            tiles.append(
                self._tile(Tile(number, place, False, wide, near), before, light, settings)
            )
            if near is not None:
                tiles.append(finer)
        is_new = self.tiles != tuple(tiles)
        self.tiles = tuple(tiles)
        self.lights, self._fitted = lights, wanted
        return is_new

    def _place(self, number: int, spots: int) -> Place:
        """Where light `number` has its wide tile."""
        if number < spots:
            return 0, number
        row, column = divmod(number - spots, SIDES_IN_A_ROW)
        return column, spots + row

    def _tile(
        self,
        wanted: Tile,
        before: Mapping[tuple[SpotLight, bool], Tile],
        light: SpotLight,
        settings: Settings,
    ) -> Tile:
        """The one that there was, if it will do; or a new one, with its casters."""
        kept = before.get((light, wanted.is_near))
        if kept is None or not kept.frustum.covers_the_same(wanted.frustum):
            return replace(wanted, casters=self._find_casters(light, wanted.frustum, settings))
        if (kept.light, kept.place, kept.finer) == (wanted.light, wanted.place, wanted.finer):
            return kept
        return replace(wanted, frustum=kept.frustum, casters=kept.casters)

    def _project(self, light: SpotLight, inside: Mask) -> Projected:
        """Casters among the level's faces, (faces,), as a light sees them."""
        chosen = inside & self._casts[self._mesh.faces["material"]]
        return drawlist.projected(self._mesh, chosen, _tangents_from_world(light), light.position)

    def _project_all(self, spot: SpotLight, size: int) -> Projected:
        """All that may cast within any window of a light's tiles."""
        reached = self._outlines[spot].within(shadow_fit.widest(spot, size))
        return self._project(spot, reached[: len(self._mesh.faces)])

    def _find_casters(
        self, light: SpotLight, frustum: ShadowFrustum, settings: Settings
    ) -> DrawList:
        """All that may cast within a frustum, wherever the camera is."""
        mesh, faces = self._mesh, self._mesh.faces
        if isinstance(light, CubeSide):  # has one window for good: what it sees is looked at once
            planes = drawlist.frustum_planes(frustum.clip_from_world)
            inside = drawlist.boxes_in_frustum(planes, faces["mins"], faces["maxs"])
            seen = self._project(light, inside)
        else:
            boxes, seen = self._outlines[light], self._projected[light]
            inside = (boxes.within(frustum.window) & (boxes.near < frustum.far))[: len(faces)]
        side = np.where(self._one_sided, _SIDE[settings.shadow_cull], 0).astype(np.float32)
        low, high = frustum.edges
        window = 2 / (high - low), (low + high) / (low - high)
        size = tile_size(settings)
        return drawlist.casters(mesh, seen, inside, self._key, side, size, window)

    def atlas_from_world(self, tile: Tile) -> Mat4:
        """World to the atlas, whose corners are at 0 and 1, through a tile."""
        place = np.eye(4)
        place[:2, 3] = tile.place
        place[:2] /= np.array(self.shape)[:, np.newaxis]
        return place @ spaces.SHADOW_FROM_CLIP @ tile.frustum.clip_from_world

    def offsets(self, tile: Tile, texels: float, size: int) -> tuple[Floats, float]:
        """How far a receiver is moved off its surface, as surface.vert has it.

        Args:
            tile: A light's wide one.
            texels: By how many texels.
            size: Of them along a tile's edge.

        Returns:
            (2, 4) the light's axes to the right and up, and what a unit along them is in the
            atlas for each unit of distance; and a texel in depth.
        """
        frustum = tile.frustum
        axes = shadow_fit.view_from_world(self.lights[tile.light])[:2, :3]
        # Depth is a constant less this over the distance, which shrinks by a share of itself.
        over_distance = frustum.near * frustum.far / (frustum.far - frustum.near)
        across = texels / size / np.array(self.shape)
        return np.c_[axes, across], -over_distance * frustum.texel * texels

    def near_from_wide(self) -> Floats:
        """(spots, 4) scales (x, y) and shifts (x, y) from the wide tiles into the near ones.

        Of homogeneous atlas coordinates: ``near.xy = wide.xy * scale + wide.w * shift``. Where
        there is no near tile, everything comes to lie outside of the atlas.
        """
        found = np.tile([1.0, 1.0, 4.0, 4.0], (spot_count(self.lights), 1))
        for tile in self.tiles:
            if tile.finer is not None:
                scale, shift = tile.finer_from_here
                before, after = np.array([[0, tile.light], [1, tile.light]])
                shift = (shift - scale * before + after) / self.shape
                found[tile.light] = *scale, *shift
        return found


def _tangents_from_world(light: SpotLight) -> Mat4:
    """World to clip coordinates whose first two, after the division, are tangents."""
    clip_from_light = np.diag([1.0, 1.0, 1.0, 0.0])
    clip_from_light[3, 2] = -1.0
    return clip_from_light @ shadow_fit.view_from_world(light)
