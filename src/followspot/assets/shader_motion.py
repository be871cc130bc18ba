"""What in a .shader stage follows the time: how its image moves, and waves.

Readers as in `shader_values`. The semantics are those of ioquake3's
``code/renderergl1/tr_shader.c``; what a surface looks like at some time is `scene.motion`'s.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from followspot.assets.shader_values import (
    Directive,
    Reader,
    known_words,
    number,
    read_images,
)

MAX_TC_MODS = 4
"""``tcMod`` lines of a stage that are read; the engine stops the game at a fifth one."""

LARGEST = 1e6
"""A number beyond this is taken for a mistake: whatever comes of four mods stays a finite float."""


class Shape(Enum):
    """One period of a wave, valued by its name in scripts."""

    SIN = "sin"
    TRIANGLE = "triangle"
    """From 0 up to 1, down to -1 and back."""
    SQUARE = "square"
    """1, then -1."""
    SAWTOOTH = "sawtooth"
    """From 0 up to 1."""
    INVERSE_SAWTOOTH = "inversesawtooth"
    """From 1 down to 0."""
    NOISE = "noise"
    """From one random number to the next, -1 to 1; of colours and alpha alone, as in the engine."""


class Wave(NamedTuple):
    """``base + amplitude * shape(phase + frequency * time)``.

    Args:
        shape: What runs with period 1.
        base: What it swings around.
        amplitude: How far.
        phase: In periods.
        frequency: Periods a second.
    """

    shape: Shape
    base: float
    amplitude: float
    phase: float
    frequency: float


@dataclass(frozen=True, slots=True)
class Scroll:
    """What is added to the coordinates in a second, whole numbers taken off."""

    s: float
    t: float


@dataclass(frozen=True, slots=True)
class Scale:
    """Factors of the coordinates."""

    s: float
    t: float


@dataclass(frozen=True, slots=True)
class Rotate:
    """Degrees a second by which an image turns clockwise about its middle."""

    degrees: float


@dataclass(frozen=True, slots=True)
class Stretch:
    """The factor by which an image grows about its middle."""

    wave: Wave


@dataclass(frozen=True, slots=True)
class Transform:
    """``s' = a s + c t + e`` and ``t' = b s + d t + f``."""

    a: float
    b: float
    c: float
    d: float
    e: float
    f: float


@dataclass(frozen=True, slots=True)
class Turbulence:
    """A swaying that runs through space: what a sine wave of this phase adds to coordinates.

    Args:
        amplitude: In coordinates.
        phase: In periods.
        frequency: Periods a second.
    """

    amplitude: float
    phase: float
    frequency: float


TcMod = Scroll | Scale | Rotate | Stretch | Transform | Turbulence

_NOTHING: tuple[TcMod, ...] = (
    Scroll(0, 0),
    Scale(1, 1),
    Rotate(0),
    Transform(1, 0, 0, 1, 0, 0),
)
_WAVES = {shape.value: shape for shape in Shape}
_WAVE = "a known wave with base, amplitude, phase and frequency"
_RGB_GENS = (
    *("wave", "const", "identity", "identitylighting", "lightingdiffuse", "entity"),
    *("oneminusentity", "vertex", "exactvertex", "oneminusvertex"),
)


def read_tc_mod(mod: Directive, wrong: list[str]) -> TcMod | None:
    """``tcMod <kind> <numbers>``; none where nothing moves, as at ``entityTranslate`` in levels.

    Where numbers are missing nothing moves, either; one that cannot be read is 0, as in the engine.
    """
    args = mod.args[1:]
    read: TcMod | None = None
    match mod.word:
        case "scroll":
            if given := read_numbers(args, 2, wrong):
                read = Scroll(*given)
        case "scale":
            if given := read_numbers(args, 2, wrong):
                read = Scale(*given)
        case "rotate":
            if given := read_numbers(args, 1, wrong):
                read = Rotate(*given)
        case "transform":
            if given := read_numbers(args, 6, wrong):
                read = Transform(*given)
        case "turb":  # its base is read by the engine, and never used
            if given := read_numbers(args, 4, wrong):
                read = Turbulence(*given[1:])
        case "stretch":
            if wave := read_wave(args, wrong):
                read = Stretch(wave)
        case "entitytranslate":
            pass
        case _:
            wrong.append("scroll, scale, rotate, stretch, transform, turb or entityTranslate")
    still = read in _NOTHING or (isinstance(read, Turbulence) and read.amplitude == 0)
    return None if still else read


def read_wave(args: Sequence[str], wrong: list[str], *, may_be_noise: bool = False) -> Wave | None:
    """A wave's name and four numbers; none where that is not what is there."""
    shape = _WAVES.get(args[0].lower() if args else "")
    if shape is None:
        wrong.append(_WAVE)
        return None
    if shape is Shape.NOISE and not may_be_noise:
        return None
    given = read_numbers(args[1:], 4, wrong)
    return None if given is None else Wave(shape, *given)


def read_color_wave(rgb_gen: Directive, wrong: list[str]) -> Wave | None:
    """``rgbGen wave <wave>``; none for other colours."""
    known_words(rgb_gen, _RGB_GENS, wrong)
    return _wave_after(rgb_gen, wrong)


def read_color(rgb_gen: Directive, wrong: list[str]) -> tuple[float, float, float] | None:
    """``rgbGen const ( <red> <green> <blue> )``, from 0 to 1 as displayed; none for others."""
    words = [word for word in rgb_gen.args if word not in ("(", ")")]
    if not words or words[0].lower() != "const":
        return None
    given = [number(word.strip("()")) for word in words[1:4]]
    if len(given) < 3 or None in given:
        wrong.append("red, green and blue in parentheses")
        return None
    red, green, blue = (min(max(value or 0.0, 0.0), 1.0) for value in given)
    return red, green, blue


def read_rgb_gen(rgb_gen: Directive, wrong: list[str]) -> None:
    """All that an ``rgbGen`` may be."""
    read_color_wave(rgb_gen, wrong)
    read_color(rgb_gen, wrong)


def read_alpha_wave(alpha_gen: Directive, wrong: list[str]) -> Wave | None:
    """``alphaGen wave <wave>``, likewise."""
    return _wave_after(alpha_gen, wrong)


def read_frame_rate(anim_map: Directive, wrong: list[str]) -> float:
    """Images a second of an ``animMap``, whose images `read_images` reads."""
    given = read_numbers(anim_map.args, 1, wrong)
    return given[0] if given else 0.0


def check_anim_map(anim_map: Directive, wrong: list[str]) -> None:
    """All of an ``animMap``."""
    if read_images(anim_map, wrong):
        read_frame_rate(anim_map, wrong)


def _wave_after(directive: Directive, wrong: list[str]) -> Wave | None:
    if directive.word != "wave":
        return None
    return read_wave(directive.args[1:], wrong, may_be_noise=True)


def read_numbers(args: Sequence[str], count: int, wrong: list[str]) -> list[float] | None:
    """The first arguments as numbers, 0 for what is none; none at all where some are missing."""
    read = [number(word) for word in args[:count]]
    usable = [x if x is not None and abs(x) <= LARGEST else None for x in read]
    if len(read) < count or None in usable:
        wrong.append(f"{count} numbers, none beyond {LARGEST:,.0f},")
    return None if len(read) < count else [x or 0.0 for x in usable]


MOTION_READERS: dict[str, Reader] = {
    "tcmod": read_tc_mod,
    "animmap": check_anim_map,
    "rgbgen": read_rgb_gen,
    "alphagen": read_alpha_wave,
}
"""Readers of those directives inside stages whose arguments are checked."""
