"""What the arguments of a .shader directive mean: the engine's words as typed values.

A reader takes a directive and a list ``wrong``; it returns the value that the engine would
use and, where the arguments are not what the engine knows, appends what it expected. So a
renderer can pass a throw-away list and never fail, and the same readers find the problems
of a whole file. A ``check_`` function is one whose value nothing here asks for. The semantics are
those of ioquake3's ``code/renderergl1/tr_shader.c``, unless a docstring names another source.
"""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from followspot.spaces import Vec3, forward_from_angles, vec3


@dataclass(frozen=True, slots=True)
class Directive:
    """One line of a script: ``tcMod scroll 0 1`` is name ``tcmod``, args ``("scroll", "0", "1")``.

    Args:
        name: The first word, lower case.
        args: The rest of the line as written, quotes and comments taken off.
        line: Line in the file, the first is 1.
    """

    name: str
    args: tuple[str, ...]
    line: int

    def __str__(self) -> str:
        return " ".join((self.name, *self.args))

    @property
    def word(self) -> str:
        """The first argument in lower case, empty where there is none."""
        return self.args[0].lower() if self.args else ""


class Sides(Enum):
    """Which sides of a polygon are drawn. The front is where its corners run clockwise."""

    FRONT = "front"
    BACK = "back"
    BOTH = "both"


class BlendFactor(Enum):
    """A factor of ``source * src + target * dst``, valued by its OpenGL name in lower case."""

    ONE = "gl_one"
    ZERO = "gl_zero"
    SRC_COLOR = "gl_src_color"
    ONE_MINUS_SRC_COLOR = "gl_one_minus_src_color"
    DST_COLOR = "gl_dst_color"
    ONE_MINUS_DST_COLOR = "gl_one_minus_dst_color"
    SRC_ALPHA = "gl_src_alpha"
    ONE_MINUS_SRC_ALPHA = "gl_one_minus_src_alpha"
    DST_ALPHA = "gl_dst_alpha"
    ONE_MINUS_DST_ALPHA = "gl_one_minus_dst_alpha"
    SRC_ALPHA_SATURATE = "gl_src_alpha_saturate"


class FogParms(NamedTuple):
    """What fills a volume.

    Args:
        color: As displayed, each 0 to 1.
        depth: Units through which nothing is to be seen any more.
    """

    color: tuple[float, float, float]
    depth: float


class AlphaTest(Enum):
    """Which texels are drawn: alpha above 0, below one half, or from one half up."""

    GT0 = "gt0"
    LT128 = "lt128"
    GE128 = "ge128"


class SkyParms(NamedTuple):
    """A sky's two boxes and the clouds between them.

    Args:
        far: Image base of the box behind the clouds (``_rt``, ``_up``, ... follow), or None.
        cloud_height: Height of the cloud layer above the eye, in units.
        near: Image base of the box before the clouds, or None.
    """

    far: str | None
    cloud_height: float
    near: str | None


@dataclass(frozen=True, slots=True, eq=False)
class Sun:
    """The light of a sky.

    Args:
        color: (3,) float64, not below 0, the largest channel is 1, as in NetRadiant's q3map2
            (``shaders.cpp``). Older q3map2 and the engine scale to unit length instead, which
            makes a white sun dimmer by the square root of 3.
        intensity: The level compiler's brightness, without unit; 100 is a fairly bright sun.
        direction_to_sun: (3,) float64 unit vector in world space.
        line: Line of the directive in its file.
    """

    color: Vec3
    intensity: float
    direction_to_sun: Vec3
    line: int


MAX_FRAMES = 8
"""Frames of an ``animMap`` that the engine reads; it ignores the rest."""

DEFAULT_CLOUD_HEIGHT = 512.0
"""In units; the engine's value where ``skyParms`` says ``-`` or 0."""

_SIDES = {
    "front": Sides.FRONT,
    "back": Sides.BACK,
    "backside": Sides.BACK,
    "backsided": Sides.BACK,
    "none": Sides.BOTH,
    "twosided": Sides.BOTH,
    "disable": Sides.BOTH,
}
_SORTS = (
    *("portal", "sky", "opaque", "decal", "seethrough", "banner", "underwater"),
    *("additive", "nearest"),
)
_BLENDS = {
    "add": (BlendFactor.ONE, BlendFactor.ONE),
    "filter": (BlendFactor.DST_COLOR, BlendFactor.ZERO),
    "blend": (BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA),
}
_NOT_SOURCES = {BlendFactor.SRC_COLOR, BlendFactor.ONE_MINUS_SRC_COLOR}
_NOT_TARGETS = {
    BlendFactor.DST_COLOR,
    BlendFactor.ONE_MINUS_DST_COLOR,
    BlendFactor.SRC_ALPHA_SATURATE,
}
_SOURCES = {factor.value: factor for factor in BlendFactor if factor not in _NOT_SOURCES}
_TARGETS = {factor.value: factor for factor in BlendFactor if factor not in _NOT_TARGETS}
_TC_GENS = ("environment", "lightmap", "texture", "base", "vector")

_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


def number(text: str) -> float | None:
    """Read the number that `text` begins with, as C's ``atof``; None without a finite one."""
    match = _NUMBER.match(text)
    value = float(match.group()) if match else math.nan
    return value if math.isfinite(value) else None


def read_cull(cull: Directive, wrong: list[str]) -> Sides:
    """Quake names the side drawn: ``back`` draws only the back. Default: the front."""
    if cull.word not in _SIDES:
        wrong.append("front, back, backside, backsided, none, twosided or disable")
    return _SIDES.get(cull.word, Sides.FRONT)


