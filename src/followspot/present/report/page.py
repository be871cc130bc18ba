"""The page: steps' results set into templates. It needs no network, server or script to be read."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from followspot.present.report.section import Section


@dataclass(frozen=True)
class Failure:
    """A step that failed: where its section would stand, and what went wrong in one line."""

    anchor: str
    title: str
    problem: str


@dataclass(frozen=True)
class Picture:
    """A picture in the report's folder.

    Attributes:
        file: Its name there.
        size: (width, height) in pixels.
        alt: What it shows, for those who do not see it.
        label: A word or two that tell it from the other one of a pair.
    """

    file: str
    size: tuple[int, int]
    alt: str
    label: str = ""


def pair(before: Picture, after: Picture, title: str, caption: str) -> str:
    """Two pictures of one size, one over the other, with a divider to drag.

    Without a script they stand side by side.

    Args:
        before: Left of the divider.
        after: Right of it.
        title: A few words, plain text.
        caption: What the difference proves; HTML that is trusted.
    """
    return fill("pair.html", before=before, after=after, title=title, caption=caption)


def page(title: Section | Failure, parts: Sequence[Section | Failure], scene: str) -> str:
    """The whole document.

    Args:
        title: What stands above everything.
        parts: The sections, in order.
        scene: What the report is about.
    """
    failures = [part for part in (title, *parts) if isinstance(part, Failure)]
    return fill("page.html", title=title, parts=parts, failures=failures, scene=scene)


def fill(template: str, **values: Any) -> str:
    """One of the templates with its values set in; they are escaped, but for sections' HTML."""
    return _environment().get_template(template).render(values)


@cache
def _environment() -> Environment:
    made = Environment(
        loader=PackageLoader("followspot.present.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.tests["failure"] = lambda part: isinstance(part, Failure)
    made.filters["percent"] = lambda share: f"{share * 100:.3g}\u00a0%"
    made.filters["small"] = _small
    return made


def _small(value: float) -> str:
    """A number far below 1 in the page's plain text: 3·10⁻⁷."""
    digits, _, power = f"{value:.0e}".partition("e")
    raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{digits}·10{raised}" if value else "0"
