"""How long a frame takes, measured so that figures can be compared."""

import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import msgspec

from followspot.passes import lighting
from followspot.passes.frame import FrameInput, FrameReport
from followspot.present import arguments
from followspot.present.renderer import Renderer
from followspot.present.still import Wish, open_scene
from followspot.present.stopwatch import Steps, peak_memory_mb
from followspot.scene.camera import Camera
from followspot.scene.scene import Scene

PASS_FRAMES = 20
"""Frames whose passes are timed apart, beside the counted ones: the queries cost time."""

FRAME_RATE = 60.0
"""Frames a second of the scene's own time."""

WARM_UP = 5
"""Frames that are drawn but not counted: drivers compile and fill caches in the first ones."""


class Timing(msgspec.Struct, frozen=True):
    """Frame times of one view; all in milliseconds.

    Attributes:
        camera: The view's name, or its place and angles.
        median_ms: Whole frames, the GPU drained after each.
        p95_ms: 95 of 100 frames are faster.
        worst_ms: The slowest one.
        submit_ms: Median of the CPU's share: culling, sorting and calls into GL.
        pass_ms: Medians of GPU time by pass.
        frame: Counts of the last frame.
    """

    camera: str
    median_ms: float
    p95_ms: float
    worst_ms: float
    submit_ms: float
    pass_ms: dict[str, float]
    frame: FrameReport


class Result(msgspec.Struct, frozen=True):
    """A run of ``followspot bench``; milliseconds, and MiB of memory."""

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
    """
    steps = Steps()
    size = arguments.parse_size(wish.size)
    scene, camera = open_scene(name, wish, steps)
    cameras = list(scene.cameras.values()) if sweep else [camera]
    with Renderer(size) as renderer:
        steps("create context")
        renderer.open(scene)
        steps("upload")
        measure(renderer, scene, cameras[0], 1)
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
    """Draw the same view again and again, waiting for the GPU after each; characters move on."""
    lights = lighting.in_order(scene.lights)
    frame = FrameInput(scene, camera, lights, scene.settings, exposure=1.0)
    for _ in range(WARM_UP if frames > 1 else 0):
        renderer.draw(frame)
        renderer.finish()
    whole, submit = [], []
    for number in range(frames):
        frame = replace(frame, time=number / FRAME_RATE)
        start = time.perf_counter()
        report = renderer.draw(frame)
        renderer.finish()
        whole.append((time.perf_counter() - start) * 1e3)
        submit.append(report.submit_ms)
    whole.sort()
    passes = [renderer.pass_times(frame) for _ in range(min(frames, PASS_FRAMES))]
    place = ",".join(f"{value:g}" for value in (*camera.position, camera.yaw, camera.pitch))
    return Timing(
        camera=camera.name or place,
        median_ms=statistics.median(whole),
        p95_ms=whole[min(len(whole) - 1, int(0.95 * len(whole)))],
        worst_ms=whole[-1],
        submit_ms=statistics.median(submit),
        pass_ms={name: statistics.median(each[name] for each in passes) for name in passes[0]},
        frame=report,
    )
