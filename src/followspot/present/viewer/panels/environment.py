"""The sky: its faces at any MIP level, how strong it is, what comes from six directions."""

from dataclasses import replace

from imgui_bundle import imgui

from followspot.assets.image import linear_to_srgb
from followspot.passes.sky_preview import FACES
from followspot.present.viewer.state import Seen, State

_CLAMPED = imgui.SliderFlags_.always_clamp
_WHEN_DONE = imgui.InputTextFlags_.enter_returns_true
"""What becomes part of the shaders is not changed while it is being typed."""
_STRONGEST = 1e4
_LEAST = 30.0
"""Edge of a face in a panel that is too low for all."""
_ROWS, _LINES = 5, 7
"""Of widgets and of text below the faces."""
_SHADOW, _LABEL = imgui.IM_COL32(0, 0, 0, 200), imgui.IM_COL32(255, 255, 255, 230)


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    sky, top = state.scene.sky, round(state.scene.sky.top_level)
    level = min(state.sky_level, top)
    state = replace(state, asked=replace(state.asked, sky_level=level))
    imgui.text(f"{sky.name}, {sky.faces.shape[1]} texels a face")
    _cross(seen)
    imgui.push_item_width(imgui.get_content_region_avail().x * 0.45)
    _, level = imgui.slider_int("MIP level shown", level, 0, top, "%d", _CLAMPED)
    state = replace(state, sky_level=level)
    changed, is_on = imgui.checkbox("Sky light", state.look.sky_light)
    if changed:
        state = replace(state, look=replace(state.look, sky_light=is_on))
    state = _strength(state)
    imgui.pop_item_width()
    _directions(state)
    return state


def _cross(seen: Seen) -> None:
    """The unfolded faces, with their names."""
    corner = imgui.get_cursor_screen_pos()
    low = _ROWS * imgui.get_frame_height_with_spacing()
    low += _LINES * imgui.get_text_line_height_with_spacing()
    room = imgui.get_content_region_avail()
    edge = min(room.x / 4, max((room.y - low) / 3, _LEAST))
    if seen.found.sky is None:
        imgui.dummy((4 * edge, 3 * edge))
        return
    imgui.image(imgui.ImTextureRef(seen.found.sky.glo), (4 * edge, 3 * edge))
    labels = imgui.get_window_draw_list()
    for face, (column, row) in FACES.items():
        x, y = corner.x + column * edge + 3, corner.y + row * edge + 2
        labels.add_text((x + 1, y + 1), _SHADOW, face)
        labels.add_text((x, y), _LABEL, face)


def _strength(state: State) -> State:
    changed, constant = imgui.input_float(
        "constant", state.environment_constant, 0.1, 1, "%.4g", _WHEN_DONE
    )
    imgui.set_item_tooltip("Radiance of a texel of value 1, in W/(m² sr)")
    if changed:
        constant = round(min(max(constant, 0.0), _STRONGEST), 6)
        state = replace(state, environment_constant=constant)
    top, level = state.scene.sky.top_level, state.settings.environment_mip
    changed, level = imgui.input_float(
        "MIP level used", top if level is None else level, 1, 1, "%.2f", _WHEN_DONE
    )
    imgui.set_item_tooltip("Of the six directions' sum; the highest has one texel a face")
    if changed:
        state = state.with_settings(environment_mip=None if level >= top else max(level, 0.0))
    if state.scene.level.fogs:
        changed, fog = imgui.checkbox("fog", state.settings.fog)
        imgui.set_item_tooltip("In the level's fog volumes, lit by the mean of the sky")
        if changed:
            state = state.with_settings(fog=fog)
    if state.scene.level.traced is not None:
        imgui.text_disabled("Light between walls as it was when the window opened")
        return state
    if state.scene.mesh.baked is None:
        return state
    changed, baked = imgui.input_float(
        "baked light", state.settings.baked_light, 0.1, 1, "%.4g", _WHEN_DONE
    )
    imgui.set_item_tooltip("The level's own lightmaps, in W/(m² sr), in place of the sky's light")
    if changed:
        state = state.with_settings(baked_light=round(min(max(baked, 0.0), _STRONGEST), 6))
    return state


def _directions(state: State) -> None:
    """The six radiances that a surface's environment is mixed from; the brightest is 1 to see."""
    imgui.text("From six directions, W/(m² sr)")
    scene = state.lit
    towards = scene.sky.towards_axes(state.settings.environment_mip)
    radiances = towards * scene.environment_constant + scene.ambient
    no_tooltip, line = imgui.ColorEditFlags_.no_tooltip, imgui.get_text_line_height()
    for face, radiance in zip(FACES, radiances, strict=True):
        shown = linear_to_srgb(radiance / max(float(radiances.max()), 1e-9)).tolist()
        imgui.color_button(f"##{face}", [*shown, 1.0], no_tooltip, (line, line))
        imgui.same_line(0, 5)
        imgui.text(f"{face}  " + ", ".join(f"{value:.4g}" for value in radiance))
