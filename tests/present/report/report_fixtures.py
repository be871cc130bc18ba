"""One whole report, made once: the steps that show what is drawn, and a stub of an answer."""

from functools import cache
from pathlib import Path
from xml.etree.ElementTree import Element

import html5lib
import numpy as np

from followspot.present.film_plan import FilmWish
from followspot.present.report import plot
from followspot.present.report.formula import formula
from followspot.present.report.material import Material
from followspot.present.report.page import Picture, pair
from followspot.present.report.pixels import jpeg
from followspot.present.report.plot import Line
from followspot.present.report.run import run
from followspot.present.report.section import Section
from followspot.present.report.steps import Step, all_steps
from followspot.present.report.ticks import Axis
from followspot.present.still import Wish

SIZE = (192, 108)
WISH = Wish(size=f"{SIZE[0]}x{SIZE[1]}")
RED, BLUE = (200, 30, 20), (20, 40, 210)

OWN = ["title", "film", "stages", "frame-time"]
"""Steps that show what is drawn; the others are tested where their experiments are."""


def answer(material: Material) -> Section:
    """Everything that answers put into the page; its pair is red before and blue after."""
    size = 320, 180
    files = {
        f"{name}.jpg": jpeg(np.full((*size[::-1], 3), colour, np.uint8))
        for name, colour in (("red", RED), ("blue", BLUE))
    }
    chart = plot.lines("A line", [Line("one", [0, 1], [0, 2])], Axis("x"), Axis("y"))
    colours = pair(
        Picture("red.jpg", size, "All red", "red"),
        Picture("blue.jpg", size, "All blue", "blue"),
        "Two colours",
        "Red, then <em>blue</em>.",
    )
    equation = formula(r"L_o = \int_\Omega f L_i \cos\theta d\omega", display=True)
    html = (
        f'<p class="formula">{equation}<span>(1)</span></p>'
        f"<figure>{chart}<figcaption>A line.</figcaption></figure>{colours}"
    )
    return Section("answer", "An answer with <brackets> & more", html, {"number": 0.25}, files)


@cache
def whole_report(base: Path) -> Path:
    """The folder of a report with a film of one second, made once below `base`."""
    folder = base / "whole-report" / "courtyard"
    film_wish = FilmWish(seconds=1)
    own = [step for step in all_steps(WISH, film_wish) if step.anchor in OWN]
    assert [step.anchor for step in own] == OWN
    steps = [*own, Step("answer", "An answer", answer)]
    assert run("courtyard", folder, WISH, film_wish, steps) == 0
    return folder


def parsed(html: str) -> Element:
    """The document's elements, without namespaces; any error in the HTML fails."""
    parser = html5lib.HTMLParser(html5lib.treebuilders.getTreeBuilder("etree"), strict=True)
    document: Element = parser.parse(html)
    for element in document.iter():
        if isinstance(element.tag, str):
            element.tag = element.tag.rpartition("}")[2]
    return document
