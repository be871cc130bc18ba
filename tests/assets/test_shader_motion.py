"""What of a stage follows the time: typed values, and what stands in for wrong arguments."""

import pytest
from shader_fixtures import parse

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
from followspot.assets.shader_script import Stage
from followspot.errors import AssetError


def read(body: str) -> tuple[Stage, tuple[AssetError, ...]]:
    """The one stage that has this body, and what is wrong with it."""
    result = parse(f"x\n{{\n{{\n{body}\n}}\n}}\n", "a.shader")
    return result.shaders[0].stages[0], result.problems


@pytest.mark.parametrize(
    ("line", "mods"),
    [
        ("tcMod scroll .5 -1", (Scroll(0.5, -1),)),
        ("tcmod Scale 7 2", (Scale(7, 2),)),
        ("tcMod rotate 30", (Rotate(30),)),
        ("tcMod transform 1 2 3 4 5 6", (Transform(1, 2, 3, 4, 5, 6),)),
        ("tcMod turb 9 .5 .25 2", (Turbulence(0.5, 0.25, 2),)),
        ("tcMod stretch Triangle 1 .2 0 3", (Stretch(Wave(Shape.TRIANGLE, 1, 0.2, 0, 3)),)),
        ("tcMod scale 2 2\ntcMod scroll 0 1\ntcMod scale 3 3",
         (Scale(2, 2), Scroll(0, 1), Scale(3, 3))),
        # What moves nothing is left out.
        ("tcMod scroll 0 0\ntcMod scale 1 1\ntcMod rotate 0", ()),
        ("tcMod turb 1 0 1 1\ntcMod transform 1 0 0 1 0 0\ntcMod entityTranslate", ()),
        # Equal numbers are not equal mods; noise is left out.
        ("tcMod scroll 1 1\ntcMod scale 0 0\ntcMod stretch noise 1 2 3 4",
         (Scroll(1, 1), Scale(0, 0))),
        # No more than four are read.
        ("tcMod scale 2 2\n" * 5, (Scale(2, 2),) * 4),
    ],
)  # fmt: skip
def test_texture_coordinate_changes(line: str, mods: tuple[TcMod, ...]) -> None:
    stage, problems = read(line)
    assert stage.tc_mods == mods
    assert problems == ()


@pytest.mark.parametrize("shape", Shape)
def test_waves_of_color_and_alpha(shape: Shape) -> None:
    name = shape.value.upper()
    stage, problems = read(f"rgbGen wave {name} 1 2 3 4\nalphaGen Wave {name} 5 6 7 8")
    assert stage.color_wave == Wave(shape, 1, 2, 3, 4)
    assert stage.alpha_wave == Wave(shape, 5, 6, 7, 8)
    assert problems == ()


def test_what_does_not_follow_the_time_has_no_wave() -> None:
    stage, problems = read("rgbGen identity\nalphaGen vertex\nanimMap 2.5 a b\nmap c")
    assert (stage.color_wave, stage.alpha_wave, stage.frame_rate) == (None, None, 0)
    assert problems == ()
    assert read("animMap 2.5 a b")[0].frame_rate == 2.5


@pytest.mark.parametrize(
    ("line", "mods"),
    [
        ("tcmod", ()),
        ("tcmod wobble 1 2", ()),
        ("tcmod scroll", ()),
        ("tcmod scroll 1", ()),
        ("tcmod transform 1 2 3 4 5", ()),
        ("tcmod stretch sin 1 2 3", ()),
        ("tcmod turb 1 2 3", ()),
        ("tcmod scroll x 1", (Scroll(0, 1),)),
        ("tcmod scale 1e999 2", (Scale(0, 2),)),
        ("tcmod rotate 1e7", ()),
        ("tcmod turb sin 0 1 0 1", ()),
    ],
)
def test_a_wrong_change_is_told_and_moves_what_the_engine_would(
    line: str, mods: tuple[TcMod, ...]
) -> None:
    stage, (problem,) = read(line)
    assert stage.tc_mods == mods
    assert (problem.place, problem.found) == ("line 4", repr(line))
    assert problem.expected.endswith("after tcmod")


@pytest.mark.parametrize(
    ("line", "color"),
    [
        ("rgbGen const ( 1 0 .5 )", (1, 0, 0.5)),
        ("rgbgen Const (1 2 -1)", (1, 1, 0)),
        ("rgbGen identity", None),
        ("rgbGen wave sin 0 1 0 1", None),
    ],
)
def test_constant_colours(line: str, color: tuple[float, ...] | None) -> None:
    stage, problems = read(line)
    assert (stage.color, problems) == (color, ())


@pytest.mark.parametrize("line", ["rgbGen const", "rgbGen const ( 1 0 )", "rgbGen const ( a b c )"])
def test_wrong_colours_are_told(line: str) -> None:
    stage, (problem,) = read(line)
    assert stage.color is None
    assert problem.expected == "red, green and blue in parentheses after rgbgen"


@pytest.mark.parametrize(
    "line",
    ["rgbgen wave", "rgbgen wave zigzag 0 1 0 1", "alphagen wave sin 0 1", "animmap fast a b"],
)
def test_wrong_waves_and_rates_are_told(line: str) -> None:
    stage, (problem,) = read(line)
    assert (stage.color_wave, stage.alpha_wave, stage.frame_rate) == (None, None, 0)
    assert problem.found == repr(line)
