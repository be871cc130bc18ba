"""Light as physics, in linear float32: furnace, falloff, cosine, power, units, sums."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from conftest import Draw
from followspot.assets.shader_values import BlendFactor, Sides
from followspot.passes.view import View
from followspot.scene.light import Light
from followspot.scene.material import Blend, Material, Shade
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.scene.sky import CubeMap
from synthetic import (
    BLACK_SKY,
    DIM,
    SIZE,
    WHITE_SKY,
    box,
    camera,
    cube_map,
    floor,
    image_archive,
    looking,
    make_scene,
    of,
    on_plane,
    point,
    quad,
    sphere,
    spot,
    srgb_decoded,
)

pytestmark = pytest.mark.gl

UP = (0, 0, 1)
METRES = 0.03
"""The default length of a unit, stated again so that a change of it is noticed."""

ROUNDING = 2e-5
"""Relative error of a few float32 operations on coordinates of a thousand units."""


def test_white_furnace(draw: Draw) -> None:
    """A white body under a uniform sky cannot be told from the sky, whichever way it faces."""
    scene = make_scene(
        [sphere((200, 60, 0), 60), *box((150, -120, -40), (230, -40, 50))],
        sky=WHITE_SKY,
        environment_constant=0.75,
    )
    view = camera((0, 0, 0))
    assert np.isfinite(draw(scene, view, View.DEPTH)).mean() > 0.2
    np.testing.assert_allclose(draw(scene, view, View.FINAL), 0.75, rtol=1e-6)


def test_uniform_sky_gives_uniform_irradiance_of_its_own_colour(draw: Draw) -> None:
    sky = cube_map((200, 120, 30))
    scene = make_scene([sphere((200, 0, 0), 150)], sky=sky, environment_constant=2.0)
    view = camera((0, 0, 0))
    hit = np.isfinite(draw(scene, view, View.DEPTH))
    shaded = draw(scene, view, View.ENVIRONMENT)[hit]
    expected = 2 * srgb_decoded(np.array([200, 120, 30]) / 255)
    np.testing.assert_allclose(shaded, np.broadcast_to(expected, shaded.shape), rtol=2e-6)


def test_point_light_inverse_square_and_cosine(draw: Draw) -> None:
    """E = Phi / (4 pi r^2) cos(theta) at every pixel of a floor, with r in metres."""
    light = point((30, -20, 120), (90, 60, 30))
    view = looking((-150, 40, 200), (40, 0, 0))
    p, depth = on_plane(view, UP)
    hit = (np.abs(p[..., :2]) < 1000).all(axis=-1) & np.isfinite(depth)
    shown = draw(make_scene([floor()], light), view, View.DIRECT, DIM)
    to_light = np.where(hit[..., np.newaxis], light.position - p, 1.0)
    r = np.linalg.norm(to_light, axis=-1)
    irradiance = light.power / (4 * np.pi * (r * METRES) ** 2)[..., np.newaxis]
    irradiance *= (to_light[..., 2] / r)[..., np.newaxis]
    assert r[hit].max() / r[hit].min() > 3
    np.testing.assert_allclose(shown[hit], irradiance[hit] / np.pi, rtol=ROUNDING)
    assert not shown[~hit].any()


@pytest.mark.parametrize("distance", [4.0, 33.0, 1000.0, 20000.0])
def test_irradiance_falls_with_the_square_of_the_distance(draw: Draw, distance: float) -> None:
    """Squarely lit, over four decades: E = Phi / (4 pi r^2) where the light stands above."""
    scene = make_scene([floor(distance)], point((0, 0, distance)))
    middle = draw(scene, looking((0, -distance, distance), (0, 0, 0), 1), View.DIRECT, DIM)
    expected = 100 / (4 * np.pi * (distance * METRES) ** 2) / np.pi
    assert middle.max() == pytest.approx(expected, rel=2e-5)


@pytest.mark.parametrize("degrees", [0, 30, 60, 80, 89, 91, 150, 180])
def test_cosine_law(draw: Draw, degrees: float) -> None:
    """A plane turned under a light, up to away from it."""
    tilt = math.radians(degrees)
    u, v = np.array([0, 50, 0]), 50 * np.array([-math.cos(tilt), 0, math.sin(tilt)])
    normal = np.cross(u, v) / 2500
    light = point((0, 0, 1e4), 1e6)
    view = looking(normal * 30, (0, 0, 0), 30)
    p, _ = on_plane(view, normal)
    to_light = light.position - p
    r = np.linalg.norm(to_light, axis=-1)
    expected = 1e6 / (4 * np.pi * (r * METRES) ** 2) * (to_light @ normal / r).clip(0) / np.pi
    shown = draw(make_scene([quad((0, 0, 0), u, v)], light), view, View.SHADING, DIM)
    np.testing.assert_allclose(shown[..., 0], expected, rtol=ROUNDING, atol=1e-6)


@pytest.mark.parametrize("metres_per_unit", [0.01, 0.0254, 0.03, 1.0])
def test_irradiance_scales_with_the_unit(draw: Draw, metres_per_unit: float) -> None:
    """Twice the length of a unit is a quarter of the irradiance."""
    scene = make_scene([floor()], point((0, 0, 100)), spot((0, 0, 100), (20, 0, 0), 30))
    view = camera((-50, 0, 80), pitch=60)
    normal = draw(scene, view, View.DIRECT, DIM)
    scaled = draw(replace(scene, metres_per_unit=metres_per_unit), view, View.DIRECT, DIM)
    np.testing.assert_allclose(scaled, normal * (METRES / metres_per_unit) ** 2, rtol=1e-5)


@pytest.mark.parametrize("softness", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("degrees", [3, 30, 60])
def test_spot_light_holds_its_power(draw: Draw, degrees: float, softness: float) -> None:
    """The flux through a wall across the cone: every pixel of it covers the same area."""
    fov = math.degrees(2 * math.atan(math.tan(math.radians(degrees)) * 1.05 * SIZE[0] / SIZE[1]))
    distance = 100.0
    light = spot((0, 0, 0), (1, 0, 0), degrees, (500, 300, 100), softness)
    wall = quad((distance, 0, 0), (0, -2e3, 0), (0, 0, 2e3))
    view = camera((0, 0, 0), fov=fov)
    pixel = 2 * distance * METRES * math.tan(math.radians(fov) / 2) / SIZE[0]
    settings = Settings(sky_light=False, shadows=False)
    flux = (draw(make_scene([wall], light), view, View.DIRECT, settings) * np.pi).sum(axis=(0, 1))
    np.testing.assert_allclose(flux * pixel**2, light.power, rtol=0.005)


@pytest.mark.parametrize("softness", [0.0, 0.5])
@pytest.mark.parametrize("make", ["spot 85", "spot 45 askew", "point"])
def test_light_in_a_room_gives_the_walls_all_its_power(
    draw: Draw, make: str, softness: float
) -> None:
    """The flux into the six walls of a cube round the light."""
    light: Light
    if make == "point":
        light = point((0, 0, 0), (500, 300, 100))
    else:
        degrees, target = (85, (1, 0, 0)) if make == "spot 85" else (45, (1, 0.8, -0.6))
        light = spot((0, 0, 0), target, degrees, (500, 300, 100), softness)
    scene = make_scene(box((-100, -100, -100), (100, 100, 100), inward=True), light)
    width, height = SIZE
    fov = math.degrees(2 * math.atan(width / height))  # the middle columns make a square of 90
    side = slice((width - height) // 2, (width + height) // 2)
    pixel = 200 * METRES / height
    settings = Settings(sky_light=False, shadows=False)
    views = [camera((0, 0, 0), yaw, 0, fov) for yaw in (0, 90, 180, 270)]
    views += [camera((0, 0, 0), 0, pitch, fov) for pitch in (90, -90)]
    flux = sum(draw(scene, view, View.DIRECT, settings)[:, side].sum(axis=(0, 1)) for view in views)
    np.testing.assert_allclose(flux * np.pi * pixel**2, light.power, rtol=0.005)


@pytest.mark.parametrize("softness", [0.0, 0.25, 1.0])
def test_spot_light_profile(draw: Draw, softness: float) -> None:
    """Even inside, nothing outside, and in the rim the smoothstep that its power is based on."""
    light = spot((10, 20, 100), (40, 0, 0), 35, 400, softness)
    view = camera((10, 20, 99), pitch=90, fov=120)
    p, _ = on_plane(view, UP)
    away = p - light.position
    r = np.linalg.norm(away, axis=-1)
    cosine = away @ light.direction / r
    rim, full = math.cos(math.radians(35)), math.cos(math.radians(35 * (1 - softness)))
    solid_angle = 2 * np.pi * (1 - (rim + full) / 2)
    irradiance = 400 / solid_angle / (r * METRES) ** 2 * (-away[..., 2] / r)
    t = np.clip((cosine - rim) / max(full - rim, 1e-6), 0, 1)
    settings = Settings(sky_light=False, shadows=False)
    shown = draw(make_scene([floor(2000)], light), view, View.DIRECT, settings)[..., 0] * np.pi
    sure = np.abs(cosine - rim) > 1e-5
    assert not shown[sure & (cosine < rim)].any()
    peak = irradiance.max()
    np.testing.assert_allclose(
        shown[sure], (irradiance * t * t * (3 - 2 * t))[sure], atol=peak * 1e-4
    )


def test_light_is_linear_in_power_and_lights_add_up(draw: Draw) -> None:
    red, blue = point((30, 0, 60), (100, 10, 1)), spot((-40, 10, 90), (0, 0, 0), 40, (1, 20, 200))
    scene, view = make_scene([floor(), sphere((0, 0, 20), 20)]), camera((-90, 0, 70), pitch=30)

    def direct(*lights: Light) -> NDArray[np.float64]:
        return draw(scene.with_lights(*lights), view, View.DIRECT, DIM)

    bare = replace(red, casts_shadow=False)
    np.testing.assert_allclose(
        direct(bare, blue), direct(bare) + direct(blue), rtol=1e-5, atol=1e-9
    )
    # Places in a wider atlas round differently, which shows where the filter mixes.
    both = direct(red, blue)
    atol = 1e-4 * both.max()
    np.testing.assert_allclose(both, direct(red) + direct(blue), rtol=1e-5, atol=atol)
    np.testing.assert_allclose(direct(blue, red), direct(red, blue), rtol=1e-5, atol=1e-9)
    thrice = replace(blue, power=blue.power * 3)
    np.testing.assert_allclose(direct(thrice), 3 * direct(blue), rtol=1e-5)
    assert not direct().any()


def colourful(folder: Path) -> Scene:
    """A textured room with a ball under two shadowed lights and a many-coloured sky."""
    random = np.random.default_rng(7)
    texture = random.integers(0, 256, (32, 32, 3), np.uint8)
    archive = image_archive(folder, {"wall.png": texture})
    pieces = [
        *of(Material("wall", "wall.png"), *box((-200, -200, 0), (200, 200, 150), inward=True)),
        sphere((60, 0, 50), 30),
    ]
    return make_scene(
        pieces,
        spot((0, 0, 140), (60, 10, 40), 50, (900, 700, 400), 0.4),
        spot((-100, 100, 120), (60, 0, 0), 40, (100, 200, 900)),
        point((0, -150, 100), 60),
        sky=cube_map(random.integers(0, 256, (6, 8, 8, 3), np.uint8)),
        archive=archive,
        environment_constant=0.8,
    )


def test_views_agree_with_one_another(draw: Draw, tmp_path: Path) -> None:
    """final = direct + environment = lambertian * shading; rho/pi E and the switches fit in."""
    scene, view = colourful(tmp_path), camera((-180, -30, 90), pitch=12, yaw=10)
    final, rho = draw(scene, view, View.FINAL), draw(scene, view, View.LAMBERTIAN)
    direct, environment = draw(scene, view, View.DIRECT), draw(scene, view, View.ENVIRONMENT)
    shading = draw(scene, view, View.SHADING)

    def close(a: NDArray[np.float64], b: NDArray[np.float64]) -> None:
        np.testing.assert_allclose(a, b, rtol=1e-5, atol=1e-7)

    assert final.min() >= 0 and final.std() > 0.05 and rho.std() > 0.1
    close(final, direct + environment)
    close(final, rho * shading)
    close(draw(scene, view, View.SHADING, sky_light=False) * rho, direct)
    close(draw(scene, view, View.FINAL, sky_light=False), direct)
    close(draw(scene.with_lights(), view, View.FINAL), environment)
    unshadowed = draw(scene, view, View.DIRECT, shadows=False)
    close(draw(scene, view, View.FINAL, shadows=False), unshadowed + environment)
    assert (direct <= unshadowed * (1 + 1e-4)).all() and (direct < unshadowed * 0.5).any()
    assert not draw(scene, view, View.ENVIRONMENT, sky_light=False).any()


def test_shadowless_lights_are_the_same_as_shadows_switched_off(draw: Draw, tmp_path: Path) -> None:
    scene, view = colourful(tmp_path), camera((-180, -30, 90), pitch=12, yaw=10)
    bare = [replace(light, casts_shadow=False) for light in scene.lights]
    np.testing.assert_allclose(
        draw(scene.with_lights(*bare), view, View.DIRECT),
        draw(scene, view, View.DIRECT, shadows=False),
        rtol=1e-6,
    )


@pytest.mark.parametrize("rho", [0.0, 0.18, 0.5, 1.0])
def test_constant_albedo(draw: Draw, tmp_path: Path, rho: float) -> None:
    """`albedo` takes the place of every texture: L = rho/pi E and rho times the sky's light."""
    scene, view = colourful(tmp_path), camera((-180, -30, 90), pitch=12, yaw=10)
    np.testing.assert_array_equal(draw(scene, view, View.LAMBERTIAN, albedo=rho), np.float32(rho))
    shading = draw(scene, view, View.SHADING)
    final = draw(scene, view, View.FINAL, albedo=rho)
    np.testing.assert_allclose(final, rho * shading, rtol=1e-5, atol=1e-7)


