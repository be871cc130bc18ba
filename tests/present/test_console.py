"""What users and files say is printed as it is, whatever brackets and colons it has."""

import shutil
import sys
from pathlib import Path

import pytest

import followspot
from followspot import cli
from followspot.present.report import run as report_run
from followspot.present.report.steps import all_steps

Capture = pytest.CaptureFixture[str]

FOLDER = Path("[maps]", "[", "b] :smile:")
"""Rich's markup has [maps] vanish and [/b] close what was never opened."""

BUILTIN = Path(followspot.__file__).parent / "builtin"
SMALL = ("--size", "32x24")


@pytest.fixture
def level(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "300")  # so that no table folds a name
    FOLDER.mkdir(parents=True)
    return Path(shutil.copy(BUILTIN / "courtyard.pk3", FOLDER / "[red]yard.pk3"))


def run(monkeypatch: pytest.MonkeyPatch, *typed: str) -> None:
    monkeypatch.setattr(sys, "argv", ["followspot", *typed])
    with pytest.raises(SystemExit) as done:
        cli.main()
    assert done.value.code == 0


@pytest.mark.gl
@pytest.mark.parametrize(
    ("command", "options", "printed"),
    [
        ("inspect", (), "[red]yard.pk3  "),
        ("bench", (*SMALL, "--frames", "1"), "[red]yard.pk3 at 32x24"),
        ("figures", (*SMALL, "-o", f"{FOLDER}/[out]"), f"{FOLDER}/[out]/1-normals.png"),
        ("film", (*SMALL, "--seconds", "0.1", "-o", f"{FOLDER}/[out].mp4"), f"{FOLDER}/[out].mp4:"),
        ("validate", (*SMALL, "-o", f"{FOLDER}/[out]"), f"figures.json are in {FOLDER}/[out]"),
        ("report", (*SMALL, "--no-film", "-o", f"{FOLDER}/[out]"), f"{FOLDER}/[out]/index.html:"),
    ],
    ids=["inspect", "bench", "figures", "film", "validate", "report"],
)
def test_brackets_in_paths(
    level: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: Capture,
    command: str,
    options: tuple[str, ...],
    printed: str,
) -> None:
    monkeypatch.setattr(report_run, "all_steps", lambda *wishes: all_steps(*wishes)[:1])
    run(monkeypatch, command, str(level), *options)
    told = capsys.readouterr()
    assert printed in told.out + told.err


def test_brackets_in_what_a_file_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capture
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "300")
    Path("a.obj").write_text(
        "mtllib a.mtl\nv 0 0 0\nv 9 0 0\nv 0 9 0\nvt 0 0\nusemtl one\nf 1/1 2/1 3/1\n"
    )
    Path("a.mtl").write_text("newmtl one\nmap_Kd [/nothere].png\n")
    run(monkeypatch, "inspect", "a.obj")
    assert "missing: [/nothere].png (tried " in capsys.readouterr().out
