"""Small plots as SVG: text stays text, colours follow the page, and they scale to a phone.

Series have their colours from the page's custom properties ``--series-1`` to ``--series-6``, with
fallbacks that stand out on light and dark ground; all else has the colour of the text around.
The shape of marks tells series apart as well, for those who do not see the colours.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from followspot.arrays import Floats
from followspot.present.report import svg
from followspot.present.report.plot_frame import (
    LINE_HEIGHT,
    Mark,
    Rows,
    label_width,
    legend,
    mark_labels,
    mark_lines,
    x_axis,
    y_axis,
)
from followspot.present.report.ticks import Axis, Scale, number


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
    labels, top = legend([(s.label, _curve_swatch(k, s)) for k, s in enumerate(series)])
    top += LINE_HEIGHT + 6
    bottom = top + 210
    up = [_values(v) for s in series for v in (s.y, *(s.band or ()))]
    to_y = Scale(y, np.array([*np.concatenate(up), *_at(marks, across=True)]), bottom, top)
    left = label_width(to_y) + 8
    along = np.concatenate([_values(s.x) for s in series])
    to_x = Scale(x, np.array([*along, *_at(marks, across=False)]), left, svg.RIGHT)
    curves = [part for k, s in enumerate(series) for part in _curve(k, s, to_x, to_y)]
    parts = [
        *labels,
        svg.text(0, top - 9, y.label),
        *y_axis(to_y, left),
        *x_axis(to_x, top, bottom),
        *mark_lines(marks, to_x, to_y),
        svg.clipped(curves, left, top, bottom),
        *mark_labels(marks, to_x, to_y),
    ]
    return svg.document(title, description, bottom + 2 * LINE_HEIGHT + 8, parts)


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
    frame = Rows(rows, list(series), swatches, thick if stacked else thick * len(series))
    widest = max(svg.width_of(number(v, 3)) for v in (0.0, *ends.flat))
    to_x = Scale(axis, np.append(ends.ravel(), 0.0), frame.left, svg.WIDTH - widest - 8)
    parts = [*frame.parts, *x_axis(to_x, frame.top, frame.bottom)]
    for k, (part, end) in enumerate(zip(table, ends, strict=True)):
        aside = 0.0 if stacked else (k - (len(series) - 1) / 2) * thick
        for x0, x1, y, value in zip(
            to_x(end - part), to_x(end), frame.middles + aside, end, strict=True
        ):
            parts.append(svg.box(x0, y - thick / 2, x1 - x0, thick - 1, f'fill="{svg.colour(k)}"'))
            if not stacked or k == len(series) - 1:
                parts.append(svg.text(x1 + 4, y + 3.5, number(value, 3), size=10))
    return svg.document(title, description, frame.bottom + 2 * LINE_HEIGHT + 8, parts)


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
    frame = Rows(rows, list(series), swatches, 12.0, above=15.0 * len(marks))
    marks = [Mark(m.value, m.label, across=False) for m in marks]
    everything = np.array([*np.concatenate(values), *_at(marks, across=False)])
    to_x = Scale(axis, everything, frame.left + 6, svg.RIGHT)
    to_y = Scale(Axis("", limits=(0, 1)), everything, frame.bottom, frame.top - 15 * len(marks))
    parts = [*frame.parts, *x_axis(to_x, frame.top, frame.bottom)]
    parts += [svg.rule(frame.left, y, svg.RIGHT, y) for y in frame.middles]
    parts += mark_lines(marks, to_x, to_y)
    for k, each in enumerate(values):
        parts += svg.symbols(k, to_x(each), frame.middles)
    parts += mark_labels(marks, to_x, to_y)
    return svg.document(title, description, frame.bottom + 2 * LINE_HEIGHT + 8, parts)


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
    top = LINE_HEIGHT + 6
    left = label_width(Scale(y, table, 0, 1)) + 8
    width = svg.RIGHT - left
    bottom = top + min(max(width * table.shape[0] / table.shape[1], 120), 400)
    below = bottom + 3 * LINE_HEIGHT + 20
    to_x, to_y = Scale(x, table, left, svg.RIGHT), Scale(y, table, bottom, top)
    to_value = Scale(value, table.ravel(), left, svg.RIGHT)
    ramp = np.linspace(to_value.low, to_value.high, 256)[np.newaxis]
    parts = [
        svg.text(0, top - 9, y.label),
        svg.picture(table, to_value, left, top, width, bottom - top),
        *y_axis(to_y, left, grid=False),
        *x_axis(to_x, top, bottom, grid=False),
        svg.text(left, below - 6, value.label),
        svg.picture(ramp, to_value, left, below, width, 12),
        *x_axis(to_value, below, below + 12, grid=False, label=False),
    ]
    return svg.document(title, description, below + 12 + LINE_HEIGHT + 6, parts)


def _values(values: ArrayLike) -> Floats:
    return np.asarray(values, np.float64).ravel()


def _at(marks: Sequence[Mark], *, across: bool) -> list[float]:
    return [mark.value for mark in marks if mark.across == across]


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
