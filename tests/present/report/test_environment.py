"""The environment's light: skies whose irradiance is known, and the shader's own answer."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import cast

import html5lib
import msgspec
import numpy as np
import pytest

from followspot.arrays import Floats
from followspot.assets.archive import Archive
from followspot.assets.locate import search_path
from followspot.errors import UsageError
from followspot.passes.view import View
from followspot.present import sky_irradiance
from followspot.present.renderer import Renderer
from followspot.present.report import environment_answer
from followspot.present.report import environment_study as study
from followspot.present.report.environment_study import HARMONICS, LITERAL, SIX, TRUE_SIX
from followspot.present.report.material import Material
from followspot.scene.scene import Scene
from followspot.scene.search import BUILTIN
from followspot.scene.sky import CubeMap
from followspot.scene.sky_files import BUILTIN_SKY, read
from synthetic import BLACK_SKY, DIM, WHITE_SKY, camera, cube_map, make_scene, sphere

Draw = Callable[..., Floats]

DIRECTIONS = sky_irradiance.texel_directions(64)
NORMALS = study.sphere(500)


def grey(values: Floats) -> Floats:
    return np.repeat(values[..., np.newaxis], 3, axis=-1)


def random_sky(size: int) -> CubeMap:
    rng = np.random.default_rng(7)
    return cube_map(rng.integers(0, 256, (6, size, size, 3)))


@pytest.mark.parametrize("size", [1, 2, 64])
def test_solid_angles_fill_the_sphere(size: int) -> None:
    angles = sky_irradiance.texel_solid_angles(size)
    assert 6 * angles.sum() == pytest.approx(4 * math.pi, rel=1e-12)
    assert (angles > 0).all()


def test_solid_angles_are_those_of_small_squares() -> None:
    """A small square at distance r, inclined by c, covers its area times c / r^2: r^-3 here."""
    size = 256
    middle = (np.arange(size) + 0.5) * 2 / size - 1
    r = np.sqrt(1 + middle[:, np.newaxis] ** 2 + middle**2)
    np.testing.assert_allclose(
        sky_irradiance.texel_solid_angles(size), 4 / size**2 / r**3, rtol=1e-4
    )


def test_normals_are_spread_evenly() -> None:
    spread = study.sphere(4000)
    np.testing.assert_allclose(np.linalg.norm(spread, axis=1), 1)
    np.testing.assert_allclose(spread.mean(axis=0), 0, atol=1e-3)
    np.testing.assert_allclose(spread.T @ spread / len(spread), np.eye(3) / 3, atol=1e-3)


def test_grid_begins_above_at_minus_180_degrees() -> None:
    grid = study.grid(90).reshape(90, 180, 3)
    assert grid[0, :, 2].min() > 0.999 and grid[-1, :, 2].max() < -0.999
    assert grid[45, 0] == pytest.approx([-1, 0, 0], abs=0.03)
    assert grid[45, 90 + 45] == pytest.approx([0, 1, 0], abs=0.03)


def test_a_constant_sky_gives_pi_times_its_radiance() -> None:
    sky = np.full((6, 64, 64, 3), 2.5)
    towards = np.full((6, 3), 2.5)
    coefficients = study.project(sky)
    np.testing.assert_allclose(
        sky_irradiance.irradiance(NORMALS, [sky])[0], math.pi * 2.5, rtol=1e-4
    )
    np.testing.assert_allclose(study.six_directions(NORMALS, towards), math.pi * 2.5)
    np.testing.assert_allclose(study.harmonics(NORMALS, coefficients), math.pi * 2.5, rtol=1e-4)
    literal = study.six_directions(NORMALS, towards, normalised=False)[:, 0]
    np.testing.assert_allclose(literal, math.pi * 2.5 * np.abs(NORMALS).sum(axis=1))


def test_a_linear_sky_gives_two_thirds_of_its_gradient() -> None:
    gradient = np.array([0.5, -0.3, 0.6])
    sky = grey(1 + DIRECTIONS @ gradient)
    truth = math.pi * (1 + 2 / 3 * NORMALS @ gradient)
    np.testing.assert_allclose(sky_irradiance.irradiance(NORMALS, [sky])[0, :, 0], truth, rtol=5e-4)
    found = study.harmonics(NORMALS, study.project(sky))[:, 0]
    np.testing.assert_allclose(found, truth, rtol=5e-4)
    # As the text has it: the mean of a face is ln(2 + sqrt 3) - pi / 6 of its gradient.
    mean = study.CUBE_FACE_COSINE * NORMALS @ gradient / np.abs(NORMALS).sum(axis=1)
    found = study.six_directions(NORMALS, sky.mean(axis=(1, 2)))[:, 0]
    np.testing.assert_allclose(found, math.pi * (1 + mean), rtol=2e-4)


def test_a_clamped_cosine_sky_gives_the_kernel_of_two_cosines() -> None:
    """Integral of max(0, n.d) max(0, z.d): 2/3 (sin t + (pi - t) cos t), t between n and z."""
    sky = grey(np.maximum(DIRECTIONS[..., 2], 0))
    angle = np.arccos(np.clip(NORMALS[:, 2], -1, 1))
    truth = 2 / 3 * (np.sin(angle) + (math.pi - angle) * np.cos(angle))
    found = sky_irradiance.irradiance(NORMALS, [sky])[0, :, 0]
    np.testing.assert_allclose(found, truth, atol=1e-3)


def test_the_basis_is_orthonormal() -> None:
    weights = np.broadcast_to(sky_irradiance.texel_solid_angles(64), (6, 64, 64)).ravel()
    values = study.basis(DIRECTIONS).reshape(-1, 9)
    np.testing.assert_allclose(values.T @ (values * weights[:, np.newaxis]), np.eye(9), atol=1e-3)


def test_harmonics_are_exact_for_skies_of_order_two() -> None:
    coefficients = np.random.default_rng(1).normal(size=(9, 3))
    sky = study.basis(DIRECTIONS) @ coefficients
    np.testing.assert_allclose(study.project(sky), coefficients, atol=2e-3)
    whole = sky_irradiance.irradiance(NORMALS, [sky])[0]
    np.testing.assert_allclose(study.harmonics(NORMALS, coefficients), whole, atol=3e-3)


def test_order_three_of_a_sky_lights_nothing() -> None:
    z = DIRECTIONS[..., 2]
    sky = grey(z * (5 * z * z - 3) / 2)
    np.testing.assert_allclose(sky_irradiance.irradiance(NORMALS, [sky])[0], 0, atol=1e-3)
    assert np.abs(study.six_directions(NORMALS, sky.mean(axis=(1, 2)))).max() > 0.3


def test_many_skies_at_once_are_each_by_itself() -> None:
    skies = [np.random.default_rng(k).random((6, 8, 8, 3)) for k in range(3)]
    together = sky_irradiance.irradiance(NORMALS, skies)
    for sky, found in zip(skies, together, strict=True):
        np.testing.assert_allclose(sky_irradiance.irradiance(NORMALS, [sky])[0], found, rtol=1e-5)


def test_skies_are_averaged_in_linear_light() -> None:
    pixels = np.zeros((6, 8, 8, 3), np.uint8)
    pixels[:, ::2] = 255
    np.testing.assert_allclose(sky_irradiance.radiance(cube_map(pixels), 2), 0.5, rtol=1e-6)
    finer = sky_irradiance.radiance(cube_map(pixels), 16)[:, :, 0, 0]
    np.testing.assert_allclose(finer, np.tile([1, 1, 0, 0], (6, 4)), rtol=1e-6)


def test_the_lowest_level_is_the_mean_of_a_face_and_the_one_above_it_too() -> None:
    sky = random_sky(16)
    mean = sky_irradiance.radiance(sky, 1)[:, 0, 0]
    np.testing.assert_allclose(sky.towards_axes(4), mean, rtol=1e-5)
    np.testing.assert_allclose(sky.towards_axes(3), mean, rtol=1e-5)


def test_errors_of_a_sky_whose_errors_are_known() -> None:
    (found,) = study.study([WHITE_SKY], study.sphere(1000))
    assert found.largest(SIX) < 1e-3 and found.largest(HARMONICS) < 1e-3
    assert found.largest(TRUE_SIX) < 1e-3
    assert found.largest(LITERAL) == pytest.approx(math.sqrt(3) - 1, abs=1e-3)
    assert found.errors[LITERAL].min() == pytest.approx(0, abs=1e-3)
    assert len(found.by_level) == 3 and found.by_level.max() < 1e-3


def test_shares_of_the_mean_weigh_errors_by_the_light_there_is() -> None:
    found = study.SkyErrors(
        "s", np.array([1.0, 3.0]), {SIX: np.array([-0.5, 0.1])}, np.array([0.0])
    )
    assert found.largest(SIX) == 0.5 and found.mean(SIX) == pytest.approx(0.3)
    assert found.of_mean(SIX) == pytest.approx(0.25)
    assert found.mean_of_mean(SIX) == pytest.approx(0.2)


def test_every_sky_is_found_once_and_no_black_one() -> None:
    with Archive.open([BUILTIN / "courtyard.pk3"]) as archive:
        own = read(archive, BUILTIN_SKY)
        assert study.known_skies(own, archive) == [own]
        assert [sky.name for sky in study.known_skies(BLACK_SKY, archive)] == [BUILTIN_SKY]


@pytest.mark.gl
def test_six_directions_are_what_the_shader_does(draw: Draw) -> None:
    ball = sphere((100, 0, 0), 40, rings=48)
    sky = random_sky(16)
    scene = make_scene([ball], sky=sky)
    view = camera((0, 0, 0), fov=60)
    settings = msgspec.structs.replace(DIM, sky_light=True)
    normals = draw(scene, view, View.NORMALS, settings) * 2 - 1
    shown = draw(scene, view, View.ENVIRONMENT, settings, albedo=1.0)
    on_ball = np.linalg.norm(normals, axis=2) < 1.01
    expected = study.six_directions(normals[on_ball], sky.towards_axes()) / math.pi
    assert on_ball.sum() > 2000
    np.testing.assert_allclose(shown[on_ball], expected, rtol=1e-4)


@pytest.mark.gl
def test_texels_lie_where_the_sky_shows_them(draw: Draw) -> None:
    sky = random_sky(4)
    truth, where = sky_irradiance.radiance(sky, 4), sky_irradiance.texel_directions(4)
    for face, row, column in np.random.default_rng(3).integers(0, [6, 4, 4], (12, 3)):
        x, y, z = where[face, row, column]
        yaw, pitch = math.degrees(math.atan2(y, x)), -math.degrees(math.asin(z))
        view = camera((0, 0, 0), yaw, pitch, fov=0.5)
        shown = draw(make_scene([], sky=sky), view, View.FINAL).mean(axis=(0, 1))
        np.testing.assert_allclose(shown, truth[face, row, column], atol=2e-2)


def material(scene: Scene, folder: Path) -> Material:
    nothing_drawn = cast(Renderer, None)
    view = camera((0, 0, 0))
    return Material(
        "a scene", scene, view, (160, 90), (), nothing_drawn, folder, lambda share, what: None
    )


def test_the_section_is_html_with_formulae_and_the_numbers_that_are_known(tmp_path: Path) -> None:
    white = replace(WHITE_SKY, name="env/white <sky>", faces=np.full((6, 64, 64, 4), 255, np.uint8))
    section = environment_answer.section(material(make_scene([], sky=white), tmp_path))
    html5lib.HTMLParser(strict=True).parseFragment(section.html)
    assert section.figures["environment_six_largest"] < 1e-3
    assert section.figures["environment_literal_largest"] == pytest.approx(math.sqrt(3) - 1, 1e-3)
    assert section.html.count("<math") > 40 and section.html.count("<svg") >= 5
    assert "white &lt;sky&gt;" in section.html and "$" not in section.html
    assert "4\u202f110" in section.html


def test_the_section_says_so_where_every_sky_is_black(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no sky"):
        environment_answer.section(material(make_scene([]), tmp_path))


@pytest.mark.openarena
def test_harmonics_miss_less_than_six_directions_under_real_skies() -> None:
    with Archive.open(search_path()) as archive:
        skies = study.known_skies(BLACK_SKY, archive)
    assert len(skies) >= 10
    for found in study.study(skies, study.sphere(500), levels=False):
        assert found.mean_of_mean(HARMONICS) < found.mean_of_mean(SIX) / 3
        assert found.mean_of_mean(SIX) < 0.35
