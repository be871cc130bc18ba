"""Shader script records: what directives mean, and what stands in for wrong arguments."""

import math

import numpy as np
import pytest
from shader_fixtures import parse

from followspot.assets.shader_script import ShaderScript, Stage, lookup_name
from followspot.assets.shader_values import (
    AlphaTest,
    BlendFactor,
    Directive,
    FogParms,
    Sides,
    SkyParms,
    number,
)
from followspot.errors import AssetError


def entry(body: str) -> ShaderScript:
    """The one entry, without problems, that has this body."""
    result = parse(f"x\n{{\n{body}\n}}\n", "a.shader")
    assert result.problems == ()
    (shader,) = result.shaders
    return shader


def stage(body: str) -> Stage:
    """The one stage, without problems, that has this body."""
    (only,) = entry(f"{{\n{body}\n}}").stages
    return only


def wrong(body: str) -> tuple[ShaderScript, AssetError]:
    """The one entry that has this body, and the one problem with it."""
    result = parse(f"x\n{{\n{body}\n}}\n", "a.shader")
    (shader,), (problem,) = result.shaders, result.problems
    return shader, problem


def test_get_gives_the_last_and_all_gives_every_one() -> None:
    shader = entry("cull none\nsurfaceparm a\ncull back\n{\ndepthFunc 1\ndepthFunc 2\n}")
    assert shader.get("cull") == Directive("cull", ("back",), 5)
    assert shader.all("cull") == (Directive("cull", ("none",), 3), Directive("cull", ("back",), 5))
    assert shader.get("cull", "surfaceparm") == shader.get("cull")
    assert shader.get("depthfunc") is None and shader.all("depthfunc") == ()
    assert shader.stages[0].get("depthfunc") == Directive("depthfunc", ("2",), 8)
    assert [item.args for item in shader.stages[0].directives] == [("1",), ("2",)]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("textures/Base/Wall.TGA", "textures/base/wall"),
        ("textures\\base\\wall", "textures/base/wall"),
        ("models/a.b/skin", "models/a.b/skin"),
        ("models/a.b\\skin.jpg", "models/a.b/skin"),
        ("a.b.c", "a.b"),
        ("", ""),
    ],
)
def test_lookup_names_lose_their_ending_as_in_the_engine(name: str, expected: str) -> None:
    assert lookup_name(name) == expected


def test_surfaceparms_add_up() -> None:
    shader = entry("surfaceparm NoMarks\nSurfaceParm sky extra\nsurfaceparm\nsurfaceparm sky")
    assert shader.surfaceparms == {"nomarks", "sky"}


@pytest.mark.parametrize(
    ("line", "sides"),
    [
        ("", Sides.FRONT),
        ("cull front", Sides.FRONT),
        ("cull back", Sides.BACK),
        ("cull backSide", Sides.BACK),
        ("cull backsided", Sides.BACK),
        ("cull none", Sides.BOTH),
        ("CULL TwoSided", Sides.BOTH),
        ("cull disable", Sides.BOTH),
        ("cull none\ncull back", Sides.BACK),
    ],
)
def test_cull(line: str, sides: Sides) -> None:
    assert entry(line).cull is sides


@pytest.mark.parametrize(
    ("line", "sky"),
    [
        ("", None),
        ("skyParms env/Sky 384 env/near", SkyParms("env/Sky", 384.0, "env/near")),
        ("skyparms - - -", SkyParms(None, 512.0, None)),
        ("skyparms full 0 -", SkyParms("full", 512.0, None)),
    ],
)
def test_sky_box(line: str, sky: SkyParms | None) -> None:
    assert entry(line).sky_box == sky


@pytest.mark.parametrize(
    ("line", "fog"),
    [
        ("", None),
        ("fogParms ( 0.5 .25 1 ) 800", FogParms((0.5, 0.25, 1.0), 800.0)),
        ("fogparms (0.5 .25 1) 800 64", FogParms((0.5, 0.25, 1.0), 800.0)),
        ("fogparms 0.5 .25 1 800", FogParms((0.5, 0.25, 1.0), 800.0)),
        ("fogparms ( 255 -1 0 ) 1e3", FogParms((1.0, 0.0, 0.0), 1000.0)),
    ],
)
def test_fog(line: str, fog: FogParms | None) -> None:
    assert entry(line).fog == fog


