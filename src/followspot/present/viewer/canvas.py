"""The picture in the window, drawn by the renderer as the state says."""

from dataclasses import replace

from followspot.gpu.targets import Part, Target
from followspot.passes.frame import FrameInput, FrameReport
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.present.viewer.state import Look, State


def prepared(renderer: Renderer, state: State) -> State:
    """Have the scene uploaded, if it is another one, and the exposure measured, if that is needed.

    Raises:
        AssetError, UsageError: it cannot be drawn.
    """
    renderer.open(state.scene)
    metered = {look.view.metered for look in state.looks if look.view.is_light}
    missing = metered - state.measured_exposures.keys()
    if state.settings.exposure or not missing:
        return state
    settings = state.look.settings(state.settings)
    measured = {
        view: renderer.exposure(state.lit, state.camera, settings, view, state.time)
        for view in missing
    }
    return replace(state, measured_exposures={**state.measured_exposures, **measured})


def draw(renderer: Renderer, state: State, target: Target | None = None) -> FrameReport:
    """Draw the scene, or its two halves; tells of the left one.

    Args:
        renderer: Has the scene open.
        state: What to draw.
        target: What to draw it into; by default the renderer's own.

    Raises:
        UsageError: there are more lights, or larger shadow maps, than can be drawn.
    """
    target = renderer.target() if target is None else target
    reports = []
    for look, part in zip(state.looks, halves(state, target.size), strict=True):
        frame = _frame(state, look)
        renderer.pipeline.prepare(frame, target)
        reports.append(renderer.pipeline.draw(frame, target, part=part))
    return reports[0]


def _frame(state: State, look: Look) -> FrameInput:
    """What the pipeline is to draw; the shadow map itself is laid over its picture of shadows."""
    frame = state.frame(look)
    is_map = look.view is View.SHADOW_MAP
    return replace(frame, view=View.SHADOW) if is_map else frame


def halves(state: State, size: tuple[int, int]) -> tuple[Part | None, ...]:
    """What of the picture each look covers; no part is all of it."""
    if state.right is None:
        return (None,)
    width, height = size
    middle = round(state.divider * width)
    return (0, 0, middle, height), (middle, 0, width - middle, height)
