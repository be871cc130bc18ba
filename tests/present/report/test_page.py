"""The report's page: valid, self-contained, and what its command makes of mistakes."""

import json
import sys
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import urlsplit
from xml.etree.ElementTree import Element

import av
import numpy as np
import pytest
from PIL import Image
from report_fixtures import parsed, whole_report

from followspot import cli
from followspot.errors import UsageError
from followspot.passes.frame import PASSES, FrameReport
from followspot.present import bench
from followspot.present.bench import Timing
from followspot.present.film_plan import FilmWish
from followspot.present.renderer import Renderer
from followspot.present.report.film_step import FilmStep
from followspot.present.report.frame_time import frame_time
from followspot.present.report.material import Material
from followspot.present.report.page import Failure, page
from followspot.present.report.run import run
from followspot.present.report.section import Section
from followspot.present.report.stage_numbers import measure
from followspot.present.report.steps import all_steps
from followspot.present.still import Wish
from followspot.scene.camera import Camera
from followspot.scene.fog import Fog
from followspot.scene.load import load
from followspot.scene.scene import Scene
from followspot.spaces import vec3
from synthetic import (
    DIM,
    SIZE,
    WHITE_SKY,
    box,
    camera,
    floor,
    looking,
    make_scene,
    point,
    quad,
    spot,
)

WISH = Wish(size="64x36")
REFERENCES = ("src", "href", "poster", "srcset", "data", "action", "formaction", "background")


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return whole_report(tmp_path_factory.getbasetemp())


@pytest.fixture(scope="module")
def document(report: Path) -> Element:
    return parsed((report / "index.html").read_text(encoding="utf-8"))


def references(document: Element) -> Iterator[str]:
    for element in document.iter():
        for name, value in element.attrib.items():
            if name.rpartition("}")[2] in REFERENCES:
                yield value


# ---- the page


@pytest.mark.gl
def test_nothing_is_fetched_from_elsewhere(report: Path, document: Element) -> None:
    """Every reference is a file of the report, a place in the page, or data; every file is used."""
    ids = [element.attrib["id"] for element in document.iter() if "id" in element.attrib]
    assert len(ids) == len(set(ids))
    used = {"index.html", "report.json"}
    for value in references(document):
        url = urlsplit(value)
        assert url.scheme in ("", "data") and not url.netloc and not url.query, value
        if url.scheme == "" and url.path:
            used.add(url.path)
        if url.fragment:
            assert not url.path and url.fragment in ids
    assert used == {path.name for path in report.iterdir()}
    text = (report / "index.html").read_text(encoding="utf-8")
    for name in ("http://www.w3.org/2000/svg", "http://www.w3.org/1998/Math/MathML"):
        text = text.replace(f'xmlns="{name}"', "")
    assert "http:" not in text and "https:" not in text and "@import" not in text
    assert "url(" not in text


@pytest.mark.gl
def test_every_picture_is_there_and_told_of(report: Path, document: Element) -> None:
    pictures = list(document.iter("img"))
    assert len(pictures) > 10
    for picture in pictures:
        assert len(picture.attrib["alt"]) > 7 or picture.attrib["alt"].startswith("All ")
        with Image.open(report / picture.attrib["src"]) as image:
            size = int(picture.attrib["width"]), int(picture.attrib["height"])
            assert image.size == size
    charts = document.findall(".//figure/svg")
    assert len(charts) == 2
    for chart in charts:
        assert chart.attrib["role"] == "img" and chart.findtext("title")


@pytest.mark.gl
def test_landmarks_and_headings(document: Element) -> None:
    assert document.find(".").attrib["lang"] == "en"  # type: ignore[union-attr]
    for landmark in ("header", "nav", "main", "footer", "h1"):
        assert len(list(document.iter(landmark))) == 1, landmark
    levels = [int(e.tag[1]) for e in document.iter() if e.tag in ("h1", "h2", "h3", "h4")]
    assert levels[0] == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    sections = {e.attrib["id"]: e.attrib["aria-labelledby"] for e in document.iter("section")}
    headings = {e.attrib["id"]: "".join(e.itertext()) for e in document.iter("h2")}
    links = [e for e in document.iter("a") if e.attrib["href"].startswith("#")]
    assert [link.attrib["href"][1:] for link in links] == list(sections)
    assert list(sections) == ["film", "making", "stages", "frame-time", "answer"]
    for link in links:
        assert headings[sections[link.attrib["href"][1:]]] == "".join(link.itertext())
    assert "An answer with <brackets> & more" in headings.values()