def check_sort(sort: Directive, wrong: list[str]) -> None:
    """``sort``, whose place in the drawing order nothing here asks for."""
    if sort.word not in _SORTS and number(sort.word) is None:
        wrong.append("a number or a known place in the drawing order")


def read_sky_parms(sky: Directive, wrong: list[str]) -> SkyParms | None:
    """``skyParms <far> <cloud height> <near>``, no sky unless it has all three; ``-`` is none."""
    if len(sky.args) < 3:
        wrong.append("a far box, a cloud height and a near box")
        return None
    far, height, near = sky.args[:3]
    cloud_height = number(height)
    if cloud_height is None and height != "-":
        wrong.append("a cloud height that is a number or -")
    return SkyParms(
        None if far == "-" else far,
        cloud_height or DEFAULT_CLOUD_HEIGHT,
        None if near == "-" else near,
    )


def read_sun(sun: Directive, wrong: list[str]) -> Sun | None:
    """``q3map_sun <red> <green> <blue> <intensity> <yaw> <elevation>``, angles in degrees.

    Yaw 0 is a sun in the east (+X), 90 in the north (+Y); elevation 90 is noon. The deviance
    and samples that follow in ``q3map_sunExt`` are the level compiler's own business.
    """
    numbers = [value for value in map(number, sun.args[:6]) if value is not None]
    if len(numbers) < 6 or min(numbers[:3]) < 0 or max(numbers[:3]) == 0:
        wrong.append("red, green, blue (not below 0, one above), intensity, yaw and elevation")
        return None
    color = vec3(numbers[:3])
    intensity, yaw, elevation = numbers[3:]
    return Sun(
        color=vec3(color / color.max()),
        intensity=intensity,
        direction_to_sun=forward_from_angles(yaw, -elevation),
        line=sun.line,
    )


def read_fog_parms(fog: Directive, wrong: list[str]) -> FogParms | None:
    """``fogParms ( <red> <green> <blue> ) <depth>``; values are bounded as displays bound them.

    The parentheses may touch their neighbours.
    """
    words = " ".join(fog.args).replace("(", " ").replace(")", " ").split()
    numbers = [value for value in map(number, words[:4]) if value is not None]
    if len(numbers) < 4 or numbers[3] <= 0:
        wrong.append("red, green and blue in parentheses and a depth above 0")
        return None
    red, green, blue = (min(max(value, 0.0), 1.0) for value in numbers[:3])
    return FogParms((red, green, blue), numbers[3])


def read_images(image: Directive, wrong: list[str]) -> tuple[str, ...]:
    """Image names of ``map``, ``clampMap`` (one) or ``animMap`` (up to 8 after the rate).

    Names are as written, but ``$lightmap``, ``$whiteimage`` and ``*white`` in lower case.
    """
    animated = image.name == "animmap"
    names = image.args[1 : 1 + MAX_FRAMES] if animated else image.args[:1]
    if not names:
        wrong.append("frames a second and image names" if animated else "an image name")
    return tuple(name.lower() if name.startswith(("$", "*")) else name for name in names)


def read_blend(blend: Directive, wrong: list[str]) -> tuple[BlendFactor, BlendFactor]:
    """Source and target factor of ``blendFunc``; an unknown or missing one is GL_ONE.

    The engine substitutes GL_ONE for an unknown factor and stops the game at a missing one.
    """
    if blend.word in _BLENDS:
        return _BLENDS[blend.word]
    target = blend.args[1].lower() if len(blend.args) > 1 else ""
    if blend.word not in _SOURCES or target not in _TARGETS:
        wrong.append("add, filter, blend or a source and a target factor")
    return _SOURCES.get(blend.word, BlendFactor.ONE), _TARGETS.get(target, BlendFactor.ONE)


def read_alpha_test(test: Directive, wrong: list[str]) -> AlphaTest | None:
    """``alphaFunc``; an unknown one tests nothing."""
    try:
        return AlphaTest(test.word)
    except ValueError:
        wrong.append("GT0, LT128 or GE128")
        return None


def read_tc_gen(tc_gen: Directive, wrong: list[str]) -> tuple[str, ...]:
    """Arguments of ``tcGen`` in lower case, empty where the engine does not know them."""
    return known_words(tc_gen, _TC_GENS, wrong)


def known_words(directive: Directive, known: Sequence[str], wrong: list[str]) -> tuple[str, ...]:
    """A directive's words in lower case, none where the first one is not a known one."""
    if directive.word not in known:
        wrong.append("one of " + ", ".join(known))
        return ()
    return tuple(word.lower() for word in directive.args)


Reader = Callable[[Directive, list[str]], object]

GENERAL_READERS: dict[str, Reader] = {
    "cull": read_cull,
    "sort": check_sort,
    "skyparms": read_sky_parms,
    "q3map_sun": read_sun,
    "q3map_sunext": read_sun,
    "sun": read_sun,
    "fogparms": read_fog_parms,
}
"""Readers of the directives outside stages whose arguments are checked."""

STAGE_READERS: dict[str, Reader] = {
    "map": read_images,
    "clampmap": read_images,
    "blendfunc": read_blend,
    "alphafunc": read_alpha_test,
    "tcgen": read_tc_gen,
    "texgen": read_tc_gen,
}
"""Readers of the directives inside stages whose arguments are checked, but for those of
`shader_motion`."""
