"""Plots: well-formed, labelled, true to their numbers, readable on light and dark ground."""

import base64
import io
import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from PIL import Image
from playwright.sync_api import sync_playwright

from followspot.present.report.plot import Line, bars, dots, heat_map, lines
from followspot.present.report.plot_frame import Mark
from followspot.present.report.svg import COLOURS
from followspot.present.report.ticks import Axis, Scale, count, linear_ticks, log_ticks, number

SVG = "{http://www.w3.org/2000/svg}"
CHROMIUM = "/usr/bin/chromium"
ROWS = ["one", "two & <three>", "a name that is far too long to stand beside its bar in full"]


class Box(NamedTuple):
    """Where a text is."""

    text: str
    left: float
    top: float
    right: float
    bottom: float


PLOTS: dict[str, Callable[[], str]] = {
    "lines": lambda: lines(
        "t",
        [
            Line("a", [0, 1, 2], [1, 2, 9], band=([0, 1, 8], [2, 3, 10]), markers=True),
            Line("b", [0, 1, 2], [3, math.nan, 5], dashed=True),
        ],
        Axis("x"),
        Axis("y"),
        marks=[Mark(2, "level"), Mark(2.01, "near it"), Mark(1.9, "upright", across=False)],
    ),
    "log": lambda: lines(
        "t", [Line("a", [1e-9, 1, 1e6], [0, 1, 100])], Axis("x", log=True), Axis("y", log=True)
    ),
    "bars": lambda: bars("t", ROWS, {"a": [1, 2, 3], "b": [0, math.nan, 7]}, Axis("ms")),
    "stacked": lambda: bars("t", ROWS, {"a": [1, 2, 3], "b": [0, 5, 7]}, Axis("ms"), stacked=True),
    "dots": lambda: dots(
        "t", ROWS, {"a": [1, 20, 300], "b": [2, 2, 2]}, Axis("%", log=True), marks=[Mark(9, "m")]
    ),
    "heat map": lambda: heat_map(
        "t",
        [[1.0, 2.0], [3.0, math.nan]],
        Axis("x", limits=(0, 2)),
        Axis("y", limits=(0, 2)),
        Axis("v"),
    ),
    "nothing": lambda: lines("t", [Line("a", [], [])], Axis("x"), Axis("y", log=True)),
}


def parsed(svg: str) -> ElementTree.Element:
    return ElementTree.fromstring(svg)


def texts(svg: str) -> list[str]:
    return [element.text or "" for element in parsed(svg).iter(f"{SVG}text")]


@pytest.mark.parametrize("name", PLOTS)
def test_a_plot_is_an_image_with_a_name_in_well_formed_xml(name: str) -> None:
    root = parsed(PLOTS[name]())
    assert root.get("role") == "img"
    assert [child.tag for child in root][:2] == [f"{SVG}title", f"{SVG}desc"]
    assert root[0].text == "t" and root[1].text
    assert root.get("viewBox", "").startswith("0 0 400 ")
    assert "nan" not in PLOTS[name]() and "inf" not in PLOTS[name]()


@pytest.fixture(scope="module")
def boxes() -> dict[str, list[Box]]:
    """Where a browser puts the texts of every plot, in the plot's own units."""
    plots = "".join(f'<div id="{name}">{make()}</div>' for name, make in PLOTS.items())
    find = """() => Object.fromEntries([...document.querySelectorAll("div")].map((plot) => [plot.id,
        [...plot.querySelectorAll("text")].map((text) => {
            const box = text.getBBox();
            return [text.textContent, box.x, box.y, box.x + box.width, box.y + box.height];
        })]))"""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page()
        page.set_content(plots)
        found = page.evaluate(find)
        browser.close()
    return {name: [Box(*box) for box in each] for name, each in found.items()}


@pytest.mark.parametrize("name", PLOTS)
def test_all_text_is_inside_of_a_plot(name: str, boxes: dict[str, list[Box]]) -> None:
    width, height = map(float, parsed(PLOTS[name]()).get("viewBox", "").split()[2:])
    for box in boxes[name]:
        assert box.left >= 0 and box.right <= width, box
        assert box.top >= 0 and box.bottom <= height, box