def test_environment_constant_scales_sky_and_light_alike(draw: Draw) -> None:
    sky = cube_map(np.random.default_rng(3).integers(0, 256, (6, 8, 8, 3), np.uint8))
    scene, view = make_scene([sphere((100, 0, 0), 40)], sky=sky), camera((0, 0, 0))
    single = draw(scene, view, View.FINAL)
    triple = draw(replace(scene, environment_constant=3.0), view, View.FINAL)
    np.testing.assert_allclose(triple, 3 * single, rtol=1e-5)


@pytest.mark.parametrize("size", [1, 8, 64])
def test_environment_light_is_the_six_direction_sum(draw: Draw, size: int) -> None:
    """Each pixel against the formula, for random normals under a random sky."""
    random = np.random.default_rng(size)
    sky = cube_map(random.integers(0, 256, (6, size, size, 3), np.uint8))
    ball = sphere((120, 0, 0), 100, rings=12)
    normals = random.normal(size=(len(ball.vertices), 3))
    ball.vertices["normal"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    scene, view = make_scene([ball], sky=sky), camera((0, 0, 0))
    hit = np.isfinite(draw(scene, view, View.DEPTH))
    n = draw(scene, view, View.NORMALS)[hit] * 2 - 1
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    six = srgb_decoded(sky.faces[..., :3] / 255).mean(axis=(1, 2))  # +X -X +Y -Y +Z -Z
    weights = np.stack([n, -n], axis=-1).clip(0).reshape(-1, 6)
    expected = weights @ six / weights.sum(axis=1, keepdims=True)
    shown = draw(scene, view, View.ENVIRONMENT)[hit]
    np.testing.assert_allclose(shown, expected, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize(("size", "level"), [(1, 0.0), (16, 4.0), (256, 8.0), (512, 9.0)])
def test_mip_level_of_the_environment_light(size: int, level: float) -> None:
    assert CubeMap("", np.zeros((6, size, size, 4), np.uint8)).top_level == level


def test_environment_light_from_behind_is_none(draw: Draw) -> None:
    """Only the half of the sky that a surface faces lights it."""
    pixels = np.zeros((6, 4, 4, 3), np.uint8)
    pixels[4] = 255  # +Z
    down = quad((0, 0, 50), (0, 100, 0), (100, 0, 0))
    scene = make_scene([floor(), down], sky=cube_map(pixels))
    above = draw(scene, camera((0, 0, 20), pitch=90), View.ENVIRONMENT)
    below = draw(scene, camera((0, 0, 20), pitch=-90), View.ENVIRONMENT)
    np.testing.assert_allclose(above, 1.0, rtol=1e-6)
    np.testing.assert_array_equal(below, 0.0)


def test_nothing_is_lit_under_a_black_sky_without_lights(draw: Draw) -> None:
    scene = make_scene([floor(), sphere((50, 0, 20), 20)], sky=BLACK_SKY)
    assert not draw(scene, camera((0, 0, 30)), View.FINAL).any()


def test_both_sides_of_a_two_sided_surface_are_lit_from_their_own_side(draw: Draw) -> None:
    sheet = of(Material("leaf", sides=Sides.BOTH), quad((0, 0, 0), (50, 0, 0), (0, 50, 0)))
    scene = make_scene(sheet, point((0, 0, 60)), metres_per_unit=METRES)
    lit = draw(scene, camera((0, 0, 40), pitch=90), View.DIRECT, DIM)
    unlit = draw(scene, camera((0, 0, -40), pitch=-90), View.DIRECT, DIM)
    assert (lit[30:90, 40:120] > 0).all()
    assert not unlit.any()


@pytest.mark.parametrize(
    ("blend", "shade", "share"),
    [
        ((BlendFactor.ONE, BlendFactor.ONE_MINUS_SRC_COLOR), Shade.EMISSIVE, lambda c: 1 - c),
        ((BlendFactor.ONE_MINUS_DST_COLOR, BlendFactor.ONE), Shade.EMISSIVE, lambda c: 1 - c),
        ((BlendFactor.ONE, BlendFactor.SRC_COLOR), Shade.LIT, lambda c: c),
        ((BlendFactor.ONE, BlendFactor.ONE), Shade.EMISSIVE, lambda c: 1 + 0 * c),
    ],
)
def test_how_much_a_flame_hides_has_nothing_to_do_with_how_bright_it_is(
    draw: Draw,
    tmp_path: Path,
    blend: Blend,
    shade: Shade,
    share: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> None:
    """What is behind shines through by the texel, however strong the light that is sent."""
    texel = np.full((4, 4, 3), (200, 90, 30), np.uint8)
    archive = image_archive(tmp_path, {"flame.png": texel})
    flame = of(
        Material("flame", "flame.png", blend=blend, shade=shade),
        quad((50, 0, 0), (0, -9, 0), (0, 0, 9)),
    )
    wall = quad((90, 0, 0), (0, -900, 0), (0, 0, 900))
    scene = make_scene([wall, *flame], sky=WHITE_SKY, environment_constant=3.0, archive=archive)
    colour = srgb_decoded(texel[0, 0] / 255)
    for emission in (0.0, 1.0, 1000.0):
        sent = colour * (emission if shade is Shade.EMISSIVE else 3.0)
        seen = draw(scene, camera((0, 0, 0)), View.FINAL, emission=emission)[60, 80]
        expected = sent + 3.0 * share(colour)
        texel_step = expected.max() / 512  # channels share an exponent
        np.testing.assert_allclose(seen, expected, rtol=1e-5, atol=texel_step)
