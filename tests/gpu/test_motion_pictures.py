"""Moving surfaces in pictures, each against the same one that stands where it has moved to."""

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from test_frame import no_new_gl_objects

from conftest import Draw
from figures import at, figure, with_characters
from followspot.assets.archive import Archive
from followspot.assets.shader_deform import Move, Sprite, Swell
from followspot.assets.shader_motion import (
    Rotate,
    Scale,
    Scroll,
    Shape,
    Stretch,
    TcMod,
    Transform,
    Turbulence,
    Wave,
)
from followspot.assets.shader_values import AlphaTest, BlendFactor
from followspot.passes.frame import FrameInput
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.deform import Deforms
from followspot.scene.material import Layer, Material, Shade
from followspot.scene.motion import STILL, Motion
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from synthetic import (
    DIM,
    Piece,
    camera,
    floor,
    image_archive,
    make_scene,
    of,
    quad,
    srgb_decoded,
)

pytestmark = pytest.mark.gl

ADDS = BlendFactor.ONE, BlendFactor.ONE
NOISE = np.random.default_rng(3).integers(0, 256, (8, 8, 4), np.uint8)
COLORS = {name: (40 * k + 30, 250 - 40 * k, 60 * (k % 3)) for k, name in enumerate("abcdef")}
VIEW = camera((0, 0, 60), 20, 60)
TIME = 0.7

Textured = Callable[[Material], Scene]


@pytest.fixture
def archive(tmp_path: Path) -> Archive:
    """Noise, the same moved by half its width, half of it a hole, and plain colours."""
    half = NOISE.copy()
    half[:, :, 3] = np.linspace(0, 255, 8).astype(np.uint8)[:, np.newaxis]
    images = {"noise.png": NOISE, "half.png": half, "moved.png": np.roll(NOISE, 4, axis=1)}
    images |= {f"{n}.png": np.full((2, 2, 3), color, np.uint8) for n, color in COLORS.items()}
    return image_archive(tmp_path, images)


def ground(material: Material) -> Piece:
    """A floor of eight images across, at places and coordinates in which nothing is special."""
    piece = quad((30, 20, 0), (300, 0, 0), (0, 200, 5))
    piece.vertices["texcoord"] *= 8
    return replace(piece, material=material)


def moved(piece: Piece, mods: tuple[TcMod, ...], seconds: float) -> Piece:
    """The piece with its texture coordinates where the mods have moved them."""
    vertices = piece.vertices.copy()
    x, y, z = vertices["position"].T.astype(np.float64)
    s, t = vertices["texcoord"].T
    angles = math.tau * (x + z) / 1024, math.tau * y / 1024
    terms = Motion(mods).terms(seconds)
    waves = [f(angle) for f in (np.sin, np.cos) for angle in angles]
    weights = [s, t, np.ones_like(s), *waves][: len(terms)]
    vertices["texcoord"] = np.stack(weights, axis=1) @ np.array(terms)
    return replace(piece, vertices=vertices)


def rho(draw: Draw, archive: Archive, *pieces: Piece, time: float = 0.0) -> NDArray[np.float64]:
    return draw(make_scene(pieces, archive=archive), VIEW, View.LAMBERTIAN, time=time)


def test_a_scrolled_image_is_the_still_one_shifted(draw: Draw, archive: Archive) -> None:
    scrolls = Material("s", "noise.png", motion=Motion((Scroll(-0.25, 0),)))
    at_two = rho(draw, archive, ground(scrolls), time=2.0)
    shifted = rho(draw, archive, ground(Material("m", "moved.png")))
    still = rho(draw, archive, ground(Material("n", "noise.png")))
    np.testing.assert_allclose(at_two, shifted, atol=1e-4)
    np.testing.assert_array_equal(rho(draw, archive, ground(scrolls)), still)
    assert (np.abs(at_two - still) > 0.05).mean() > 0.3


