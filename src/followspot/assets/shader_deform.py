"""What ``deformVertexes`` in a .shader entry means: how vertices move as time goes by.

Readers as in `shader_values`. The semantics are those of ioquake3's
``code/renderergl1/tr_shader.c``; `scene.deform` makes meshes and numbers of them.
"""

from enum import Enum
from typing import NamedTuple

from followspot.assets.shader_motion import Wave, read_numbers, read_wave
from followspot.assets.shader_values import Directive, Reader


class Swell(NamedTuple):
    """A wave along the normals, whose phase runs through space.

    Args:
        spread: Periods a unit of x + y + z.
        wave: In units.
    """

    spread: float
    wave: Wave


class Move(NamedTuple):
    """All of a surface moves by a vector times a wave.

    Args:
        by: World units.
        wave: Without unit.
    """

    by: tuple[float, float, float]
    wave: Wave


class Sprite(Enum):
    """Rectangles that turn to the camera, valued by their names in scripts."""

    WHOLE = "autosprite"
    """Squares in the picture's plane."""
    PIVOT = "autosprite2"
    """About their long axis only."""


Deform = Swell | Move | Sprite

SHORTEST = 1e-6
"""Units that a wave is long at least: so many periods of it in a unit stay a finite float."""

_SPRITES = {sprite.value: sprite for sprite in Sprite}
_LEFT_OUT = ("bulge", "normal", "projectionshadow", *(f"text{k}" for k in range(8)))


def read_deform(deform: Directive, wrong: list[str]) -> Deform | None:
    """``deformVertexes <kind> <numbers>``; none for kinds that are left out here."""
    args = deform.args[1:]
    if deform.word in _SPRITES:
        return _SPRITES[deform.word]
    if deform.word == "wave":
        if (given := read_numbers(args, 1, wrong)) and (wave := read_wave(args[1:], wrong)):
            if abs(given[0]) < SHORTEST:
                wrong.append(f"a length of {SHORTEST:g} or more")
                return None
            return Swell(1 / given[0] if wave.frequency else 0.0, wave)
    elif deform.word == "move":
        if (given := read_numbers(args, 3, wrong)) and (wave := read_wave(args[3:], wrong)):
            x, y, z = given
            return Move((x, y, z), wave)
    elif deform.word not in _LEFT_OUT:
        wrong.append("wave, move, autosprite, autosprite2, bulge, normal, text or projectionShadow")
    return None


DEFORM_READERS: dict[str, Reader] = {"deformvertexes": read_deform}
"""Readers of those directives outside stages whose arguments are checked."""
