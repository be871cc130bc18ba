"""The light of a level that nobody lit."""

import math
from dataclasses import replace

import numpy as np
import pytest

from conftest import Draw
from followspot.assets.bsp import LUMPS, BspFile
from followspot.assets.shader_values import Sun
from followspot.assets.surface_flags import Surface
from followspot.passes.view import View
from followspot.scene import auto_path, bsp_tree, key_light
from followspot.scene.level import Level
from followspot.scene.light import SpotLight
from followspot.scene.load import load, with_chosen_light
from followspot.scene.scene import Scene
from followspot.scene.sight import crossings
from followspot.spaces import vec3
from synthetic import camera, rays

from test_level import build, squares  # isort: skip

HALF = 256.0
METRES = 0.03


def room() -> BspFile:
    """A hollow cube with solid all round; its ceiling is sky, its floor is drawn."""
    bsp = squares([(0, 0, -HALF), (0, 0, HALF)], [0, 1], [0, Surface.SKY])
    bsp.vertices["position"][:, :2] *= HALF / 8
    axes = np.repeat(np.eye(3, dtype=np.float32), 2, axis=0) * np.tile([1, -1], 3)[:, np.newaxis]
    planes = np.zeros(6, LUMPS["planes"])
    planes["normal"], planes["distance"] = axes, -HALF
    nodes = np.zeros(6, LUMPS["nodes"])
    nodes["plane"] = np.arange(6)
    nodes["children"] = [(k + 1 if k < 5 else -1, -2) for k in range(6)]
    leafs = np.zeros(2, LUMPS["leafs"])
    leafs["cluster"] = 0, -1
    models = bsp.models.copy()
    models["mins"], models["maxs"] = -HALF, HALF
    return replace(
        bsp,
        planes=planes,
        nodes=nodes,
        leafs=leafs,
        models=models,
        cluster_count=1,
        cluster_visible=np.ones((1, 1), np.uint8),
    )


@pytest.fixture
def hall() -> Level:
    return build(room())


def sun(direction: tuple[float, float, float]) -> Sun:
    towards = np.array(direction) / np.linalg.norm(direction)
    return Sun(vec3((1, 0.8, 0.4)), 100.0, vec3(towards), 1)


def test_sun_through_the_sky_is_the_key_light(hall: Level) -> None:
    overhead = sun((0.2, 0.1, 1))
    light = key_light.choose(hall, overhead, [camera((0, 0, 0), pitch=50)], METRES)
    assert light.name == "sun"
    np.testing.assert_allclose(light.direction, -overhead.direction_to_sun, atol=1e-12)
    np.testing.assert_allclose(light.power / light.power[0], (1, 0.8, 0.4))
    # Far, so that rays are nearly parallel, and wide enough to hold all that is drawn.
    corners = hall.mesh.vertices["position"] - light.position
    angles = corners @ light.direction / np.linalg.norm(corners, axis=1)
    assert (angles > light.cos_rim).all() and light.cos_rim > math.cos(math.radians(10))
    distance = float(np.linalg.norm(light.position)) * METRES
    assert light.intensity.max() / distance**2 == pytest.approx(key_light.IRRADIANCE, rel=0.2)


@pytest.mark.parametrize("direction", [(0, 0, -1), (1, 0, 0.05), (0, -1, -0.5)])
def test_sun_behind_walls_is_not(hall: Level, direction: tuple[float, float, float]) -> None:
    assert key_light.choose(hall, sun(direction), [camera((0, 0, 0))], METRES).name == "spot"


@pytest.mark.parametrize("pitch", [-80, 0, 45, 90])
def test_spot_light_stands_in_the_open_and_lights_what_the_camera_sees(
    hall: Level, pitch: float
) -> None:
    view = camera((-100, 50, -200), yaw=-20, pitch=pitch)
    light = key_light.choose(hall, None, [view], METRES)
    assert light.name == "spot" and (np.abs(light.position) < HALF).all()
    seen = view.position + view.forward * 40
    path = bsp_tree.trace(hall.bsp, light.position[np.newaxis], seen[np.newaxis])
    assert path[0] == 1
    ways = rays(view, (16, 12)).reshape(-1, 3) * 8 * HALF
    eyes = np.broadcast_to(view.position, ways.shape)
    share = bsp_tree.trace(hall.bsp, eyes, eyes + ways)
    walls = eyes + ways * share[:, np.newaxis]
    beams = walls - light.position
    in_cone = beams @ light.direction > light.cos_rim * np.linalg.norm(beams, axis=1)
    assert in_cone.mean() > 0.5, "and nothing else is in the room"
    assert np.isfinite(light.power).all() and (light.power > 0).all()


def test_camera_in_a_wall_gets_a_light_all_the_same(hall: Level) -> None:
    light = key_light.choose(hall, sun((0, 0, 1)), [camera((0, 0, 900))], METRES)
    assert isinstance(light, SpotLight)
    assert np.isfinite([*light.position, *light.direction, *light.power]).all()


def test_light_scales_with_the_unit(hall: Level) -> None:
    """The same irradiance whatever a unit's length."""
    one, two = (key_light.choose(hall, None, [camera((0, 0, 0))], m) for m in (METRES, 2 * METRES))
    np.testing.assert_allclose(two.power, 4 * one.power)
    np.testing.assert_array_equal(two.position, one.position)


def test_glow_under_a_black_sky() -> None:
    assert key_light.ambient(np.zeros((6, 3))) == key_light.FILL
    assert key_light.ambient(np.ones((6, 3))) == 0
    dim = np.full((6, 3), key_light.FILL / 4)
    assert key_light.ambient(dim) == pytest.approx(0.75 * key_light.FILL)


def test_glow_under_a_sky_that_is_black_below() -> None:
    towards = np.full((6, 3), 1.2)
    towards[5] = 0
    assert key_light.ambient(towards) == pytest.approx(key_light.BOUNCE)
    towards[5] = 0.4
    assert key_light.ambient(towards) == 0


@pytest.mark.gl
@pytest.mark.openarena
@pytest.mark.parametrize(
    ("name", "kind"), [("oa_dm1", "spot"), ("oa_dm3", "spot"), ("mlctf1beta", "sun")]
)
def test_chosen_lights_reach_what_the_camera_sees(draw: Draw, name: str, kind: str) -> None:
    scene = load(name)
    with scene.archive:
        assert scene.lights_chosen and [light.name for light in scene.lights] == [kind]
        lit = draw(scene, scene.camera(), View.DIRECT).max(axis=2) > 0
        assert lit.mean() > 0.1


@pytest.mark.openarena
def test_a_light_keeps_away_from_surfaces() -> None:
    """In the plane of a wall it would be cut off, or not, by rounding."""
    scene = load("oa_dm4")
    with scene.archive:
        scene = with_chosen_light(scene, [scene.camera("spawn1")])
        place = scene.lights[0].position
        for arm in 7.9 * np.eye(3):
            assert not crossings(scene, place - arm, place + arm)


@pytest.mark.gl
@pytest.mark.openarena
def test_a_light_for_a_whole_path_serves_most_of_it(draw: Draw) -> None:
    """One that is chosen for the start is out of sight soon."""
    scene = load("oa_dm1")
    with scene.archive:
        path = auto_path.find(scene, 10)
        cameras = [path.camera(t) for t in np.linspace(0, 10, 15)]

        def lit(scene: Scene) -> int:
            return sum(
                bool((draw(scene, each, View.SHADOW) > 0.5).mean() > 0.02) for each in cameras
            )

        assert lit(with_chosen_light(scene, cameras)) >= 8
        assert lit(with_chosen_light(scene, cameras[:1])) <= 3
