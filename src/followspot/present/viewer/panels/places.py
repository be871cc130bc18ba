"""Where the camera is, where else it can go, and that in words to keep."""

from dataclasses import replace

from imgui_bundle import imgui

from followspot import spaces
from followspot.present.viewer import copying
from followspot.present.viewer.flight import STEEPEST
from followspot.present.viewer.state import Seen, State
from followspot.scene.entry import FARTHEST

_CLAMPED = imgui.SliderFlags_.always_clamp


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    state = _here(state)
    changed, walks = imgui.checkbox("Walk (N)", state.walks)
    if changed:
        state = replace(state, walks=walks)
    if imgui.button("Copy as TOML"):
        imgui.set_clipboard_text(copying.as_toml(state.camera))
        state = replace(state, notice="The view is in the clipboard, for a scene file.")
    imgui.same_line()
    if imgui.button("Copy as command"):
        imgui.set_clipboard_text(copying.as_command(state, seen.size))
        untold = copying.untold(state)
        but = f", without {' and '.join(untold)}" if untold else ""
        state = replace(state, notice=f"The command is in the clipboard{but}.")
    imgui.separator_text("Go to")
    if imgui.begin_child("places"):
        for name, camera in state.scene.cameras.items():
            if imgui.selectable(name, name == state.camera.name)[0]:
                state = state.jumped(camera)
    imgui.end_child()
    return state


def _here(state: State) -> State:
    """The camera's numbers, to read and to type over."""
    camera = state.camera
    imgui.push_item_width(imgui.get_content_region_avail().x * 0.62)
    moved, position = imgui.drag_float3(
        "x, y, z", camera.position.tolist(), 1, -FARTHEST, FARTHEST, "%.0f", _CLAMPED
    )
    turned, angles = imgui.drag_float2(
        "yaw, pitch", [camera.yaw, camera.pitch], 0.5, -360, 360, "%.1f°", _CLAMPED
    )
    zoomed, fov = imgui.slider_float("field of view", camera.fov, 20, 140, "%.0f°", _CLAMPED)
    imgui.pop_item_width()
    if not (moved or turned or zoomed):
        return state
    camera = replace(
        camera,
        position=spaces.vec3(position) if moved else camera.position,
        yaw=angles[0] if turned else camera.yaw,
        pitch=min(max(angles[1], -STEEPEST), STEEPEST) if turned else camera.pitch,
        fov=fov if zoomed else camera.fov,
        name="",
    )
    return replace(state, flight=state.flight.at(camera))
