"""Small plots as SVG: text stays text, colours follow the page, and they scale to a phone.

Series have their colours from the page's custom properties ``--series-1`` to ``--series-6``, with
fallbacks that stand out on light and dark ground; all else has the colour of the text around.
The shape of marks tells series apart as well, for those who do not see the colours.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from followspot.arrays import Floats
from followspot.present.report import svg
from followspot.present.report.ticks import Axis, Scale, number

__all__ = ["Axis", "Line", "Mark", "bars", "dots", "heat_map", "lines"]

_LINE = 16.0  # height of a line of text


@dataclass(frozen=True, eq=False)
class Line:
    """One series over a common axis.

    Attributes:
        label: Its name in the legend.
        x: (n,) values along x.
        y: (n,) values along y; the line is broken where they are not finite.
        band: (n,) low and (n,) high values, shaded between.
        markers: Whether a mark stands at every point.
        line: Whether the points are joined.
        dashed: Whether the line is.
    """

    label: str
    x: ArrayLike
    y: ArrayLike
    band: tuple[ArrayLike, ArrayLike] | None = None
    markers: bool = False
    line: bool = True
    dashed: bool = False


@dataclass(frozen=True)
class Mark:
    """A straight line for reference: at a value of y if it goes `across`, else of x."""

    value: float
    label: str
    across: bool = True


def lines(
    title: str,
    series: Sequence[Line],
    x: Axis,
    y: Axis,
    *,
    marks: Sequence[Mark] = (),
    description: str = "",
) -> str:
    """Curves or points over two axes.

    Args:
        title: What is read out in the plot's place.
        series: At most six.
        x: The axis to the right.
        y: The axis upwards; its label stands above it.
        marks: Lines for reference, which the axes hold as well.
        description: What it shows, for those who cannot see it.
    """
    legend, top = _legend([(s.label, _curve_swatch(k, s)) for k, s in enumerate(series)])
    top += _LINE + 6
    bottom = top + 210
    up = [_values(v) for s in series for v in (s.y, *(s.band or ()))]
    to_y = Scale(y, np.array([*np.concatenate(up), *_at(marks, across=True)]), bottom, top)
    left = _label_width(to_y) + 8
    along = np.concatenate([_values(s.x) for s in series])
    to_x = Scale(x, np.array([*along, *_at(marks, across=False)]), left, svg.RIGHT)
    curves = [part for k, s in enumerate(series) for part in _curve(k, s, to_x, to_y)]
    parts = [
        *legend,
        svg.text(0, top - 9, y.label),
        *_y_axis(to_y, left),
        *_x_axis(to_x, top, bottom),
        *_marks(marks, to_x, to_y),
        svg.clipped(curves, left, top, bottom),
        *_mark_labels(marks, to_x, to_y),
    ]
    return svg.document(title, description, bottom + 2 * _LINE + 8, parts)


def bars(
    title: str,
    rows: Sequence[str],
    series: Mapping[str, ArrayLike],
    axis: Axis,
    *,
    stacked: bool = False,
    description: str = "",
) -> str:
    """Horizontal bars from zero, each with its number.

    Args:
        title: What is read out in the plot's place.
        rows: Names from top to bottom.
        series: (rows,) values by name, none negative; what is not finite is left out. The bars of a
            row stand below one another, or end to end if `stacked`; then the sum is written.
        axis: Of the values; linear.
        stacked: Whether the values of a row are parts of one.
        description: What it shows, for those who cannot see it.

    Raises:
        ValueError: a negative value, or a logarithmic axis, which has no zero.
    """
    table = np.array([_values(v) for v in series.values()]).reshape(len(series), len(rows))
    if axis.log or (table < 0).any():
        raise ValueError("bars begin at zero and grow from there")
    table = np.where(np.isfinite(table), table, 0)
    ends = table.cumsum(axis=0) if stacked else table
    thick = 14.0 if stacked or len(series) == 1 else 10.0
    swatches = [svg.box(-5, -5, 10, 10, f'fill="{svg.colour(k)}"') for k in range(len(series))]
    frame = _Rows(rows, list(series), swatches, thick if stacked else thick * len(series))
    widest = max(svg.width_of(number(v, 3)) for v in (0.0, *ends.flat))
    to_x = Scale(axis, np.append(ends.ravel(), 0.0), frame.left, svg.WIDTH - widest - 8)
    parts = [*frame.parts, *_x_axis(to_x, frame.top, frame.bottom)]
    for k, (part, end) in enumerate(zip(table, ends, strict=True)):
        aside = 0.0 if stacked else (k - (len(series) - 1) / 2) * thick
        for x0, x1, y, value in zip(
            to_x(end - part), to_x(end), frame.middles + aside, end, strict=True
        ):
            parts.append(svg.box(x0, y - thick / 2, x1 - x0, thick - 1, f'fill="{svg.colour(k)}"'))
            if not stacked or k == len(series) - 1:
                parts.append(svg.text(x1 + 4, y + 3.5, number(value, 3), size=10))
    return svg.document(title, description, frame.bottom + 2 * _LINE + 8, parts)


def dots(
    title: str,
    rows: Sequence[str],
    series: Mapping[str, ArrayLike],
    axis: Axis,
    *,
    marks: Sequence[Mark] = (),
    description: str = "",
) -> str:
    """Names from top to bottom, and a dot for every series on the line of each.

    Args:
        title: What is read out in the plot's place.
        rows: Names from top to bottom.
        series: (rows,) values by name; what is not finite is left out.
        axis: Of the values.
        marks: Upright lines for reference, whatever their `across`.
        description: What it shows, for those who cannot see it.
    """
    values = [_values(v) for v in series.values()]
    swatches = [svg.symbol(k, 0, 0) for k in range(len(series))]
    frame = _Rows(rows, list(series), swatches, 12.0, above=15.0 * len(marks))
    marks = [Mark(m.value, m.label, across=False) for m in marks]
    everything = np.array([*np.concatenate(values), *_at(marks, across=False)])
    to_x = Scale(axis, everything, frame.left + 6, svg.RIGHT)
    to_y = Scale(Axis("", limits=(0, 1)), everything, frame.bottom, frame.top - 15 * len(marks))
    parts = [*frame.parts, *_x_axis(to_x, frame.top, frame.bottom)]
    parts += [svg.rule(frame.left, y, svg.RIGHT, y) for y in frame.middles]
    parts += _marks(marks, to_x, to_y)
    for k, each in enumerate(values):
        parts += svg.symbols(k, to_x(each), frame.middles)
    parts += _mark_labels(marks, to_x, to_y)
    return svg.document(title, description, frame.bottom + 2 * _LINE + 8, parts)


def heat_map(
    title: str, values: ArrayLike, x: Axis, y: Axis, value: Axis, *, description: str = ""
) -> str:
    """A table of numbers as colours.

    Args:
        title: What is read out in the plot's place.
        values: (h, w), the top row first; what is not finite is left out.
        x: The axis to the right, whose limits are the picture's left and right edge.
        y: The axis upwards, whose limits are the lower and upper edge.
        value: What the colours mean, linear; if its limits lie on both sides of zero, they are two
            colours which part there.
        description: What it shows, for those who cannot see it.
    """
    table = np.asarray(values, np.float64)
    top = _LINE + 6
    left = _label_width(Scale(y, table, 0, 1)) + 8
    width = svg.RIGHT - left
    bottom = top + min(max(width * table.shape[0] / table.shape[1], 120), 400)
    below = bottom + 3 * _LINE + 20
    to_x, to_y = Scale(x, table, left, svg.RIGHT), Scale(y, table, bottom, top)
    to_value = Scale(value, table.ravel(), left, svg.RIGHT)
    ramp = np.linspace(to_value.low, to_value.high, 256)[np.newaxis]
    parts = [
        svg.text(0, top - 9, y.label),
        svg.picture(table, to_value, left, top, width, bottom - top),
        *_y_axis(to_y, left, grid=False),
        *_x_axis(to_x, top, bottom, grid=False),
        svg.text(left, below - 6, value.label),
        svg.picture(ramp, to_value, left, below, width, 12),
        *_x_axis(to_value, below, below + 12, grid=False, label=False),
    ]
    return svg.document(title, description, below + 12 + _LINE + 6, parts)


class _Rows:
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
        self.parts, self.top = _legend(entries if len(names) > 1 else [])
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


def _values(values: ArrayLike) -> Floats:
    return np.asarray(values, np.float64).ravel()


def _at(marks: Sequence[Mark], *, across: bool) -> list[float]:
    return [mark.value for mark in marks if mark.across == across]


def _label_width(scale: Scale) -> float:
    return max((svg.width_of(number(tick)) for tick in scale.ticks(6)), default=0.0)


def _legend(entries: Sequence[tuple[str, str]]) -> tuple[list[str], float]:
    """Labels with their swatches (drawn round 0, 0), and where what is below may begin."""
    parts: list[str] = []
    x, y = 0.0, 10.0
    for label, swatch in entries:
        width = 30 + svg.width_of(label) + 14
        if x > 0 and x + width > svg.WIDTH:
            x, y = 0.0, y + _LINE + 2
        parts.append(f'<g transform="translate({x + 13:.1f} {y:.1f})">{swatch}</g>')
        parts.append(svg.text(x + 30, y + 4, label))
        x += width
    return parts, y + _LINE if entries else 4.0


def _y_axis(scale: Scale, left: float, *, grid: bool = True) -> list[str]:
    parts = []
    for tick in scale.ticks(6):
        y = scale.at(tick)
        if grid:
            parts.append(svg.rule(left, y, svg.RIGHT, y))
        parts.append(svg.text(left - 6, y + 4, number(tick), anchor="end"))
    return parts


def _x_axis(
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
        parts.append(svg.text(scale.end, bottom + 15 + _LINE, scale.axis.label, anchor="end"))
    return parts


def _have_room(scale: Scale, ticks: Sequence[float]) -> bool:
    places = scale(np.array(ticks))
    needed = [
        (svg.width_of(number(a)) + svg.width_of(number(b))) / 2 + 8 for a, b in pairwise(ticks)
    ]
    return bool((np.diff(places) >= needed).all())


def _marks(marks: Sequence[Mark], to_x: Scale, to_y: Scale) -> list[str]:
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


def _mark_labels(marks: Sequence[Mark], to_x: Scale, to_y: Scale) -> list[str]:
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


def _curve(k: int, series: Line, to_x: Scale, to_y: Scale) -> list[str]:
    x, y = to_x(_values(series.x)), to_y(_values(series.y))
    parts = []
    if series.band:
        low, high = (to_y(_values(edge)) for edge in series.band)
        known = np.isfinite(x) & np.isfinite(low) & np.isfinite(high)
        around = np.concatenate([x[known], x[known][::-1]])
        edges = np.concatenate([low[known], high[known][::-1]])
        parts.append(f'<path d="{svg.path(around, edges)}" fill="{svg.colour(k)}" opacity="0.2"/>')
    if series.line:
        parts.append(f'<path d="{svg.path(x, y)}" {svg.stroke(k, dashed=series.dashed)}/>')
    if series.markers:
        parts += svg.symbols(k, x, y)
    return parts


def _curve_swatch(k: int, series: Line) -> str:
    line = f'<path d="M-11 0L11 0" {svg.stroke(k, dashed=series.dashed)}/>'
    return (line if series.line else "") + (svg.symbol(k, 0, 0) if series.markers else "")
