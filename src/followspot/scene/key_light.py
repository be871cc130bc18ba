"""A light for a level that nobody lit: its own sun, or a spot light in the open.

Levels come with light baked into lightmaps, and what baked it is gone but for traces. The sun
stays in the sky's shader script (``q3map_sun``); where it can reach the ground, it is used.
Elsewhere a spot light goes under the ceiling where most of what the camera sees is in reach.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from followspot import spaces
from followspot.arrays import Floats, Mask
from followspot.assets.bsp import BspFile
from followspot.assets.image import LUMINANCE
from followspot.assets.shader_values import Sun
from followspot.assets.surface_flags import Surface
from followspot.scene import bsp_tree
from followspot.scene.camera import Camera
from followspot.scene.level import Level
from followspot.scene.light import SpotLight
from followspot.scene.triangle_tree import TriangleTree
from followspot.spaces import Vec3

IRRADIANCE = 4.0
"""W/m^2 that a chosen light gives to a surface facing it: about four times what a sky of radiance
0.3 does (0.3 pi)."""

FILL = 0.15
"""Radiance in W/(m^2 sr) that a chosen light's surroundings have at least, on average: a level in
space has a black sky, and would show nothing beside the lit spots."""

BOUNCE = 0.3
"""Share of the average that comes from the darkest side at least, as if from light ground: skies of
clouds are black below, and ceilings would be, too."""

SUN_DISTANCE = 8.0
"""How far away the sun's spot light stands, in radii of the level: nearly parallel light."""

SUN_SHARE = 0.08
"""Share of what the camera sees that the sun must reach, for it to be the key light."""

SPOT_HALF_ANGLE = math.radians(55)
REACH = 4096.0
"""Units that a look around goes at most."""

_FAR_ENOUGH = 400.0  # units from which a spot light may light a wall, and no farther is better
_FINALISTS = 32
_CHECKED, _CLEAR = 8, 0.8  # finalists at most that triangles are asked about; a share that will do
_ROOM = 8.0  # units that a light keeps from surfaces


