"""followspot against Mitsuba 3 on the same scene: how much radiance differs, and where visibility.

Both look through the middles of the same pixels at the same triangles, so that a difference is
one of light or of shadow and not of sampling. A pixel is compared where both see the same
surface, which turns its shading normal to the light inside the cone. There

- *false light* is where the shadow map says lit (by half or more) and the light's centre cannot
  be seen; *false shadow* the other way round;
- a shadow's true *edge* is near where a place within EDGE_TEXELS texels of the map is lit unlike
  the pixel's own: a map of that size cannot know better. False light anywhere else is a leak,
  false shadow acne;
- radiance is compared where both say lit, no edge is near, and the light has not come through
  something cut out.
"""

import math
from dataclasses import dataclass, replace

import msgspec
import numpy as np
from msgspec import Struct

from followspot.arrays import Floats, Mask
from followspot.errors import UsageError
from followspot.passes.lighting import in_order
from followspot.passes.shadow_tiles import tile_size
from followspot.passes.view import View
from followspot.present.raytracer import RayTracer, Truth
from followspot.present.renderer import Renderer
from followspot.present.shadow_edges import EDGE_TEXELS, near_edge
from followspot.scene.camera import Camera
from followspot.scene.character import Crowd
from followspot.scene.light import PointLight, SpotLight
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings

SAME_SURFACE = 1e-3
"""Relative difference of depth up to which both have hit the same surface."""


class RadianceFigures(Struct, frozen=True):
    """Relative differences of radiance where both say lit and no shadow's edge is near."""

    pixels: int
    median: float
    p99: float
    worst: float

    @property
    def shares(self) -> tuple[float, ...]:
        """Median, 99th percentile and worst."""
        return self.median, self.p99, self.worst


class VisibilityFigures(Struct, frozen=True):
    """Shares of the compared pixels on which visibility disagrees, at one size of shadow map.

    Attributes:
        disagreement: `false_light` and `false_shadow` together.
        edges: Of both, what is near a true edge.
        cut_out: Of both, what leaves and grates are about, edges apart.
        leak: The rest of false light, on triangles turned to the light.
        terminator: Likewise on triangles turned away from it, whose smooth normals are not.
        acne: The rest of false shadow.
    """

    map_size: int
    pixels: int
    disagreement: float
    false_light: float
    false_shadow: float
    edges: float
    cut_out: float
    leak: float
    terminator: float
    acne: float

    @property
    def shares(self) -> tuple[float, ...]:
        """All of them, in the order of the fields."""
        return msgspec.structs.astuple(self)[2:]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Both pictures and what they have in common.

    Attributes:
        truth: Mitsuba's picture.
        radiance: (h, w, 3) followspot's, W/(m^2 sr).
        depth: (h, w) followspot's, units.
        share: (h, w) how much of the light followspot's shadow map lets through, 0 to 1.
        same_surface: (h, w) where both have hit something at the same depth.
        compared: (h, w) where that surface is turned to the light inside the cone.
        turned_away: (h, w) those of `compared` whose triangle looks away from the light, though its
            smooth normal does not.
        in_full_part: (h, w) those of `compared` where the cone's soft rim has not begun, in which
            Mitsuba's spot light fades by another curve.
        near_edge: (h, w) those of `compared` with a true shadow's edge near; not looked for where
            both say dark.
    """

    truth: Truth
    radiance: Floats
    share: Floats
    depth: Floats
    same_surface: Mask
    compared: Mask
    turned_away: Mask
    in_full_part: Mask
    near_edge: Mask

    @property
    def false_light(self) -> Mask:
        """(h, w) lit where no light comes."""
        return self.compared & ~self.truth.lit & (self.share >= 0.5)

    @property
    def false_shadow(self) -> Mask:
        """(h, w) dark where light comes."""
        return self.compared & self.truth.lit & (self.share < 0.5)

    @property
    def clear(self) -> Mask:
        """(h, w) where both say lit, in the cone's full part, and no edge is near.

        Not through leaves and grates: where their edges are depends on their texture's filter.
        """
        both_lit = self.truth.lit & (self.share >= 0.5)
        return self.in_full_part & both_lit & ~self.near_edge & ~self.truth.cut_out

    @property
    def relative_error(self) -> Floats:
        """(h, w) relative difference of the channels' sum where both say lit, else 0."""
        ours, true = self.radiance.sum(axis=2), self.truth.radiance.sum(axis=2)
        wanted = self.in_full_part & self.truth.lit & (self.share >= 0.5)
        difference = np.divide(ours - true, true, out=np.zeros_like(true), where=wanted)
        return np.asarray(np.abs(difference))


