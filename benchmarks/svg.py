"""Line plots as SVG text: a few panels side by side, nothing more."""

from dataclasses import dataclass
from xml.sax.saxutils import escape

WIDTH, HEIGHT = 360, 280
LEFT, RIGHT, TOP, BOTTOM = 52, 14, 34, 46
COLOURS = ("#1b6ca8", "#c8553d", "#4f772d", "#7b4f9d")


@dataclass(frozen=True)
class Panel:
    """One plot, both axes linear and from 0.

    Attributes:
        title: Over the plot.
        x_label: Below it.
        y_label: Left of it.
        lines: By name, the points (x, y) with x ascending.
    """

    title: str
    x_label: str
    y_label: str
    lines: dict[str, list[tuple[float, float]]]


def plot(panels: list[Panel]) -> str:
    """The panels side by side, as the text of an SVG file."""
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH * len(panels)} {HEIGHT}" '
        f'width="{WIDTH * len(panels)}" height="{HEIGHT}" font-family="sans-serif" '
        'font-size="11" fill="#222">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    for number, panel in enumerate(panels):
        parts += [f'<g transform="translate({WIDTH * number},0)">', *_panel(panel), "</g>"]
    return "\n".join([*parts, "</svg>\n"])


def _panel(panel: Panel) -> list[str]:
    points = [point for line in panel.lines.values() for point in line]
    x_step, x_end = _ticks(max(x for x, _ in points))
    y_step, y_end = _ticks(max(y for _, y in points))

    def place(x: float, y: float) -> tuple[float, float]:
        across = LEFT + x / x_end * (WIDTH - LEFT - RIGHT)
        return across, HEIGHT - BOTTOM - y / y_end * (HEIGHT - TOP - BOTTOM)

    left, bottom = place(0, 0)
    right, top = place(x_end, y_end)
    parts = [
        _text(WIDTH / 2, 18, panel.title, "middle", ' font-weight="bold"'),
        _text((left + right) / 2, HEIGHT - 10, panel.x_label, "middle"),
        f'<g transform="rotate(-90)">{_text(-(top + bottom) / 2, 13, panel.y_label, "middle")}</g>',
    ]
    for k in range(round(y_end / y_step) + 1):
        _, y = place(0, k * y_step)
        parts.append(f'<path d="M{left:.1f} {y:.1f}H{right:.1f}" stroke="#ddd"/>')
        parts.append(_text(left - 5, y + 4, f"{k * y_step:g}", "end"))
    for k in range(round(x_end / x_step) + 1):
        x, _ = place(k * x_step, 0)
        parts.append(f'<path d="M{x:.1f} {bottom:.1f}v4" stroke="#222"/>')
        parts.append(_text(x, bottom + 16, f"{k * x_step:g}", "middle"))
    parts.append(
        f'<path d="M{left:.1f} {top:.1f}V{bottom:.1f}H{right:.1f}" fill="none" stroke="#222"/>'
    )
    for number, (name, line) in enumerate(panel.lines.items()):
        colour = COLOURS[number % len(COLOURS)]
        places = [place(x, y) for x, y in line]
        path = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
        parts.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>' for x, y in places]
        parts.append(_text(left + 10, top + 12 + 14 * number, name, "start", f' fill="{colour}"'))
    return parts


def _text(x: float, y: float, text: str, anchor: str, more: str = "") -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{more}>{escape(text)}</text>'


def _ticks(largest: float) -> tuple[float, float]:
    """A round step, and the first multiple of it that holds the largest value."""
    step = 10.0 ** len(str(int(largest)))
    for divisor in (1, 2, 5, 10, 20, 50, 100):
        if largest / (step / divisor) >= 4:
            step /= divisor
            break
    count = -(-largest // step)
    return step, count * step
