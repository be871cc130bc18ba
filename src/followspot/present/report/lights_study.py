"""A few dozen lamps in the level at hand: how many of them matter where, by how one asks."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats, Ints, Mask
from followspot.passes import drawlist
from followspot.passes.view import View
from followspot.passes.visible import VisibleFaces
from followspot.present.renderer import Renderer
from followspot.present.report import lamps, light_times
from followspot.present.report.clusters import SLICES, TILES, Clusters
from followspot.present.report.lamps import CUT_OFF, LEAST_CUT_OFF, REACH, Lamps
from followspot.present.report.visibility import CLEARANCE, Rays, fitted, ways
from followspot.scene.camera import Camera
from followspot.scene.light import casting
from followspot.scene.scene import Scene
from followspot.spaces import vec3

PLACES = 2000
"""Pixels, about, from which rays look for the lamps."""


@dataclass(frozen=True, eq=False)
class LightsStudy:
    """Everything that is told; lamps n, means over pixels or faces.

    Attributes:
        placed: The lamps.
        per_pixel: Lamps that a pixel is asked to add up, by how they are chosen.
        per_face: Likewise for faces that the camera sees.
        in_frame: Lamps that the frame has to know of.
        bounds: Median cubic metres of what bounds a lamp, by how.
        casters: Median triangles that a lamp's shadow map would have to draw, by how.
        cluster_sizes: (n + 1,) share of pixels whose cluster holds so many lamps, by spheres.
        fitted_sizes: Likewise by fitted boxes, too.
        clusters: Clusters that hold a pixel, and all of them.
        over_cut_off: Cut-offs and the mean number of lamps above each that arrive at a pixel.
        kept_of_frame: (n + 1,) share of all lamp light in the picture that the so many strongest
            lamps of the frame give.
        kept_of_pixel: (n + 1,) likewise, each pixel with its own strongest.
        tiles: (n,) texels along an edge of the map that gives each lit pixel a texel.
        light_ns: Nanoseconds that a light without a shadow takes a pixel, measured here: of all
            processors' time where they rasterise, else of time.
        frame_ms: The times behind that, by number of lights.
        map_ms: What drawing a map of the scene's own lights anew adds to that; none without one.
        window: Share of its cone's square that the key light's wide tile covers; none without one.
        pixels: Of the picture.
    """

    placed: Lamps
    per_pixel: dict[str, float]
    per_face: dict[str, float]
    in_frame: dict[str, int]
    bounds: dict[str, float]
    casters: dict[str, float]
    cluster_sizes: Floats
    fitted_sizes: Floats
    clusters: tuple[int, int]
    over_cut_off: tuple[Floats, Floats]
    kept_of_frame: Floats
    kept_of_pixel: Floats
    tiles: Ints
    light_ns: float
    frame_ms: dict[int, float]
    map_ms: float | None
    window: float | None
    pixels: int


def study(
    scene: Scene, camera: Camera, renderer: Renderer, on_progress: Callable[[float, str], None]
) -> LightsStudy | None:
    """Count; none where the level has no open place for a lamp, or the camera sees no surface."""
    placed = lamps.place_lamps(scene)
    places = placed.position
    on_progress(0.0, "drawing depth and normals")
    picture = _look(scene, camera, renderer)
    if not len(places) or not len(picture.pixel):
        return None
    on_progress(0.1, "tracing rays to the lamps")
    some = picture.chosen(slice(None, None, max(1, len(picture.pixel) // PLACES)))
    shown = lamps.shown_at(places, some.position, some.normal)
    arrives = shown * _see(Rays(scene), places, some, shown)
    needed = arrives >= CUT_OFF

    on_progress(0.6, "filling clusters")
    reached, ends = lamps.reached_faces(scene, places), lamps.traced_ends(scene, places)
    clusters = Clusters(camera, renderer.size, float(picture.depth.max()))
    of_pixel = clusters.of_pixels(picture.pixel, picture.depth)
    in_sphere = clusters.in_spheres(places, REACH)
    boxes = _boxes(scene, places, reached["facing it"], ends)
    in_box = in_sphere & clusters.in_boxes(*boxes["both boxes"])
    by_sphere, by_box = in_sphere.sum(axis=0)[of_pixel], in_box.sum(axis=0)[of_pixel]
    near = np.linalg.norm(some.position - places[:, np.newaxis], axis=2) < REACH
    leafs = scene.visibility.leafs_at(some.position + some.normal)
    by_leaf = np.array([scene.visibility.leafs_from(vec3(place))[leafs] for place in places])

    on_progress(0.7, "timing lights")
    frame_ms = light_times.by_count(scene, camera, renderer, places)
    slope = float(np.polyfit(list(frame_ms), list(frame_ms.values()), 1)[0])
    pixels, seen = renderer.size[0] * renderer.size[1], _visible(scene, camera, renderer.size)
    in_frustum = _in_frustum(scene, camera, renderer.size, places)
    useful = in_frustum & reached["facing it"][:, seen].any(axis=1)
    cut_offs = np.geomspace(LEAST_CUT_OFF, 0.1, 31)
    return LightsStudy(
        placed,
        per_pixel={
            "every lamp": float(len(places)),
            "within its reach": _mean_count(near),
            "and leafs see each other": _mean_count(near & by_leaf),
            "in cluster, by spheres": float(by_sphere.mean()),
            "in cluster, by boxes": float(by_box.mean()),
            "facing it, above the cut-off": _mean_count(shown >= CUT_OFF),
            "arrives": _mean_count(needed),
        },
        per_face={way: _mean_count(mask[:, seen]) for way, mask in reached.items()},
        in_frame={
            "in the level": len(places),
            "spheres that meet the frustum": int(in_frustum.sum()),
            "of these, facing a visible face in reach of their leafs": int(useful.sum()),
            "really arriving at a pixel": int(needed.any(axis=1).sum()),
        },
        bounds=_bounds(scene, places, boxes, ends),
        casters=_casters(scene, reached),
        cluster_sizes=_shares(by_sphere, len(places)),
        fitted_sizes=_shares(by_box, len(places)),
        clusters=(len(np.unique(of_pixel)), TILES[0] * TILES[1] * SLICES),
        over_cut_off=(cut_offs, np.array([_mean_count(arrives >= cut) for cut in cut_offs])),
        kept_of_frame=_kept(np.sort(arrives.sum(axis=1))[::-1]),
        kept_of_pixel=_kept(np.sort(arrives, axis=0)[::-1].sum(axis=1)),
        tiles=_tiles(needed.mean(axis=1) * len(picture.pixel)),
        light_ns=max(slope, 0.0) * 1e6 / pixels,
        frame_ms=frame_ms,
        map_ms=light_times.of_a_map(scene, camera, renderer),
        window=_window(scene, camera, renderer.size),
        pixels=pixels,
    )


@dataclass(frozen=True, eq=False)
class _Picture:
    """Surfaces in a picture: (n,) pixels, depths in units, (n, 3) world places and normals."""

    pixel: Ints
    depth: Floats
    position: Floats
    normal: Floats

    def chosen(self, which: slice) -> "_Picture":
        return _Picture(*(each[which] for each in vars(self).values()))


def _look(scene: Scene, camera: Camera, renderer: Renderer) -> _Picture:
    views = renderer.render(scene, camera, [View.DEPTH, View.NORMALS], linear=True)
    depth = views[View.DEPTH].ravel().astype(np.float64)
    normal = views[View.NORMALS].reshape(-1, 3).astype(np.float64) * 2 - 1
    pixel = np.flatnonzero(np.isfinite(depth))
    depth = depth[pixel]
    position = camera.position + ways(camera, renderer.size)[pixel] * depth[:, np.newaxis]
    return _Picture(pixel, depth, position, normal[pixel])


def _mean_count(mask: Mask) -> float:
    """Lamps a place, of (lamps, places); 0 where there is no place."""
    return float(mask.sum() / max(mask.shape[1], 1))


def _window(scene: Scene, camera: Camera, size: tuple[int, int]) -> float | None:
    """Share of the key light's cone, as a square, that its wide tile covers; none without one."""
    spots = casting(scene.lights)
    if not (spots and scene.settings.shadows):
        return None
    found = fitted(scene, camera, size, spots[0], scene.settings)
    edges = np.array([found.cone.window, found.wide.window]).reshape(2, 2, 2)  # axis; low, high
    areas = np.ptp(edges, axis=2).prod(axis=1)
    return float(areas[1] / areas[0])