class Validation:
    """One scene, camera and light in both renderers; Mitsuba's part is made once.

    Args:
        renderer: Its size is that of the pictures.
        scene: Of its lights the first that casts a shadow is compared, spot lights before point
            lights; characters are left out.
        camera: Where both look from.
        albedo: Lambertian coefficient of every surface.

    Attributes:
        scene: With no other light than the one that is compared, and without characters.
        light: That one.
        tracer: The scene in Mitsuba.
        truth: Mitsuba's picture.
        albedo: As given.

    Raises:
        UsageError: Mitsuba cannot run, or no light casts a shadow.
    """

    def __init__(self, renderer: Renderer, scene: Scene, camera: Camera, albedo: float) -> None:
        light = next((light for light in in_order(scene.lights) if light.casts_shadow), None)
        if light is None:
            raise UsageError("validation compares a light with a shadow; there is none")
        self.light = light
        self.scene = replace(scene.with_lights(light), crowd=Crowd())  # rays do not meet them
        self.tracer = RayTracer(self.scene, albedo)
        self.truth = self.tracer.render(camera, renderer.size, light)
        self.albedo = albedo
        self._renderer, self._camera = renderer, camera

    def compare(self, settings: Settings) -> Comparison:
        """Draw with some settings, all but the albedo, and compare."""
        views = View.DIRECT, View.SHADOW, View.DEPTH
        settings = msgspec.structs.replace(settings, albedo=self.albedo, shadows=True)
        drawn = self._renderer.render(
            self.scene, self._camera, views, settings=settings, linear=True
        )
        radiance, share, depth = (drawn[view].astype(np.float64) for view in views)
        truth = self.truth
        hit = np.isfinite(depth) & np.isfinite(truth.depth)
        same_surface = hit & np.isclose(depth, truth.depth, rtol=SAME_SURFACE, atol=0)
        cos_rim, cos_full = -1.0, -1.0  # all around
        if isinstance(self.light, SpotLight):
            cos_rim, cos_full = self.light.cos_rim, self.light.cos_full
        compared = same_surface & self._within(cos_rim)
        return Comparison(
            truth,
            radiance,
            share,
            depth,
            same_surface,
            compared,
            turned_away=compared & (self._cos_light(truth.face_normal) <= 0),
            in_full_part=compared & self._within(cos_full),
            near_edge=self._near_edge(compared & (truth.lit | (share >= 0.5)), settings),
        )

    def _within(self, cos_angle: float) -> Mask:
        """(h, w) lit within an angle from the light's axis, were there no shadows.

        Mitsuba's word counts as well: float32 puts a cone's rim a little off. A point light has no
        axis, and no angle matters.
        """
        lit = np.asarray(self.truth.unshadowed.sum(axis=2) > 0)
        if isinstance(self.light, PointLight):
            return lit
        return np.asarray(lit & (-self._to_light() @ self.light.direction > cos_angle))

    def _cos_light(self, normals: Floats) -> Floats:
        """(h, w) cosines between normals (h, w, 3) and the way to the light."""
        return np.asarray((self._to_light() * normals).sum(axis=2))

    def _to_light(self) -> Floats:
        """(h, w, 3) unit directions."""
        way = self.light.position - self.truth.position
        return np.asarray(way / np.linalg.norm(way, axis=2, keepdims=True))

    def _near_edge(self, chosen: Mask, settings: Settings) -> Mask:
        """(h, w) those of `chosen` with a place nearby that is lit unlike them."""
        cones: tuple[SpotLight, ...]
        if isinstance(self.light, PointLight):
            cones, map_size = self.light.sides, tile_size(settings)
        else:
            cones, map_size = (self.light,), settings.shadow_map_size
        directions = np.stack([cone.direction for cone in cones])
        nearest = (-self._to_light() @ directions.T).argmax(axis=2)
        result = np.zeros_like(chosen)
        for number, cone in enumerate(cones):
            here = chosen & (nearest == number)
            points, normals = self.truth.position[here], self.truth.face_normal[here]
            texel = 2 * math.tan(cone.half_angle) / map_size  # at a distance of one
            along = (points - cone.position) @ cone.direction
            radii = tuple(share * EDGE_TEXELS * texel * along for share in (0.5, 1.0))
            lit = self.truth.lit[here]
            result[here] = near_edge(points, normals, lit, cone, radii, self._is_lit)
        return result

    def _is_lit(self, places: Floats, normals: Floats) -> Mask:
        """(n,) which places (n, 3) on surfaces of some normals see the light's centre."""
        return self.tracer.reached(places, normals, self.light)[0]


def radiance_figures(comparison: Comparison) -> RadianceFigures:
    """Statistics of the relative difference where shadows have no say."""
    error = comparison.relative_error[comparison.clear]
    if not len(error):
        return RadianceFigures(0, 0.0, 0.0, 0.0)
    median, p99, worst = np.percentile(error, [50, 99, 100]).tolist()
    return RadianceFigures(len(error), median, p99, worst)


def visibility_figures(comparison: Comparison, map_size: int) -> VisibilityFigures:
    """Shares of the compared pixels."""
    pixels = int(comparison.compared.sum())

    def share(mask: Mask) -> float:
        return int(mask.sum()) / max(pixels, 1)

    light, shadow = comparison.false_light, comparison.false_shadow
    cut_out = comparison.truth.cut_out & ~comparison.near_edge
    plain = ~comparison.truth.cut_out & ~comparison.near_edge
    return VisibilityFigures(
        map_size,
        pixels,
        share(light | shadow),
        share(light),
        share(shadow),
        edges=share((light | shadow) & comparison.near_edge),
        cut_out=share((light | shadow) & cut_out),
        leak=share(light & plain & ~comparison.turned_away),
        terminator=share(light & plain & comparison.turned_away),
        acne=share(shadow & plain),
    )
