"""The report in a real browser, from its file, without network: Debian's Chromium, headless."""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright
from report_fixtures import whole_report

CHROMIUM = "/usr/bin/chromium"
RED_SHOWN, BLUE_SHOWN = 0, 2
"""Which channel is the brightest where a picture of the stub's pair shows."""

pytestmark = pytest.mark.gl


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return whole_report(tmp_path_factory.getbasetemp())


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield browser
        browser.close()


@contextmanager
def opened(
    browser: Browser,
    report: Path,
    width: int = 1280,
    *,
    script: bool = True,
    scheme: str = "light",
) -> Iterator[Page]:
    """The report's page; whatever it complains of, or wants from elsewhere, fails."""
    context = browser.new_context(
        viewport={"width": width, "height": 800},
        java_script_enabled=script,
        color_scheme=scheme,  # type: ignore[arg-type]
    )
    page = context.new_page()
    complaints: list[str] = []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    fetched: list[str] = []
    page.on("request", lambda request: fetched.append(request.url))
    page.goto((report / "index.html").as_uri(), wait_until="load")
    yield page
    context.close()
    assert complaints == []
    assert {url.partition(":")[0] for url in fetched} <= {"file", "data"}


def seen(page: Page) -> NDArray[np.uint8]:
    """(h, w, 3) pixels of the pair that is red before and blue after, as it is shown."""
    shot = page.locator(".pair").last.screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"))


def divider(page: Page) -> float:
    """Share of the pair's width up to where red gives way to blue, halfway up the top half."""
    row = seen(page)[len(seen(page)) // 4].astype(np.int64)
    is_red = row[:, 0] - row[:, 2] > 60
    is_blue = row[:, 2] - row[:, 0] > 60
    assert (is_red | is_blue).mean() > 0.97
    end = int(np.flatnonzero(is_red).max(initial=-1)) + 1
    assert not is_blue[:end].any(), "red and blue are mixed"
    return end / len(row)


def test_it_loads_without_complaint(browser: Browser, report: Path) -> None:
    """Nothing in the console, nothing from elsewhere, and every picture is decoded."""
    with opened(browser, report) as page:
        assert "courtyard" in page.title()
        pictures = page.locator("img")
        assert pictures.count() > 10
        for picture in pictures.all():
            assert picture.evaluate("e => e.decode().then(() => e.naturalWidth)") > 100


def test_the_film_plays(browser: Browser, report: Path) -> None:
    with opened(browser, report) as page:
        film = page.locator("video")
        film.scroll_into_view_if_needed()
        assert film.evaluate("e => e.paused")
        film.evaluate("e => e.play()")
        page.wait_for_function("document.querySelector('video').currentTime > 0.2", timeout=20_000)
        assert film.evaluate("e => [e.error, e.videoWidth, e.videoHeight]") == [None, 192, 108]
        assert film.evaluate("e => e.duration") == pytest.approx(1, abs=0.05)


def test_the_divider_follows_the_mouse(browser: Browser, report: Path) -> None:
    with opened(browser, report) as page:
        pair = page.locator(".pair").last
        pair.scroll_into_view_if_needed()
        assert divider(page) == pytest.approx(0.5, abs=0.01)
        box = pair.bounding_box()
        assert box is not None
        middle = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + 0.5 * box["width"], middle)
        page.mouse.down()
        for share in (0.4, 0.2, 0.75):
            page.mouse.move(box["x"] + share * box["width"], middle + 5)
            assert divider(page) == pytest.approx(share, abs=0.01)
        page.mouse.move(box["x"] + 2 * box["width"], middle)  # beyond the picture
        assert divider(page) > 0.98
        page.mouse.up()
        page.mouse.move(box["x"] + 0.3 * box["width"], middle)
        assert divider(page) > 0.98
        page.mouse.click(box["x"] + 0.3 * box["width"], middle)
        assert divider(page) == pytest.approx(0.3, abs=0.01)


