"""A light for a level that nobody lit: its own sun, or a spot light in the open.

Levels come with light baked into lightmaps, and what baked it is gone but for traces. The sun
stays in the sky's shader script (``q3map_sun``); where it can reach the ground, it is used.
Elsewhere a spot light goes under the ceiling where most of what the camera sees is in reach.
"""

import math

import numpy as np
from numpy.typing import NDArray

from followspot import spaces
from followspot.assets.bsp import BspFile
from followspot.assets.image import LUMINANCE
from followspot.assets.shader_values import Sun
from followspot.scene import bsp_tree
from followspot.scene.camera import Camera
from followspot.scene.level import Level
from followspot.scene.light import SpotLight
from followspot.scene.material import SURFACE_SKY
from followspot.spaces import Vec3

IRRADIANCE = 4.0
"""W/m^2 of a chosen light where it shines squarely: some times that of a sky of radiance 0.3."""

FILL = 0.15
"""Radiance in W/(m^2 sr) that a chosen light's surroundings have at least, on average: a level in
space has a black sky, and would show nothing beside the lit spots."""

SUN_DISTANCE = 8.0
"""How far away the sun's spot light stands, in radii of the level: nearly parallel light."""

SUN_SHARE = 0.08
"""Share of what the camera sees that the sun must reach, for it to be the key light."""

SPOT_HALF_ANGLE = math.radians(55)
REACH = 4096.0
"""Units that a look around goes at most."""

_FAR_ENOUGH = 400.0  # units from which a spot light may light a wall, and no farther is better
_FINALISTS = 32


def choose(level: Level, sun: Sun | None, camera: Camera, metres_per_unit: float) -> SpotLight:
    """The light of a level that came without any.

    Args:
        level: Its tree of planes tells what is open.
        sun: Of the level's sky, if it has one.
        camera: What the spot light is chosen for, where there is no sun.
        metres_per_unit: Length of a unit.
    """
    if sun is not None and _sun_share(level.bsp, sun.direction_to_sun, camera) >= SUN_SHARE:
        return _sun_light(level, sun, metres_per_unit)
    return _spot_light(level, camera, metres_per_unit)


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
    power = spaces.vec3(light.power * (wanted / light.intensity.max()))
    return SpotLight(
        light.position, light.direction, light.half_angle, power, light.softness, name=light.name
    )


def ambient(sky_mean: NDArray[np.float64]) -> float:
    """Radiance in W/(m^2 sr) to add from all around, where a sky of this mean (3,) is too dark."""
    return max(0.0, FILL - float(sky_mean @ LUMINANCE))


def _sun_share(bsp: BspFile, to_sun: Vec3, camera: Camera) -> float:
    """Share of the places that a camera sees which the sun reaches through the sky."""
    is_sky = (bsp.shaders["surface_flags"][bsp.faces["shader"]] & SURFACE_SKY) != 0
    sky = np.flatnonzero(is_sky & (bsp.faces["vertex_count"] > 0))
    if not len(sky):
        return 0.0
    seen = _look(bsp, camera.position, _ahead(camera))
    places = seen + (camera.position - seen) * 0.02  # off the wall that was hit
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


def _spot_light(level: Level, camera: Camera, metres_per_unit: float) -> SpotLight:
    """A spot light under the ceiling, ahead of the camera, aimed at what the camera sees."""
    bsp, eye = level.bsp, camera.position
    seen = _look(bsp, eye, _ahead(camera))
    # Candidates: part of the way along lines of sight, lifted most of the way to the ceiling.
    shares = np.repeat([0.2, 0.4, 0.6], len(seen[::2]))[:, np.newaxis]
    places = eye + (np.tile(seen[::2], (3, 1)) - eye) * shares
    up = np.array([0.0, 0.0, 512.0])
    places = places + up * (bsp_tree.trace(bsp, places, places + up) * 0.8)[:, np.newaxis]
    # The best one by a rough look at all, then a close look at those that did well.
    rough = _scores(_distances_lit(bsp, places, seen[::16]))
    places = places[np.argsort(-rough, kind="stable")[:_FINALISTS]]
    sample = seen[::3]
    distances = _distances_lit(bsp, places, sample)
    best = int(_scores(distances).argmax())
    position = places[best]
    lit = sample[distances[best] > 0]
    target = lit.mean(axis=0) if len(lit) else eye + camera.forward * 100
    away = target - position
    if np.linalg.norm(away) < 1e-3:
        away = np.array([0.0, 0.0, -1.0])
    metres = (
        max(float(np.median(np.linalg.norm(sample - position, axis=1))), 64.0) * metres_per_unit
    )
    light = SpotLight(
        spaces.vec3(position),
        spaces.normalised(away),
        SPOT_HALF_ANGLE,
        spaces.vec3([1.0, 0.95, 0.85]),
        softness=0.3,
        name="spot",
    )
    return _with_irradiance(light, metres)


def _distances_lit(
    bsp: BspFile, places: NDArray[np.float64], targets: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(places, targets) units from one to the other, 0 where a wall is between them."""
    start = np.repeat(places, len(targets), axis=0)
    way = np.tile(targets, (len(places), 1)) - start
    clear = bsp_tree.trace(bsp, start, start + way * 0.98) >= 1.0  # off the target's own wall
    distances = np.where(clear, np.linalg.norm(way, axis=1), 0.0)
    return distances.reshape(len(places), len(targets))


def _scores(distances: NDArray[np.float64]) -> NDArray[np.float64]:
    """(places,) how good each is for a light: it sees much, from not too near."""
    return np.asarray(np.minimum(distances, _FAR_ENOUGH).mean(axis=1))


def _ahead(camera: Camera) -> NDArray[np.float64]:
    """(n, 3) unit vectors spread over what a camera sees, and a little beside it."""
    directions = spaces.directions_around(1024)
    return directions[directions @ camera.forward > math.cos(math.radians(50))]


def _look(bsp: BspFile, eye: Vec3, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) where lines of sight from an eye end."""
    start = np.broadcast_to(eye, directions.shape)
    end = start + directions * REACH
    return start + (end - start) * bsp_tree.trace(bsp, start, end)[:, np.newaxis]
