"""Where a frame's time goes, measured in the report's own view."""

from dataclasses import replace

import msgspec

from followspot.gpu.context import is_software
from followspot.passes.frame import PASSES
from followspot.present import bench
from followspot.present.report import plot
from followspot.present.report.material import Material
from followspot.present.report.page import fill
from followspot.present.report.section import Section
from followspot.present.report.ticks import Axis
from followspot.scene.scene import Scene

FRAMES = 30
"""Frames that are counted for the whole frame's time; its passes are timed apart."""

LEAST_MS = 0.05
"""Passes that take less have nothing to draw here."""


def frame_time(material: Material) -> Section:
    """The whole frame and each of its passes, with the shadow map kept and drawn anew."""
    kept = _scene(material, redraw_shadows=False)
    redrawn = _scene(material, redraw_shadows=True)
    first = bench.measure(material.renderer, kept, material.camera, FRAMES)
    material.on_progress(0.5, "shadow map drawn anew")
    second = bench.measure(material.renderer, redrawn, material.camera, FRAMES)
    slowest = {name: max(first.pass_ms[name], second.pass_ms[name]) for name in PASSES}
    # On a machine where every pass takes next to nothing, all of them are shown.
    passes = [name for name in PASSES if slowest[name] > LEAST_MS] or list(PASSES)
    chart = plot.bars(
        "Time of each pass of a frame",
        passes,
        {
            "shadow map kept": [round(first.pass_ms[name], 2) for name in passes],
            "drawn anew": [round(second.pass_ms[name], 2) for name in passes],
        },
        Axis("milliseconds"),
        description="One group of bars a pass, in the order in which they are drawn.",
    )
    html = fill(
        "frame_time.html",
        chart=chart,
        kept=first,
        redrawn=second,
        size=material.size,
        frames=FRAMES,
        longest=max(passes, key=lambda name: first.pass_ms[name]),
        software=is_software(material.renderer.gl_renderer),
    )
    return Section("frame-time", "Where a frame's time goes", html, _figures(first, second))


def _scene(material: Material, *, redraw_shadows: bool) -> Scene:
    settings = msgspec.structs.replace(material.scene.settings, redraw_shadows=redraw_shadows)
    return replace(material.scene, settings=settings)


def _figures(kept: bench.Timing, redrawn: bench.Timing) -> dict[str, float]:
    figures = {
        "median_ms": kept.median_ms,
        "p95_ms": kept.p95_ms,
        "submit_ms": kept.submit_ms,
        "redrawn_median_ms": redrawn.median_ms,
    }
    figures |= {f"{name}_ms": ms for name, ms in kept.pass_ms.items()}
    return figures | {f"redrawn_{name}_ms": ms for name, ms in redrawn.pass_ms.items()}
