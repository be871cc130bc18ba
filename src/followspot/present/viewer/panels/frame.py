"""How long frames take, what is in them, how bright they are shown."""

from dataclasses import replace

import numpy as np
from imgui_bundle import imgui, implot

from followspot.present.viewer.history import LENGTH, History
from followspot.present.viewer.state import Seen, State

SIXTY = 1e3 / 60
"""Milliseconds of a frame at 60 a second."""
BAND = (15.0, 35.0)
"""Milliseconds that a software rasteriser may take."""
_BAND_LOOK = implot.Spec(
    fill_color=(0.4, 0.8, 0.4, 1), fill_alpha=0.3, flags=implot.ItemFlags_.no_legend
)
_LINE_LOOK = implot.Spec(line_color=(1, 1, 1, 0.6), flags=implot.ItemFlags_.no_legend)
_SHOWN = ("CPU", "submission", "GPU")
_CLAMPED = imgui.SliderFlags_.always_clamp
_LOGARITHMIC = imgui.SliderFlags_.logarithmic


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    _plot(seen.history)
    _counts(seen)
    imgui.push_item_width(imgui.get_content_region_avail().x * 0.55)
    changed, limit = imgui.slider_int(
        "frames/s at most", state.frame_limit, 10, 240, "%d", _CLAMPED
    )
    if changed:
        state = replace(state, frame_limit=limit)
    state = _exposure(state)
    imgui.pop_item_width()
    changed, runs = imgui.checkbox("Time runs (P)", state.runs)
    imgui.same_line()
    imgui.text(f"{state.time:.1f} s")
    return replace(state, runs=runs) if changed else state


def _plot(history: History) -> None:
    width = imgui.get_content_region_avail().x
    quiet = implot.Flags_.no_mouse_text | implot.Flags_.no_menus | implot.Flags_.no_box_select
    if not implot.begin_plot("##times", imgui.ImVec2(width, width * 0.55), quiet):
        return
    highest = 2 * max(history.median(kind) for kind in _SHOWN)  # a hitch may stick out
    fixed = implot.AxisFlags_.no_highlight | implot.AxisFlags_.lock
    implot.setup_axes("", "ms", fixed | implot.AxisFlags_.no_tick_labels, fixed)
    implot.setup_axes_limits(0, LENGTH, 0, max(BAND[1], highest) * 1.1, implot.Cond_.always)
    implot.setup_legend(implot.Location_.north_west, implot.LegendFlags_.horizontal)
    across = np.array([0, LENGTH], np.float32)
    low, high = (np.full(2, edge, np.float32) for edge in BAND)
    implot.plot_shaded("15 to 35 ms", across, low, high, _BAND_LOOK)
    implot.plot_line("16.7 ms", across, np.full(2, SIXTY, np.float32), _LINE_LOOK)
    for kind in _SHOWN:
        values = history.of(kind)
        implot.plot_line(kind, values, xstart=LENGTH - len(values))
    implot.end_plot()


def _counts(seen: Seen) -> None:
    history, report = seen.history, seen.report
    times = ", ".join(f"{kind} {history.median(kind):.1f}" for kind in _SHOWN)
    culled = report.triangles_in_scene - report.triangles
    imgui.text(f"{history.frame_rate:.0f} frames/s at {seen.size[0]} x {seen.size[1]}")
    imgui.text(f"{times} ms")
    imgui.set_item_tooltip("Medians of the last frames. Line: 16.7 ms; band: 15 to 35 ms.")
    imgui.text(f"{report.draws} draws, {report.triangles:,} triangles, {culled:,} culled")
    shadow = f"{report.shadow_draws} draws" if report.shadow_redrawn else "kept"
    imgui.text(f"shadow maps: {shadow}")


def _exposure(state: State) -> State:
    changed, exposure = imgui.slider_float(
        "exposure", state.exposure_of(state.look.view), 0.01, 100, "%.3f", _CLAMPED | _LOGARITHMIC
    )
    if changed:
        return state.with_settings(exposure=exposure)
    if imgui.button("Measure exposure here (X)"):
        return replace(state.with_settings(exposure=None), measured_exposures={})
    return state