def choose(
    level: Level, sun: Sun | None, cameras: Sequence[Camera], metres_per_unit: float
) -> SpotLight:
    """The light of a level that came without any.

    Args:
        level: Its tree of planes tells what is open.
        sun: Of the level's sky, if it has one.
        cameras: What is to be lit: what one camera sees, or one on its way at several times.
        metres_per_unit: Length of a unit.
    """
    bsp, tree = level.bsp, _blockers(level)
    looks = [
        _look(bsp, tree, each.position, _ahead(each, 1024 // len(cameras))) for each in cameras
    ]
    seen = np.concatenate(looks)
    eyes = np.repeat([each.position for each in cameras], [len(look) for look in looks], axis=0)
    if sun is not None and _sun_share(bsp, sun.direction_to_sun, eyes, seen) >= SUN_SHARE:
        return _sun_light(level, sun, metres_per_unit)
    return _spot_light(bsp, tree, cameras[0], eyes, seen, metres_per_unit)


def _sun_light(level: Level, sun: Sun, metres_per_unit: float) -> SpotLight:
    """A far spot light whose cone holds the level's bounding sphere."""
    mins, maxs = (np.asarray(b, np.float64) for b in level.mesh.bounds)
    centre, radius = (mins + maxs) / 2, float(np.linalg.norm(maxs - mins)) / 2
    distance = SUN_DISTANCE * radius
    half_angle = math.asin(1 / SUN_DISTANCE)
    color = sun.color / sun.color.max() if sun.color.max() > 0 else np.ones(3)
    position = spaces.vec3(centre + sun.direction_to_sun * distance)
    direction = spaces.vec3(-sun.direction_to_sun)
    return _with_irradiance(
        SpotLight(position, direction, half_angle, spaces.vec3(color), name="sun"),
        distance * metres_per_unit,
    )


def _with_irradiance(light: SpotLight, metres: float) -> SpotLight:
    """The light scaled so that it gives IRRADIANCE at a distance on its axis."""
    wanted = IRRADIANCE * metres**2
    return replace(light, power=spaces.vec3(light.power * (wanted / light.intensity.max())))


def ambient(towards: Floats) -> float:
    """Radiance in W/(m^2 sr) to add from all around, where a sky leaves too much dark.

    Args:
        towards: (6, 3) the sky's radiance along the axes, likewise; see `CubeMap.towards_axes`.
    """
    seen = towards @ LUMINANCE
    mean, darkest = float(seen.mean()), float(seen.min())
    return max(0.0, FILL - mean, BOUNCE * mean - darkest)


def _sun_share(bsp: BspFile, to_sun: Vec3, eyes: Floats, seen: Floats) -> float:
    """Share of the places that eyes see which the sun reaches through the sky."""
    is_sky = (bsp.shaders["surface_flags"][bsp.faces["shader"]] & Surface.SKY) != 0
    sky = np.flatnonzero(is_sky & (bsp.faces["vertex_count"] > 0))
    if not len(sky):
        return 0.0
    places = seen + (eyes - seen) * 0.02  # off the wall that was hit
    reach = float(np.linalg.norm(bsp.models["maxs"][0] - bsp.models["mins"][0])) + 1
    ends = places + to_sun * reach
    fractions = bsp_tree.trace(bsp, places, ends)
    hits = places + (ends - places) * fractions[:, np.newaxis]
    first, count = bsp.faces["first_vertex"][sky], bsp.faces["vertex_count"][sky]
    runs = np.stack([first, first + count], axis=1)
    boxes = _run_boxes(bsp.vertices["position"], runs)
    margin = 8.0  # the tree may stop a line a little before the sky's face
    near = (hits[:, np.newaxis] >= boxes[0] - margin) & (hits[:, np.newaxis] <= boxes[1] + margin)
    return float(np.any(np.all(near, axis=2), axis=1).mean())


def _run_boxes(
    positions: NDArray[np.float32], runs: NDArray[np.int32]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Boxes of the runs [start, end) of positions, which may overlap or leave gaps."""
    last = len(positions)
    padded = np.concatenate([positions, positions[-1:]])
    edges = np.minimum(runs, last).ravel()
    mins = np.minimum.reduceat(padded, edges, axis=0)[::2]
    maxs = np.maximum.reduceat(padded, edges, axis=0)[::2]
    return mins, maxs


def _spot_light(
    bsp: BspFile,
    tree: TriangleTree,
    camera: Camera,
    eyes: Floats,
    seen: Floats,
    metres_per_unit: float,
) -> SpotLight:
    """A spot light under the ceiling, ahead of the camera, aimed at what is seen."""
    # Candidates: part of the way along lines of sight, lifted most of the way to the ceiling.
    ways = (seen - eyes)[::2]
    places = np.concatenate([eyes[::2] + ways * share for share in (0.2, 0.4, 0.6)])
    up = np.array([0.0, 0.0, 512.0])
    places = places + up * (bsp_tree.trace(bsp, places, places + up) * 0.8)[:, np.newaxis]
    # The best one by a rough look at all, then a close look at those that did well.
    rough = _worth(_distances_lit(bsp, places, seen[::16])).mean(axis=1)
    places = places[np.argsort(-rough, kind="stable")[:_FINALISTS]]
    sample = seen[::3]
    distances = _distances_lit(bsp, places, sample)
    aims = [_best_aim(sample - places[k], distances[k]) for k in range(len(places))]
    best = _clearest(tree, places, sample, aims)
    position, lit = places[best], aims[best].lit
    target = camera.position + camera.forward * 100
    if lit.any():
        target = sample[lit].mean(axis=0)
    away = target - position
    if np.linalg.norm(away) < 1e-3:
        away = np.array([0.0, 0.0, -1.0])
    far = np.linalg.norm(sample[lit] - position, axis=1) if lit.any() else np.zeros(1)
    metres = max(float(np.median(far)), 64.0) * metres_per_unit
    light = SpotLight(
        spaces.vec3(position),
        spaces.normalised(away),
        SPOT_HALF_ANGLE,
        spaces.vec3([1.0, 0.95, 0.85]),
        softness=0.3,
        name="spot",
    )
    return _with_irradiance(light, metres)


def _distances_lit(bsp: BspFile, places: Floats, targets: Floats) -> Floats:
    """(places, targets) units from one to the other, 0 where a wall is between them."""
    start = np.repeat(places, len(targets), axis=0)
    way = np.tile(targets, (len(places), 1)) - start
    clear = bsp_tree.trace(bsp, start, start + way * 0.98) >= 1.0  # off the target's own wall
    distances = np.where(clear, np.linalg.norm(way, axis=1), 0.0)
    return distances.reshape(len(places), len(targets))


class _Aim(NamedTuple):
    """What a spot light is worth that is turned to one of (n,) places, and which it lights."""

    worth: float
    lit: Mask


def _best_aim(ways: Floats, distances: Floats) -> _Aim:
    """The best of a light's aims.

    Args:
        ways: (n, 3) to the places from the light, in units.
        distances: (n,) units, 0 where a wall is between.
    """
    units = ways / np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-6)
    in_cone = (units @ units.T > math.cos(SPOT_HALF_ANGLE)) & (distances > 0)
    worth = in_cone @ _worth(distances) * (distances > 0)
    aim = int(worth.argmax())
    return _Aim(float(worth[aim]), in_cone[aim])


def _clearest(tree: TriangleTree, places: Floats, targets: Floats, aims: Sequence[_Aim]) -> int:
    """Which place for a light is best, seen with the triangles that are drawn."""
    by_worth = sorted(range(len(aims)), key=lambda k: -aims[k].worth)
    best, most = by_worth[0], -1.0
    arms = np.eye(3) * _ROOM
    for k in by_worth[:_CHECKED]:
        if (tree.first_hits(places[k] - arms, places[k] + arms) < 1).any():
            continue  # in or at a surface, which would cut its light off
        ends = targets[aims[k].lit][::2]
        start = np.broadcast_to(places[k], ends.shape)
        clear = tree.first_hits(start, start + (ends - start) * 0.97) == 1
        share = float(clear.mean()) if len(clear) else 0.0
        if aims[k].worth * share > most:
            best, most = k, aims[k].worth * share
        if share >= _CLEAR:
            break
    return best


def _blockers(level: Level) -> TriangleTree:
    """The triangles that light does not go through.

    The level's planes know nothing of doors and curved surfaces, nor of what is drawn in the open.
    """
    blocks = np.array([m.blend is None and m.alpha_test is None for m in level.materials], bool)
    faces = level.mesh.faces
    chosen = np.repeat(blocks[faces["material"]], faces["index_count"] // 3)
    return TriangleTree(level.mesh, chosen)


def _worth(distances: Floats) -> Floats:
    """How good it is for a light to reach places at some distances, 0 if it does not: not near."""
    return np.minimum(distances, _FAR_ENOUGH)


def _ahead(camera: Camera, count: int) -> Floats:
    """(n, 3) unit vectors spread over what a camera sees, of `count` all around."""
    directions = spaces.directions_around(count)
    return directions[directions @ camera.forward > math.cos(math.radians(50))]


def _look(bsp: BspFile, tree: TriangleTree, eye: Vec3, directions: Floats) -> Floats:
    """(n, 3) where lines of sight from an eye end."""
    start = np.broadcast_to(eye, directions.shape)
    end = start + directions * REACH
    end = start + (end - start) * bsp_tree.trace(bsp, start, end)[:, np.newaxis]
    return start + (end - start) * tree.first_hits(start, end)[:, np.newaxis]
