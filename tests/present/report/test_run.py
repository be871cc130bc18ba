"""Making a report: whole or as it was before, and honest about what failed."""

import errno
import json
import os
import resource
import signal
from dataclasses import replace
from pathlib import Path

import pytest
from report_fixtures import parsed

from followspot.errors import UnwritableError, UsageError
from followspot.present import files
from followspot.present.film_plan import FilmWish
from followspot.present.interrupt import Terminated, interruptible
from followspot.present.renderer import Renderer
from followspot.present.report.film_step import FilmStep
from followspot.present.report.material import Material
from followspot.present.report.run import run
from followspot.present.report.section import Section
from followspot.present.report.steps import Step
from followspot.present.still import Wish
from followspot.scene.load import load

WISH = Wish(size="64x36")


def section_of(html: str) -> Step:
    return Step("fine", "Fine", lambda _: Section("fine", "Fine", html))


def failing(error: BaseException) -> Step:
    def make(_: Material) -> Section:
        raise error

    return Step("broken", "Broken", make)


FINE = section_of("<p>still here</p>")
TITLE = Step("title", "Title", lambda _: Section("title", "Title", "", files={"a.jpg": b"x"}))


@pytest.mark.gl
@pytest.mark.parametrize(
    ("error", "told"),
    [
        (UsageError("no lamp <here>"), "no lamp <here>"),
        (ZeroDivisionError("by zero"), "ZeroDivisionError: by zero"),
    ],
)
def test_a_step_that_fails_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], error: Exception, told: str
) -> None:
    folder = tmp_path / "report"
    assert run("courtyard", folder, WISH, None, [TITLE, failing(error), FINE]) == 1
    document = parsed((folder / "index.html").read_text(encoding="utf-8"))
    text = " ".join("".join(document.itertext()).split())
    assert told in text and "still here" in text and "Broken (failed)" in text
    assert "Not all of this report could be made. What failed: Broken." in text
    assert json.loads((folder / "report.json").read_text())["failed"] == {"broken": told}
    out = capsys.readouterr().err
    assert f"Broken: failed: {told}" in out
    assert ("Traceback" in out) == isinstance(error, ZeroDivisionError)


@pytest.mark.gl
@pytest.mark.parametrize("where", ["section", "film", "page"])
def test_no_room_ends_it_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], where: str
) -> None:
    """One line that names the report's folder, and no step after that."""
    large = b"x" * 9999

    def own(material: Material) -> Section:
        with files.writing(material.folder / "film.mp4"):
            (material.folder / "film.mp4").write_bytes(large)
        raise AssertionError("went on")

    section = Section("s", "S", "x" * 9999 if where == "page" else "")
    steps = {
        "section": [Step("s", "S", lambda _: replace(section, files={"a.jpg": large}))],
        "film": [Step("f", "F", own)],
        "page": [Step("s", "S", lambda _: section)],
    }[where]
    later = [] if where == "page" else [failing(AssertionError("went on"))]
    folder = tmp_path / "report"
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
    try:
        with pytest.raises(UnwritableError) as caught:
            run("courtyard", folder, WISH, None, [*steps, *later])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert str(caught.value) == f"{folder}: cannot be written: File too large"
    assert "Traceback" not in (told := capsys.readouterr().err) and "failed" not in told
    assert list(tmp_path.iterdir()) == []


@pytest.mark.gl
def test_two_steps_with_one_file_do_not_go_unnoticed(tmp_path: Path) -> None:
    same = Step("b", "B", lambda _: Section("b", "B", "", files={"a.jpg": b"y"}))
    assert run("courtyard", tmp_path / "report", WISH, None, [TITLE, same]) == 1
    assert (tmp_path / "report" / "a.jpg").read_bytes() == b"x"


@pytest.mark.gl
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_leaves_the_report_before(tmp_path: Path, number: int) -> None:
    folder = tmp_path / "deep" / "report"
    assert run("courtyard", folder, WISH, None, [TITLE, FINE]) == 0
    before = {path.name: path.read_bytes() for path in folder.iterdir()}

    def make(material: Material) -> Section:
        (material.folder / "half").write_bytes(b"half")
        os.kill(os.getpid(), number)
        raise AssertionError("went on")

    with pytest.raises(KeyboardInterrupt), interruptible():
        run("courtyard", folder, WISH, None, [TITLE, Step("stop", "Stop", make)])
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert list(folder.parent.iterdir()) == [folder]
    assert run("courtyard", folder, WISH, None, [FINE]) == 0
    assert sorted(path.name for path in folder.iterdir()) == ["index.html", "report.json"]


@pytest.mark.gl
@pytest.mark.parametrize(
    ("number", "kind"), [(signal.SIGINT, KeyboardInterrupt), (signal.SIGTERM, Terminated)]
)
def test_an_interrupt_ends_the_film_too(
    tmp_path: Path, number: signal.Signals, kind: type[BaseException]
) -> None:
    shares: list[float] = []

    def stop(share: float, _: str) -> None:
        shares.append(share)
        if len(shares) == 3:
            os.kill(os.getpid(), number)

    scene = load("courtyard")
    with Renderer((64, 36)) as renderer, pytest.raises(KeyboardInterrupt) as told, interruptible():
        own = Material("courtyard", scene, scene.camera(), (64, 36), (), renderer, tmp_path, stop)
        FilmStep(WISH, FilmWish(seconds=10))(own)
    assert len(shares) < 10 and told.type is kind


@pytest.mark.gl
def test_a_scene_whose_name_is_no_text(tmp_path: Path) -> None:
    scene = str(tmp_path / os.fsdecode(b"b\xffd.toml"))
    Path(scene).write_text('level = "courtyard"\n')
    folder = tmp_path / "report"
    assert run(scene, folder, WISH, None, [FINE]) == 0
    parsed((folder / "index.html").read_text(encoding="utf-8"))
    assert json.loads((folder / "report.json").read_text())["scene"].endswith(r"b\udcffd.toml")


@pytest.mark.parametrize("kind", ["file", "link", "notes", "bad json", "nameless"])
def test_folders_that_are_no_reports_are_left_alone(tmp_path: Path, kind: str) -> None:
    folder = tmp_path / "precious"
    if kind == "file":
        folder.write_text("mine")
    elif kind == "link":
        (tmp_path / "elsewhere").mkdir()
        folder.symlink_to(tmp_path / "elsewhere")
    elif kind != "nameless":
        folder.mkdir()
        listed = '{"files": 3}' if kind == "bad json" else '{"files": ["report.json"]}'
        (folder / "report.json").write_text(listed)
        (folder / "notes.txt").write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(UsageError, match=r"report|anew"):
        run("courtyard", Path("/") if kind == "nameless" else folder, WISH, None, [FINE])
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.gl
def test_a_page_that_cannot_be_written_is_told_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(UsageError, match="report: cannot be written: No space left"):
        run("courtyard", tmp_path / "report", WISH, None, [FINE])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.gl
def test_an_empty_folder_will_do(tmp_path: Path) -> None:
    folder = tmp_path / "empty"
    folder.mkdir()
    assert run("courtyard", folder, WISH, None, [FINE]) == 0
    assert (folder / "index.html").exists()
