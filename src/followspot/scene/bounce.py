"""Light between walls: how far the sky's gets, and what surfaces throw back of that and of lights.

Radiosity (Goral, Torrance, Greenberg, Battaile 1984) over surfels, gathered along rays: what lights
a surfel is the mean radiance along rays that are spread as the cosine (Malley's method; Pharr,
Jakob, Humphreys, PBR, 4th ed., A.5.3). What the rays meet is found once; then light goes along them
a few times. The result takes the place of what a level's compiler baked.

Irradiance is told by the radiance that something white shows under it: itself over pi.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from followspot.arrays import Floats, Ints
from followspot.assets.binary import run_members
from followspot.assets.image import LUMINANCE, Image, decode_all, to_linear
from followspot.assets.surface_flags import Surface
from followspot.errors import UsageError
from followspot.scene import luxels
from followspot.scene.baked import LightGrid, TracedLight
from followspot.scene.level import Level
from followspot.scene.light import Light, SpotLight
from followspot.scene.luxels import SurfelLight
from followspot.scene.open_space import OpenSpace
from followspot.scene.scene import Scene
from followspot.scene.surfels import SKY, Surfels, with_beyond

RAYS = 32
"""From each surfel, and from each point of the grid."""

BOUNCES = 4
"""Times that light is thrown back: where half of it is, a thirtieth is left."""

UNKNOWN = 0.5
"""Reflectance of what has no image."""

MAX_POINTS = 20_000
"""Of the grid, about."""

_ROOM = 2.0
"""Units around a point of the grid that have to be free: from inside of a wall all is seen."""

_GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))


def bake(scene: Scene) -> Scene:
    """Trace a level's light; the scene shows it in place of the sky's.

    It is that of the scene's lights, sky, ambient light and reflectances as they are now, to be
    traced anew where one of them changes. Lights themselves shine as before. Surfaces are taken for
    Lambertian, with the mean of their image. What is cut out or blended neither stops light nor
    throws it back, nor do characters, and what shines by itself lights nothing.

    Returns:
        The scene with `Level.traced`.

    Raises:
        UsageError: It is no level, or what its compiler baked is to be shown.
    """
    level, own = scene.level, scene.level.baked
    if own is None or level.mesh.baked is None:
        raise UsageError(f"--bake: expected a level, found {scene.name}")
    if scene.settings.baked_light:
        raise UsageError("--bake: expected no setting baked_light beside it")
    light = trace(scene)
    areas = light.surfels.areas
    typical = (light.light @ LUMINANCE * areas).sum() / max(areas.sum(), 1e-12)
    unit = max(float(typical), 1e-6)
    light = light.times(1 / unit)
    traced = TracedLight(luxels.image(level, own, light), light.grid, unit)
    mesh = replace(level.mesh, baked=luxels.at_vertices(level, own, light))
    return replace(scene, level=replace(level, mesh=mesh, traced=traced))


def trace(scene: Scene) -> SurfelLight:
    """What the sky and walls light a level's surfaces by, without the lights themselves.

    The light is radiance of white surfaces in W/(m^2 sr).
    """
    level = scene.level
    assert level.baked is not None
    surfels = _surfels(level)
    reflects = _reflectances(scene, surfels)
    environment = scene.sky.towards_axes() * scene.environment_constant + scene.ambient
    direct = np.zeros((len(surfels.places), 3))
    for each in scene.lights:
        direct += _arriving(each, surfels, scene.metres_per_unit)

    met, from_sky = _look(surfels, surfels.places, _hemispheres(surfels.normals), environment)
    gathered = from_sky
    for _ in range(BOUNCES):
        gathered = from_sky + _mean(met, reflects * (direct + gathered))
    first, cell, count = level.baked.grid_points(MAX_POINTS)
    steps = np.stack(np.unravel_index(np.arange(count.prod()), count, order="F"), axis=1)
    points = first + cell * steps
    met, open_ = _look(surfels, points, _spheres(len(points)), environment)
    around = open_ + _mean(met, reflects * (direct + gathered))
    around[~OpenSpace(level, _ROOM).is_free(points)] = 0.0
    grid = LightGrid(first, cell, count, around.astype(np.float32))
    return SurfelLight(surfels, _smooth(surfels, gathered), grid)


def _surfels(level: Level) -> Surfels:
    """Of what is solid; the backs of what is seen from both sides are surfaces, too."""
    mesh, bsp = level.mesh, level.bsp
    corners = mesh.vertices["position"].astype(np.float64)[mesh.indices.reshape(-1, 3)]
    of = mesh.material_of_triangle.astype(np.int64)
    solid = np.array([m.casts and m.alpha_test is None for m in level.materials], bool)[of]
    both = solid & np.array([m.is_two_sided for m in level.materials], bool)[of]
    flags = bsp.shaders["surface_flags"][bsp.faces["shader"]]
    sky = np.flatnonzero(((flags & Surface.SKY) != 0) & (bsp.faces["index_count"] > 0))
    runs = bsp.faces["first_index"][sky], bsp.faces["index_count"][sky]
    shift = np.repeat(bsp.faces["first_vertex"][sky], bsp.faces["index_count"][sky])
    vertices = bsp.indices[run_members(*runs)] + shift
    return Surfels.of(
        np.concatenate([corners[solid], corners[both][:, ::-1]]),
        np.concatenate([of[solid], of[both]]),
        bsp.vertices["position"][vertices].astype(np.float64).reshape(-1, 3, 3),
    )


def _reflectances(scene: Scene, surfels: Surfels) -> Floats:
    """(s, 3) means over each surfel's materials."""
    materials = scene.level.materials
    if scene.settings.albedo is not None:
        return np.full((len(surfels.places), 3), scene.settings.albedo)
    names = sorted({m.image for m in materials if m.image is not None})
    means = {}
    for number, image in decode_all(scene.archive, names):
        if isinstance(image, Image):
            means[names[number]] = to_linear(image.pixels[::2, ::2])[..., :3].mean(axis=(0, 1))
    unknown = np.full(3, UNKNOWN)
    of_material = np.array([means.get(m.image or "", unknown) for m in materials])
    return surfels.means(of_material)


