"""Why the shadow matrix may be applied per vertex, and the division may not."""

import math
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from followspot import spaces
from followspot.arrays import Floats, Ints, Mask
from followspot.errors import UsageError
from followspot.passes import shadow_fit
from followspot.passes.shadow_fit import Boxes
from followspot.present.report.interpolation_study import (
    Map,
    Seen,
    Ways,
    compare,
    edge_error,
    lit,
    rasterise,
)
from followspot.present.report.material import Material
from followspot.present.report.plot import Line, heat_map, lines
from followspot.present.report.plot_frame import Mark
from followspot.present.report.prose import prose
from followspot.present.report.section import Section
from followspot.present.report.ticks import Axis, count, number
from followspot.scene.light import SpotLight, casting
from followspot.scene.scene import Scene

WIDTH = 320
"""Pixels along the picture's width that the experiment looks at."""

_BESIDE = 40.0  # units that a light stands beside the camera, if no other one reaches what is seen
_POINTS = 160  # of a plotted distribution


@dataclass(frozen=True, eq=False)
class Experiment:
    """What was compared, on the pixels that see a surface inside a light's map.

    Attributes:
        light: Whose map it is.
        map: That one.
        size: (width, height) of the picture in pixels.
        pixel: (n,) numbers of the pixels.
        triangle: (n,) what they see.
        corners: (n, 3, 3) of that, world.
        ways: Coordinates in the map, by every way.
        in_front: (n,) whether all corners are in front of the camera.
    """

    light: SpotLight
    map: Map
    size: tuple[int, int]
    pixel: Ints
    triangle: Ints
    corners: Floats
    ways: Ways
    in_front: Mask


@dataclass(frozen=True)
class Difference:
    """How far two ways are apart: in texels of the map, and along the light's axis in units."""

    pixels: int
    median: float
    p99: float
    largest: float
    depth: float


def section(material: Material) -> Section:
    """The proof, and the experiment on what the report's camera sees.

    Raises:
        UsageError: the camera sees no surface.
    """
    material.on_progress(0.0, "finding triangles")
    done = run(material.scene, material)
    material.on_progress(0.7, "comparing")
    ways, all_ = done.ways, np.ones(len(done.pixel), bool)
    pairs = {
        "float32": (ways.by_vertex, ways.by_pixel, all_),
        "vertex": (ways.by_vertex, ways.exact, all_),
        "pixel": (ways.by_pixel, ways.exact, all_),
        "early": (ways.divided_early, ways.exact, all_),
        "screen": (ways.screen_linear, ways.exact, done.in_front),
        "offset": (ways.offset_by_vertex, ways.offset_by_pixel, all_),
    }
    found = {name: difference(a[m], b[m]) for name, (a, b, m) in pairs.items()}
    homogeneous = np.concatenate([done.corners, np.ones((len(done.pixel), 3, 1))], axis=2)
    distance = (homogeneous @ done.map.shadow_from_world.T)[..., 3]
    seen_triangles = np.unique(done.triangle)
    full = material.size[0] * material.size[1] / (done.size[0] * done.size[1])
    html = prose(
        "interpolation.html",
        scene=material.name,
        light=done.light.name or "key light",
        map_size=done.map.size,
        pixels=len(done.pixel),
        triangles=len(seen_triangles),
        per_vertex=round(len(done.pixel) * full / (3 * len(seen_triangles)), 1),
        behind=int((distance <= 0).any(axis=1).sum()),
        spread=_spread(distance),
        offset=done.map.offset,
        found=found,
        steps=found["float32"].largest / (done.map.size * 2.0**-24),
        third=edge_error(1.0, 4.0),
        number=number,
        count=count,
        distribution=Markup(_distribution(done)),
        picture=Markup(_picture(done)),
        curved=bool(found["offset"].largest > 1e-6),
    )
    figures = {
        f"interpolation_{name}_{what}": getattr(each, what)
        for name, each in found.items()
        for what in ("median", "largest", "depth")
    }
    title = "The shadow matrix: before or after interpolation?"
    return Section("interpolation", title, html, figures)


def _spread(distance: Floats) -> float:
    """Median of farthest over nearest corner (n, 3), of what is wholly in front of the light."""
    near, far = distance.min(axis=1), distance.max(axis=1)
    return float(np.median(far[near > 0] / near[near > 0])) if (near > 0).any() else math.nan


def run(scene: Scene, material: Material) -> Experiment:
    """Every way of getting shadow coordinates, for all pixels that see a lit surface."""
    size = WIDTH, max(round(WIDTH * material.size[1] / material.size[0]), 1)
    camera, mesh = material.camera, scene.mesh
    of_material = mesh.material_of_triangle
    solid = np.array([m.blend is None for m in scene.materials], bool)[of_material]
    triangles = mesh.indices.reshape(-1, 3)[solid]
    corners, normals = (
        mesh.vertices[name].astype(np.float64)[triangles] for name in ("position", "normal")
    )
    projection = camera.clip_from_view(size[0] / size[1], camera.far_for(*scene.bounds))
    seen = rasterise(corners, projection @ camera.view_from_world, size)
    hit: Ints = np.flatnonzero(seen.triangle >= 0)
    if not len(hit):
        raise UsageError("the camera sees no surface whose shadow coordinates could be compared")
    light, map_, pixel = _light(scene, material, corners, seen, hit)
    of = seen.triangle[pixel]
    ways = compare(corners[of], normals[of], seen.weights[pixel], seen.w[pixel], map_)
    in_front: Mask = np.all(seen.w[pixel] > 0, axis=1)
    return Experiment(light, map_, size, pixel, of, corners[of], ways, in_front)