@pytest.mark.parametrize(
    "mods",
    [
        (Scale(2, -0.5),),
        (Rotate(80), Scroll(0.3, 1.9)),
        (Stretch(Wave(Shape.SIN, 2, 1, 0.2, 0.5)), Transform(1, 0.5, -0.2, 0.8, 0.1, 0.2)),
        (Turbulence(0.4, 0.1, 0.6),),
        (Scale(0.5, 2), Turbulence(0.3, 0.4, 1), Rotate(-30), Turbulence(0.2, 0, 0.3)),
    ],
)
@pytest.mark.parametrize("is_layer", [False, True])
def test_images_are_looked_up_where_mods_move_them(
    draw: Draw, archive: Archive, mods: tuple[TcMod, ...], is_layer: bool
) -> None:
    """A layer's mods leave the base where it is: under one without holes none of it is seen."""
    still = Material("still", "noise.png")
    motion = Motion(mods)
    moving = replace(still, motion=motion)
    if is_layer:
        base = Motion((Scroll(0.1, 0.7),))
        moving = Material("m", "a.png", layer=Layer("noise.png", motion=motion), motion=base)
        still = Material("still", "a.png", layer=Layer("noise.png"))
    expected = rho(draw, archive, moved(ground(still), mods, TIME))
    found = rho(draw, archive, ground(moving), time=TIME)
    assert np.isclose(found, expected, atol=2e-3).mean() > 0.99
    assert not np.isclose(found, rho(draw, archive, ground(still)), atol=2e-3).mean() > 0.9


def test_base_and_layer_share_coordinates_where_their_mods_are_the_same(
    draw: Draw, archive: Archive
) -> None:
    mods = (Scroll(0.2, 0.3),)
    layered = Material("l", "moved.png", layer=Layer("half.png"))
    moving = replace(layered, motion=Motion(mods), layer=Layer("half.png", motion=Motion(mods)))
    expected = rho(draw, archive, moved(ground(layered), mods, TIME))
    np.testing.assert_allclose(rho(draw, archive, ground(moving), time=TIME), expected, atol=1e-4)


@pytest.mark.parametrize("seconds", [0.0, 0.24, 0.26, 0.74, 0.76, 1.1])
def test_images_follow_each_other(draw: Draw, archive: Archive, seconds: float) -> None:
    """Three of the base at four a second, two of a see-through layer at two a second."""
    base = Motion(frames=("a.png", "b.png", "c.png"), rate=4)
    number = math.floor(seconds * 4) % 3
    picture = rho(draw, archive, ground(Material("m", "a.png", motion=base)), time=seconds)
    color = srgb_decoded(np.array(COLORS["abc"[number]]) / 255)
    np.testing.assert_allclose(picture[-1, 80], color, atol=2e-3)
    layer = Layer("noise.png", motion=Motion(frames=("noise.png", "half.png"), rate=2))
    material = Material("l", "a.png", layer=layer, motion=base)
    shown = ("noise.png", "half.png")[math.floor(seconds * 2) % 2]
    still = Material("still", f"{'abc'[number]}.png", layer=Layer(shown))
    np.testing.assert_array_equal(
        rho(draw, archive, ground(material), time=seconds), rho(draw, archive, ground(still))
    )


def test_a_layer_is_laid_over_only_where_its_alpha_test_keeps_it(
    draw: Draw, archive: Archive
) -> None:
    layered = Material("l", "a.png", layer=Layer("half.png"))
    base = rho(draw, archive, ground(Material("b", "a.png")))
    mixed = rho(draw, archive, ground(layered))
    shown = {
        test: rho(draw, archive, ground(replace(layered, layer=Layer("half.png", alpha_test=test))))
        for test in AlphaTest
    }
    np.testing.assert_array_equal(shown[AlphaTest.GT0], mixed)
    is_low = (shown[AlphaTest.LT128] == mixed).all(axis=2)
    is_high = (shown[AlphaTest.GE128] == mixed).all(axis=2)
    is_base = (np.abs(mixed - base) < 1e-6).all(axis=2)
    assert (is_low ^ is_high | is_base).all()
    assert is_low.mean() > 0.2 and is_high.mean() > 0.2
    np.testing.assert_array_equal(shown[AlphaTest.LT128][~is_low], base[~is_low])
    np.testing.assert_array_equal(shown[AlphaTest.GE128][~is_high], base[~is_high])


def test_glowing_surfaces_pulse(draw: Draw, archive: Archive) -> None:
    wave = Wave(Shape.SAWTOOTH, 0, 1, 0, 1)
    glow = Material("g", "noise.png", blend=ADDS, shade=Shade.EMISSIVE, motion=Motion(color=wave))
    scene = make_scene([ground(glow)], archive=archive)
    steady = make_scene([ground(replace(glow, motion=STILL))], archive=archive)
    full = draw(steady, VIEW, View.FINAL, DIM)
    for seconds in (0.0, 0.3, 0.9, 1.3):
        picture = draw(scene, VIEW, View.FINAL, DIM, time=seconds)
        np.testing.assert_allclose(picture, full * (seconds % 1) ** 2.2, rtol=1e-3, atol=1e-6)


