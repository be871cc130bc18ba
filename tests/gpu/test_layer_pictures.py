"""Images that are laid on others, and surfaces that shine by themselves."""

from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from conftest import Draw
from followspot.assets.archive import Archive
from followspot.assets.shader_motion import Scale, Shape, Wave
from followspot.assets.shader_values import BlendFactor
from followspot.passes.materials import variant_of
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.material import BRIGHTENS, ByVertex, Laid, Layer, Material, Shade
from followspot.scene.motion import STILL, Motion
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from synthetic import WHITE_SKY, camera, image_archive, make_scene, quad, srgb_decoded, srgb_encoded

pytestmark = pytest.mark.gl

VIEW = camera((0, 0, 60), 20, 60)
BASE = Material("m", "a.png")
LAVA = Material("lava", "plain.png", shade=Shade.EMISSIVE)
COLOR = (200, 90, 30)
TEXEL_STEP = 2e-3  # channels of a texel share an exponent


@pytest.fixture
def archive(tmp_path: Path) -> Archive:
    """Two images of noise that are no brighter than nine tenths, and a plain one."""
    a, b = np.random.default_rng(5).integers(20, 240, (2, 8, 8, 3), np.uint8)
    plain = np.full((2, 2, 3), COLOR, np.uint8)
    return image_archive(tmp_path, {"a.png": a, "b.png": b, "plain.png": plain})


def ground(material: Material, archive: Archive, tint: tuple[float, ...] | None = None) -> Scene:
    piece = replace(quad((30, 20, 0), (300, 0, 0), (0, 200, 5)), material=material)
    piece.vertices["texcoord"] *= 2
    scene = make_scene([piece], sky=WHITE_SKY, environment_constant=3.0, archive=archive)
    if tint is None:
        return scene
    mesh = replace(scene.mesh, tints=np.full((4, 4), tint, np.float32))
    return replace(scene, level=replace(scene.level, mesh=mesh))


