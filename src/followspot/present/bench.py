"""How long a frame takes, measured so that figures can be compared."""

import statistics
import time
from collections.abc import Callable
from typing import Any

import msgspec

from followspot.errors import UsageError
from followspot.passes.frame import FrameInput, FrameReport
from followspot.present import arguments
from followspot.present.renderer import Renderer
from followspot.present.still import Wish, open_scene
from followspot.present.stopwatch import Steps, peak_memory_mb
from followspot.scene.camera import Camera
from followspot.scene.scene import Scene

PASS_FRAMES = 20
"""Frames whose passes are timed, at most, after the counted ones: the queries cost time."""

FRAME_RATE = 60.0
"""Frames a second of the scene's own time."""

WARM_UP = 5
"""Frames that are drawn but not counted: drivers compile and fill caches in the first ones."""


class FrameTimes(msgspec.Struct, frozen=True):
    """Times of whole frames; all in milliseconds.

    Attributes:
        median_ms: Whole frames, the GPU drained after each.
        p95_ms: 95 of 100 frames are faster.
        worst_ms: The slowest one.
        submit_ms: Median of the CPU's share: culling, sorting and calls into GL.
        frame: Counts of the last frame.
    """

    median_ms: float
    p95_ms: float
    worst_ms: float
    submit_ms: float
    frame: FrameReport


class Timing(FrameTimes, frozen=True):
    """Frame times of one view, and of their passes.

    Attributes:
        camera: The view's name, or its place and angles.
        pass_ms: Medians of GPU time by pass, of frames apart from those; characters move on in
            them, too.
    """

    camera: str
    pass_ms: dict[str, float]


class Result(msgspec.Struct, frozen=True):
    """A run of ``followspot bench``; milliseconds, and MiB of memory.

    The first frame, among the steps of loading, is one that is drawn and waited for.
    """

    scene: str
    size: tuple[int, int]
    gl_renderer: str
    frames: int
    shadow_map_size: int
    redraw_shadows: bool
    load_ms: dict[str, float]
    load_total_ms: float
    peak_memory_mb: float
    views: list[Timing]


def run(
    name: str, wish: Wish, frames: int, sweep: bool, on_view: Callable[[Timing], Any]
) -> Result:
    """Measure a scene from one camera, or from all of them.

    Args:
        name: Scene or level.
        wish: Camera, size, lights and settings.
        frames: How many are counted for each view.
        sweep: Whether all of the scene's cameras are measured instead of one.
        on_view: Told of each view's figures when they are there.

    Raises:
        AssetError: the scene cannot be opened.
        ContextError: there is no OpenGL.
        UsageError: something in the wish makes no sense.
    """
    for option, given in (("--camera", wish.camera), ("--fov", wish.fov)):
        if sweep and given is not None:
            raise UsageError(f"{option}: expected none with --sweep, which has views of its own")
    steps = Steps()
    size = arguments.parse_size(wish.size)
    scene, camera = open_scene(name, wish, steps)
    cameras = list(scene.cameras.values()) if sweep else [camera]
    with Renderer(size) as renderer:
        steps("create context")
        renderer.open(scene)
        steps("upload")
        renderer.draw(_frame(scene, cameras[0], 0))
        renderer.finish()
        steps("first frame")
        timings = []
        for each in cameras:
            timings.append(measure(renderer, scene, each, frames))
            on_view(timings[-1])
        return Result(
            scene=name,
            size=size,
            gl_renderer=renderer.gl_renderer,
            frames=frames,
            shadow_map_size=scene.settings.shadow_map_size,
            redraw_shadows=scene.settings.redraw_shadows,
            load_ms=steps.ms,
            load_total_ms=steps.total_ms,
            peak_memory_mb=peak_memory_mb(),
            views=timings,
        )


def measure(renderer: Renderer, scene: Scene, camera: Camera, frames: int) -> Timing:
    """The times of one view's frames, and of their passes."""
    times = frame_times(renderer, scene, camera, frames)
    place = ",".join(f"{value:g}" for value in (*camera.position, camera.yaw, camera.pitch))
    return Timing(
        **msgspec.structs.asdict(times),
        camera=camera.name or place,
        pass_ms=pass_times(renderer, scene, camera, min(frames, PASS_FRAMES)),
    )


def frame_times(renderer: Renderer, scene: Scene, camera: Camera, frames: int) -> FrameTimes:
    """Draw the open scene again and again, waiting for the GPU after each; characters move on."""
    for number in range(-WARM_UP, 0):
        renderer.draw(_frame(scene, camera, number))
        renderer.finish()
    whole, submit = [], []
    for number in range(frames):
        frame = _frame(scene, camera, number)
        start = time.perf_counter()
        report = renderer.draw(frame)
        renderer.finish()
        whole.append((time.perf_counter() - start) * 1e3)
        submit.append(report.submit_ms)
    whole.sort()
    return FrameTimes(
        median_ms=statistics.median(whole),
        p95_ms=whole[min(len(whole) - 1, int(0.95 * len(whole)))],
        worst_ms=whole[-1],
        submit_ms=statistics.median(submit),
        frame=report,
    )


def pass_times(renderer: Renderer, scene: Scene, camera: Camera, frames: int) -> dict[str, float]:
    """Medians of GPU time in ms by pass; characters move on."""
    renderer.draw(_frame(scene, camera, -1))
    passes = [renderer.pass_times(_frame(scene, camera, number)) for number in range(frames)]
    return {name: statistics.median(each[name] for each in passes) for name in passes[0]}


def _frame(scene: Scene, camera: Camera, number: int) -> FrameInput:
    """A frame of the scene's own time; one drawn twice would find its characters as they are."""
    return FrameInput(scene, camera, scene.settings, exposure=1.0, time=number / FRAME_RATE)
