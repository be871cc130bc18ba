"""Which ways to OpenGL work on this machine, and what to install if none does.

Each way is tried in a process of its own, since a broken driver may take its process with it.
"""

import json
import os
import platform
import re
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata

import moderngl
from rich.table import Table
from rich.text import Text

from followspot import __version__
from followspot.assets.locate import search_path
from followspot.errors import AssetError
from followspot.gpu.context import HEADLESS_PACKAGES, REQUIRED_VERSION, backends, is_software
from followspot.present.console import open_console

_TIMEOUT = 60.0
"""Seconds after which a driver that doesn't answer is given up."""

_VERTEX = """#version 330 core
void main() { gl_Position = vec4(4 * (gl_VertexID & 1) - 1, 2 * (gl_VertexID & 2) - 1, 0, 1); }
"""
_FRAGMENT = """#version 330 core
out vec4 colour;
void main() { colour = vec4(51, 102, 204, 255) / 255; }
"""
_PIXEL = (51, 102, 204, 255)


@dataclass(frozen=True)
class Trial:
    """What came of one way: the version and renderer that GL told, or the problem."""

    way: str
    version: str = ""
    renderer: str = ""
    problem: str = ""

    @property
    def works(self) -> bool:
        """Whether a pixel was drawn and read back."""
        return not self.problem


def examine() -> list[Trial]:
    """Try every way that `followspot.gpu.context` knows, in its order; the first is used."""
    listed, problem = _in_own_process()
    if problem:
        return [Trial("listing EGL's devices", problem=problem)]
    return [try_way(way) for way in listed]


def try_way(way: str) -> Trial:
    """Draw and read back one pixel by one way, named as in `backends`."""
    told, problem = _in_own_process(way)
    return Trial(way, problem=problem) if problem else Trial(way, *told)


def _in_own_process(*way: str) -> tuple[list[str], str]:
    """What this module prints when it is run (see `_main`), or the problem."""
    command = [sys.executable, "-P", "-m", __name__, *way]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_TIMEOUT)
    except subprocess.TimeoutExpired:
        return [], f"no answer within {_TIMEOUT:g} s"
    if done.returncode < 0:
        return [], f"the driver crashed ({signal.Signals(-done.returncode).name})"
    if done.returncode > 0:
        return [], (done.stderr.strip().splitlines() or ["failed without a word"])[-1]
    told: list[str] = json.loads(done.stdout.splitlines()[-1])
    return told, ""


def _main(way: str | None = None) -> None:
    """Print the names of all ways, or the version and renderer of one that works, as JSON."""
    if way is None:
        print(json.dumps(list(backends())))
        return
    try:
        print(json.dumps(_draw_pixel(way)))
    except Exception as error:  # glcontext raises bare Exception for every cause
        sys.exit(str(error))


def _draw_pixel(way: str) -> tuple[str, str]:
    context = moderngl.create_standalone_context(require=REQUIRED_VERSION, **backends()[way])
    target = context.simple_framebuffer((1, 1))
    target.use()
    program = context.program(vertex_shader=_VERTEX, fragment_shader=_FRAGMENT)
    context.vertex_array(program, []).render(vertices=3)
    pixel = tuple(target.read(components=4))
    found = context.info["GL_VERSION"], context.info["GL_RENDERER"]
    context.release()
    if pixel != _PIXEL:
        raise RuntimeError(f"a pixel drawn as {_PIXEL} came back as {pixel}")
    return found


def verdict(trials: Sequence[Trial]) -> str:
    """What the trials mean, in plain sentences."""
    working = [trial for trial in trials if trial.works]
    if not working:
        return (
            "Nothing can be drawn here: no way to OpenGL 3.3 works. Install a driver for your GPU "
            "or Mesa's software one, which needs neither GPU nor display. "
            f"Debian and Ubuntu: apt-get install {HEADLESS_PACKAGES}. "
            "Fedora: dnf install mesa-dri-drivers mesa-libEGL mesa-libGL. Arch: pacman -S mesa."
        )
    used = working[0]
    if not is_software(used.renderer):
        return f"followspot draws with {used.way}, on the GPU."
    sentence = f"followspot draws with {used.way}, in software on the CPU. "
    gpus = [trial.way for trial in working if not is_software(trial.renderer)]
    if gpus:
        return sentence + f"There is a GPU on {gpus[0]}: to use it, install its driver's EGL."
    return sentence + "A GPU with a driver that offers EGL would come first; none was found."


def print_report() -> int:
    """Examine the machine, print what was found, and return the exit code: 2 if nothing works."""
    trials = examine()
    console = open_console()
    console.print(_ways_table(trials), _surroundings_table())
    console.print(verdict(trials))
    return 0 if any(trial.works for trial in trials) else 2


def _ways_table(trials: Sequence[Trial]) -> Table:
    table = Table("way", "works", "renderer and version, or the problem", title="OpenGL")
    for trial in trials:
        kind = "software" if is_software(trial.renderer) else "GPU"
        found = f"{trial.renderer}, {kind}\nOpenGL {trial.version}"
        works = Text("yes", "green") if trial.works else Text("no", "red")
        table.add_row(trial.way, works, trial.problem or found)
    if sys.platform.startswith("linux") and not os.environ.get("DISPLAY"):
        table.add_row("GLX", "-", "not tried: DISPLAY is not set")
    return table


def _surroundings_table() -> Table:
    table = Table(show_header=False, title="Surroundings")
    table.add_row("followspot", __version__)
    table.add_row("Python", f"{platform.python_version()} on {platform.platform()}")
    table.add_row("packages", ", ".join(_dependencies()))
    try:
        folders = (
            "\n".join(map(str, search_path())) or "none found; --assets and FOLLOWSPOT_ASSETS add"
        )
    except AssetError as error:
        folders = str(error)
    table.add_row("game folders", folders)
    return table


def _dependencies() -> list[str]:
    """Name and version of what followspot needs at run time."""
    wanted = (text for text in metadata.requires("followspot") or () if "extra ==" not in text)
    names = [re.split(r"[^\w.-]", text)[0] for text in wanted]
    return [f"{name} {metadata.version(name)}" for name in names]


if __name__ == "__main__":
    _main(*sys.argv[1:])
