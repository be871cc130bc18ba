"""What a step of the report hands to the page."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Section:
    """A part of the page.

    Attributes:
        anchor: Its id in the page, of letters and dashes.
        title: Plain text.
        html: The body: HTML that is trusted, with its SVG plots, MathML and figures in it.
        figures: Numbers that it found, by name; they are written into ``report.json`` too.
        files: What the page refers to, by name in the report's folder.
    """

    anchor: str
    title: str
    html: str
    figures: Mapping[str, float] = field(default_factory=dict)
    files: Mapping[str, bytes] = field(default_factory=dict)