def _see(rays: Rays, places: Floats, picture: _Picture, shown: Floats) -> Mask:
    """(lamps, places) whether nothing is between them; asked down to the least cut-off of all."""
    lamp, place = np.nonzero(shown >= LEAST_CUT_OFF)
    lift = 4 * CLEARANCE  # the depth is known in float32 only
    start = picture.position[place] + picture.normal[place] * lift
    sees = np.zeros(shown.shape, bool)
    sees[lamp, place] = ~rays.are_blocked(start, places[lamp])
    return sees


def _visible(scene: Scene, camera: Camera, size: tuple[int, int]) -> Mask:
    """(faces,) those that the renderer draws."""
    visible = VisibleFaces(scene)
    clip_from_world = _clip_from_world(scene, camera, size)
    visible.update(camera.position, clip_from_world, cull=True)
    drawn = np.zeros(len(scene.mesh.vertices), bool)
    drawn[visible.opaque.indices] = True
    faces = scene.mesh.faces
    return np.asarray(drawn[scene.mesh.indices[faces["first_index"]]])


def _clip_from_world(scene: Scene, camera: Camera, size: tuple[int, int]) -> Floats:
    far = camera.far_for(*scene.bounds)
    return camera.clip_from_view(size[0] / size[1], far) @ camera.view_from_world


