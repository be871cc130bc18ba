"""What can be grabbed in the picture itself: the split's divider, and the lights."""

from dataclasses import replace

import numpy as np
from imgui_bundle import imgui
from imgui_bundle.imguizmo import im_guizmo
from numpy.typing import NDArray

from followspot import spaces
from followspot.passes.view import View
from followspot.present.viewer.inspection import arranged
from followspot.present.viewer.state import Lamp, Seen, State, Tool
from followspot.scene.light import Light, SpotLight
from followspot.spaces import Mat4

BEHIND = (20, 20, 24)
"""Beside a shadow map, which is square: sRGB bytes."""
_LINE, _OUTLINE = imgui.IM_COL32(255, 255, 255, 200), imgui.IM_COL32(0, 0, 0, 160)
_ON, _OFF = imgui.IM_COL32(255, 220, 120, 255), imgui.IM_COL32(150, 150, 150, 255)
_GRIP = 12.0
"""Width in pixels of what counts as the divider."""
_DOT = 7.0
"""Radius in pixels of a light's mark."""

_OPERATION = {
    Tool.MOVE: im_guizmo.OPERATION.translate,
    Tool.TURN: im_guizmo.OPERATION.rotate,
}


def show(state: State, seen: Seen) -> State:
    """Draw the handles and let them be dragged."""
    _shadow_maps(state, seen)
    if state.right is not None:
        state = _divider(state)
    if not state.panels:
        return state
    state = _picked(state)
    state = _marks(state)
    if state.selected is not None:
        state = _gizmo(state, state.selected)
    return state


def _shadow_maps(state: State, seen: Seen) -> None:
    """The key light's map, as large as fits, in each half that shows it."""
    width, height = imgui.get_io().display_size
    edges = (0, width) if state.right is None else (0, state.divider * width, width)
    for look, left, right in zip(state.looks, edges, edges[1:], strict=False):
        if look.view is not View.SHADOW_MAP:
            continue
        picture = imgui.get_background_draw_list()
        picture.add_rect_filled((left, 0), (right, height), imgui.IM_COL32(*BEHIND, 255))
        maps = seen.found.key_maps
        if not maps:
            text = "No light casts shadows here."
            picture.add_text(((left + right) / 2 - 100, height / 2), _LINE, text)
            continue
        (columns, rows), cells = arranged(maps)
        edge = min((right - left) / columns, height / rows)
        corner_x, corner_y = (left + right - columns * edge) / 2, (height - rows * edge) / 2
        for texture, (row, column) in zip(maps, cells, strict=True):
            x, y = corner_x + column * edge, corner_y + row * edge
            picture.add_image(imgui.ImTextureRef(texture.glo), (x, y), (x + edge, y + edge))


def _divider(state: State) -> State:
    """A line with an invisible button on it, so that ImGui remembers the drag."""
    io = imgui.get_io()
    width, height = io.display_size
    x = state.divider * width
    lines = imgui.get_background_draw_list()
    lines.add_line((x, 0), (x, height), _OUTLINE, 3)
    lines.add_line((x, 0), (x, height), _LINE, 1)
    lines.add_circle_filled((x, height / 2), _GRIP / 2, _LINE)
    imgui.set_next_window_pos((x - _GRIP / 2, 0))
    imgui.set_next_window_size((_GRIP, height))
    imgui.push_style_var(imgui.StyleVar_.window_padding, (0, 0))
    flags = imgui.WindowFlags_
    imgui.begin(
        "##divider",
        None,
        flags.no_decoration | flags.no_background | flags.no_docking | flags.no_saved_settings
        | flags.no_move | flags.no_bring_to_front_on_focus | flags.no_focus_on_appearing,
    )  # fmt: skip
    imgui.invisible_button("grip", (_GRIP, height))
    if imgui.is_item_hovered() or imgui.is_item_active():
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
    if imgui.is_item_active():
        state = replace(state, divider=min(max(io.mouse_pos.x / width, 0.02), 0.98))
    imgui.end()
    imgui.pop_style_var()
    return state