def _light(
    scene: Scene, material: Material, corners: Floats, seen: Seen, hit: Ints
) -> tuple[SpotLight, Map, Ints]:
    """The light whose map holds most of what is seen, and those pixels.

    A light beside the camera stands in where no light with a shadow map reaches anything.
    """
    camera = material.camera
    aside = np.cross(camera.forward, [0.0, 0.0, 1.0]) * _BESIDE
    stand_in = SpotLight(
        camera.position + aside, camera.forward, 1.2, spaces.vec3([1, 1, 1]), name="stand-in"
    )

    def reached(light: SpotLight) -> tuple[SpotLight, Map, Ints]:
        map_ = _map(scene, light)
        return light, map_, hit[lit(corners[seen.triangle[hit]], seen.weights[hit], map_)]

    found = max(
        (reached(light) for light in casting(scene.lights)), key=lambda x: len(x[2]), default=None
    )
    return found if found is not None and len(found[2]) else reached(stand_in)


def _map(scene: Scene, light: SpotLight) -> Map:
    """A single map of a light's whole cone, as large as the scene's settings have it."""
    faces, settings = scene.mesh.faces, scene.settings
    everything = shadow_fit.outlines(light, Boxes(faces["mins"], faces["maxs"]))
    frustum = shadow_fit.fit(light, everything, None, settings.shadow_map_size)
    return Map(
        spaces.SHADOW_FROM_CLIP @ frustum.clip_from_world,
        shadow_fit.view_from_world(light),
        settings.shadow_map_size,
        frustum.near,
        frustum.far,
        settings.shadow_normal_offset,
    )


def texels_apart(a: Floats, b: Floats) -> Floats:
    """(n,) distances in the map between coordinates (n, 3); infinite where one has no place."""
    apart = np.linalg.norm((a - b)[:, :2], axis=1)
    return np.where(np.isfinite(apart), apart, np.inf)


def difference(a: Floats, b: Floats) -> Difference:
    """Statistics of how far coordinates (n, 3) are apart."""
    if not len(a):
        return Difference(0, 0.0, 0.0, 0.0, 0.0)
    apart, depth = texels_apart(a, b), np.abs(a[:, 2] - b[:, 2])
    median, p99 = np.percentile(apart, [50, 99], method="lower").tolist()
    largest_depth = float(np.where(np.isfinite(depth), depth, np.inf).max())
    return Difference(len(a), median, p99, float(apart.max()), largest_depth)


def _distribution(done: Experiment) -> str:
    """How large a share of the pixels is off by more than so many texels."""
    ways, front = done.ways, done.in_front
    curves = {
        "matrix per vertex against per pixel, float32": (ways.by_vertex, ways.by_pixel),
        "divided too early": (ways.divided_early, ways.exact),
        "interpolated linearly on the screen": (
            ways.screen_linear[front],
            ways.exact[front],
        ),
    }
    series = []
    for label, (a, b) in curves.items():
        apart = np.sort(texels_apart(a, b))
        rank = np.linspace(0, max(len(apart) - 1, 0), _POINTS).astype(int)
        share = 100 * (1 - rank / max(len(apart), 1))
        series.append(Line(label, apart[rank] if len(apart) else share * np.nan, share))
    return lines(
        "Pixels whose shadow coordinates are off by more than so many texels",
        series,
        Axis("texels of the shadow map", log=True, limits=_reach(series)),
        Axis("share of the pixels that are off by more, %", limits=(0, 100)),
        marks=[Mark(0.5, "half a texel", across=False)],
        description="One falling curve for each way. The difference between per vertex and per "
        "pixel ends far below a texel; the two wrong ways reach far above it.",
    )


def _reach(series: list[Line]) -> tuple[float, float]:
    """Limits for the texels' axis that hold all but the smallest and most absurd differences."""
    known = np.concatenate([np.asarray(s.x) for s in series])
    largest = known[np.isfinite(known)].max(initial=1.0)
    return 1e-6, float(min(10 ** np.ceil(np.log10(largest)), 1e5))


def _picture(done: Experiment) -> str:
    """Where in the picture dividing too early puts the shadow elsewhere."""
    width, height = done.size
    values = np.full(width * height, np.nan)
    apart = texels_apart(done.ways.divided_early, done.ways.exact)
    values[done.pixel] = np.log10(np.clip(apart, 1e-3, 1e3))
    return heat_map(
        "Texels by which dividing too early misses, over the picture",
        values.reshape(height, width),
        Axis("pixels", limits=(0, width)),
        Axis("pixels", limits=(0, height)),
        Axis("powers of ten of texels: 0 is one texel, 2 is a hundred", limits=(-3, 3)),
        description="The report's view. Large triangles that run away from the light are wrong "
        "by many texels in their middle; edges and small triangles are hardly wrong.",
    )
