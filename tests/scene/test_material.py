from dataclasses import replace

import numpy as np
import pytest

from followspot.assets.bsp import LUMPS
from followspot.assets.shader_motion import Rotate, Scale, Scroll, Shape, Wave
from followspot.assets.shader_parser import find_entries
from followspot.assets.shader_script import ShaderScript
from followspot.assets.shader_values import AlphaTest, Sides
from followspot.assets.shader_values import BlendFactor as Factor
from followspot.scene.material import Material, Shade, from_script, is_drawn
from followspot.scene.motion import Motion
from synthetic import open_bsp

WALL = Material("s", "wall")
ADDS = Factor.ONE, Factor.ONE
MIXES = Factor.SRC_ALPHA, Factor.ONE_MINUS_SRC_ALPHA
FILTERS = Factor.DST_COLOR, Factor.ZERO
BRIGHTENS = Factor.DST_COLOR, Factor.ONE


def script(*stages: str, general: str = "") -> ShaderScript:
    """A script of stages, whose directives are parted by semicolons."""
    lines = [general, *(f"{{\n{stage}\n}}" for stage in stages)]
    text = "s\n{\n" + "\n".join(lines).replace("; ", "\n") + "\n}"
    (entry,), _ = find_entries(text, "s")
    return entry.read()


def made(*stages: str, general: str = "") -> Material:
    """The material of a script, in an archive that has every image."""
    return from_script("s", script(*stages, general=general), lambda name: name)


@pytest.mark.parametrize(
    "stages",
    [
        ("map $lightmap", "map wall; blendFunc filter"),
        ("map wall", "map $lightmap; blendFunc filter"),
        ("map wall", "map glow; blendFunc add"),
        ("map env; tcGen environment", "map wall; blendFunc add"),
        ("map env; tcGen environment", "map wall; blendFunc blend; alphaGen wave sin 0 1 0 1"),
        ("map wall; tcMod scroll 0 0", "map env; tcGen environment; blendFunc blend"),
        ("map wall; tcMod scale 1 1", "map glow; blendFunc add; tcMod scroll 0 1"),
    ],
)
def test_the_base_image_is_the_surface_and_not_what_plays_on_it(stages: tuple[str, ...]) -> None:
    assert made(*stages) == WALL


@pytest.mark.parametrize(
    ("stages", "blend", "shade"),
    [
        (("map wall; blendFunc add",), ADDS, Shade.EMISSIVE),
        (("map $whiteimage; blendFunc add", "map wall"), ADDS, Shade.EMISSIVE),
        (("map wall; blendFunc blend",), MIXES, Shade.LIT),
        (("map wall; blendFunc filter",), FILTERS, Shade.FILTER),
        (("map wall; blendFunc GL_DST_COLOR GL_ONE",), BRIGHTENS, Shade.FILTER),
        (("map pool; blendFunc filter", "map wall; blendFunc add"), ADDS, Shade.EMISSIVE),
        (
            ("map wall; blendFunc filter", "map env; tcGen environment; blendFunc add"),
            FILTERS,
            Shade.FILTER,
        ),
    ],
)
def test_blended_surfaces(
    stages: tuple[str, ...], blend: tuple[Factor, Factor], shade: Shade
) -> None:
    assert made(*stages) == replace(WALL, blend=blend, shade=shade)


@pytest.mark.parametrize(
    "stages",
    [
        ("map wall", "map lamps; blendFunc blend"),
        ("map wall", "map lamps; blendFunc blend", "map $lightmap; blendFunc filter"),
        ("map wall", "map glow; blendFunc add; tcMod scroll 1 0", "map lamps; blendFunc blend"),
        ("map wall", "map env; tcGen environment; blendFunc blend", "map lamps; blendFunc blend"),
        ("map wall", "map $lightmap; blendFunc blend", "map lamps; blendFunc blend"),
        ("map wall", "map lamps; blendFunc blend; alphaGen identity", "map sign; blendFunc blend"),
    ],
)
def test_an_image_lies_over_another(stages: tuple[str, ...]) -> None:
    assert made(*stages) == replace(WALL, layer="lamps")


