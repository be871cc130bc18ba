"""The same scene in Mitsuba 3: what a picture of it is without a rasteriser's shortcuts.

Mitsuba's sensor, ray tracer, lights and BSDF make the picture; only the rules of what is
seen are put in here, since they are the game's: the camera does not see the backs of one-sided
faces, blended surfaces and sprites throw no shadow, everything else stops light from both sides,
and leaves and grates do both only where their texture says so. Lengths are metres in Mitsuba, so
that the light's arithmetic is not shared with the shaders.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from followspot.arrays import Floats, Mask
from followspot.assets.shader_values import Sides
from followspot.present import mitsuba_scene
from followspot.present.cut_outs import CutOuts
from followspot.scene.camera import Camera
from followspot.scene.light import Light
from followspot.scene.scene import Scene

_CLEARANCE = 0.05
"""Units that a shadow ray starts above its surface: float32's error over a level is a tenth."""


@dataclass(frozen=True, eq=False)
class Truth:
    """What Mitsuba finds at the middles of a picture's pixels, top row first.

    Attributes:
        position: (h, w, 3) world, units; meaningless where nothing is hit.
        normal: (h, w, 3) unit world normal that shading uses, towards the viewer's side.
        face_normal: (h, w, 3) unit world normal of the triangle, towards the viewer's side.
        depth: (h, w) units along the view axis, infinite where nothing is hit.
        unshadowed: (h, w, 3) radiance in W/(m^2 sr) if nothing stood in the light's way.
        lit: (h, w) whether the light's centre can be seen.
        cut_out: (h, w) whether the surface or something on the way to the light is cut out: how
            much of it there is depends on how its texture is filtered.
    """

    position: Floats
    normal: Floats
    face_normal: Floats
    depth: Floats
    unshadowed: Floats
    lit: Mask
    cut_out: Mask

    @property
    def radiance(self) -> Floats:
        """(h, w, 3) W/(m^2 sr)."""
        return np.asarray(self.unshadowed * self.lit[..., np.newaxis])


@dataclass(frozen=True, eq=False)
class _Surface:
    """What rays hit first: (n,) or (n, 3), metres; distances are infinite where nothing is."""

    distance: Floats
    position: Floats
    normal: Floats
    face_normal: Floats
    radiance: Floats

    def where(self, chosen: Mask, other: "_Surface") -> "_Surface":
        """These where `chosen`, elsewhere the others."""
        mine, others = vars(self), vars(other)
        wide = {
            name: chosen if value.ndim == 1 else chosen[:, np.newaxis]
            for name, value in mine.items()
        }
        return _Surface(**{n: np.where(wide[n], mine[n], others[n]) for n in mine})