@pytest.mark.parametrize("name", PLOTS)
def test_texts_do_not_overlap(name: str, boxes: dict[str, list[Box]]) -> None:
    for k, a in enumerate(boxes[name]):
        for b in boxes[name][:k]:
            # A line's box is higher than its letters: some of it may be the other's.
            apart_y = a.bottom - 4 <= b.top or b.bottom - 4 <= a.top
            assert apart_y or a.right <= b.left or b.right <= a.left, (a, b)


def test_text_is_text_and_escaped() -> None:
    svg = bars("<t> & t", ["<b> & b"], {"a": [1]}, Axis("m/s²"), description="a < b")
    assert {"<b> & b", "m/s²", "1"} <= set(texts(svg))
    assert parsed(svg)[0].text == "<t> & t" and parsed(svg)[1].text == "a < b"


def test_points_are_where_their_numbers_say() -> None:
    axis = Axis("x", limits=(0, 10))
    svg = lines("t", [Line("a", [0, 5, 10], [0, 5, 10], markers=True)], axis, axis)
    inner = parsed(svg).find(f"{SVG}svg")
    assert inner is not None
    x, y = ([float(dot.get(key, "")) for dot in inner.iter(f"{SVG}circle")] for key in ("cx", "cy"))
    assert x[1] - x[0] == pytest.approx(x[2] - x[1], abs=0.1)
    assert x[2] == 386 and y[0] - y[2] == pytest.approx(210) and y[1] == sum(y[::2]) / 2


def test_bars_are_as_long_as_their_numbers() -> None:
    svg = bars("t", ["a", "b"], {"only": [2, 6]}, Axis("ms"))
    short, long_ = (float(box.get("width", "")) for box in parsed(svg).iter(f"{SVG}rect"))
    assert long_ == pytest.approx(3 * short, abs=0.2)


def test_stacked_bars_follow_one_another_and_name_their_sum() -> None:
    svg = bars("t", ["a"], {"first": [2], "second": [6]}, Axis("ms"), stacked=True)
    first, second = list(parsed(svg).iter(f"{SVG}rect"))[2:]
    end = float(first.get("x", "")) + float(first.get("width", ""))
    assert float(second.get("x", "")) == pytest.approx(end, abs=0.11)
    assert "8" in texts(svg) and first.get("y") == second.get("y")


def test_bars_that_cannot_be_drawn_are_our_own_mistake() -> None:
    for axis, value in ((Axis("a"), -1.0), (Axis("a", log=True), 1.0)):
        with pytest.raises(ValueError, match="begin at zero"):
            bars("t", ["a"], {"a": [value]}, axis)


def test_a_line_is_broken_where_it_has_no_value() -> None:
    whole, broken = (
        lines("t", [Line("a", [0, 1, 2, 3], [1, y, 2, 3])], Axis("x"), Axis("y"))
        for y in (1.5, math.nan)
    )
    assert path_of(whole).count("M") == 1 and path_of(broken).count("M") == 2


def path_of(svg: str) -> str:
    inner = parsed(svg).find(f"{SVG}svg")
    assert inner is not None
    return next(inner.iter(f"{SVG}path")).get("d", "")


def test_what_has_no_logarithm_is_left_out() -> None:
    svg = lines("t", [Line("a", [1, 2, 3], [0, -1, 5])], Axis("x"), Axis("y", log=True))
    assert path_of(svg).count("M") == 1 and "L" not in path_of(svg)


@pytest.mark.parametrize("ground", ["#fbfaf7", "#161513"])
@pytest.mark.parametrize("colour", COLOURS)
def test_colours_stand_out_from_light_and_dark_ground(colour: str, ground: str) -> None:
    """WCAG 2.2, 1.4.11: three to one for graphical objects."""
    dark, light = sorted((luminance(colour), luminance(ground)))
    assert (light + 0.05) / (dark + 0.05) >= 3