def put_together(laid: Laid, a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """What a surface of image a reflects with image b on it."""
    grey = srgb_decoded(np.array([0.5]))
    return {
        Laid.SHEEN: np.minimum(a + b, 1),
        Laid.FILTER: a * b,
        Laid.GRAIN: np.minimum(a * b / grey, 1),
        Laid.GLOW: a,
    }[laid]


@pytest.mark.parametrize("laid", [Laid.SHEEN, Laid.FILTER, Laid.GRAIN, Laid.GLOW])
def test_what_a_layer_does(draw: Draw, archive: Archive, laid: Laid) -> None:
    layered = replace(BASE, layer=Layer("b.png", laid))
    alone = (ground(Material("m", f"{name}.png"), archive) for name in "ab")
    a, b = (draw(scene, VIEW, View.LAMBERTIAN) for scene in alone)
    is_ground = np.isfinite(draw(ground(BASE, archive), VIEW, View.DEPTH))
    assert is_ground.mean() > 0.3
    a, b = a[is_ground], b[is_ground]
    rho = put_together(laid, a, b)
    scene = ground(layered, archive)
    shown = draw(scene, VIEW, View.LAMBERTIAN, grain=True)[is_ground]
    np.testing.assert_allclose(shown, rho, atol=TEXEL_STEP)
    own = 7.0 * b if laid is Laid.GLOW else np.zeros_like(b)
    final = draw(scene, VIEW, View.FINAL, grain=True, emission=7.0)[is_ground]
    np.testing.assert_allclose(final, 3 * shown + own, rtol=1e-5, atol=1e-5)
    constant = draw(scene, VIEW, View.FINAL, albedo=0.5, grain=True)[is_ground]
    np.testing.assert_allclose(constant, 1.5, rtol=1e-5)


@pytest.mark.parametrize("laid", [Laid.SHEEN, Laid.FILTER, Laid.GRAIN, Laid.GLOW])
def test_the_base_below_a_layer_has_its_own_colour(
    draw: Draw, archive: Archive, laid: Laid
) -> None:
    """And the layer none of it."""
    tint = (0.9, 0.3, 0.5, 1.0)
    below = replace(BASE, is_tinted=True)
    on_top = replace(below, layer=Layer("b.png", laid))
    a, b = (
        draw(ground(Material("m", f"{name}.png"), archive), VIEW, View.LAMBERTIAN) for name in "ab"
    )
    alone, shown = (
        draw(ground(material, archive, tint), VIEW, View.LAMBERTIAN, grain=True)
        for material in (below, on_top)
    )
    np.testing.assert_allclose(alone, a * tint[:3], atol=1e-5)
    is_ground = a.max(axis=2) > 0
    expected = put_together(laid, alone, b)[is_ground]
    np.testing.assert_allclose(shown[is_ground], expected, atol=TEXEL_STEP)


def test_grain_that_is_left_out_takes_no_program_of_its_own() -> None:
    layer = Layer("b.png", Laid.GRAIN, color=(0.5, 1, 0.25), motion=Motion((Scale(3, 3),)))
    smooth, rough = (
        variant_of(replace(BASE, layer=each), is_smoothed=True) for each in (None, layer)
    )
    assert rough != smooth and rough.without_grain == smooth == smooth.without_grain
    glows = variant_of(replace(BASE, layer=replace(layer, laid=Laid.GLOW)), is_smoothed=True)
    assert glows.without_grain == glows


def test_grain_is_left_out_unless_it_is_asked_for(draw: Draw, archive: Archive) -> None:
    rough = replace(BASE, layer=Layer("b.png", Laid.GRAIN, motion=Motion((Scale(3, 3),))))
    smooth, shown, without = (
        draw(ground(material, archive), VIEW, View.LAMBERTIAN, grain=grain)
        for material, grain in ((BASE, True), (rough, True), (rough, False))
    )
    assert np.array_equal(smooth, without)
    assert np.abs(shown - smooth).mean() > 0.01


def test_a_layer_has_a_colour_a_pulse_and_the_vertices_colours(
    draw: Draw, archive: Archive
) -> None:
    """All of them multiply; the base has none of them."""
    wave = Wave(Shape.NOISE, 0.5, 0.3, 0, 2)
    plain = Layer("b.png", Laid.SHEEN)
    colored = replace(
        plain, color=(0.5, 1, 0.25), by_vertex=ByVertex.DIMS, motion=Motion(color=wave)
    )
    tint = (1.0, 0.5, 0.75, 0.0)
    base, whole, shown = (
        draw(ground(replace(BASE, layer=layer), archive, tint), VIEW, View.LAMBERTIAN, time=0.7)
        for layer in (None, plain, colored)
    )
    pulse, _ = colored.motion.pulse(0.7)
    assert 0.01 < pulse < 0.8
    factor = pulse * np.array(tint[:3]) * (0.5, 1, 0.25)
    unclamped = whole < 0.999
    expected = base + (whole - base) * factor
    np.testing.assert_allclose(shown[unclamped], expected[unclamped], atol=TEXEL_STEP)


def test_a_layer_may_end_at_its_border(draw: Draw, archive: Archive) -> None:
    """While the base goes on."""
    ends = Layer("b.png", Laid.FILTER, clamps=True)
    base, border, shown = (
        draw(ground(material, archive), VIEW, View.LAMBERTIAN)
        for material in (
            BASE,
            Material("b", "b.png", clamps=True),
            replace(BASE, layer=ends),
        )
    )
    is_ground = np.isfinite(draw(ground(BASE, archive), VIEW, View.DEPTH))
    np.testing.assert_allclose(shown[is_ground], (base * border)[is_ground], atol=TEXEL_STEP)


@pytest.mark.parametrize("exposure", [0.01, 1.0, 40.0])
def test_what_shines_is_displayed_as_it_is_painted(
    renderer: Renderer, archive: Archive, exposure: float
) -> None:
    """Unless it is said how strongly; in linear values it is what the exposure makes that of."""
    scene = ground(LAVA, archive)
    settings = Settings(exposure=exposure)
    is_lava = renderer.render(scene, VIEW, "depth", linear=True)["depth"] < np.inf
    shown = renderer.render(scene, VIEW, settings=settings)["final"][is_lava]
    assert np.abs(shown.astype(int) - COLOR).max() <= 1
    linear = renderer.render(scene, VIEW, settings=settings, linear=True)["final"][is_lava]
    painted = srgb_decoded(np.array(COLOR) / 255)
    np.testing.assert_allclose(linear * exposure, np.tile(painted, (len(linear), 1)), atol=2e-3)
    weak = msgspec.structs.replace(settings, emission=0.25 / exposure)
    dimmer = renderer.render(scene, VIEW, settings=weak)["final"][is_lava]
    quarter = srgb_decoded(dimmer / 255)
    np.testing.assert_allclose(quarter, np.tile(painted / 4, (len(quarter), 1)), atol=3e-3)


@pytest.mark.parametrize("exposure", [0.01, 40.0])
@pytest.mark.parametrize("color", [None, Wave(Shape.SQUARE, 0.6, 0, 0, 1)])
def test_two_images_that_shine_are_summed_as_they_are_painted(
    renderer: Renderer, archive: Archive, exposure: float, color: Wave | None
) -> None:
    """The layer does not pulse with the base."""
    lava = replace(BASE, shade=Shade.EMISSIVE, motion=Motion(color=color))
    settings = Settings(exposure=exposure)
    a, b, both = (
        renderer.render(ground(material, archive), VIEW, settings=settings)["final"].astype(int)
        for material in (
            lava,
            replace(lava, image="b.png", motion=STILL),
            replace(lava, layer=Layer("b.png", Laid.GLOW)),
        )
    )
    is_ground = np.isfinite(
        renderer.render(ground(lava, archive), VIEW, "depth", linear=True)["depth"]
    )
    expected = np.minimum(a + b, 255)[is_ground]
    assert np.abs(both[is_ground] - expected).max() <= 2
    assert (expected < 255).mean() > 0.2


def test_what_shines_is_no_matter_for_the_exposure(renderer: Renderer, archive: Archive) -> None:
    """And linear values are those of the picture that is displayed."""
    lamp = replace(BASE, layer=Layer("b.png", Laid.GLOW))
    dark, lit = ground(BASE, archive), ground(lamp, archive)
    exposure = renderer.exposure(lit, VIEW)
    assert exposure == renderer.exposure(dark, VIEW) > 0
    assert renderer.exposure(lit, VIEW, Settings(emission=100.0)) < exposure / 2
    linear, plain = (
        renderer.render(scene, VIEW, linear=True)["final"].astype(np.float64)
        for scene in (lit, dark)
    )
    own = (linear - plain) * exposure
    shining = replace(BASE, image="b.png", shade=Shade.EMISSIVE)
    painted = renderer.render(ground(shining, archive), VIEW, linear=True,
                              settings=Settings(exposure=1.0))["final"]  # fmt: skip
    is_ground = np.isfinite(renderer.render(dark, VIEW, "depth", linear=True)["depth"])
    np.testing.assert_allclose(own[is_ground], painted[is_ground], atol=TEXEL_STEP)


def test_a_constant_albedo_is_lit_whatever_shone(draw: Draw, archive: Archive) -> None:
    shining, lit = (
        draw(ground(material, archive), VIEW, View.FINAL, albedo=0.5)
        for material in (LAVA, replace(LAVA, shade=Shade.LIT))
    )
    assert np.array_equal(shining, lit)


def test_signs_brighten_what_is_displayed_and_ripples_the_light(
    draw: Draw, archive: Archive
) -> None:
    """By 1 and the texel more, for each of two images; GL can double the light that is there."""
    dim, sky = np.array([0.01, 0.9, 0.04]), 3.0
    sign = replace(BASE, is_tinted=True, blend=BRIGHTENS, shade=Shade.FILTER)
    ripples = replace(sign, layer=Layer("b.png", Laid.FILTER, color=(0.1, 1.0, 0.2)))
    is_ground = np.isfinite(draw(ground(BASE, archive), VIEW, View.DEPTH))
    a, b = (
        draw(ground(Material("m", image), archive), VIEW, View.LAMBERTIAN)[is_ground]
        for image in ("a.png", "b.png")
    )
    displayed = 1 + srgb_encoded(a * dim)
    light = (1 + a * dim) * (1 + b * (0.1, 1.0, 0.2))
    for material, factor in ((sign, displayed**2.2), (ripples, light)):
        shown = draw(ground(material, archive, (*dim, 1.0)), VIEW, View.FINAL)[is_ground]
        np.testing.assert_allclose(shown, sky * np.minimum(factor, 2.0), rtol=5e-3)
        assert 0.5 < (factor < 1.9).mean() < 1


@pytest.mark.parametrize("shade", [Shade.EMISSIVE, Shade.LIT])
@pytest.mark.parametrize("behind", [BlendFactor.ONE, BlendFactor.ONE_MINUS_SRC_ALPHA])
def test_a_glow_is_added_to_what_is_blended(
    draw: Draw, archive: Archive, shade: Shade, behind: BlendFactor
) -> None:
    adds = replace(BASE, blend=(BlendFactor.ONE, BlendFactor.ONE), shade=Shade.EMISSIVE)
    base = replace(BASE, blend=(BlendFactor.ONE, behind), shade=shade)
    a, b, both = (
        draw(ground(material, archive), VIEW, View.FINAL, emission=0.5)
        for material in (
            base,
            replace(adds, image="b.png"),
            replace(base, layer=Layer("b.png", Laid.GLOW)),
        )
    )
    sky = 3.0
    assert (b - sky).max() > 0.2
    np.testing.assert_allclose(both, a + b - sky, atol=TEXEL_STEP)


def test_alpha_weights_what_is_added_but_no_glow_on_it(draw: Draw, tmp_path: Path) -> None:
    rgb, alpha, ball = np.array([200, 120, 40]), 90, np.array([60, 10, 150])
    flame, glow = np.full((2, 4, 4, 4), 255, np.uint8)
    flame[:], glow[..., :3] = (*rgb, alpha), ball
    archive = image_archive(tmp_path, {"a.png": flame, "b.png": glow})
    adds = (BlendFactor.SRC_ALPHA, BlendFactor.ONE)
    plain = replace(BASE, blend=adds, shade=Shade.EMISSIVE)
    expected = 3.0 + 0.5 * srgb_decoded(rgb / 255) * alpha / 255
    for material, own in (
        (plain, expected),
        (
            replace(plain, layer=Layer("b.png", Laid.GLOW)),
            expected + 0.5 * srgb_decoded(ball / 255),
        ),
    ):
        shown = draw(ground(material, archive), VIEW, View.FINAL, emission=0.5)
        place = shown.reshape(-1, 3)[shown.sum(axis=2).argmax()]
        np.testing.assert_allclose(place, own, atol=TEXEL_STEP)