class RayTracer:
    """One scene's solid surfaces, and pictures of them under one light.

    Args:
        scene: Its mesh is what counts; textures are not looked at.
        albedo: Lambertian coefficient of every surface.

    Raises:
        UsageError: Mitsuba is not installed or cannot run.
    """

    def __init__(self, scene: Scene, albedo: float) -> None:
        self._mi = mitsuba_scene.load_mitsuba()
        self._mesh = scene.mesh
        self._metres = scene.metres_per_unit
        self._albedo = albedo
        material = scene.mesh.material_of_triangle
        materials = scene.materials
        casts = np.array([m.casts for m in materials], bool)
        cut_out = np.array([m.alpha_test is not None for m in materials], bool)
        drawn = [(m.sides is not Sides.BACK, m.sides is not Sides.FRONT) for m in materials]
        self._drawn = np.array(drawn, bool).reshape(-1, 2)[material]  # from the front, the back
        self._is_solid, self._is_cut_out = (casts & ~cut_out)[material], (casts & cut_out)[material]
        # Three corners a triangle, turned round: Mitsuba's fronts are counter-clockwise.
        self._triangles = scene.mesh.indices.reshape(-1, 3)[:, ::-1]
        self._solid = self._scene(self._is_solid)
        self._cut_out = self._scene(self._is_cut_out)
        self._cut_outs = CutOuts(scene)

    def _scene(self, chosen: Mask, **others: Any) -> Any:
        """A Mitsuba scene of the chosen triangles."""
        mi, vertices = self._mi, self._mesh.vertices
        properties = mi.Properties()
        properties["bsdf"] = self._bsdf()
        count = int(chosen.sum())
        shapes = {}
        if count:
            shape = mi.Mesh(
                "level", len(vertices), count, has_vertex_normals=True, props=properties
            )
            parameters = mi.traverse(shape)
            metres = vertices["position"].astype(np.float64) * self._metres
            parameters["vertex_positions"] = metres.astype(np.float32).ravel()
            parameters["vertex_normals"] = np.ascontiguousarray(vertices["normal"]).ravel()
            parameters["faces"] = np.ascontiguousarray(self._triangles[chosen]).ravel()
            parameters.update()
            shapes["level"] = shape
        return mi.load_dict({"type": "scene", **shapes, **others})

    def render(self, camera: Camera, size: tuple[int, int], light: Light) -> Truth:
        """A picture of (width, height) pixels, each seen through its middle."""
        seen, lamp = self._seen_by(camera), mitsuba_scene.emitter(self._mi, light, self._metres)
        rays = self._rays(camera, size)
        start, way = _array(rays.o), _array(rays.d)
        solid = self._shade(self._scene(self._is_solid & seen, light=lamp), start, way)
        chosen = self._is_cut_out & seen
        leaves = self._scene(chosen, light=lamp)
        before = self._reach_cut_out(leaves, chosen, start, way, solid.distance * (1 + 1e-5))
        is_leaf = np.isfinite(before)
        surface = solid
        if is_leaf.any():
            moved = start + way * np.where(is_leaf, before, 0)[:, np.newaxis]
            surface = self._shade(leaves, moved, way).where(is_leaf, solid)

        hit = np.isfinite(surface.distance)
        position = surface.position / self._metres
        lit, cut_out = self.reached(position, surface.face_normal, light)
        depth = np.where(hit, (position - camera.position) @ camera.forward, np.inf)
        shape = size[::-1]
        return Truth(
            position=position.reshape(*shape, 3),
            normal=surface.normal.reshape(*shape, 3),
            face_normal=surface.face_normal.reshape(*shape, 3),
            depth=depth.reshape(shape),
            unshadowed=surface.radiance.reshape(*shape, 3),
            lit=(lit & hit).reshape(shape),
            cut_out=(cut_out | is_leaf).reshape(shape),
        )

    def _shade(self, scene: Any, start: Floats, way: Floats) -> "_Surface":
        """What rays (n, 3), in metres, hit first, and how the scene's light would light it."""
        mi = self._mi
        rays = mi.Ray3f(mi.Point3f(start.T), mi.Vector3f(way.T))
        si = scene.ray_intersect_preliminary(rays, coherent=True).compute_surface_interaction(rays)
        hit = np.asarray(si.is_valid())
        face_normal, normal = _array(si.n), _array(si.sh_frame.n)
        # What is seen from its back is lit there as its front would be.
        side = -np.copysign(1.0, (face_normal * way).sum(axis=1, keepdims=True))
        at, weight = scene.emitters()[0].sample_direction(si, mi.Point2f(0.5), si.is_valid())
        to_light = si.to_local(at.d)
        to_light.z *= mi.Float(side[:, 0])
        si.wi = mi.Vector3f(0, 0, 1)  # Lambertian: alike from all sides
        radiance = _array(self._bsdf().eval(mi.BSDFContext(), si, to_light) * weight)
        distance = np.where(hit, np.asarray(si.t, np.float64), np.inf)
        return _Surface(
            distance=distance,
            position=start + way * np.where(hit, distance, 0)[:, np.newaxis],
            normal=normal * side,
            face_normal=face_normal * side,
            radiance=radiance * hit[:, np.newaxis],
        )

    def _reach_cut_out(
        self, scene: Any, chosen: Mask, start: Floats, way: Floats, reach: Floats
    ) -> Floats:
        """How far rays get until just before a cut-out surface that is there.

        Args:
            scene: In Mitsuba.
            chosen: (triangles,) those that it is made of.
            start: (n, 3) metres.
            way: (n, 3) unit.
            reach: (n,) metres, where the rays end anyway.

        Returns:
            (n,) metres, infinite where nothing is in the way.
        """
        numbers = np.flatnonzero(chosen)
        result = np.full(len(start), np.inf)
        going, passed = np.arange(len(start) if len(numbers) else 0), np.zeros(len(start))
        step = _CLEARANCE * self._metres / 5
        while len(going):
            origin = start[going] + way[going] * passed[going, np.newaxis]
            rays = self._rays_between(origin, way[going], reach[going] - passed[going])
            hit = scene.ray_intersect_preliminary(rays)
            found = np.asarray(hit.is_valid())
            going, distance = going[found], np.asarray(hit.t, np.float64)[found]
            u, v = np.asarray(hit.prim_uv)[:, found].astype(np.float64)
            triangles = numbers[np.asarray(hit.prim_index)[found]]
            # The corners were turned round on their way to Mitsuba.
            kept = self._cut_outs.are_there(triangles, np.stack([v, u, 1 - u - v], axis=1))
            result[going[kept]] = passed[going[kept]] + np.maximum(distance[kept] - step, 0)
            passed[going] += distance + step
            going = going[~kept]
        return result

    def reached(self, points: Floats, normals: Floats, light: Light) -> tuple[Mask, Mask]:
        """Which points see the light's centre, and which have something cut out on the way.

        Args:
            points: (n, 3) world, units.
            normals: (n, 3) unit, of the surfaces that the points lie on, either way round.
            light: A spot light's cone is not looked at.

        Returns:
            Two masks (n,). What is cut out counts where nothing solid is in the way.
        """
        if not len(points):  # which Mitsuba does not take
            return np.zeros(0, bool), np.zeros(0, bool)
        facing = np.copysign(1.0, ((light.position - points) * normals).sum(axis=1, keepdims=True))
        start = points + normals * facing * _CLEARANCE
        way = light.position - start
        distance = np.linalg.norm(way, axis=1)
        way /= np.maximum(distance, 1e-9)[:, np.newaxis]
        start, distance = start * self._metres, distance * self._metres
        rays = self._rays_between(start, way, distance)
        lit = ~np.asarray(self._solid.ray_test(rays))
        cut_out = lit & np.asarray(self._cut_out.ray_test(rays))
        lit[cut_out] = np.isinf(
            self._reach_cut_out(
                self._cut_out, self._is_cut_out, start[cut_out], way[cut_out], distance[cut_out]
            )
        )
        return lit, cut_out

    def _rays_between(self, start: Floats, way: Floats, reach: Floats) -> Any:
        mi = self._mi
        ends = mi.Float(reach.astype(np.float32))
        return mi.Ray3f(mi.Point3f(start.T), mi.Vector3f(way.T), ends, 0.0, mi.Color0f())

    def direct(self, camera: Camera, size: tuple[int, int], light: Light) -> Floats:
        """(h, w, 3) radiance by Mitsuba's own ``direct`` integrator, at the pixels' middles.

        It differs from `render` where the camera sees backs or what is cut out, since it knows
        no face that is there for one and not for the other.
        """
        mi = self._mi
        scene = self._scene(self._is_solid, light=mitsuba_scene.emitter(mi, light, self._metres))
        middle = {"type": "stratified", "sample_count": 1, "jitter": False}
        integrator = mi.load_dict({"type": "direct", "emitter_samples": 1, "bsdf_samples": 0})
        sensor = mitsuba_scene.sensor(mi, camera, size, middle, self._metres)
        picture = mi.render(scene, integrator=integrator, sensor=sensor)
        return np.asarray(picture, np.float64)

    def under_constant_sky(self, normals: Floats, radiance: float) -> Floats:
        """Radiance of surfaces that see nothing but Mitsuba's ``constant`` emitter.

        One direction a normal is enough, since drawn by the cosine all weigh alike. They are drawn
        here: what Mitsuba's BSDF draws with makes LLVM before version 17 end the process.

        Args:
            normals: (n, 3) unit, world.
            radiance: Of the emitter, W/(m^2 sr).

        Returns:
            (n, 3) W/(m^2 sr).
        """
        mi = self._mi
        cos, around = np.random.default_rng(0).random((2, len(normals)))
        cos, around = np.sqrt(cos), around * 2 * math.pi
        sin = np.sqrt(1 - cos * cos)
        si = mi.SurfaceInteraction3f()
        si.sh_frame = mi.Frame3f(mi.Normal3f(normals.T))
        si.wi = mi.Vector3f(0, 0, 1)
        way = mi.Vector3f(np.stack([sin * np.cos(around), sin * np.sin(around), cos]))
        weight = self._bsdf().eval(mi.BSDFContext(), si, way) / mi.Float(cos / math.pi)
        si.wi = -si.to_world(way)
        constant = {"type": "constant", "radiance": {"type": "rgb", "value": radiance}}
        return _array(weight * mi.load_dict(constant).eval(si))

    def _bsdf(self) -> Any:
        grey = {"type": "rgb", "value": self._albedo}
        return self._mi.load_dict({"type": "diffuse", "reflectance": grey})

    def _seen_by(self, camera: Camera) -> Mask:
        """(triangles,) those that turn a drawn side to the camera, which a pinhole sees whole."""
        corners = self._mesh.vertices["position"].astype(np.float64)[self._triangles]
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        height = (np.cross(b - a, c - a) * (camera.position - a)).sum(axis=1)
        return np.asarray(np.where(height > 0, self._drawn[:, 0], self._drawn[:, 1]))

    def _rays(self, camera: Camera, size: tuple[int, int]) -> Any:
        """Rays through the pixels' middles, row by row from the top."""
        mi = self._mi
        x, y = np.meshgrid(*((np.arange(n) + 0.5) / n for n in size))
        on_film = mi.Point2f(np.stack([x.ravel(), y.ravel()]))
        sensor = mitsuba_scene.sensor(mi, camera, size, {"type": "independent"}, self._metres)
        return sensor.sample_ray(0.0, 0.5, on_film, mi.Point2f(0.5))[0]


def _array(vectors: Any) -> Floats:
    """Mitsuba's vectors as (n, 3)."""
    return np.asarray(np.asarray(vectors, np.float64).reshape(3, -1).T)