def test_the_divider_follows_the_keyboard(browser: Browser, report: Path) -> None:
    """It is reached with the tab key, says what it divides, and tells where it is."""
    with opened(browser, report) as page:
        slider = page.get_by_role("slider", name="Divider between red and blue")
        for _ in range(60):
            page.keyboard.press("Tab")
            if slider.evaluate("e => e === document.activeElement"):
                break
        else:
            raise AssertionError("the tab key does not reach the divider")
        assert slider.get_attribute("aria-valuetext") == "50 % red, 50 % blue"
        at = divider(page)
        for key in ("ArrowRight", "ArrowRight", "ArrowUp"):
            page.keyboard.press(key)
            assert divider(page) > at
            at = divider(page)
        page.keyboard.press("ArrowLeft")
        assert divider(page) < at
        page.keyboard.press("End")
        assert divider(page) > 0.98
        page.keyboard.press("Home")
        assert divider(page) < 0.02
        assert slider.get_attribute("aria-valuetext") == "0 % red, 100 % blue"


def test_without_a_script_both_pictures_stand_side_by_side(browser: Browser, report: Path) -> None:
    with opened(browser, report, script=False) as page:
        sides_by_side(page)


def test_on_paper_too(browser: Browser, report: Path) -> None:
    with opened(browser, report) as page:
        page.emulate_media(media="print")
        sides_by_side(page)
        assert (
            not page.locator("video").is_visible() and page.get_by_alt_text("A frame").is_visible()
        )
        assert not page.get_by_role("slider").first.is_visible()
        assert page.pdf(format="A4").startswith(b"%PDF")


def sides_by_side(page: Page) -> None:
    boxes = [side.bounding_box() for side in page.locator(".pair").last.locator("img").all()]
    left, right = boxes
    assert left is not None and right is not None
    assert left["x"] + left["width"] <= right["x"] and left["y"] == right["y"]
    assert left["width"] == right["width"] > 100
    pixels = seen(page)
    for pixel, brightest in ((pixels[40, 40], RED_SHOWN), (pixels[40, -40], BLUE_SHOWN)):
        assert int(np.argmax(pixel)) == brightest


@pytest.mark.parametrize("script", [True, False])
@pytest.mark.parametrize("width", [320, 380, 800, 1600])
def test_no_scrolling_sideways(browser: Browser, report: Path, width: int, script: bool) -> None:
    with opened(browser, report, width, script=script) as page:
        for locator in page.locator("header > *, main > *, section > *, img, video, footer").all():
            box = locator.bounding_box()
            assert box is None or (box["x"] >= 0 and box["x"] + box["width"] <= width + 0.01)
        if script:
            assert page.evaluate("document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out(browser: Browser, report: Path, scheme: str) -> None:
    """By the contrast that WCAG 2 asks of all text, 4.5 to 1, in both colour schemes."""
    with opened(browser, report, scheme=scheme) as page:
        paper = luminance(page, "body", "backgroundColor")
        assert (paper > 0.8) if scheme == "light" else (paper < 0.02)
        for text in (
            "p.lead",
            "p.kicker",
            "figcaption",
            "figcaption b",
            "h2",
            "dt",
            "nav a",
            "svg",
        ):
            ink = luminance(page, text, "color")
            contrast = (max(ink, paper) + 0.05) / (min(ink, paper) + 0.05)
            assert contrast > 4.5, (text, contrast)


def luminance(page: Page, selector: str, what: str) -> float:
    """Relative luminance of the first such element's colour (WCAG 2.2)."""
    colour = page.locator(selector).first.evaluate(f"e => getComputedStyle(e).{what}")
    numbers = colour.removeprefix("rgb(").removesuffix(")").split(",")
    v = np.array([float(number) for number in numbers]) / 255
    linear = np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def test_formulae_are_set(browser: Browser, report: Path) -> None:
    """As mathematics: the integral's limit stands below its sign, not after it as text."""
    with opened(browser, report) as page:
        place = "e => e.getBoundingClientRect()"
        integral, limit = (
            page.locator("math msub", has_text="∫").first.locator(f"xpath=./*[{k}]").evaluate(place)
            for k in (1, 2)
        )
        assert limit["top"] > integral["top"] and limit["height"] < integral["height"]
        assert limit["left"] >= integral["left"]