def _arriving(light: Light, surfels: Surfels, metres_per_unit: float) -> Floats:
    """(s, 3) radiance of white surfels under a light, as in shaders/common/light.glsl."""
    way = light.position - surfels.places
    distance = np.maximum(np.linalg.norm(way, axis=1), 1e-6)
    cosine = np.einsum("ij,ij->i", way, surfels.normals) / distance
    share = np.maximum(cosine, 0) / (distance * metres_per_unit) ** 2 / math.pi
    if isinstance(light, SpotLight):
        width = max(light.cos_full - light.cos_rim, 1e-6)
        rim = np.clip((-(way @ light.direction) / distance - light.cos_rim) / width, 0, 1)
        share *= rim * rim * (3 - 2 * rim)
    lit = np.flatnonzero(share)
    if light.casts_shadow:
        share[lit[surfels.met(surfels.places[lit], way[lit], ends=True) >= 0]] = 0
    return np.asarray(share[:, np.newaxis] * light.intensity)


def _look(
    surfels: Surfels, places: Floats, ways: Iterable[Floats], environment: Floats
) -> tuple[Ints, Floats]:
    """(RAYS, n) what rays from places meet, and (n, 3) their mean radiance of the sky."""
    met, total = [], np.zeros((len(places), 3))
    for way in ways:
        met.append(surfels.met(places, way))
        squares = way**2 / (way**2).sum(axis=1, keepdims=True)
        for axis in range(3):  # the sky as six radiances, mixed by squared cosines
            seen = environment[2 * axis + (way[:, axis] < 0)]
            total += seen * (squares[:, axis] * (met[-1] == SKY))[:, np.newaxis]
    return np.stack(met), total / RAYS


def _mean(met: Ints, radiances: Floats) -> Floats:
    """(n, 3) mean radiance of the surfels that are met, (RAYS, n)."""
    radiances = with_beyond(radiances)
    total = np.zeros((met.shape[1], 3))
    for hit in met:
        total += radiances[hit]
    return total / len(met)


def _smooth(surfels: Surfels, light: Floats) -> Floats:
    """(s, 3) means over each surfel and its neighbours: so few rays scatter."""
    total, count = light.copy(), np.ones(len(light))
    light = with_beyond(light)
    for neighbour in surfels.beside():
        total += light[neighbour]
        count += neighbour >= 0
    return np.asarray(total / count[:, np.newaxis])


def _hemispheres(normals: Floats) -> Iterator[Floats]:
    """RAYS times (n, 3) unit directions, as a white surface weights them, turned at random."""
    helper = np.where(np.abs(normals[:, 2:]) > 0.9, [[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]])
    right = np.cross(helper, normals)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    up = np.cross(normals, right)
    turned, moved = np.random.default_rng(1).uniform(0, 1, (2, len(normals), 1))
    for ray in range(RAYS):
        angle, out = 2 * math.pi * turned + ray * _GOLDEN_ANGLE, (ray + moved) / RAYS
        across = right * np.cos(angle) + up * np.sin(angle)
        yield across * np.sqrt(out) + normals * np.sqrt(1 - out)


def _spheres(count: int) -> Iterator[Floats]:
    """RAYS times (count, 3) unit directions, spread evenly, turned at random about Z."""
    turned = np.random.default_rng(2).uniform(0, 2 * math.pi, count)
    for ray in range(RAYS):
        angle, height = turned + ray * _GOLDEN_ANGLE, (2 * ray + 1) / RAYS - 1
        out = math.sqrt(1 - height * height)
        z = np.full(count, height)
        yield np.stack([out * np.cos(angle), out * np.sin(angle), z], axis=1)
