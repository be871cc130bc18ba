"""What stands around the data of a plot: legend, axes, names of rows, lines for reference."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from followspot.arrays import Floats
from followspot.present.report import svg
from followspot.present.report.ticks import Scale, number

LINE_HEIGHT = 16.0
"""Units of the picture from one line of text to the next."""


@dataclass(frozen=True)
class Mark:
    """A straight line for reference: at a value of y if it goes `across`, else of x."""

    value: float
    label: str
    across: bool = True


class Rows:
    """Names from top to bottom with a legend above.

    Attributes:
        parts: Legend and names.
        left: Where values begin.
        top: Of the first row.
        bottom: Of the last row.
        middles: (rows,) heights of the rows.
    """

    def __init__(
        self,
        rows: Sequence[str],
        names: Sequence[str],
        swatches: Sequence[str],
        height: float,
        above: float = 0.0,
    ) -> None:
        entries = list(zip(names, swatches, strict=True))
        self.parts, self.top = legend(entries if len(names) > 1 else [])
        self.top += above
        widest = max((svg.width_of(row) for row in rows), default=0.0)
        self.left = min(widest + 12, svg.WIDTH * 0.45)
        step = height + 8
        self.middles: Floats = self.top + step * (np.arange(len(rows), dtype=np.float64) + 0.5)
        self.bottom = self.top + step * len(rows)
        for row, y in zip(rows, self.middles, strict=True):
            self.parts.append(
                svg.text(self.left - 8, y + 4, svg.cut(row, self.left - 8), anchor="end")
            )


def label_width(scale: Scale) -> float:
    """Width of the widest number of a y axis."""
    return max((svg.width_of(number(tick)) for tick in scale.ticks(6)), default=0.0)


def legend(entries: Sequence[tuple[str, str]]) -> tuple[list[str], float]:
    """Labels with their swatches (drawn round 0, 0), and where what is below may begin."""
    parts: list[str] = []
    x, y = 0.0, 10.0
    for label, swatch in entries:
        width = 30 + svg.width_of(label) + 14
        if x > 0 and x + width > svg.WIDTH:
            x, y = 0.0, y + LINE_HEIGHT + 2
        parts.append(f'<g transform="translate({x + 13:.1f} {y:.1f})">{swatch}</g>')
        parts.append(svg.text(x + 30, y + 4, label))
        x += width
    return parts, y + LINE_HEIGHT if entries else 4.0


def y_axis(scale: Scale, left: float, *, grid: bool = True) -> list[str]:
    """Numbers to the left of the plot, and lines across it."""
    parts = []
    for tick in scale.ticks(6):
        y = scale.at(tick)
        if grid:
            parts.append(svg.rule(left, y, svg.RIGHT, y))
        parts.append(svg.text(left - 6, y + 4, number(tick), anchor="end"))
    return parts


def x_axis(
    scale: Scale, top: float, bottom: float, *, grid: bool = True, label: bool = True
) -> list[str]:
    """Numbers below the plot, as many as have room, and the axis' label below them."""
    count = 8
    ticks = scale.ticks(count)
    while count > 2 and not _have_room(scale, ticks):
        count -= 1
        ticks = scale.ticks(count)
    parts = [svg.rule(scale.start, bottom, scale.end, bottom, 'opacity="0.6"')] if grid else []
    for tick in ticks:
        x = scale.at(tick)
        parts.append(svg.rule(x, top if grid else bottom, x, bottom + (0 if grid else 4)))
        half = svg.width_of(number(tick)) / 2
        parts.append(svg.text(min(x, svg.WIDTH - half), bottom + 15, number(tick), anchor="middle"))
    if label:
        parts.append(svg.text(scale.end, bottom + 15 + LINE_HEIGHT, scale.axis.label, anchor="end"))
    return parts


def _have_room(scale: Scale, ticks: Sequence[float]) -> bool:
    places = scale(np.array(ticks))
    needed = [
        (svg.width_of(number(a)) + svg.width_of(number(b))) / 2 + 8 for a, b in pairwise(ticks)
    ]
    return bool((np.diff(places) >= needed).all())


def mark_lines(marks: Sequence[Mark], to_x: Scale, to_y: Scale) -> list[str]:
    """Lines for reference, without their names."""
    style = 'stroke-dasharray="2 3" opacity="0.8"'
    parts = []
    for mark in marks:
        if mark.across:
            y = to_y.at(mark.value)
            parts.append(svg.rule(to_x.start, y, to_x.end, y, style))
        else:
            x = to_x.at(mark.value)
            parts.append(svg.rule(x, to_y.start, x, to_y.end, style))
    return parts


def mark_labels(marks: Sequence[Mark], to_x: Scale, to_y: Scale) -> list[str]:
    """Their names: at the right end of level lines, beside the upper end of upright ones."""
    level = sorted((m for m in marks if m.across), key=lambda m: to_y.at(m.value))
    upright = [m for m in marks if not m.across]
    parts = []
    y = -math.inf
    for mark in level:
        y = max(to_y.at(mark.value) - 4, y + 14, to_y.end + 12)
        parts.append(svg.text(to_x.end - 2, y, mark.label, anchor="end"))
    for k, mark in enumerate(upright):
        x, y = to_x.at(mark.value), to_y.end + 12 + 15 * k
        fits = x + 6 + svg.width_of(mark.label) <= svg.WIDTH
        parts.append(
            svg.text(x + (4 if fits else -4), y, mark.label, anchor="start" if fits else "end")
        )
    return parts
