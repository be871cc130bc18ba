"""What ``deformVertexes`` means, and what stands in for wrong arguments."""

import pytest
from shader_fixtures import parse

from followspot.assets.shader_deform import Deform, Move, Sprite, Swell
from followspot.assets.shader_motion import Shape, Wave
from followspot.assets.shader_script import ShaderScript
from followspot.errors import AssetError


def read(body: str) -> tuple[ShaderScript, tuple[AssetError, ...]]:
    """The one entry that has this body, and what is wrong with it."""
    result = parse(f"x\n{{\n{body}\n}}\n", "a.shader")
    return result.shaders[0], result.problems


@pytest.mark.parametrize(
    ("line", "deforms"),
    [
        ("deformVertexes autosprite", (Sprite.WHOLE,)),
        ("DeformVertexes AutoSprite2", (Sprite.PIVOT,)),
        ("deformVertexes wave 64 sin .5 2 0 3", (Swell(1 / 64, Wave(Shape.SIN, 0.5, 2, 0, 3)),)),
        # One that stands still has the same phase everywhere, as in the engine.
        ("deformVertexes wave 64 sin 3 0 0 0", (Swell(0, Wave(Shape.SIN, 3, 0, 0, 0)),)),
        (
            "deformVertexes move 1 2 3 sawtooth 0 1 .25 .5\ndeformVertexes autosprite",
            (Move((1, 2, 3), Wave(Shape.SAWTOOTH, 0, 1, 0.25, 0.5)), Sprite.WHOLE),
        ),
        ("deformVertexes bulge 4 2 0.75\ndeformVertexes text0", ()),
    ],
)
def test_deformations(line: str, deforms: tuple[Deform, ...]) -> None:
    shader, problems = read(line)
    assert shader.deforms == deforms
    assert problems == ()


@pytest.mark.parametrize(
    "line",
    [
        "deformvertexes",
        "deformvertexes melt 1",
        "deformvertexes wave 64 sin 1 2 3",
        "deformvertexes wave",
        "deformvertexes wave 0 sin 1 2 3 4",
        "deformvertexes wave 1e-40 sin 1 2 3 4",
        "deformvertexes move 1 2 sin 0 1 0 1",
        "deformvertexes move 1 2 3 wobble 0 1 0 1",
    ],
)
def test_a_wrong_one_is_told_and_leaves_everything_in_its_place(line: str) -> None:
    shader, problems = read(line)
    assert not any(isinstance(each, Swell) for each in shader.deforms)
    assert {(each.place, each.found) for each in problems} == {("line 3", repr(line))}
