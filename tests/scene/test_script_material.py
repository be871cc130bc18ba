from dataclasses import replace

import numpy as np
import pytest

from followspot.assets.bsp import LUMPS
from followspot.assets.shader_motion import Rotate, Scale, Scroll, Shape, Wave
from followspot.assets.shader_parser import find_entries
from followspot.assets.shader_script import ShaderScript
from followspot.assets.shader_values import AlphaTest, Sides
from followspot.assets.shader_values import BlendFactor as Factor
from followspot.scene.material import ByVertex, Laid, Layer, Material, Shade
from followspot.scene.motion import Motion
from followspot.scene.script_material import from_script, is_drawn
from synthetic import open_bsp

WALL = Material("s", "wall")
LIGHT = "map $lightmap; blendFunc filter"
SHEEN = Layer("env", Laid.SHEEN, mirrors=True)
ROUGH = Layer("rock", Laid.GRAIN, motion=Motion((Scale(8, 8),)))
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
        ("map wall", LIGHT),
        ("map $lightmap", "map wall; blendFunc GL_DST_COLOR GL_SRC_COLOR"),
        ("map wall", "map env; tcGen environment; blendFunc blend", LIGHT),
        ("map wall; tcMod scroll 0 0; tcMod scale 1 1", LIGHT),
        ("map wall; rgbGen vertex",),
        ("map wall; rgbGen lightingDiffuse", "map rock; blendFunc GL_ONE GL_SRC_ALPHA"),
    ],
)
def test_the_base_image_is_the_surface(stages: tuple[str, ...]) -> None:
    assert made(*stages) == WALL


GRAIN = "map rock; blendFunc GL_DST_COLOR GL_SRC_COLOR; tcMod scale 8 8"
GLOW = "map glow; blendFunc add"
MIRROR = "map env; tcGen environment"
AGAIN = "map wall; blendFunc add"


@pytest.mark.parametrize(
    ("stages", "layer"),
    [
        (("map wall", LIGHT, GLOW), Layer("glow", Laid.GLOW)),
        (("map $lightmap", "map wall; blendFunc filter", GLOW), Layer("glow", Laid.GLOW)),
        (("map wall; rgbGen vertex", GLOW), Layer("glow", Laid.GLOW)),
        (("map wall", GLOW, LIGHT), Layer("glow", Laid.SHEEN)),
        (("map wall", f"{MIRROR}; blendFunc add", LIGHT), SHEEN),
        (("map wall; rgbGen vertex", f"{MIRROR}; blendFunc add"), SHEEN),
        (("map wall", MIRROR, AGAIN, LIGHT), SHEEN),
        ((MIRROR, AGAIN, LIGHT), SHEEN),
        (
            ("map wall", f"{MIRROR}; rgbGen vertex", AGAIN, LIGHT),
            replace(SHEEN, by_vertex=ByVertex.BRIGHTENS),
        ),
        (
            ("map wall", f"{MIRROR}; rgbGen oneMinusVertex; tcMod scale 2 2", AGAIN, LIGHT),
            replace(SHEEN, by_vertex=ByVertex.DIMS, motion=Motion((Scale(2, 2),))),
        ),
        (
            ("map wall", f"clamp{MIRROR}; rgbGen const ( 0.5 1 0 ); blendFunc add", LIGHT),
            replace(SHEEN, clamps=True, color=(0.5**2.2, 1, 0)),
        ),
        (("map wall", LIGHT, GRAIN), Layer("rock", Laid.GRAIN, motion=Motion((Scale(8, 8),)))),
        (("map $lightmap", GRAIN, "map wall; blendFunc filter"), ROUGH),
        (("map wall", "map rock; blendFunc filter", LIGHT), Layer("rock", Laid.FILTER)),
        (
            ("map wall", "map rock; blendFunc GL_ZERO GL_SRC_COLOR", LIGHT),
            Layer("rock", Laid.FILTER),
        ),
        (("map wall", LIGHT, GRAIN, GLOW), Layer("glow", Laid.GLOW)),
        (("map wall", GRAIN, f"{MIRROR}; blendFunc add", LIGHT), SHEEN),
        (("map wall", GLOW, "map rock; blendFunc blend", LIGHT), Layer("rock")),
    ],
)
def test_what_is_laid_on_the_base(stages: tuple[str, ...], layer: Layer) -> None:
    assert made(*stages) == replace(WALL, layer=layer)