def luminance(colour: str) -> float:
    value = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [v / 12.92 if v <= 0.04045 else ((v + 0.055) / 1.055) ** 2.4 for v in value]
    return float(np.dot(linear, [0.2126, 0.7152, 0.0722]))


def test_series_take_the_pages_colours() -> None:
    svg = PLOTS["lines"]()
    assert set(re.findall(r"--series-\d", svg)) == {"--series-1", "--series-2"}


@given(st.floats(-1e6, 1e6), st.floats(1e-6, 1e6), st.integers(2, 9))
@example(low=879609.9999999999, size=1e-06, count=7)
def test_linear_ticks_are_round_and_within_limits(low: float, size: float, count: int) -> None:
    high = low + size
    ticks = linear_ticks(low, high, count)
    assert len(ticks) <= count
    assert all(low - 1e-6 * size <= tick <= high + 1e-6 * size for tick in ticks)
    if len(ticks) > 1:
        step = ticks[1] - ticks[0]
        digits = step / 10 ** math.floor(math.log10(step) + 1e-9)
        assert min(abs(digits - d) for d in (1, 2, 5, 10)) < 1e-2
        assert size / step < count


@given(st.floats(-9, 9), st.floats(0.5, 12), st.integers(2, 9))
def test_logarithmic_ticks_are_decades_or_ones_twos_and_fives(
    start: float, decades: float, count: int
) -> None:
    low, high = 10**start, 10 ** (start + decades)
    ticks = log_ticks(low, high, count)
    assert ticks == sorted(ticks) and 1 <= len(ticks) <= count
    assert all(low * 0.999 <= tick <= high * 1.001 for tick in ticks)
    assert {f"{tick:e}"[0] for tick in ticks} <= {"1", "2", "5"}


@given(st.floats(1e-30, 1e30), st.integers(1, 6))
def test_a_written_number_is_the_number(value: float, digits: int) -> None:
    text = number(-value, digits)
    assert text.startswith("−")
    plain = text.replace("−", "-").translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
    if "·" in plain:
        mantissa, power = plain.split("·")
        found = float(mantissa) * 10.0 ** int(power[2:])
    elif text.startswith("−10") and any(c in text for c in "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"):
        found = -(10.0 ** int(plain[3:]))
    else:
        found = float(plain)
    assert found == pytest.approx(-value, rel=0.51 * 10.0 ** (1 - digits))


def test_numbers_as_people_write_them() -> None:
    values = 0, 0.25, 100, 1e5, 1e-5, 2.5e-7, -1e6, math.nan, 1e-3, 123456
    written = "0", "0.25", "100", "10⁵", "10⁻⁵", "2.5·10⁻⁷", "−10⁶", "–", "0.001", "1.23456·10⁵"
    assert tuple(map(number, values)) == written
    assert count(1572864) == "1\u202f572\u202f864"


def test_limits_hold_the_data() -> None:
    scale = Scale(Axis("x"), np.array([3.2, 17.9, np.nan]), 0, 100)
    assert (scale.low, scale.high) == (0, 20)
    scale = Scale(Axis("x", log=True), np.array([0.03, 0, 700]), 0, 100)
    assert (scale.low, scale.high) == pytest.approx((0.02, 1000))
    assert scale.at(scale.high) == 100 and math.isnan(scale.at(-1))


def test_a_heat_map_leaves_out_what_is_not_known_and_parts_at_zero() -> None:
    x, y = (Axis(name, limits=(0, 4)) for name in "xy")
    svg = heat_map("t", [[-2.0, 0.0, 1.0, math.nan]], x, y, Axis("v", limits=(-2, 1)))
    image = next(parsed(svg).iter(f"{SVG}image"))
    data = base64.b64decode(image.get("href", "").partition(",")[2])
    pixels = np.asarray(Image.open(io.BytesIO(data)))[0].astype(int)
    assert pixels[:, 3].tolist() == [255, 255, 255, 0]
    assert np.ptp(pixels[1, :3]) == 0  # grey at zero
    assert pixels[0, 2] > pixels[0, 0] and pixels[2, 0] > pixels[2, 2]  # blue below, red above
