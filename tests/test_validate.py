"""The comparison with Mitsuba: that it compares rightly, and what it says of the renderer."""

import json
import math
import os
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from followspot.assets.shader_values import AlphaTest, Sides
from followspot.errors import UsageError
from followspot.passes.view import View
from followspot.present.comparison import (
    RadianceFigures,
    Validation,
    radiance_figures,
    visibility_figures,
)
from followspot.present.mitsuba_scene import load_mitsuba
from followspot.present.raytracer import RayTracer
from followspot.present.renderer import Renderer
from followspot.present.sky_irradiance import irradiance, radiance
from followspot.present.validate import EnvironmentFigures, measure
from followspot.scene.character import Crowd
from followspot.scene.light import Light
from followspot.scene.load import load, load_figure
from followspot.scene.material import Material
from followspot.scene.scene import Scene
from followspot.scene.settings import CullFace, Settings
from synthetic import (
    SIZE,
    WHITE_SKY,
    Piece,
    box,
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
)

VIEW = looking((-180, -120, 110), (30, 20, 30))
LIGHT = spot((-60, 130, 190), (30, 10, 20), 35, (500, 400, 300))
METRES = 0.03


def room() -> list[Piece]:
    """A room with a pillar, a ball and a shelf on the wall."""
    return [
        *box((-200, -200, 0), (200, 200, 200), inward=True),
        *box((20, 0, 0), (50, 30, 120)),
        *box((140, -60, 60), (199, 60, 70)),
        sphere((-20, -50, 30), 25),
    ]


def test_a_missing_mitsuba_is_told_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    with pytest.raises(UsageError, match=r"^[^\n]*pip install followspot\[validate\]$"):
        load_mitsuba()


def test_the_picture_is_that_of_the_direct_integrator() -> None:
    """Where no face is one-sided or cut out, at every pixel, shadows and rim included."""
    two_sided = Material("two-sided", sides=Sides.BOTH)
    tracer = RayTracer(make_scene(of(two_sided, *room()), LIGHT), 0.5)
    ours, theirs = tracer.render(VIEW, SIZE, LIGHT).radiance, tracer.direct(VIEW, SIZE, LIGHT)
    different = ~np.isclose(ours, theirs, rtol=1e-4, atol=1e-6 * theirs.max()).all(axis=2)
    assert (theirs > 0).any(axis=2).mean() > 0.2
    assert different.mean() < 2e-3  # rays that graze an edge


def test_the_truth_agrees_with_the_closed_form() -> None:
    """A floor under a spot light: L = rho / pi I cos(theta) / r^2 inside the cone."""
    truth = RayTracer(make_scene([floor()], LIGHT), 0.5).render(VIEW, SIZE, LIGHT)
    place, depth = on_plane(VIEW, (0, 0, 1))
    hit = np.isfinite(truth.depth)
    np.testing.assert_allclose(truth.depth[hit], depth[hit], rtol=3e-5)  # float32, in metres
    to_light = LIGHT.position - np.where(hit[..., np.newaxis], place, 0)
    r = np.linalg.norm(to_light, axis=2)
    cos_axis = -(to_light @ LIGHT.direction) / r
    intensity = LIGHT.power / (2 * math.pi * (1 - math.cos(math.radians(35))))
    expected = 0.5 / math.pi * intensity * (to_light[..., 2] / r / (r * METRES) ** 2)[..., None]
    inside, outside = hit & (cos_axis > LIGHT.cos_rim + 1e-4), cos_axis < LIGHT.cos_rim - 1e-4
    np.testing.assert_allclose(truth.radiance[inside], expected[inside], rtol=1e-4)
    assert not truth.radiance[outside].any()
    assert inside.sum() > 1000
    assert truth.lit[hit].all()


def test_the_camera_sees_through_backs_and_the_light_does_not() -> None:
    """A one-sided roof seen from above: not there for the camera, and its shadow is."""
    roof = quad((0, 0, 100), (0, 40, 0), (40, 0, 0))  # looks down
    light = spot((0, 0, 300), (0, 0, 0), 40)
    view = looking((0, -200, 250), (0, 0, 0), 60)
    truth = RayTracer(make_scene([floor(), roof], light), 0.5).render(view, SIZE, light)
    place, _ = on_plane(view, (0, 0, 1))
    np.testing.assert_allclose(truth.position[..., 2], 0, atol=1e-3)
    outside = np.abs(place[..., :2]).max(axis=2) - 60  # the roof's half of 40, seen from 300
    assert truth.lit[outside > 0.1].all()
    assert not truth.lit[outside < -0.1].any()