def test_what_the_game_does_not_light_shines_by_itself() -> None:
    lava = replace(WALL, shade=Shade.EMISSIVE)
    assert made("map wall") == made("map wall; rgbGen identity") == lava
    assert lava.shines and not WALL.shines
    assert made("map wall", GLOW) == replace(lava, layer=Layer("glow", Laid.GLOW))
    assert made("map wall; alphaFunc GE128", GLOW) == replace(lava, alpha_test=AlphaTest.GE128)
    assert made(MIRROR).shade is Shade.LIT


def test_what_shines_pulses() -> None:
    wave = Wave(Shape.NOISE, 0.8, 0.2, 0, 1)
    pulses = "rgbGen wave noise 0.8 0.2 0 1"
    assert made(f"map wall; {pulses}").motion == Motion(color=wave)
    lamp = made("map wall", LIGHT, f"{GLOW}; {pulses}")
    assert lamp.layer == Layer("glow", Laid.GLOW, motion=Motion(color=wave))
    assert lamp.shines and lamp.moves
    assert made(f"map wall; {pulses}", LIGHT) == WALL


def test_a_pulse_and_a_colour_make_one_factor() -> None:
    wave = Wave(Shape.SQUARE, 0.5, 0.25, 0, 1)
    layer = Layer("a", Laid.GLOW, color=(0.5, 1, 0), motion=Motion(color=wave))
    assert layer.color_at(0) == pytest.approx([0.5 * 0.75**2.2, 0.75**2.2, 0])
    assert Layer("a").color_at(3) == (1, 1, 1)


def test_what_glows_twice_is_painted_twice_as_bright() -> None:
    lava = replace(WALL, shade=Shade.EMISSIVE)
    half = "map glow; blendFunc add; rgbGen const ( 0.5 0.5 0.5 )"
    twice = made("map wall", f"{half}; tcMod rotate 9", half, "map glow; blendFunc filter")
    moving = Motion((Rotate(9),))
    once = Layer("glow", Laid.GLOW, motion=moving, color=(1.0, 1.0, 1.0))
    assert twice.layer is not None and twice.layer.color == pytest.approx(once.color)
    assert replace(twice, layer=replace(twice.layer, color=once.color)) == replace(lava, layer=once)


def test_two_that_only_add_are_both_drawn_unless_they_fade_into_one_another() -> None:
    turned = "map wall; blendFunc add; tcMod rotate 9"
    flare = replace(WALL, blend=ADDS, shade=Shade.EMISSIVE)
    both = replace(flare, layer=Layer("wall", Laid.GLOW, motion=Motion((Rotate(9),))))
    assert made(AGAIN, turned) == both
    assert made(AGAIN, f"{MIRROR}; blendFunc add") == flare
    glass = made("map wall; blendFunc GL_ONE GL_ONE_MINUS_SRC_ALPHA", LIGHT, GLOW)
    through = Factor.ONE, Factor.ONE_MINUS_SRC_ALPHA
    assert glass == replace(WALL, blend=through, layer=Layer("glow", Laid.GLOW))
    assert made("map wall; blendFunc blend", LIGHT, GLOW) == replace(WALL, blend=MIXES)
    flame = replace(flare, motion=Motion(frames=("wall", "b"), rate=9))
    fading = "animMap 9 wall b; blendFunc add", "animMap 9 b wall; blendFunc add"
    assert made(*fading) == flame
    assert made(*fading, turned) == replace(flame, layer=both.layer)
    by_alpha = [stage.replace("add", "GL_SRC_ALPHA GL_ONE") for stage in fading]
    weighted = replace(flame, blend=(Factor.SRC_ALPHA, Factor.ONE))
    assert made(*by_alpha, turned) == replace(weighted, layer=both.layer)


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