@pytest.mark.gl
def test_one_viewpoint_and_shape(report: Path) -> None:
    """All stages have one aspect, and are different pictures of the same place."""
    names = ("normals", "lambertian", "shading", "light", "environment", "shadows", "bounds")
    pictures = [np.asarray(Image.open(report / f"stage-{name}.jpg")) for name in names]
    assert {picture.shape for picture in pictures} == {(216, 384, 3)}
    stacked = np.array(pictures, np.float64)
    for k in range(len(names)):
        others = np.delete(np.arange(len(names)), k)
        assert np.abs(stacked[others] - stacked[k]).mean(axis=(1, 2, 3)).min() > 1, names[k]
    title = np.asarray(Image.open(report / "title.jpg"))
    assert np.array_equal(title, pictures[names.index("shadows")])


@pytest.mark.gl
def test_the_figures(report: Path) -> None:
    told = json.loads((report / "report.json").read_text())
    assert told["files"] == sorted(path.name for path in report.iterdir())
    assert told["scene"] == "courtyard" and told["size"] == [192, 108] and told["failed"] == {}
    courtyard = load("courtyard")
    assert told["camera"] == pytest.approx([*courtyard.camera().position, 36, -5, 80])
    stages = told["figures"]["stages"]
    assert stages["normal_length_error"] < 1e-6 and stages["product_error"] < 5e-6
    assert 0 < stages["albedo_mean"] < stages["albedo_largest"] <= 1
    assert stages["product_share"] > 0.9
    times = told["figures"]["frame-time"]
    names = [*PASSES, "median", *(f"redrawn_{name}" for name in (*PASSES, "median"))]
    assert times.keys() == {f"{name}_ms" for name in (*names, "p95", "submit")}
    assert np.isfinite(list(times.values())).all()
    assert told["figures"]["film"]["frames"] == 30
    assert told["figures"]["film"]["bytes"] == (report / "film.mp4").stat().st_size
    assert told["figures"]["answer"] == {"number": 0.25}
    assert told["figures"]["making"]["lines_of_Python"] > 10_000


def test_text_is_escaped_and_markup_is_not() -> None:
    failure = Failure("b", "T & U", "expected <x>, found 'y'")
    html = page(
        failure, [Section("a", "<i>", "<p>1 &lt; 2</p>"), failure], "<script>alert(1)</script>"
    )
    document = parsed(html)
    assert [e.text for e in document.iter("h1")] == ["<script>alert(1)</script>"]
    assert len(list(document.iter("script"))) == 1
    assert [e.text for e in document.iter("h2")] == ["<i>", "T & U"]
    assert "1 < 2" in "".join(document.itertext())
    assert "".join(document.itertext()).count("expected <x>, found 'y'") == 2


@pytest.mark.gl
@pytest.mark.openarena
def test_a_level_without_paths(tmp_path: Path) -> None:
    """Its film flies where `auto` finds a way."""
    folder = tmp_path / "report"
    film_wish = FilmWish(seconds=0.2)
    steps = [step for step in all_steps(WISH, film_wish) if step.anchor in ("title", "film")]
    assert run("oa_dm5", folder, WISH, film_wish, steps) == 0
    text = (folder / "index.html").read_text(encoding="utf-8")
    parsed(text)
    assert "The way was found in the level" in text
    with av.open(str(folder / "film.mp4")) as container:
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert len(frames) == 6 and frames[0].std() > 5


# ---- what is measured


def timing(ms: float) -> Timing:
    """Every time alike."""
    frame = FrameReport(ms, 1, 1, 1, 0, False, 0, 0)
    return Timing(ms, ms, ms, ms, frame, "view", dict.fromkeys(PASSES, ms))


@pytest.mark.parametrize("ms", [0.0, 0.02, 3.0])
def test_frame_times_of_a_fast_machine(monkeypatch: pytest.MonkeyPatch, ms: float) -> None:
    monkeypatch.setattr(bench, "measure", lambda *_: timing(ms))
    renderer = SimpleNamespace(gl_renderer="a fast one")
    section = frame_time(material(renderer, make_scene([floor()])))  # type: ignore[arg-type]
    assert all(name in section.html for name in PASSES)


