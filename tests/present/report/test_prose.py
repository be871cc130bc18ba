"""Prose: formulae where dollar signs stood."""

from pathlib import Path

import html5lib
import pytest
from jinja2 import Environment, FileSystemLoader

from followspot.present.report import page, prose


@pytest.fixture
def template(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    made = Environment(loader=FileSystemLoader(tmp_path), autoescape=True)
    monkeypatch.setattr(page, "_environment", lambda: made)
    return tmp_path / "t.html"


def test_formulae_stand_in_the_line_or_on_their_own(template: Path) -> None:
    template.write_text(r"<p>Let $x \lt 2$, and</p><p>$$ y = {{ n }} $$</p>", "utf-8")
    html = prose.prose("t.html", n=7)
    parsed = html5lib.HTMLParser(strict=True).parseFragment(html)
    inline, block = parsed.iter("{http://www.w3.org/1998/Math/MathML}math")
    assert (inline.get("display"), block.get("display")) == ("inline", "block")
    assert "".join(inline.itertext()) == "x<2" and "".join(block.itertext()) == "y=7"
    assert "$" not in html


def test_a_mark_stays_with_its_formula(template: Path) -> None:
    template.write_text("<p>$a$, $b$ and ($c$).</p>", "utf-8")
    html = prose.prose("t.html")
    assert html.count("nowrap") == 2 and html.index("</math>,</span>") < html.index(
        "</math>)</span>"
    )
    assert "".join(html5lib.parseFragment(html).itertext()) == "a, b and (c)."