def test_water_ripples_twice() -> None:
    """Of several images that brighten what is behind, two are drawn."""
    stages = [f"map {name}; blendFunc GL_DST_COLOR GL_ONE" for name in ("wall", "rock", "b")]
    water = replace(WALL, blend=BRIGHTENS, shade=Shade.FILTER)
    assert made(*stages, LIGHT) == replace(water, layer=Layer("rock", Laid.FILTER))


def test_flames_are_not_lit_but_water_is() -> None:
    """What covers things and is in no lightmap shines, unless a stage of it is lit."""
    nowhere = "surfaceparm nolightmap"
    flame = replace(WALL, blend=MIXES, shade=Shade.EMISSIVE)
    assert made("map wall; blendFunc blend", general=nowhere) == flame
    lit = replace(flame, shade=Shade.LIT)
    assert made("map wall; blendFunc blend; rgbGen vertex", general=nowhere) == lit
    assert made("map wall; blendFunc blend", general=f"{nowhere}\nsurfaceparm water") == lit


@pytest.mark.parametrize(
    "stages",
    [
        ("map wall", LIGHT, "map lamps; blendFunc blend"),
        ("map wall", "map lamps; blendFunc blend", LIGHT),
        ("map wall", LIGHT, "map glow; blendFunc add", "map lamps; blendFunc blend"),
        ("map wall", f"{MIRROR}; blendFunc blend", "map lamps; blendFunc blend", LIGHT),
        ("map wall", "map $lightmap; blendFunc blend", "map lamps; blendFunc blend"),
        (
            "map wall",
            LIGHT,
            "map lamps; blendFunc blend; alphaGen identity",
            "map sign; blendFunc blend",
        ),
    ],
)
def test_an_image_lies_over_another(stages: tuple[str, ...]) -> None:
    assert made(*stages) == replace(WALL, layer=Layer("lamps"))


@pytest.mark.parametrize(
    "before", [(), ("map $lightmap",), ("map wood",), ("map wood", "map glow; blendFunc add")]
)
def test_metal_mirrors_below_what_lies_over_it(before: tuple[str, ...]) -> None:
    metal = replace(WALL, image="env", mirrors=True)
    assert made(*before, MIRROR, "map wall; blendFunc blend") == replace(metal, layer=Layer("wall"))


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
    assert made(first, "map shine; tcGen environment; blendFunc blend") == moving
    shine = replace(SHEEN, image="shine")
    both = made(first, "map shine; tcGen environment; blendFunc add")
    assert both == replace(moving, layer=shine)


def test_vertices_alpha_lays_an_image_over_terrain() -> None:
    rock = "map rock; blendFunc blend; alphaGen vertex"
    assert made("map wall", rock, LIGHT) == replace(WALL, layer=Layer("rock", fades=True))
    assert made("map wall", rock.replace("vertex", "wave sin 0 1 0 1"), LIGHT) == WALL
    assert made("map wall; blendFunc add", rock).layer is None
    cut_out = made("map wall; alphaFunc GE128", rock, LIGHT)
    assert cut_out == replace(WALL, alpha_test=AlphaTest.GE128)
    missing = from_script("s", script("map wall", rock, LIGHT), {"wall": "wall"}.get)
    assert missing == WALL


def test_base_and_layer_move_each_by_its_own_directives() -> None:
    base = "map wall; tcMod rotate 10; tcMod scroll 0 1"
    layer = "animMap 4 a b c; blendFunc blend; alphaFunc GE128; tcMod scale 7 7"
    material = made(base, layer, LIGHT)
    assert material == replace(
        WALL,
        layer=Layer(
            "a",
            alpha_test=AlphaTest.GE128,
            motion=Motion((Scale(7, 7),), frames=("a", "b", "c"), rate=4),
        ),
        motion=Motion((Rotate(10), Scroll(0, 1))),
    )
    assert material.images == ("wall", "a", "b", "c")
    assert material.moves and not WALL.moves