def _in_frustum(scene: Scene, camera: Camera, size: tuple[int, int], places: Floats) -> Mask:
    """(lamps,) whose spheres meet the camera's frustum."""
    planes = drawlist.frustum_planes(_clip_from_world(scene, camera, size))
    planes = planes / np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    height = places @ planes[:, :3].T + planes[:, 3]
    return np.asarray((height > -REACH).all(axis=1))


def _boxes(
    scene: Scene, places: Floats, reached: Mask, ends: Floats
) -> dict[str, tuple[Floats, Floats]]:
    """Boxes of lamps, (lamps, 3) mins and maxs, by what they are fitted to; all hold the lamp."""
    faces, kept = scene.mesh.faces, reached[..., np.newaxis]
    mins = np.where(kept, faces["mins"], np.inf).min(axis=1, initial=np.inf)
    maxs = np.where(kept, faces["maxs"], -np.inf).max(axis=1, initial=-np.inf)
    mins, maxs = np.clip(mins, places - REACH, places), np.clip(maxs, places, places + REACH)
    low, high = np.minimum(ends.min(axis=1), places), np.maximum(ends.max(axis=1), places)
    return {
        "box of faces it may light": (mins, maxs),
        "box of where its rays end": (low, high),
        "both boxes": (np.maximum(mins, low), np.minimum(maxs, high)),
    }


def _bounds(
    scene: Scene, places: Floats, boxes: dict[str, tuple[Floats, Floats]], ends: Floats
) -> dict[str, float]:
    """Median cubic metres."""
    mins, maxs = (bound.astype(np.float64) for bound in scene.bounds)
    share = (np.linalg.norm(ends - places[:, np.newaxis], axis=2) / REACH) ** 3
    sphere = 4 / 3 * math.pi * REACH**3
    volumes = {
        "none: the level's box": (maxs - mins).prod(),
        "sphere of its reach": sphere,
        **{way: (high - low).prod(axis=1) for way, (low, high) in boxes.items()},
        "what its rays fill": sphere * share.mean(axis=1),
    }
    return {way: float(np.median(v)) * scene.metres_per_unit**3 for way, v in volumes.items()}


def _casters(scene: Scene, reached: dict[str, Mask]) -> dict[str, float]:
    """Median triangles a lamp; those that turn away from it cast as well as others."""
    faces = scene.mesh.faces
    casts = np.array([m.casts for m in scene.materials], bool)[faces["material"]]
    triangles = np.where(casts, faces["index_count"] // 3, 0)
    ways_ = [way for way in reached if way != "facing it"]
    return {way: float(np.median(reached[way] @ triangles)) for way in ways_}


def _shares(counts: Ints, most: int) -> Floats:
    return np.bincount(counts, minlength=most + 1) / len(counts)


def _kept(strongest_first: Floats) -> Floats:
    """(n + 1,) share of the sum that the first 0, 1, ... n values make."""
    sums = np.concatenate([[0.0], np.cumsum(strongest_first)])
    return np.asarray(sums / max(sums[-1], 1e-12))


def _tiles(lit_pixels: Floats) -> Ints:
    """(n,) powers of two whose squares hold so many pixels; 0 for none."""
    edge = 2.0 ** np.ceil(np.log2(np.sqrt(np.maximum(lit_pixels, 1))))
    return np.where(lit_pixels > 0, edge, 0).astype(np.int64)