@pytest.mark.parametrize("name", ["q3map_sun", "q3map_sunExt", "SUN"])
@pytest.mark.parametrize(
    ("yaw", "elevation", "direction"),
    [
        ("0", "0", (1, 0, 0)),
        ("90", "0", (0, 1, 0)),
        ("-90", "0", (0, -1, 0)),
        ("12", "90", (0, 0, 1)),
        ("180", "45", (-math.sqrt(0.5), 0, math.sqrt(0.5))),
    ],
)
def test_the_direction_points_to_the_sun(
    name: str, yaw: str, elevation: str, direction: tuple[float, float, float]
) -> None:
    sun = entry(f"nopicmip\n{name} .5 .25 0 120 {yaw} {elevation} 2 16").sun
    assert sun is not None
    np.testing.assert_allclose(sun.direction_to_sun, direction, atol=1e-15)
    assert sun.color.tolist() == [1.0, 0.5, 0.0]
    assert (sun.intensity, sun.line) == (120.0, 4)


def test_the_last_sun_wins() -> None:
    sun = entry("q3map_sunext 1 1 1 10 0 0 1 1\nq3map_sun 0 0 2 20 0 0").sun
    assert sun is not None
    assert (sun.color.tolist(), sun.intensity, sun.line) == ([0, 0, 1], 20, 4)


def test_a_level_without_a_sun_has_none() -> None:
    assert entry("q3map_surfacelight 100").sun is None


@pytest.mark.parametrize(
    "line",
    ["sort additive", "sort seeThrough", "sort 3.5", "portal", "sort nearest", "sort 0"],
)
def test_places_in_the_drawing_order_are_taken(line: str) -> None:
    assert str(entry(line).directives[0]) == line


def test_polygon_offset() -> None:
    assert entry("sort banner\npolygonOffset").is_polygonoffset
    assert not entry("sort banner").is_polygonoffset


@pytest.mark.parametrize(
    ("line", "images", "clamps"),
    [
        ("", (), False),
        ("map Textures/A.tga", ("Textures/A.tga",), False),
        ("clampMap a b", ("a",), True),
        ("map $LightMap", ("$lightmap",), False),
        ("map $whiteImage", ("$whiteimage",), False),
        ("map *White", ("*white",), False),
        ("animmap 2.5 a b c", ("a", "b", "c"), False),
        ("animMap 1 1 2 3 4 5 6 7 8 9", tuple("12345678"), False),
        ("clampmap a\nmap b", ("b",), False),
        ("videoMap video/intro.roq", (), False),
    ],
)
def test_images(line: str, images: tuple[str, ...], clamps: bool) -> None:
    layer = stage(line)
    assert layer.images == images
    assert layer.image == (images[0] if images else None)
    assert layer.clamps is clamps


@pytest.mark.parametrize(
    ("line", "blend"),
    [
        ("", None),
        ("blendFunc add", ("ONE", "ONE")),
        ("BLENDFUNC Filter", ("DST_COLOR", "ZERO")),
        ("blendfunc blend", ("SRC_ALPHA", "ONE_MINUS_SRC_ALPHA")),
        ("blendfunc gl_zero GL_Src_Color", ("ZERO", "SRC_COLOR")),
        ("blendfunc GL_DST_COLOR GL_ONE\ndepthwrite", ("DST_COLOR", "ONE")),
        ("blendfunc GL_ONE GL_ZERO", None),
        ("blendfunc filter\nblendfunc add", ("ONE", "ONE")),
    ],
)
def test_blending(line: str, blend: tuple[str, str] | None) -> None:
    assert stage(line).blend == (blend and tuple(BlendFactor[name] for name in blend))


def test_every_factor_may_stand_where_the_engine_takes_it() -> None:
    sources = [factor for factor in BlendFactor if "SRC_COLOR" not in factor.name]
    targets = [
        factor
        for factor in BlendFactor
        if "DST_COLOR" not in factor.name and factor.name != "SRC_ALPHA_SATURATE"
    ]
    assert (len(sources), len(targets)) == (9, 8)
    for factor in sources:
        assert stage(f"blendFunc {factor.value} GL_ONE").blend == (factor, BlendFactor.ONE)
    for factor in targets:
        line = f"blendFunc GL_DST_COLOR {factor.value.upper()}"
        assert stage(line).blend == (BlendFactor.DST_COLOR, factor)


@pytest.mark.parametrize("test", AlphaTest)
def test_alpha_tests(test: AlphaTest) -> None:
    assert stage("map a").alpha_test is None
    assert stage(f"alphaFunc {test.name}").alpha_test is test


def test_where_texture_coordinates_come_from() -> None:
    lines = "map $lightmap\nrgbGen Wave Sin 0 1 0 .5\ntcMod scroll 0 1\ntexGen environment"
    assert stage(lines).tc_gen == ("environment",)
    assert stage("map $lightmap").tc_gen == ("lightmap",)
    assert stage("map a").tc_gen == ("texture",)


