"""Prose with mathematics in it: templates that are read almost like what they become."""

import re
from html import unescape
from typing import Any

from followspot.present.report.formula import formula
from followspot.present.report.page import fill

_MATHEMATICS = re.compile(r"\$\$(.+?)\$\$|\$(.+?)\$([.,;:)]?)", re.DOTALL)


def prose(template: str, **values: Any) -> str:
    r"""A template filled in, with ``$...$`` as formulae and ``$$...$$`` as ones on their own line.

    Values may stand inside of formulae. In templates ``<`` is ``\lt`` there, and two opening braces
    have a blank between them, since they would be the template's.
    """
    return _MATHEMATICS.sub(_set, fill(template, **values))


def _set(match: re.Match[str]) -> str:
    display, inline, mark = match.groups()
    if display is not None:
        return formula(unescape(display).strip(), display=True)
    made = formula(unescape(inline).strip()) + mark
    # Browsers may break a line between a formula and the mark behind it.
    return f'<span style="white-space:nowrap">{made}</span>' if mark else made