def _picked(state: State) -> State:
    """The pixel under a click of the middle button, and a ring round it."""
    io = imgui.get_io()
    scale = io.display_framebuffer_scale
    if imgui.is_mouse_clicked(imgui.MouseButton_.middle) and not io.want_capture_mouse:
        look = state.look_at(io.mouse_pos.x / io.display_size.x)
        if look.view is not View.SHADOW_MAP:  # which is no picture of the scene
            pixel = int(io.mouse_pos.x * scale.x), int(io.mouse_pos.y * scale.y)
            state = replace(state, asked=replace(state.asked, pixel=pixel))
            imgui.set_window_focus("Pixel")
    if state.asked.pixel is not None:
        x, y = state.asked.pixel
        place = (x + 0.5) / scale.x, (y + 0.5) / scale.y
        marks = imgui.get_background_draw_list()
        marks.add_circle(place, _DOT, _OUTLINE, 0, 3)
        marks.add_circle(place, _DOT, _LINE)
    return state


def _marks(state: State) -> State:
    """A dot with a name where each light is; a click selects it."""
    io = imgui.get_io()
    marks = imgui.get_background_draw_list()
    clicked = imgui.is_mouse_clicked(imgui.MouseButton_.left) and not io.want_capture_mouse
    for number, lamp in enumerate(state.lamps):
        place = _in_window(state, lamp.light)
        if place is None:
            continue
        marks.add_circle_filled(place, _DOT, _ON if lamp.is_on else _OFF)
        marks.add_circle(place, _DOT, _OUTLINE)
        if number == state.selected:  # its name would be under the gizmo
            continue
        text = place[0] + _DOT + 4, place[1] - imgui.get_font_size() / 2
        marks.add_text((text[0] + 1, text[1] + 1), _OUTLINE, lamp.light.name)
        marks.add_text(text, _LINE, lamp.light.name)
        away = np.hypot(io.mouse_pos.x - place[0], io.mouse_pos.y - place[1])
        if clicked and away <= _DOT and not im_guizmo.is_over():
            state = replace(state, selected=number)
    return state


def _matrices(state: State) -> tuple[Mat4, Mat4]:
    """(view_from_world, clip_from_view) of the picture."""
    width, height = imgui.get_io().display_size
    camera = state.camera
    far = camera.far_for(*state.scene.bounds)
    return camera.view_from_world, camera.clip_from_view(width / height, far)


def _in_window(state: State, light: Light) -> tuple[float, float] | None:
    """Where a light is in the window, in ImGui's units; none if it is behind the camera."""
    view_from_world, clip_from_view = _matrices(state)
    x, y, _, w = clip_from_view @ view_from_world @ np.append(light.position, 1)
    if w <= 0:
        return None
    width, height = imgui.get_io().display_size
    return (1 + x / w) / 2 * width, (1 - y / w) / 2 * height


def _gizmo(state: State, number: int) -> State:
    """ImGuizmo's handles on one light; a spot light's axis is its matrix's X axis."""
    lamp = state.lamps[number]
    if _in_window(state, lamp.light) is None:
        return state
    view_from_world, clip_from_view = (im_guizmo.Matrix16(_columns(m)) for m in _matrices(state))
    tool = state.tool if isinstance(lamp.light, SpotLight) else Tool.MOVE
    placed = im_guizmo.Matrix16(_columns(_world_from_light(lamp.light)))
    im_guizmo.set_drawlist(imgui.get_background_draw_list())
    im_guizmo.set_rect(0, 0, *imgui.get_io().display_size)
    is_changed = im_guizmo.manipulate(
        view_from_world, clip_from_view, _OPERATION[tool], im_guizmo.MODE.world, placed
    )
    return state.with_lamp(number, _moved(lamp, placed.values, tool)) if is_changed else state


def _moved(lamp: Lamp, columns: NDArray[np.float32], tool: Tool) -> Lamp:
    """The lamp where, or as, its gizmo has been dragged."""
    matrix = columns.reshape(4, 4).T.astype(np.float64)
    if tool is Tool.TURN and isinstance(lamp.light, SpotLight):
        return replace(lamp, light=replace(lamp.light, direction=matrix[:3, 0]))
    return replace(lamp, light=replace(lamp.light, position=matrix[:3, 3]))


def _world_from_light(light: Light) -> Mat4:
    matrix = np.eye(4)
    if isinstance(light, SpotLight):
        eye_from_world = spaces.VIEW_FROM_EYE.T @ spaces.view_from_world(
            np.zeros(3), *spaces.angles_from_forward(light.direction)
        )
        matrix = eye_from_world.T
    matrix[:3, 3] = light.position
    return matrix


def _columns(matrix: Mat4) -> list[float]:
    return [float(value) for value in matrix.T.ravel()]