@pytest.mark.parametrize(
    ("line", "expected", "sides"),
    [
        ("cull sideways", "front, back", Sides.FRONT),
        ("cull none\ncull", "front, back", Sides.FRONT),
    ],
)
def test_a_wrong_cull_draws_the_front(line: str, expected: str, sides: Sides) -> None:
    shader, problem = wrong(line)
    assert shader.cull is sides
    assert problem.expected.startswith(expected) and problem.expected.endswith("after cull")
    assert problem.found == repr(line.splitlines()[-1])
    assert problem.place == f"line {2 + len(line.splitlines())}"


@pytest.mark.parametrize(
    "line",
    [
        "q3map_sun",
        "q3map_sun 1 1 1 100 90",
        "q3map_sun 1 1 x 100 90 45",
        "q3map_sun 0 0 0 100 90 45",
        "q3map_sun 1 1 -1 100 90 45",
        "q3map_sun 1 1 1 1e999 90 45",
        "q3map_sun nan 1 1 1 90 45",
    ],
)
def test_a_wrong_sun_is_none(line: str) -> None:
    shader, problem = wrong(line)
    assert shader.sun is None
    assert problem.found == repr(line)


@pytest.mark.parametrize(
    ("line", "sky"),
    [("skyparms", None), ("skyparms a 512", None), ("skyparms a b -", SkyParms("a", 512.0, None))],
)
def test_a_wrong_sky(line: str, sky: SkyParms | None) -> None:
    assert wrong(line)[0].sky_box == sky


@pytest.mark.parametrize(
    "line",
    [
        "fogparms",
        "fogparms ( 1 1 1 )",
        "fogparms ( 1 x 1 ) 300",
        "fogparms ( 1 1 1 ) 0",
        "fogparms ( 1 1 1 ) -20",
    ],
)
def test_wrong_fog_is_none(line: str) -> None:
    shader, problem = wrong(line)
    assert shader.fog is None
    assert problem.found == repr(line)


@pytest.mark.parametrize("line", ["sort", "sort sideways", "sort blend", "{\nrgbGen rainbow\n}"])
def test_what_is_only_checked_is_a_problem_too(line: str) -> None:
    assert wrong(line)[1].place == ("line 4" if line.startswith("{") else "line 3")


@pytest.mark.parametrize(
    ("line", "blend"),
    [
        ("blendFunc", ("ONE", "ONE")),
        ("blendFunc GL_DST_COLOR", ("DST_COLOR", "ONE")),
        ("blendFunc GL_ADD", ("ONE", "ONE")),
        ("blendFunc multiply GL_ZERO", None),
        ("blendFunc GL_SRC_COLOR GL_SRC_COLOR", ("ONE", "SRC_COLOR")),
        ("blendFunc GL_DST_COLOR GL_DST_COLOR", ("DST_COLOR", "ONE")),
    ],
)
def test_a_wrong_blend_factor_is_one(line: str, blend: tuple[str, str] | None) -> None:
    shader, problem = wrong(f"{{\n{line}\n}}")
    assert shader.stages[0].blend == (blend and tuple(BlendFactor[name] for name in blend))
    assert problem.place == "line 4"


def test_other_wrong_arguments_of_stages_fall_back() -> None:
    assert wrong("{\nalphaFunc GE64\n}")[0].stages[0].alpha_test is None
    assert wrong("{\nmap\n}")[0].stages[0].image is None
    assert wrong("{\nanimMap 10\n}")[0].stages[0].image is None
    assert wrong("{\ntcGen\n}")[0].stages[0].tc_gen == ("texture",)


def test_problems_of_arguments_follow_lost_entries() -> None:
    result = parse("x { cull a\n cull b\n { blendfunc c\n } }\n}", "a.shader")
    assert [problem.place for problem in result.problems] == [
        "line 5",
        "line 1",
        "line 2",
        "line 3",
    ]
    assert [str(item) for item in result.shaders[0].problems] == [
        str(item) for item in result.problems[1:]
    ]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1.0),
        ("-.5", -0.5),
        ("+2.", 2.0),
        ("1e-2x", 0.01),
        ("0.5,", 0.5),
        ("1_0", 1.0),
        ("0x10", 0.0),
        ("", None),
        (".", None),
        ("e5", None),
        ("inf", None),
        ("nan", None),
        ("1e999", None),
    ],
)
def test_numbers_are_read_as_by_atof(text: str, value: float | None) -> None:
    assert number(text) == value