@pytest.mark.parametrize("test", [AlphaTest.GE128, AlphaTest.LT128, AlphaTest.GT0])
def test_cut_outs_are_there_where_their_texture_says(tmp_path: Path, test: AlphaTest) -> None:
    """Two quarters of a board are clear: for the camera, and for the light behind it."""
    pixels = np.full((64, 64, 4), 255, np.uint8)
    pixels[:32, :32, 3] = pixels[32:, 32:, 3] = 0
    grate = Material("grate", image="grate.png", sides=Sides.BOTH, alpha_test=test, clamps=True)
    board = quad((0, 0, 100), (50, 0, 0), (0, 50, 0))
    light = spot((0, 0, 300), (0, 0, 0), 40)
    view = looking((0.3, -1.7, 90), (0, 0, 0), 100)  # below the board
    above = looking((0.3, -1.7, 250), (0, 0, 0), 60)
    with image_archive(tmp_path, {"grate.png": pixels}) as archive:
        scene = make_scene([floor(), *of(grate, board)], light, archive=archive)
        tracer = RayTracer(scene, 0.5)
    x, y = (on_plane(view, (0, 0, 1))[0][..., k] / 1.5 for k in range(2))  # on the board
    # s runs along x and t against y, so that the clear quarters have x and y of other signs.
    clear = (np.sign(x) != np.sign(y)) ^ (test is AlphaTest.LT128)
    away = np.minimum(np.minimum(abs(x), abs(y)), 50 - np.maximum(abs(x), abs(y)))
    on_board, beside = away > 1.5, np.maximum(abs(x), abs(y)) > 51
    truth = tracer.render(view, SIZE, light)
    np.testing.assert_array_equal(truth.lit[on_board], clear[on_board])
    assert truth.lit[beside].all()
    seen = tracer.render(above, SIZE, light)
    x, y = (on_plane(above, (0, 0, 1), 100)[0][..., k] for k in range(2))
    clear = (np.sign(x) != np.sign(y)) ^ (test is AlphaTest.LT128)
    on_board = np.minimum(np.minimum(abs(x), abs(y)), 50 - np.maximum(abs(x), abs(y))) > 1
    height = np.where(clear, 0.0, 100.0)
    np.testing.assert_allclose(seen.position[on_board][:, 2], height[on_board], atol=0.05)


def test_a_uniform_sky_gives_pi_and_each_face_lights_its_own_side() -> None:
    normals = np.concatenate([np.eye(3), -np.eye(3)])[[0, 3, 1, 4, 2, 5]]
    np.testing.assert_allclose(irradiance(normals, [radiance(WHITE_SKY)])[0], math.pi, rtol=1e-3)
    for face in range(6):
        pixels = np.zeros((6, 4, 4, 3), np.uint8)
        pixels[face] = 255
        lit = irradiance(normals, [radiance(cube_map(pixels))])[0, :, 0]
        assert lit.argmax() == face
        assert lit[face ^ 1] == 0


@pytest.mark.gl
@pytest.mark.parametrize("light", [LIGHT, point((-60, -10, 150), 900)], ids=["spot", "point"])
def test_a_synthetic_room_is_right(renderer: Renderer, light: Light) -> None:
    figures, pictures = measure(renderer, of_albedo(make_scene(room(), light, sky=WHITE_SKY)), VIEW)
    assert figures.same_surface > 0.995
    assert figures.radiance.pixels > 2000
    assert figures.radiance.median < 1e-4
    assert figures.radiance.p99 < 1e-3
    assert figures.environment.constant_worst < 1e-5
    assert figures.environment.sky_worst < 1e-3  # this sky, too, has one colour
    by_size = {row.map_size: row for row in figures.visibility}
    assert list(by_size) == [512, 1024, 2048, 4096]
    assert by_size[1024].disagreement < 0.01
    assert by_size[4096].disagreement < by_size[512].disagreement
    assert by_size[1024].leak == by_size[1024].acne == 0
    for name, picture in pictures.items():
        assert np.isfinite(picture).all(), name


