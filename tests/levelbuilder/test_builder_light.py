"""The bake against brute force and closed forms."""

import numpy as np
import pytest

from followspot.assets.bsp_reader import read_bsp
from followspot.levelbuilder import Level, Material, Surface, compile_level, room
from followspot.levelbuilder.lights import find_lights, lit, lit_volume
from followspot.levelbuilder.raycast import Occluders, passed_along, passed_to

SKY = Material("textures/test/sky", surface=Surface.SKY, script="q3map_sun 1 0.5 0.25 120 90 30")
NOTHING = Occluders(np.empty((0, 3, 3)), np.empty(0))


def brute_force(scene: Occluders, origins: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return the light that passes from origins to ends, each ray against each triangle."""
    passed = np.ones(len(origins))
    for i, (origin, end) in enumerate(zip(origins, ends, strict=True)):
        for triangle, opacity in zip(scene.corners, scene.opacity, strict=True):
            edges = np.column_stack([triangle[1] - triangle[0], triangle[2] - triangle[0]])
            system = np.column_stack([edges, origin - end])
            u, v, t = np.linalg.solve(system, origin - triangle[0])
            if u >= 0 and v >= 0 and u + v <= 1 and 0 < t < 1:
                passed[i] *= 1 - opacity
    return passed


@pytest.fixture
def scene() -> Occluders:
    rng = np.random.default_rng(5)
    centres = rng.uniform(-100, 100, (60, 1, 3))
    corners = centres + rng.uniform(-60, 60, (60, 3, 3))
    return Occluders(corners, np.where(np.arange(60) % 3, 1.0, 0.5))


def test_rays_towards_a_direction_agree_with_brute_force(scene: Occluders) -> None:
    points = np.random.default_rng(6).uniform(-150, 150, (80, 3))
    direction = np.array([0.48, -0.6, 0.64])
    expected = brute_force(scene, points, points + 1e4 * direction)
    assert 5 < (expected == 1).sum() < 75
    np.testing.assert_allclose(passed_along(scene, points, direction), expected)


def test_rays_towards_a_lamp_agree_with_brute_force(scene: Occluders) -> None:
    points = np.random.default_rng(7).uniform(-150, 150, (80, 3))
    lamp = np.array([3.0, -4.0, 5.0])
    expected = brute_force(scene, points, np.tile(lamp, (80, 1)))
    assert 5 < (expected == 1).sum() < 75
    np.testing.assert_allclose(passed_to(scene, points, lamp), expected)


@pytest.mark.parametrize(("lit_wall", "elevation"), [("+z", 40), ("-z", -40)])
def test_a_level_with_nothing_that_faces_its_sun_is_lit_by_the_rest(
    lit_wall: str, elevation: int
) -> None:
    script = f"q3map_sun 1 1 1 100 0 {elevation}"
    sky = Material("textures/test/sky", surface=Surface.SKY | Surface.NOLIGHTMAP, script=script)
    stone = Material("textures/test/stone", (64, 64), 1.0)
    level = Level(ambient=(20.0, 30.0, 40.0))
    level.add(room((-64, -64, 0), (64, 64, 64), sky, faces={lit_wall: stone}))
    level.spawn(0, 0, floor=0)
    bsp = read_bsp(compile_level(level), "x.bsp")
    (face,) = bsp.faces[bsp.faces["lightmap"] >= 0]
    (x, y), (width, height) = face["lightmap_corner"], face["lightmap_size"]
    page = bsp.lightmaps[face["lightmap"], y : y + height, x : x + width]
    assert (page == (20, 30, 40)).all()


def test_a_sun_lights_by_the_cosine_and_a_lamp_by_the_square_of_its_distance() -> None:
    level = Level()
    level.light((0, 0, 100), 200, color=(1, 0.5, 0))
    lights = find_lights(level.entities, [SKY], np.zeros(3))
    level_floor = np.array([[0.0, 0.0, 0.0]])
    up = np.array([[0.0, 0.0, 1.0]])
    sun = 120 * np.array([1, 0.5, 0.25]) * np.sin(np.radians(30))
    lamp = 7500 * 200 / 100**2 * np.array([1, 0.5, 0])
    np.testing.assert_allclose(lit(lights, NOTHING, level_floor, up)[0], sun + lamp)
    np.testing.assert_allclose(lights.directions[0], [0, np.cos(np.pi / 6), 0.5], atol=1e-12)


def test_the_suns_of_both_spellings_light() -> None:
    script = "q3map_sunExt 1 1 1 100 0 90 2 16\nq3map_SUN 1 1 1 50 0 90"
    sky = Material("sky", surface=Surface.SKY, script=script)
    lights = find_lights([], [sky], np.zeros(3))
    light = lit(lights, NOTHING, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    np.testing.assert_allclose(light, [[150, 150, 150]])
    assert lights.suns == 2


def test_a_level_surface_under_the_open_sky_gets_the_skys_value() -> None:
    sky = Material("sky", surface=Surface.SKY, script="q3map_skyLight 80 3")
    lights = find_lights([], [sky], np.zeros(3))
    light = lit(lights, NOTHING, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]))
    np.testing.assert_allclose(light[0], 80 * np.array([0.8, 0.95, 1.25]))


def test_light_in_free_air_points_to_the_lamp() -> None:
    level = Level()
    level.light((100, 0, 0), 300)
    lights = find_lights(level.entities, [], np.full(3, 7.0))
    ambient, directed, towards = lit_volume(lights, NOTHING, np.zeros((1, 3)))
    np.testing.assert_allclose(ambient, [[7, 7, 7]])
    np.testing.assert_allclose(directed, np.full((1, 3), 225.0))
    np.testing.assert_allclose(towards, [[1, 0, 0]])
