"""A viewer in a process of its own, with somebody at its keys and mouse.

`play` starts a process that runs one of `scenarios`' functions. Those are of two kinds:

- a generator takes `Hands` and goes on after each frame; it types and clicks through xdotool, so
  that real X11 events arrive;
- a function takes `Finger` and is run by ImGui's test engine, which finds widgets by their names.

An assertion that fails in either ends the process with its traceback; so does a window that closes
before they are through, but for those scenarios that close it.
"""

import ctypes
import inspect
import os
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.present.viewer.state import State
from followspot.scene.light import Light

SCREEN = "1400x900x24"
SMALL, LARGE = (320, 240), (900, 700)
"""Sizes of the window."""

Condition = Callable[[State], Any]


@contextmanager
def display() -> Iterator[str]:
    """An X server of our own; gives its name."""
    read, write = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", SCREEN, "-nolisten", "tcp"],
        pass_fds=[write],
        stderr=subprocess.DEVNULL,
    )
    os.close(write)
    try:
        with os.fdopen(read) as pipe:
            yield f":{pipe.readline().strip()}"
    finally:
        server.terminate()
        server.wait()


def play(scenario: str, display: str, home: Path, **more: str) -> str:
    """Run a scenario with a home folder, in another working directory.

    Args:
        scenario: Name of a function in `scenarios`.
        display: The X server's name.
        home: Where the process finds its user's settings.
        more: Environment variables.

    Returns:
        What it printed.
    """
    environment = {**os.environ, "DISPLAY": display, "HOME": str(home), **more}
    environment.pop("XDG_CONFIG_HOME", None)
    work = home / "work"
    work.mkdir(exist_ok=True)
    ended = subprocess.run(
        [sys.executable, __file__, scenario],
        cwd=work,
        env=environment,
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    assert "Traceback" not in ended.stderr, ended.stderr
    return ended.stdout


_CLOSE = (b"WM_PROTOCOLS", b"WM_DELETE_WINDOW")


class _ClientMessage(ctypes.Structure):
    """Xlib's XClientMessageEvent, as large as its XEvent."""

    _fields_ = (
        ("type", ctypes.c_int),
        ("serial", ctypes.c_ulong),
        ("send_event", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("window", ctypes.c_ulong),
        ("message_type", ctypes.c_ulong),
        ("format", ctypes.c_int),
        ("data", ctypes.c_long * 5),
        ("padding", ctypes.c_long * 12),
    )


class Hands:
    """What a scenario sees of the viewer, and hands at its real keys and mouse."""

    def __init__(self, viewer: Any) -> None:
        self.viewer = viewer

    @property
    def state(self) -> State:
        state: State = self.viewer.state
        return state

    def xdotool(self, *words: object) -> None:
        subprocess.run(["xdotool", *map(str, words)], check=True, timeout=10)

    def frames(self, count: int) -> Iterator[None]:
        """Let so many frames pass."""
        for _ in range(count):
            yield

    def until(self, condition: Condition, frames: int = 200) -> Iterator[None]:
        """Let frames pass until something is so."""
        for _ in range(frames):
            if condition(self.state):
                return
            yield
        raise AssertionError("it did not come to that")

    def press(self, key: str, condition: Condition) -> Iterator[None]:
        """Press a key, and wait until something is so that was not before."""
        assert not condition(self.state), f"it was so before {key} was pressed"
        self.xdotool("key", key)
        yield from self.until(condition)

    def windows(self) -> list[str]:
        """Numbers of the windows on the display."""
        found = subprocess.run(
            ["xdotool", "search", "--name", "followspot"],
            capture_output=True,
            text=True,
            check=True,
        )
        return found.stdout.split()

    def ask_to_close(self, window: int) -> None:
        """Send what a window manager sends when its button to close is clicked."""
        x11 = ctypes.CDLL("libX11.so.6")
        x11.XOpenDisplay.restype = ctypes.c_void_p
        display = ctypes.c_void_p(x11.XOpenDisplay(None))
        protocols, close = (x11.XInternAtom(display, name, 0) for name in _CLOSE)
        message = _ClientMessage(
            type=33, window=window, message_type=protocols, format=32, data=(close, 0, 0, 0, 0)
        )
        x11.XSendEvent(display, ctypes.c_ulong(window), 0, 0, ctypes.byref(message))
        x11.XCloseDisplay(display)

    def picture(self) -> NDArray[np.uint8]:
        """(h, w, 3) what the window shows, top row first."""
        width, height = self.viewer.renderer.size
        screen = self.viewer.renderer.target().framebuffer.ctx.screen
        data = screen.read((0, 0, width, height), components=3, alignment=1)
        return np.frombuffer(data, np.uint8).reshape(height, width, 3)[::-1]


class Finger(Hands):
    """Points at widgets by their names, which `context` finds."""

    context: Any

    def __init__(self, viewer: Any) -> None:
        super().__init__(viewer)
        self._asked: list[Callable[[], Any]] = []
        self._answers: list[Any] = []

    def click(self, *widgets: str) -> None:
        for widget in widgets:
            self.context.item_click(widget)
            self.context.yield_(2)
            assert not self.context.is_error(), widget

    def put_light(self, light: Light) -> None:
        """In place of the second one, selected."""
        state = self.state.with_lamp(1, replace(self.state.lamps[1], light=light))
        self.viewer.state = replace(state, selected=1)
        self.context.yield_(3)

    def wait(self, condition: Condition, frames: int = 200) -> None:
        for _ in self.until(condition, frames):
            self.context.yield_()

    def in_frame(self, question: Callable[[], Any]) -> Any:
        """Ask something in the viewer's own thread, which has the OpenGL context."""
        self._asked.append(question)
        while not self._answers:
            self.context.yield_()
        return self._answers.pop()

    def on_frame(self) -> None:
        """Called by that thread."""
        if self._asked:
            self._answers.append(self._asked.pop()())


def main(name: str) -> None:
    import scenarios

    from followspot.present.still import Wish
    from followspot.present.viewer import window

    scenario = getattr(scenarios, name)
    state = replace(window.start("courtyard", Wish()), frame_limit=1000)
    viewer = window.Viewer(state, LARGE if name in scenarios.LARGE else SMALL)
    failures: list[str] = []
    through: list[str] = []
    if inspect.isgeneratorfunction(scenario):
        steps = scenario(Hands(viewer))

        def go_on() -> None:
            if next(steps, "the end") == "the end":
                through.append(name)
                viewer.params.app_shall_exit = True

        viewer.on_frame = go_on
    else:
        _let_engine_play(scenario, viewer, failures, through)
    viewer.run()
    assert not failures, failures[0]
    assert bool(through) is (name not in scenarios.CLOSING), "the window closed at another time"


def _let_engine_play(
    scenario: Callable[[Finger], None], viewer: Any, failures: list[str], through: list[str]
) -> None:
    """Have ImGui's test engine run a scenario once there are frames, and note what comes of it."""
    from imgui_bundle import hello_imgui, imgui

    engine = imgui.test_engine
    finger = Finger(viewer)
    tests: list[Any] = []
    frames = iter(range(10**9))

    def play_it(context: Any) -> None:
        finger.context = context
        try:
            scenario(finger)
            through.append(scenario.__name__)
        except BaseException:
            failures.append(traceback.format_exc())

    def register() -> None:
        running = hello_imgui.get_imgui_test_engine()
        engine.get_io(running).config_run_speed = engine.TestRunSpeed.fast
        tests.append(engine.register_test(running, "viewer", "scenario"))
        tests[0].test_func = play_it

    def go_on() -> None:
        running = hello_imgui.get_imgui_test_engine()
        finger.on_frame()
        if (number := next(frames)) == 3:
            engine.queue_test(running, tests[0])
        elif number > 3 and engine.is_test_queue_empty(running):
            if tests[0].output.status != engine.TestStatus.success and not failures:
                failures.append(f"the engine says {tests[0].output.status}")
            viewer.params.app_shall_exit = True

    viewer.on_frame = go_on
    viewer.params.use_imgui_test_engine = True
    viewer.params.callbacks.register_tests = register


if __name__ == "__main__":
    sys.path.append(str(Path(__file__).parents[2] / "gpu"))  # gl_calls
    main(sys.argv[1])