@pytest.mark.gl
def test_black_surfaces_are_black_in_both(renderer: Renderer) -> None:
    """No warning, and figures that JSON has words for."""
    scene = replace(make_scene(room(), LIGHT, sky=WHITE_SKY), settings=Settings(albedo=0.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figures, pictures = measure(renderer, scene, VIEW)
    assert figures.same_surface > 0.995 and figures.direct_integrator == 1
    assert figures.environment == EnvironmentFigures(0.0, 0.0, 0.0)
    assert figures.radiance == RadianceFigures(0, 0.0, 0.0, 0.0)
    assert not pictures["followspot.exr"].any() and not pictures["relative-error.exr"].any()


@pytest.mark.gl
@pytest.mark.parametrize(
    ("change", "wrong"),
    [
        ({"shadow_bias": 30.0}, "leak"),
        (
            {"shadow_bias": 0.0, "shadow_normal_offset": 0.0, "shadow_cull": CullFace.NONE},
            "acne",
        ),
    ],
)
def test_bad_settings_are_found_out(
    renderer: Renderer, change: dict[str, object], wrong: str
) -> None:
    both = Validation(renderer, make_scene(room(), LIGHT), VIEW, 0.5)
    figures = visibility_figures(both.compare(Settings(**change)), 1024)  # type: ignore[arg-type]
    assert getattr(figures, wrong) > 0.01


@pytest.mark.gl
def test_characters_are_left_out_of_both_pictures(renderer: Renderer) -> None:
    """Rays do not meet them, so that they and their shadows would count as errors of ours."""
    scene = load_figure("models/robot/robot.md2")
    camera = scene.camera()
    alone = replace(scene, crowd=Crowd())
    views = [View.DEPTH, View.SHADOW]
    with_robot, without = (renderer.render(s, camera, views) for s in (scene, alone))
    assert any((with_robot[view] != without[view]).any() for view in views)
    ours, expected = (
        Validation(renderer, s, camera, 0.5).compare(Settings()) for s in (scene, alone)
    )
    assert expected.compared.mean() > 0.1
    np.testing.assert_array_equal(ours.depth, expected.depth)
    np.testing.assert_array_equal(ours.share, expected.share)
    np.testing.assert_array_equal(ours.compared, expected.compared)


@pytest.mark.gl
@pytest.mark.openarena
@pytest.mark.parametrize("level", ["oa_dm5", "oasago2"])
def test_levels_are_right(renderer: Renderer, level: str) -> None:
    scene = load(level)
    with scene.archive:
        both = Validation(renderer, scene, scene.camera(), 0.5)
        comparison = both.compare(Settings())
    radiance = radiance_figures(comparison)
    assert radiance.pixels > 500
    assert radiance.median < 0.005
    assert radiance.p99 < 0.03
    assert visibility_figures(comparison, 1024).disagreement < 0.01


@pytest.mark.gl
def test_the_command_writes_pictures_and_figures(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "followspot", "validate", "courtyard", "--camera", "gate"]
    done = subprocess.run(
        [*command, "--size", "96x72", "-o", str(tmp_path / "out")],
        capture_output=True,
        text=True,
        env={**os.environ, "COLUMNS": "200"},
    )
    assert done.returncode == 0, done.stderr
    assert "relative difference of radiance" in done.stdout
    names = {"followspot", "mitsuba", "relative-error"}
    expected = {f"{name}.{ending}" for name in names for ending in ("exr", "png")}
    expected |= {"mitsuba-direct.exr", "visibility.png", "figures.json"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == expected
    figures = json.loads((tmp_path / "out" / "figures.json").read_bytes())
    assert figures["size"] == [96, 72]
    assert figures["radiance"]["median"] < 0.005
    assert figures["radiance"]["p99"] < 0.03
    by_size = {row["map_size"]: row for row in figures["visibility"]}
    assert by_size[1024]["disagreement"] < 0.01
    assert by_size[4096]["disagreement"] < by_size[512]["disagreement"]
    assert by_size[1024]["acne"] == 0


def of_albedo(scene: Scene) -> Scene:
    """The scene with the settings of the command."""
    return replace(scene, settings=Settings(albedo=0.5))