def test_glass_fades_by_its_alpha(draw: Draw, archive: Archive) -> None:
    """Half as much of it, and all that it hides half comes through."""
    mixes = BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA
    glass = Material("g", "a.png", blend=mixes)
    half = Motion(alpha=Wave(Shape.SQUARE, 0.25, 0.25, 0, 1))
    over = quad((0, 0, 20), (300, 0, 0), (0, 300, 0))
    below, above = of(Material("b", "b.png"), floor()), of(replace(glass, motion=half), over)
    a, b = (srgb_decoded(np.array(COLORS[name]) / 255) for name in "ab")
    for seconds, share in ((0.2, 0.5), (0.7, 0.0)):
        picture = rho(draw, archive, *below, *above, time=seconds)
        np.testing.assert_allclose(picture[60, 80], a * share + b * (1 - share), atol=3e-3)


def test_what_characters_wear_moves_too(draw: Draw, archive: Archive) -> None:
    """Turbulence by vertices' places in the model, wherever that stands."""
    mods = (Scroll(0.3, 0.1), Turbulence(0.4, 0.2, 1))
    material = Material("worn", "noise.png", layer=Layer("half.png"), motion=Motion(mods))
    piece = ground(material)
    still = ground(replace(material, motion=STILL))
    expected_base = moved(still, mods, TIME)
    place = (200, 100, 0)
    scene = make_scene([floor()], archive=archive)
    walker = with_characters(scene, at(figure([[piece]]), place))
    plain = replace(material, layer=None)
    picture = draw(
        with_characters(scene, at(figure([[replace(piece, material=plain)]]), place)),
        VIEW, View.LAMBERTIAN, time=TIME,
    )  # fmt: skip
    there = replace(expected_base, material=replace(plain, motion=STILL))
    expected = draw(
        with_characters(scene, at(figure([[there]]), place)), VIEW, View.LAMBERTIAN, time=TIME
    )
    assert np.isclose(picture, expected, atol=2e-3).mean() > 0.99
    layered = draw(walker, VIEW, View.LAMBERTIAN, time=TIME)
    assert not np.isclose(layered, picture, atol=2e-3).all()


def test_frames_of_moving_surfaces_create_nothing(renderer: Renderer, archive: Archive) -> None:
    motion = Motion((Scroll(1, 1), Turbulence(1, 0, 1)), ("a.png", "b.png"), 5)
    material = Material("m", "a.png", layer=Layer("noise.png"), motion=motion)
    scene = make_scene([ground(material)], archive=archive)
    renderer.open(scene)

    def frame(seconds: float) -> FrameInput:
        return FrameInput(scene, VIEW, Settings(exposure=1.0), 1.0, time=seconds)

    renderer.draw(frame(0))
    with no_new_gl_objects():
        for seconds in (0.1, 0.5, 1.1):
            renderer.draw(frame(seconds))


MACROS = {"MOVES", "SWAYS", "LAYER_APART", "LAYER_SWAYS", "LAYER_TEST", "PULSES"}
MACROS |= {"DISPLACED", "SWELLS", "SPRITE"}


def test_programs_of_a_still_level_know_nothing_of_motion(
    renderer: Renderer, archive: Archive
) -> None:
    def macros(*materials: Material) -> tuple[set[str], set[str]]:
        scene = make_scene([ground(material) for material in materials], archive=archive)
        renderer.render(scene, VIEW, [View.FINAL])
        assert renderer.pipeline is not None
        shaders = renderer.pipeline._surfaces.programs.shaders
        uniforms = {name for shader in shaders for name in shader.program}
        return {name for shader in shaders for name in shader._defines} & MACROS, uniforms

    added = {"base_moved", "base_swayed", "layer_moved", "layer_swayed", "pulse"}
    added |= {"displaced", "swell"}
    still = Material("s", "noise.png", layer=Layer("half.png")), Material("g", "a.png", blend=ADDS)
    found, uniforms = macros(*still)
    assert found == set() and not uniforms & added
    sways, wave = Motion((Turbulence(1, 0, 1),)), Wave(Shape.SIN, 1, 1, 0, 1)
    found, uniforms = macros(
        replace(still[0], motion=sways), replace(still[0], layer=Layer("half.png", motion=sways)),
        replace(still[0], layer=Layer("half.png", alpha_test=AlphaTest.GE128)),
        replace(still[1], motion=Motion(color=wave)),
        replace(still[1], deforms=Deforms((Move((1, 1, 1), wave),), Swell(1, wave), Sprite.WHOLE)),
    )  # fmt: skip
    assert found == MACROS and added <= uniforms
