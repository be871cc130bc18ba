"""followspot itself, as the benchmarks run it: in this process, or as one that takes its turn."""

import os
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import common
import msgspec
from common import BenchmarkError, Ended, View

os.environ.update(common.LLVMPIPE)  # before a GL library is loaded

from followspot import Renderer
from followspot.errors import FollowspotError
from followspot.passes.frame import FrameInput
from followspot.present.arguments import parse_camera
from followspot.present.bench import Timing, frame_times
from followspot.scene.camera import Camera
from followspot.scene.level import PATCH_TOLERANCE
from followspot.scene.load import load, with_chosen_light
from followspot.scene.scene import Scene

SIZE = (640, 480)

__all__ = [
    "SIZE",
    "Renderer",
    "Timing",
    "bench",
    "draw",
    "frame_times",
    "open_scene",
    "program",
    "run",
]


class Bench(msgspec.Struct):
    """What is read of ``followspot bench --json`` for a single view."""

    views: list[Timing]


def open_scene(
    view: View, tolerance: float = PATCH_TOLERANCE, **settings: Any
) -> tuple[Scene, Camera]:
    """A level with the one shadowed light that followspot chooses for a view.

    Args:
        view: Level and camera.
        tolerance: Units by which triangles may miss a curved patch.
        settings: Changes to `followspot.scene.settings.Settings`.
    """
    try:
        scene = load(view.level, patch_tolerance=tolerance)
    except FollowspotError as error:
        raise BenchmarkError(str(error)) from None
    camera = parse_camera(view.camera, None, scene)
    scene = with_chosen_light(scene, [camera])
    return replace(scene, settings=msgspec.structs.replace(scene.settings, **settings)), camera


def draw(renderer: Renderer, scene: Scene, camera: Camera) -> float:
    """Draw one frame and wait for it; gives its milliseconds."""
    renderer.open(scene)
    frame = FrameInput(scene, camera, scene.settings, exposure=1.0)
    start = time.perf_counter()
    renderer.draw(frame)
    renderer.finish()
    return (time.perf_counter() - start) * 1e3


def program() -> Path:
    """The installed command that belongs to this Python."""
    found = Path(sys.executable).with_name("followspot")
    if not found.exists():
        raise BenchmarkError("followspot is not installed beside this Python; run `make demo`")
    return found


def bench(view: View, frames: int, *options: str, **variables: str) -> tuple[Timing, Ended]:
    """One process of ``followspot bench`` at one view.

    Args:
        view: Level and camera.
        frames: Counted frames.
        options: Further ones of the command.
        variables: Environment variables.
    """
    command: list[str | Path] = [program(), "bench", view.level, "--camera", view.camera, "--json"]
    ended = common.run([*command, "--frames", str(frames), *options], common.LLVMPIPE | variables)
    return msgspec.json.decode(ended.output, type=Bench).views[0], ended


def run(view: View, frames: int, redraw: bool) -> Timing:
    """One process of ``followspot bench`` with the shadow map redrawn in every frame, or kept."""
    return bench(view, frames, *(["--redraw-shadows"] if redraw else []))[0]