@pytest.mark.parametrize(
    "before", [(), ("map $lightmap",), ("map wood",), ("map wood", "map glow; blendFunc add")]
)
def test_metal_mirrors_below_what_lies_over_it(before: tuple[str, ...]) -> None:
    metal = replace(WALL, image="env", mirrors=True)
    assert made(*before, "map env; tcGen environment", "map wall; blendFunc blend") == replace(
        metal, layer="wall"
    )


@pytest.mark.parametrize("first", ["map wall; alphaFunc GE128", "map wall; blendFunc blend"])
def test_what_is_cut_out_or_blended_mirrors_nothing(first: str) -> None:
    """Nothing lies over such a base, so the image itself has to be it."""
    material = made(first, "map env; tcGen environment", "map rock; blendFunc blend")
    assert (material.image, material.layer, material.mirrors) == ("wall", None, False)


def test_reflections_alone_are_what_a_surface_shows() -> None:
    metal = replace(WALL, image="env", mirrors=True)
    assert made("map env; tcGen environment") == metal
    assert made("map env; tcGen environment", "map $lightmap; blendFunc filter") == metal
    first = "map env; tcGen environment; tcMod scroll 1 0"
    moving = replace(metal, motion=Motion((Scroll(1, 0),)))
    assert made(first, "map shine; tcGen environment; blendFunc add") == moving


def test_vertices_alpha_lays_an_image_over_terrain() -> None:
    rock, light = "map rock; blendFunc blend; alphaGen vertex", "map $lightmap; blendFunc filter"
    assert made("map wall", rock, light) == replace(WALL, layer="rock", fades=True)
    assert made("map wall", rock.replace("vertex", "wave sin 0 1 0 1"), light) == WALL
    assert made("map wall", rock.replace("blend;", "add;"), light) == WALL
    assert made("map wall; blendFunc add", rock).layer is None
    cut_out = made("map wall; alphaFunc GE128", rock)
    assert cut_out == replace(WALL, alpha_test=AlphaTest.GE128)
    missing = from_script("s", script("map wall", rock), {"wall": "wall"}.get)
    assert missing == WALL


def test_base_and_layer_move_each_by_its_own_directives() -> None:
    base = "map wall; tcMod rotate 10; tcMod scroll 0 1"
    layer = "animMap 4 a b c; blendFunc blend; alphaFunc GE128; tcMod scale 7 7"
    material = made(base, layer)
    assert material == replace(
        WALL,
        layer="a",
        layer_alpha_test=AlphaTest.GE128,
        motion=Motion((Rotate(10), Scroll(0, 1))),
        layer_motion=Motion((Scale(7, 7),), frames=("a", "b", "c"), rate=4),
    )
    assert material.images == ("wall", "a", "b", "c")
    assert material.moves and not WALL.moves


def test_images_that_are_not_there_are_left_out_of_an_animation() -> None:
    def found(stage: str, *names: str) -> Material:
        return from_script("s", script(stage), {name: name for name in names}.get)

    flame = found("animMap 10 a b c", "a", "c")
    assert (flame.image, flame.motion.frames) == ("a", ("a", "a", "c"))
    assert found("animMap 10 a b c", "b") == Material("s")
    for still in ("animMap 10 a", "animMap 0 a b", "map a b"):
        assert found(still, "a", "b") == Material("s", "a")


def test_a_constant_colour_is_the_base_images() -> None:
    """In linear light; what a layer lies over keeps its own colours."""
    assert made("map wall; rgbGen const ( 1 0.5 0 )").color == (1, 0.5**2.2, 0)
    assert made("map wall; rgbGen const ( 1 1 1 )") == WALL
    layered = made("map wall; rgbGen const ( 1 0 0 )", "map b; blendFunc blend")
    assert (layered.layer, layered.color) == ("b", None)


