"""The sky: its faces at any MIP level, what comes from six directions, how strong it is."""

from dataclasses import replace

from imgui_bundle import imgui

from followspot.assets.image import linear_to_srgb
from followspot.present.viewer.inspection import CROSS, FACE
from followspot.present.viewer.state import Seen, State

_CLAMPED = imgui.SliderFlags_.always_clamp
_AXES = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")
_STRONGEST = 1e4


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    sky, top = state.scene.sky, round(state.scene.sky.top_level)
    level = min(state.sky_level, top)
    state = replace(state, asked=replace(state.asked, sky_level=level))
    imgui.text(f"{sky.name}, {sky.faces.shape[1]} texels a face")
    _cross(seen)
    imgui.push_item_width(imgui.get_content_region_avail().x * 0.5)
    _, level = imgui.slider_int("level shown", level, 0, top, "%d", _CLAMPED)
    state = replace(state, sky_level=level)
    state = _strength(state)
    imgui.pop_item_width()
    _directions(state)
    return state


def _cross(seen: Seen) -> None:
    width = min(imgui.get_content_region_avail().x, 4.0 * FACE)
    edge = width / 4
    corner = imgui.get_cursor_screen_pos()
    if seen.found.sky is None:
        imgui.dummy((width, 3 * edge))
        return
    imgui.image(imgui.ImTextureRef(seen.found.sky.glo), (width, 3 * edge))
    labels = imgui.get_window_draw_list()
    for number, side in enumerate(CROSS):
        row, column = divmod(number, 4)
        place = corner.x + column * edge + 3, corner.y + row * edge + 2
        labels.add_text((place[0] + 1, place[1] + 1), imgui.IM_COL32(0, 0, 0, 200), side)
        labels.add_text(place, imgui.IM_COL32(255, 255, 255, 230), side)


def _strength(state: State) -> State:
    constant = state.scene.environment_constant
    step = max(constant, 0.01) * 0.01
    changed, constant = imgui.drag_float(
        "W/(m2 sr)", constant, step, 0, _STRONGEST, "%.3f", _CLAMPED
    )
    if changed:
        state = replace(state, scene=replace(state.scene, environment_constant=constant))
    changed, is_on = imgui.checkbox("lights surfaces", state.look.sky_light)
    if changed:
        state = replace(state, look=replace(state.look, sky_light=is_on))
    own = state.settings.environment_mip
    changed, is_own = imgui.checkbox("summed at a level of its own", own is not None)
    top = state.scene.sky.top_level
    if changed:
        state = state.with_settings(environment_mip=top if is_own else None)
    if own is not None:
        changed, own = imgui.slider_float("level summed", own, 0, top, "%.1f", _CLAMPED)
        if changed:
            state = state.with_settings(environment_mip=own)
    return state


def _directions(state: State) -> None:
    """The six radiances that the sum over directions mixes."""
    scene = state.scene
    towards = scene.sky.towards_axes(state.settings.environment_mip) * scene.environment_constant
    for number, (axis, radiance) in enumerate(zip(_AXES, towards + scene.ambient, strict=True)):
        if number % 2:
            imgui.same_line(imgui.get_content_region_avail().x / 2)
        shown = linear_to_srgb(radiance / max(float(radiance.max()), 1e-9)).tolist()
        imgui.color_button(f"##{axis}", [*shown, 1.0])
        imgui.same_line()
        imgui.text(f"{axis} " + " ".join(f"{value:.2f}" for value in radiance))