def test_images_that_are_not_there_are_left_out_of_an_animation() -> None:
    def found(stage: str, *names: str) -> Material:
        return from_script("s", script(stage, LIGHT), {name: name for name in names}.get)

    flame = found("animMap 10 a b c", "a", "c")
    assert (flame.image, flame.motion.frames) == ("a", ("a", "a", "c"))
    assert found("animMap 10 a b c", "b") == Material("s")
    for still in ("animMap 10 a", "animMap 0 a b", "map a b"):
        assert found(still, "a", "b") == Material("s", "a")


def test_a_constant_colour_is_the_base_images() -> None:
    """In linear light; where vertices tell how far a layer covers, it keeps its own colours."""
    assert made("map wall; rgbGen const ( 1 0.5 0 )", LIGHT).color == (1, 0.5**2.2, 0)
    assert made("map wall; rgbGen const ( 1 1 1 )", LIGHT) == WALL
    red = "map wall; rgbGen const ( 1 0 0 )"
    layered = made(red, LIGHT, "map b; blendFunc blend")
    assert layered == replace(WALL, layer=Layer("b"), color=(1.0, 0.0, 0.0))
    terrain = made(red, LIGHT, "map b; blendFunc blend; alphaGen vertex")
    assert terrain == replace(WALL, layer=Layer("b", fades=True))


def test_what_is_blended_pulses_unless_its_images_follow_each_other() -> None:
    wave = "rgbGen wave sin .5 .5 0 2; alphaGen wave square 0 1 .5 1"
    color, alpha = Wave(Shape.SIN, 0.5, 0.5, 0, 2), Wave(Shape.SQUARE, 0, 1, 0.5, 1)
    assert made(f"map wall; blendFunc add; {wave}").motion == Motion(color=color, alpha=alpha)
    assert made(f"map wall; {wave}", LIGHT) == WALL
    assert made("map wall", f"map lamps; blendFunc blend; {wave}", LIGHT) == WALL
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
    assert made("map leaf; alphaFunc GE128", LIGHT) == leaf
    assert made("map leaf; alphaFunc GE128; blendFunc blend", LIGHT) == leaf
    assert made("map leaf; alphaFunc GE128; blendFunc filter", "map $lightmap") == leaf
    assert made("map $lightmap; alphaFunc GE128", "map leaf; blendFunc filter") == leaf


def test_a_cut_out_stain_dims_what_is_below() -> None:
    stain = made("map stain; alphaFunc GT0; blendFunc filter", "map glow; blendFunc add")
    assert (stain.blend, stain.shade, stain.alpha_test) == (FILTERS, Shade.FILTER, AlphaTest.GT0)
    assert stain.layer is None


def test_stages_that_are_painted_over_do_not_count() -> None:
    hole = "map wall; blendFunc blend"
    found = made("map wall", "map slime; tcMod scroll 0 1", hole, LIGHT)
    assert (found.image, found.shade) == ("slime", Shade.LIT) and found.layer is not None
    assert (found.layer.image, found.layer.laid) == ("wall", Laid.OVER)
    # A reflection takes part, whatever it is laid on.
    shiny = made("map wall", "map room; tcGen environment", "map wall; blendFunc add", LIGHT)
    assert shiny.image == "wall" and shiny.layer is not None and shiny.layer.laid is Laid.SHEEN
    assert made("map wall", "map leaf; alphaFunc GE128", LIGHT).image == "wall"


def test_a_cut_out_decal_that_brightens_what_is_below_stays_one() -> None:
    decal = made("map leaf; alphaFunc GE128; blendFunc GL_DST_COLOR GL_ONE")
    assert decal == Material("s", "leaf", Sides.FRONT, AlphaTest.GE128, BRIGHTENS, Shade.FILTER)


def test_what_a_script_says_of_the_whole_surface() -> None:
    assert made("clampMap wall", LIGHT, general="cull none") == replace(
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
