"""Axes of a plot: round numbers along them, and numbers as text."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Axis:
    """What is measured along one direction of a plot.

    Attributes:
        label: What it is, with its unit.
        log: Whether equal steps are equal factors. Values that are not positive are left out.
        limits: Smallest and largest value shown; none takes the data's, rounded outwards.
        ticks: Where to put numbers; none chooses round ones.
    """

    label: str
    log: bool = False
    limits: tuple[float, float] | None = None
    ticks: Sequence[float] | None = None


class Scale:
    """Values of an axis to positions along it.

    Args:
        axis: What it shows.
        data: (n,) all values that it should hold; those that are not finite do not count.
        start: Position of the lower limit in the picture.
        end: Position of the upper limit; smaller than `start` if the axis runs upwards.
    """

    def __init__(self, axis: Axis, data: Floats, start: float, end: float) -> None:
        self.axis = axis
        self.low, self.high = axis.limits or _limits(data, log=axis.log)
        self.start, self.end = start, end

    def __call__(self, values: Floats) -> Floats:
        """Positions; NaN where a logarithm does not exist."""
        values = np.asarray(values, np.float64)
        low, high = self.low, self.high
        if self.axis.log:
            values = np.log(np.where(values > 0, values, np.nan))
            low, high = math.log(low), math.log(high)
        share = (values - low) / (high - low)
        return np.asarray(self.start + share * (self.end - self.start), np.float64)

    def at(self, value: float) -> float:
        """Position of one value."""
        return float(self(np.array([value]))[0])

    def ticks(self, count: int) -> list[float]:
        """About `count` round values within the limits."""
        if self.axis.ticks is not None:
            return [t for t in self.axis.ticks if self.low <= t <= self.high]
        if self.axis.log:
            return log_ticks(self.low, self.high, count)
        return linear_ticks(self.low, self.high, count)


def linear_ticks(low: float, high: float, count: int) -> list[float]:
    """Multiples of 1, 2 or 5 times a power of ten within limits, `count` of them or fewer."""
    rough = (high - low) / max(count - 1, 1)
    step = 10.0 ** math.floor(math.log10(rough))
    step *= next(m for m in (1, 2, 5, 10) if step * m >= rough * (1 - 1e-9))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    # Between large limits close together, rounding may put a multiple beyond the one that it is at.
    return [min(max(k * step, low), high) for k in range(first, last + 1)]


def log_ticks(low: float, high: float, count: int) -> list[float]:
    """Powers of ten within limits, every one or every so many; 2 and 5 between if they are few."""
    first, last = math.ceil(math.log10(low) - 1e-9), math.floor(math.log10(high) + 1e-9)
    every = [m * 10.0**e for e in range(first - 1, last + 1) for m in (1, 2, 5)]
    every = [t for t in every if low * (1 - 1e-9) <= t <= high * (1 + 1e-9)]
    if len(every) <= count:
        return every
    step = math.ceil((last - first + 1) / count)
    return [10.0**e for e in range(first, last + 1) if e % step == 0]


def number(value: float, digits: int = 6) -> str:
    """A number as plain text: 0.25, −3, 10⁻⁵, 2·10⁶; a dash for what is not finite."""
    if not math.isfinite(value):
        return "–"
    text = f"{value:.{digits}g}"
    size = abs(float(text))
    if size == 0 or 1e-3 <= size < 1e5:
        plain = f"{float(text):.10f}".rstrip("0").rstrip(".") if size < 1 else f"{float(text):.12g}"
        return plain.replace("-", "−")
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    power = "10" + str(int(exponent)).translate(_SUPERSCRIPT)
    text = power if mantissa == "1" else "-" + power if mantissa == "-1" else f"{mantissa}·{power}"
    return text.replace("-", "−")


def count(value: int) -> str:
    """A whole number with its thousands set apart."""
    return f"{value:,}".replace(",", "\u202f")


def _limits(data: Floats, *, log: bool) -> tuple[float, float]:
    """Limits a little outside of the data, at round values."""
    data = data[np.isfinite(data) & ((data > 0) | (not log))]
    if not len(data):
        return (1.0, 10.0) if log else (0.0, 1.0)
    low, high = float(data.min()), float(data.max())
    if log:
        # To the next of 1, 2, 5, 10 outwards: whole decades would leave half a plot empty.
        return _round_log(low, up=False), _round_log(high * (1 + 1e-9) + 1e-300, up=True)
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        low, high = (min(low, 0.0), max(high, 0.0)) if high or low else (0.0, 1.0)
    ticks = linear_ticks(low, high, 6)
    step = ticks[1] - ticks[0]
    return math.floor(low / step + 1e-9) * step, math.ceil(high / step - 1e-9) * step


def _round_log(value: float, *, up: bool) -> float:
    decade = 10.0 ** math.floor(math.log10(value))
    steps = [decade * m for m in (1, 2, 5, 10)]
    return next(s for s in steps if s > value) if up else max(s for s in steps if s <= value)
