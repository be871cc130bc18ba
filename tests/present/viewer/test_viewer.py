"""The window, in processes of their own on an X server of their own."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from driver import display, play
from PIL import Image

import synthetic
from followspot.errors import UsageError
from followspot.present.viewer import window
from followspot.present.viewer.state import State

NOTHING_DRAWN = {"GALLIUM_NOOP": "1", "GALLIUM_THREAD": "0"}
"""For Mesa, where nobody looks at the picture: all but the pixels is done."""

pytestmark = pytest.mark.gl


@pytest.fixture(scope="module")
def screen() -> Iterator[str]:
    with display() as name:
        yield name


def test_flying(screen: str, tmp_path: Path) -> None:
    play("flying", screen, tmp_path)


def test_choosing_stages_and_halves(screen: str, tmp_path: Path) -> None:
    play("choosing", screen, tmp_path)


def test_the_window_shows_what_render_writes(screen: str, tmp_path: Path) -> None:
    commands = json.loads(play("rendering", screen, tmp_path))
    assert set(commands) == {"normals", "direct", "final"}
    shown = []
    for view, words in commands.items():
        subprocess.run([sys.executable, "-m", *words], cwd=tmp_path, check=True, timeout=60)
        shown.append(np.load(tmp_path / "work" / f"{view}.npy"))
        assert np.array_equal(shown[-1], np.asarray(Image.open(tmp_path / "view.png"))), view
        assert shown[-1].std() > 20
    assert not np.array_equal(shown[0], shown[1])


def test_resizing_and_closing(screen: str, tmp_path: Path) -> None:
    play("resizing", screen, tmp_path)


def test_the_panels_widgets(screen: str, tmp_path: Path) -> None:
    play("panels", screen, tmp_path, **NOTHING_DRAWN)


def test_a_light_is_moved_by_its_gizmo(screen: str, tmp_path: Path) -> None:
    play("dragging", screen, tmp_path, **NOTHING_DRAWN)


def test_ten_levels_leave_no_gl_object_behind(screen: str, tmp_path: Path) -> None:
    play("switching", screen, tmp_path, **NOTHING_DRAWN)


def test_a_scene_that_cannot_be_drawn(screen: str, tmp_path: Path) -> None:
    play("failing", screen, tmp_path, **NOTHING_DRAWN)


def test_fourteen_levels_leave_no_memory_behind(screen: str, tmp_path: Path) -> None:
    play("reopening", screen, tmp_path)


def test_panels_hide_and_their_layout_is_remembered(screen: str, tmp_path: Path) -> None:
    for was_closed in "01":
        play("hiding", screen, tmp_path, WAS_CLOSED=was_closed)
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert tmp_path / ".config" / "followspot" / "viewer.ini" in files
    assert not any((tmp_path / "work").iterdir())


def test_a_window_that_closes_too_early_does_not_go_unnoticed(screen: str, tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="closed at another time"):
        play("ending_early", screen, tmp_path, **NOTHING_DRAWN)


def test_it_works_where_nothing_can_be_remembered(screen: str, tmp_path: Path) -> None:
    play("standing", screen, tmp_path, HOME="/dev/null/nobody")


def test_all_is_closed_even_if_a_film_cannot_be_written(monkeypatch: pytest.MonkeyPatch) -> None:
    closed = Mock()
    for name in ("hello_imgui.manual_render", "implot", "Renderer", "Inspector"):
        monkeypatch.setattr(f"{window.__name__}.{name}", getattr(closed, name.split(".")[0]))
    for name in ("window_context", "Pointer", "FrameTimer", "is_software"):
        monkeypatch.setattr(window, name, Mock())
    closed.Renderer.return_value.__enter__ = Mock()
    closed.Renderer.return_value.__exit__ = Mock(return_value=False)
    scene = synthetic.make_scene([synthetic.floor()])
    viewer = window.Viewer(State.of(scene, synthetic.camera((0, 0, 9))), (64, 48))
    viewer.params.app_shall_exit = True
    monkeypatch.setattr(viewer._recorder, "close", Mock(side_effect=UsageError("disk is full")))
    with pytest.raises(UsageError, match="disk is full"):
        viewer.run()
    closed.Inspector.return_value.release.assert_called_once()
    closed.Renderer.return_value.__exit__.assert_called_once()
    closed.implot.destroy_context.assert_called_once()
    closed.hello_imgui.tear_down.assert_called_once()


@pytest.mark.parametrize("name", ["", ":98765"])
def test_without_a_display_one_sentence_says_what_works(name: str) -> None:
    ended = _view("courtyard", name)
    assert ended.returncode == 2
    assert ended.stdout == ""
    assert ended.stderr.count("\n") == 1
    assert "no display" in ended.stderr
    assert "followspot render" in ended.stderr
    assert "followspot film" in ended.stderr


@pytest.mark.parametrize("words", [["no_such_level"], ["courtyard", "--camera=nowhere"]])
def test_what_cannot_be_opened_is_told_in_one_line(words: list[str], screen: str) -> None:
    ended = _view(*words, screen)
    assert ended.returncode == 2
    assert ended.stderr.count("\n") == 1
    assert words[-1].removeprefix("--camera=") in ended.stderr


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--light=point:1,1,100:50"] * 9, "--light: at most 8 lights"),
        (["--set=shadow_map_size=8192", *["--light=point:1,1,100:50"] * 8], "shadow_map_size: "),
    ],
)
def test_what_cannot_be_drawn_is_told_in_one_line(words: list[str], told: str, screen: str) -> None:
    ended = _view("courtyard", *words, screen)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr.startswith(f"followspot: {told}") and ended.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("number", "told"), [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated")]
)
def test_an_interrupt_closes_the_window(
    screen: str, monkeypatch: pytest.MonkeyPatch, number: signal.Signals, told: str
) -> None:
    """After a frame has been drawn; that is, in the midst of the loop."""
    code = (
        "import os, sys; from followspot import cli; from followspot.present.viewer import canvas;"
        "draw = canvas.draw;"
        f"canvas.draw = lambda *a: (os.kill(os.getpid(), {int(number)}), draw(*a))[1];"
        "sys.argv = ['followspot', 'view', 'courtyard']; cli.main()"
    )
    monkeypatch.setenv("DISPLAY", screen)
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert (ended.returncode, ended.stderr) == (128 + number, f"followspot: {told}\n")


def _view(*words: str) -> subprocess.CompletedProcess[str]:
    """``followspot view``; the last word is the display's name, or empty for none."""
    environment = {key: value for key, value in os.environ.items() if "DISPLAY" not in key}
    if words[-1]:
        environment["DISPLAY"] = words[-1]
    return subprocess.run(
        [sys.executable, "-m", "followspot", "view", *words[:-1]],
        env=environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
