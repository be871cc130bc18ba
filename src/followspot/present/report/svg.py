"""The elements that plots are made of, as SVG.

Texts are 12 high where plots are 400 wide, so that a phone of that width still shows them.
"""

import base64
import io
import math
from collections.abc import Sequence
from html import escape

import numpy as np
from PIL import Image as PillowImage

from followspot.arrays import Floats
from followspot.present.report.ticks import Scale

WIDTH = 400.0
"""Of every plot."""

RIGHT = WIDTH - 14
"""Where what is plotted ends; half a number may stand beyond."""

COLOURS = ("#2a78d6", "#d4631b", "#1c9a68", "#c2529f", "#8a68d0", "#94791f")
"""Of the series, where the page does not say otherwise."""

_VIRIDIS = ("#440154", "#3b528b", "#21918c", "#5ec962", "#fde725")  # by van der Walt and Smith
_TWO_SIDED = ("#1f4f9e", "#7fb0e0", "#f4f4f4", "#eba26a", "#a3410e")
_NARROW, _WIDE = " .,:;|/'()[]iljtfrI-", "mwMW%@GOQ&<>=+~"


def colour(k: int) -> str:
    """Of series `k`."""
    return f"var(--series-{k + 1}, {COLOURS[k]})"


def width_of(text: str) -> float:
    """About how wide a text is, in one of the wider fonts that a browser may choose."""
    return sum(4.2 if c in _NARROW else 11.8 if c in _WIDE else 7.5 for c in text)


def cut(text: str, width: float) -> str:
    """The text, shortened if it is wider than that."""
    if width_of(text) <= width:
        return text
    while width_of(text) > width - 12:
        text = text[:-1]
    return text + "…"


def document(title: str, description: str, height: float, parts: Sequence[str]) -> str:
    """All of a plot: an image with a name and words for those who cannot see it."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" role="img" viewBox="0 0 {WIDTH:g} {height:g}" '
        f'style="width:100%;max-width:34rem;height:auto" fill="currentColor" font-size="12" '
        f'font-family="system-ui, sans-serif"><title>{escape(title)}</title>'
        f"<desc>{escape(description or title)}</desc>{''.join(parts)}</svg>"
    )


def text(x: float, y: float, content: str, *, anchor: str = "start", size: int = 12) -> str:
    """Text with a rim in the ground's colour, so that it can be read over lines."""
    rim = "paint-order:stroke;stroke:var(--paper, Canvas);stroke-width:3px"
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}" '
        f'style="{rim}">{escape(content)}</text>'
    )


def rule(x0: float, y0: float, x1: float, y1: float, style: str = 'opacity="0.18"') -> str:
    """A straight line in the colour of the text."""
    place = f'x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"'
    return f'<line {place} stroke="currentColor" {style}/>'


def box(x: float, y: float, width: float, height: float, style: str) -> str:
    """A rectangle."""
    place = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
    return f"<rect {place} {style}/>"


def picture(table: Floats, scale: Scale, x: float, y: float, width: float, height: float) -> str:
    """A table (h, w) in colours, as a picture inside the SVG."""
    low, high = scale.low, scale.high
    stops = _TWO_SIDED if low < 0 < high else _VIRIDIS
    reach = max(-low, high)
    start, extent = (-reach, 2 * reach) if low < 0 < high else (low, high - low)
    known = np.isfinite(table)
    along = np.where(known, (table - start) / extent, 0) * (len(stops) - 1)
    rgb = np.array([[int(stop[i : i + 2], 16) for i in (1, 3, 5)] for stop in stops])
    channels = [np.interp(along, np.arange(len(stops)), rgb[:, c]) for c in range(3)]
    pixels = np.stack([*channels, known * 255], axis=-1).round().astype(np.uint8)
    file = io.BytesIO()
    PillowImage.fromarray(pixels).save(file, "png")
    place = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
    data = base64.b64encode(file.getvalue()).decode()
    return (
        f'<image {place} preserveAspectRatio="none" style="image-rendering:pixelated" '
        f'href="data:image/png;base64,{data}"/>'
    )


def clipped(parts: Sequence[str], left: float, top: float, bottom: float) -> str:
    """What of the parts is inside the plot; a mark on its edge is shown whole."""
    rim = 5.0
    x, y, width, height = left - rim, top - rim, RIGHT - left + 2 * rim, bottom - top + 2 * rim
    place = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
    view = f"{x:.1f} {y:.1f} {width:.1f} {height:.1f}"
    return f'<svg {place} viewBox="{view}" overflow="hidden">{"".join(parts)}</svg>'


def path(x: Floats, y: Floats) -> str:
    """Joined points; where one is not finite the line is broken."""
    words = []
    down = False
    for place_x, place_y in zip(x.tolist(), y.tolist(), strict=True):
        known = math.isfinite(place_x) and math.isfinite(place_y)
        if known:
            words.append(f"{'L' if down else 'M'}{place_x:.1f} {place_y:.1f}")
        down = known
    return "".join(words)


def stroke(k: int, *, dashed: bool) -> str:
    """How the line of series `k` is drawn."""
    dashes = ' stroke-dasharray="6 4"' if dashed else ""
    return f'fill="none" stroke="{colour(k)}" stroke-width="2" stroke-linejoin="round"{dashes}'


def symbols(k: int, x: Floats, y: Floats) -> list[str]:
    """A mark of series `k` at every point that is finite."""
    known = np.isfinite(x) & np.isfinite(y)
    return [symbol(k, *place) for place in zip(x[known].tolist(), y[known].tolist(), strict=True)]


def symbol(k: int, x: float, y: float) -> str:
    """A disc, square, diamond, triangle, ... as large as one another to the eye."""
    style = f'fill="{colour(k)}"'
    if k % 4 == 0:
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" {style}/>'
    if k % 4 == 1:
        return box(x - 3.5, y - 3.5, 7, 7, style)
    shape = "M0 -5L5 0L0 5L-5 0Z" if k % 4 == 2 else "M0 -5L5 4L-5 4Z"
    return f'<path d="{shape}" transform="translate({x:.1f} {y:.1f})" {style}/>'