@pytest.mark.gl
def test_frame_time_has_the_shadow_map_kept_and_drawn_anew(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    measured: list[Timing] = []

    def measure_few(renderer: Renderer, scene: Scene, view: Camera, frames: int) -> Timing:
        renderer.open(scene)
        measured.append(whole(renderer, scene, view, 3))
        return measured[-1]

    whole = bench.measure
    monkeypatch.setattr(bench, "measure", measure_few)
    lamp = spot((0, 0, 300), (0, 0, 0), 40)
    frame_time(material(renderer, make_scene([floor(), *box((-20, -20, 20), (20, 20, 60))], lamp)))
    kept, redrawn = (each.frame for each in measured)
    assert (kept.shadow_redrawn, redrawn.shadow_redrawn) == (False, True)
    assert kept.shadow_draws == 0 < redrawn.shadow_draws


def material(renderer: Renderer, scene: Scene, **where: Any) -> Material:
    view = where.get("view") or looking((-300, 0, 200), (0, 0, 0))
    return Material("synthetic", scene, view, SIZE, (), renderer, Path("nowhere"), lambda *_: None)


@pytest.mark.gl
def test_a_roof_takes_all_the_light(renderer: Renderer) -> None:
    """A floor under a large roof, looked at from between: nothing of the lamp arrives."""
    lamp = spot((0, 0, 900), (0, 0, 0), 60, 900)
    roof = [quad((0, 0, z), (3000, 0, 0), (0, turn * 3000, 0)) for z, turn in ((500, -1), (510, 1))]
    below = looking((-300, 0, 200), (0, 0, 0), 60)
    numbers = measure(material(renderer, make_scene([floor(), *roof], lamp), view=below))
    assert numbers.shadowed_share == pytest.approx(1, abs=1e-6)
    open_air = measure(material(renderer, make_scene([floor()], lamp), view=below))
    assert open_air.shadowed_share == pytest.approx(0, abs=1e-6)
    assert open_air.unlit_share < numbers.unlit_share + 1e-9


@pytest.mark.gl
def test_where_light_comes_from(renderer: Renderer) -> None:
    """All of it from the sky, or none; a floor lit from below is lit by nothing."""
    sky = measure(material(renderer, make_scene([floor()], sky=WHITE_SKY)))
    assert sky.environment_share == 1 and sky.unlit_share == 1
    lamp = make_scene([floor()], point((0, 0, 300)), settings=DIM)
    assert measure(material(renderer, lamp)).environment_share == 0
    assert measure(material(renderer, lamp)).unlit_share == 0
    below = make_scene([floor()], point((0, 0, -300)), settings=DIM)
    assert measure(material(renderer, below)).unlit_share == 1
    numbers = measure(material(renderer, lamp))
    assert numbers.albedo_mean == numbers.albedo_largest == 1
    assert numbers.product_share == 1 and numbers.product_error < 1e-6
    low, high, grey = (vec3((x, x, x)) for x in (-900, 900, 0.5))
    fog = Fog(low, high, grey, 0.01)
    foggy = replace(lamp, level=replace(lamp.level, fogs=(fog,)))
    assert measure(material(renderer, foggy)) == numbers, "of surfaces, not of what is before them"
    nothing = measure(material(renderer, lamp, view=camera((0, 0, 100), pitch=-60)))
    assert nothing.albedo_largest == nothing.unlit_share == 0


# ---- the command


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--path", "nowhere"), "no path is named"),
        (("--camera", "roof"), "no camera is named"),
        (("--size", "big"), "WIDTHxHEIGHT"),
        (("--size", "8193x64", "--no-film"), "--size: expected edges of at most 8192 pixels"),
        (("--size", "64x8193"), "have 2 times as many, found '64x8193'"),
        (("--seconds", "0"), "--seconds: expected 0.001 to 36000 s, found 0"),
        (("--seconds", "nan"), "--seconds"),
        (("--jobs", "1000"), "--jobs"),
        (("--set", "baked_light=1"), "setting baked_light: expected 0 in a report"),
        (("-o", "x" * 300), "xxx: cannot be written: File name too long"),
    ],
)
def test_mistakes_are_told_before_anything_is_made(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    options: tuple[str, ...],
    told: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["followspot", "report", "courtyard", "-o", "r", *options])
    with pytest.raises(SystemExit) as caught:
        cli.main()
    assert caught.value.code == 2
    error = capsys.readouterr().err
    assert told in error and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("typed", "is_filmed"),
    [
        (("courtyard",), True),
        (("courtyard", "--no-film", "--path", "auto"), False),
        (("player:sarge", "--jobs", "2"), False),
        (("x.obj", "--film"), True),
        (("player:sarge", "--seconds", "3"), True),
    ],
)
def test_models_alone_have_no_film_unless_one_is_asked_for(
    monkeypatch: pytest.MonkeyPatch, typed: tuple[str, ...], is_filmed: bool
) -> None:
    wishes: list[FilmWish | None] = []

    def take(scene: str, folder: Path, wish: Wish, film_wish: FilmWish | None) -> int:
        wishes.append(film_wish)
        return 0

    monkeypatch.setattr("followspot.present.report.run.run", take)
    monkeypatch.setattr(sys, "argv", ["followspot", "report", *typed, "-o", "r"])
    with pytest.raises(SystemExit):
        cli.main()
    assert [wish is not None for wish in wishes] == [is_filmed]


def test_a_film_of_a_model_is_refused_at_once(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"--film: expected a level .*, found a model: player:x"):
        run("player:x", tmp_path / "r", WISH, FilmWish(), [])


def test_the_steps_and_the_film() -> None:
    """Without a film there is no such step; with one, its size is even whatever is asked for."""
    assert [step.anchor for step in all_steps(WISH, None)] == [
        "title", "stages", "frame-time", "environment", "bias", "lights", "interpolation",
    ]  # fmt: skip
    film = all_steps(replace(WISH, size="65x37"), FilmWish())[1]
    assert isinstance(film.make, FilmStep) and film.make.wish.size == "66x38"
