"""How a surface's images move, by time alone: what ioquake3 works out for each of its vertices.

Formulae are those of its ``code/renderergl1/tr_shade_calc.c``, but exact, where the engine looks
waves up in tables of 1024 steps.

All of a stage's ``tcMod`` lines are put together on the CPU, whatever their order. Most of them are
affine maps of (s, t). Turbulence adds to s a sine wave that runs along x + z, and to t one along y;
all turbulence has the same length of wave, so that

    sin(angle + phase) = sin(angle) cos(phase) + cos(angle) sin(phase)

leaves for a vertex one sum of seven terms, however much turbulence there is.
"""

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

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

DISPLAY_GAMMA = 2.2
"""The engine multiplies what is displayed; in linear light the factor is to this power."""

LEAST_STRETCH = 1 / 1024
"""An image never stretches to less of its size: the first step of the engine's tables."""

Pair = tuple[float, float]

Terms = tuple[Pair, ...]
"""What s, t and 1 contribute to texture coordinates, each a pair; and with turbulence sin x, sin y,
cos x and cos y, too, where x = 2 pi (x + z) / 1024 of a vertex' place as its model
has it, and y = 2 pi y / 1024."""

_UNMOVED: Terms = ((1.0, 0.0), (0.0, 1.0), (0.0, 0.0))
_SWAY: Terms = ((0.0, 0.0),) * 4


@dataclass(frozen=True)
class Motion:
    """What a stage's image does as time goes by.

    Attributes:
        tc_mods: What moves its coordinates, in this order.
        frames: Paths of the images that it shows one after the other, if there are several.
        rate: How many of them in a second.
        color: What its colours are multiplied by, as they are displayed.
        alpha: What its alpha is multiplied by.
    """

    tc_mods: tuple[TcMod, ...] = ()
    frames: tuple[str, ...] = ()
    rate: float = 0.0
    color: Wave | None = None
    alpha: Wave | None = None

    @cached_property
    def is_turbulent(self) -> bool:
        """Whether coordinates have terms of turbulence."""
        return any(isinstance(mod, Turbulence) for mod in self.tc_mods)

    @property
    def pulses(self) -> bool:
        """Whether colours or alpha change."""
        return self.color is not None or self.alpha is not None

    def frame(self, seconds: float) -> int:
        """Number of the image that is shown."""
        return int(seconds * self.rate % len(self.frames)) % len(self.frames)

    def terms(self, seconds: float) -> Terms:
        """What texture coordinates are put together from."""
        terms = _UNMOVED + _SWAY if self.is_turbulent else _UNMOVED
        for mod in self.tc_mods:
            if isinstance(mod, Turbulence):
                terms = _swayed(terms, mod, seconds)
            else:
                affine = _affine(mod, seconds)
                terms = affine if terms is _UNMOVED else _mapped(terms, affine)
        return terms

    def pulse(self, seconds: float) -> Pair:
        """Factors of the image's colours, in linear light, and of its alpha, in [0, 1]."""
        return share(self.color, seconds) ** DISPLAY_GAMMA, share(self.alpha, seconds)


STILL = Motion()
"""That of most images."""


def share(wave: Wave | None, seconds: float) -> float:
    """What of something a wave leaves at a time, from 0 to 1; without one, all of it."""
    return 1.0 if wave is None else min(max(value(wave, seconds), 0.0), 1.0)


def value(wave: Wave, seconds: float) -> float:
    """A wave at a time."""
    shape, base, amplitude, phase, frequency = wave
    if shape is Shape.NOISE:
        return base + amplitude * _noise((phase + seconds) * frequency)
    return base + amplitude * _HEIGHTS[shape]((phase + seconds * frequency) % 1.0)


_random = random.Random(1)
_NOISE = tuple(_random.uniform(-1, 1) for _ in range(256))
"""What noise is at whole numbers; the engine's is as long."""


def _noise(at: float) -> float:
    """Numbers that look random, and straight lines from one to the next."""
    whole = math.floor(at)
    before, behind = _NOISE[whole % len(_NOISE)], _NOISE[(whole + 1) % len(_NOISE)]
    return before + (at - whole) * (behind - before)


_HEIGHTS: dict[Shape, Callable[[float], float]] = {
    Shape.SIN: lambda at: math.sin(math.tau * at),
    Shape.TRIANGLE: lambda at: 1 - abs((4 * at + 1) % 4 - 2),
    Shape.SQUARE: lambda at: 1.0 if at < 0.5 else -1.0,
    Shape.SAWTOOTH: lambda at: at,
    Shape.INVERSE_SAWTOOTH: lambda at: 1 - at,
}
"""What waves are at a share of their period."""


def _affine(mod: TcMod, seconds: float) -> Terms:
    """What s, t and 1 contribute."""
    match mod:
        case Scroll(s, t):
            return (1.0, 0.0), (0.0, 1.0), (s * seconds % 1.0, t * seconds % 1.0)
        case Scale(s, t):
            return (s, 0.0), (0.0, t), (0.0, 0.0)
        case Transform(a, b, c, d, e, f):
            return (a, b), (c, d), (e, f)
        case Rotate(degrees):
            angle = math.radians(-degrees * seconds % 360.0)
            return _about_middle(math.cos(angle), math.sin(angle))
        case Stretch(wave):
            size = value(wave, seconds)
            return _about_middle(1 / math.copysign(max(abs(size), LEAST_STRETCH), size), 0.0)
        case Turbulence():
            raise AssertionError(mod)


def _about_middle(x: float, y: float) -> Terms:
    """Turned and scaled as (1, 0) is by which it becomes (x, y), with (0.5, 0.5) in its place."""
    return (x, y), (-y, x), (0.5 - 0.5 * x + 0.5 * y, 0.5 - 0.5 * y - 0.5 * x)


def _mapped(terms: Terms, affine: Terms) -> Terms:
    """All terms after an affine map."""
    (a, b), (c, d), (e, f) = affine
    of_s, of_t, (s, t), *sway = ((a * s + c * t, b * s + d * t) for s, t in terms)
    return of_s, of_t, (s + e, t + f), *sway


def _swayed(terms: Terms, mod: Turbulence, seconds: float) -> Terms:
    """All terms, those of turbulence with some more of it."""
    phase = math.tau * ((mod.phase + seconds * mod.frequency) % 1.0)
    sine, cosine = mod.amplitude * math.sin(phase), mod.amplitude * math.cos(phase)
    more = (cosine, 0.0), (0.0, cosine), (sine, 0.0), (0.0, sine)
    swayed = ((s + ds, t + dt) for (s, t), (ds, dt) in zip(terms[3:], more, strict=True))
    return *terms[:3], *swayed