def test_what_is_blended_pulses_unless_its_images_follow_each_other() -> None:
    wave = "rgbGen wave sin .5 .5 0 2; alphaGen wave square 0 1 .5 1"
    color, alpha = Wave(Shape.SIN, 0.5, 0.5, 0, 2), Wave(Shape.SQUARE, 0, 1, 0.5, 1)
    assert made(f"map wall; blendFunc add; {wave}").motion == Motion(color=color, alpha=alpha)
    assert made(f"map wall; {wave}") == WALL
    assert made("map wall", f"map lamps; blendFunc blend; {wave}") == WALL
    fire = made(f"animMap 10 wall b; blendFunc add; {wave}")
    assert fire.motion == Motion(frames=("wall", "b"), rate=10)


@pytest.mark.parametrize(
    ("blend", "adds"),
    [
        (ADDS, True),
        ((Factor.SRC_ALPHA, Factor.ONE), True),
        (MIXES, False),
        (FILTERS, False),
        (BRIGHTENS, False),  # what it adds depends on what is there
        ((Factor.DST_ALPHA, Factor.ONE), False),
        (None, False),
    ],
)
def test_what_only_adds(blend: tuple[Factor, Factor] | None, adds: bool) -> None:
    assert replace(WALL, blend=blend).only_adds is adds


def test_cut_out_surfaces_are_not_blended_too() -> None:
    leaf = Material("s", "leaf", alpha_test=AlphaTest.GE128)
    assert made("map leaf; alphaFunc GE128") == leaf
    assert made("map leaf; alphaFunc GE128; blendFunc blend") == leaf
    assert made("map leaf; alphaFunc GE128; blendFunc filter", "map $lightmap") == leaf
    assert made("map $lightmap; alphaFunc GE128", "map leaf; blendFunc filter") == leaf


def test_a_cut_out_decal_that_brightens_what_is_below_stays_one() -> None:
    decal = made("map leaf; alphaFunc GE128; blendFunc GL_DST_COLOR GL_ONE")
    assert decal == Material("s", "leaf", Sides.FRONT, AlphaTest.GE128, BRIGHTENS, Shade.FILTER)


def test_what_a_script_says_of_the_whole_surface() -> None:
    assert made("clampMap wall", general="cull none") == replace(
        WALL, sides=Sides.BOTH, clamps=True
    )
    assert made("map $lightmap", general="cull back") == Material("s", "s", Sides.BACK)
    assert made("map wall; blendFunc blend", general="polygonOffset") == replace(
        WALL, blend=MIXES, polygon_offset=True
    )
    assert from_script("s", None, lambda name: None) == Material("s")


@pytest.mark.parametrize(
    ("stages", "general", "drawn"),
    [
        (("map wall",), "", True),
        ((), "", False),
        *((("map wall",), f"surfaceparm {word}", False) for word in ("sky", "nodraw", "hint")),
        (("map wall",), "surfaceparm skip", False),
        (("map shine; blendFunc add; tcGen environment",), "", True),
        (
            ("map $lightmap; blendFunc filter", "map shine; blendFunc add; tcGen environment"),
            "",
            False,
        ),
        (
            ("map shine; blendFunc add; tcGen environment", "map $lightmap; blendFunc filter"),
            "",
            False,
        ),
        (("map shine; tcGen environment",), "", True),
        (("map wall; blendFunc add", "map shine; blendFunc add; tcGen environment"), "", True),
        (("map $lightmap; blendFunc filter",), "", True),
    ],
)
def test_tools_sky_and_reflections_that_lightmaps_dim_are_not_drawn(
    stages: tuple[str, ...], general: str, drawn: bool
) -> None:
    level = replace(open_bsp(), shaders=np.zeros(1, LUMPS["shaders"]))
    assert is_drawn(level, 0, script(*stages, general=general)) is drawn
    assert is_drawn(level, 0, None)
