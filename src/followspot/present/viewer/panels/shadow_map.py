"""A light's shadow map as it is now, texel by texel, and what decides how it is drawn and read."""

from dataclasses import replace

import moderngl
from imgui_bundle import imgui

from followspot.passes import lighting
from followspot.present.viewer.state import Seen, State
from followspot.scene.light import SpotLight
from followspot.scene.settings import CullFace

SIZES = (256, 512, 1024, 2048, 4096)
_CLAMPED = imgui.SliderFlags_.always_clamp
_WHEN_DONE = imgui.InputTextFlags_.enter_returns_true
"""What becomes part of the shaders is not changed while it is being typed."""
_ZOOM = 1.25
"""Of a notch of the wheel."""
_LEAST = 120.0
"""Edge of the picture in a panel that is too low for all."""
_LINES, _ROWS = 3, 5
"""Of text and of widgets below the picture."""


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    lights = _shadowed(state)
    if not lights:
        imgui.text_wrapped("No light casts shadows here.")
        return _settings(state)
    number = min(state.map_light, len(lights) - 1)
    names = lighting.names(lights)
    imgui.set_next_item_width(imgui.get_content_region_avail().x * 0.4)
    _, number = imgui.combo("##light", number, names)
    state = replace(state, map_light=number, asked=replace(state.asked, shadow_map=number))
    imgui.same_line()
    age = seen.found.map_age
    imgui.text(f"kept for {age} frames" if age else "drawn in this frame")
    low = _LINES * imgui.get_text_line_height_with_spacing()
    low += _ROWS * imgui.get_frame_height_with_spacing()
    room = imgui.get_content_region_avail()
    edge = min(room.x, max(room.y - low, _LEAST))
    if seen.found.shadow_map is None:
        imgui.dummy((edge, edge))
    else:
        state = _picture(state, seen.found.shadow_map, edge)
        _tiles(seen.found.shadow_map.width, seen.found.finer)
    _texel(seen)
    return _settings(state)


def _shadowed(state: State) -> tuple[SpotLight, ...]:
    """What maps of the picture, or of a half of it, look into."""
    lights = state.lit.lights
    each = (lighting.shadowed(lights, look.settings(state.settings)) for look in state.looks)
    return max(each, key=len)


def _picture(state: State, texture: moderngl.Texture, edge: float) -> State:
    """The map, which the wheel zooms and dragging moves; asks for the texel under the mouse."""
    x, y, zoom = state.map_view
    half = 0.5 / zoom
    room, corner = imgui.get_content_region_avail(), imgui.get_cursor_screen_pos()
    corner = imgui.ImVec2(corner.x + (room.x - edge) / 2, corner.y)
    imgui.set_cursor_screen_pos(corner)
    reference = imgui.ImTextureRef(texture.glo)
    imgui.image(reference, (edge, edge), (x - half, y - half), (x + half, y + half))
    imgui.set_cursor_screen_pos(corner)
    imgui.invisible_button("map", (edge, edge))
    io = imgui.get_io()
    imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
    if imgui.is_item_active():
        x -= io.mouse_delta.x / edge / zoom
        y -= io.mouse_delta.y / edge / zoom
    if imgui.is_item_hovered():
        u = x - half + (io.mouse_pos.x - corner.x) / edge / zoom
        v = y - half + (io.mouse_pos.y - corner.y) / edge / zoom
        size = texture.width
        state = replace(state, asked=replace(state.asked, texel=(int(u * size), int(v * size))))
        if io.mouse_wheel:  # what is under the pointer stays there
            closer = min(max(zoom * _ZOOM**io.mouse_wheel, 1.0), size / 8)
            x, y, zoom = u + (x - u) * zoom / closer, v + (y - v) * zoom / closer, closer
    half = 0.5 / zoom
    x, y = (min(max(at, half), 1 - half) for at in (x, y))
    return replace(state, map_view=(x, y, zoom))


def _tiles(size: int, finer: float | None) -> None:
    """A line on what the light's map consists of."""
    if finer is None:
        imgui.text(f"one tile of {size}")
        imgui.set_item_tooltip("Texels along an edge")
        return
    imgui.text(f"tiles of {size}, near {finer:.1f} x finer")
    imgui.set_item_tooltip(
        "Texels along an edge. The wide tile holds all that the camera sees, the near one what is\n"
        "near to it; the picture shows the wide one, with the near one's depths in its place."
    )


def _texel(seen: Seen) -> None:
    """Two lines on the texel under the mouse."""
    texel = seen.found.texel
    if texel is None:
        imgui.text_disabled("Point at a texel to read it.")
        imgui.text_disabled("The wheel zooms, dragging moves.")
        return
    column, row = texel.place
    near = " (near)" if texel.is_near else ""
    if texel.depth == 1:
        imgui.text(f"{column}, {row}{near}: depth 1")
        imgui.text("nothing is there")
        return
    x, y, z = texel.position
    imgui.text(f"{column}, {row}{near}: depth {texel.depth:.6f}")
    imgui.text(f"{texel.distance:.1f} units, at {x:.0f}, {y:.0f}, {z:.0f}")


def _settings(state: State) -> State:
    now, across = state.settings, imgui.get_content_region_avail().x
    imgui.push_item_width(across * 0.27)
    sizes = sorted({*SIZES, now.shadow_map_size})
    names = [str(size) for size in sizes]
    changed, index = imgui.combo("texels", sizes.index(now.shadow_map_size), names)
    imgui.set_item_tooltip("Along an edge; a spot's tiles together have those of such a map")
    if changed:
        state = state.with_settings(shadow_map_size=sizes[index])
    imgui.same_line(across / 2)
    faces = list(CullFace)
    names = [face.value for face in faces]
    changed, index = imgui.combo("culled", faces.index(now.shadow_cull), names)
    if changed:
        state = state.with_settings(shadow_cull=faces[index])
    changed, taps = imgui.slider_int("taps", now.shadow_taps, 1, 4, "%d", _CLAMPED)
    imgui.set_item_tooltip("Fetches along an edge of the filter's square")
    if changed:
        state = state.with_settings(shadow_taps=taps)
    imgui.same_line(across / 2)
    changed, fits = imgui.checkbox("fit", now.shadow_fit)
    imgui.set_item_tooltip("Two tiles: all that the camera sees, and what is near to it")
    if changed:
        state = state.with_settings(shadow_fit=fits)
    imgui.pop_item_width()
    return _biases(state)


def _biases(state: State) -> State:
    now = state.settings
    imgui.push_item_width(imgui.get_content_region_avail().x * 0.5)
    for name, label, most in (
        ("shadow_normal_offset", "normal offset, texels", 4.0),
        ("shadow_slope_bias", "slope bias", 8.0),
    ):
        changed, value = imgui.slider_float(label, getattr(now, name), 0, most, "%.2f", _CLAMPED)
        if changed:
            state = state.with_settings(**{name: value})
    changed, bias = imgui.input_float("bias, units", now.shadow_bias, 0.25, 1, "%.2f", _WHEN_DONE)
    if changed:
        state = state.with_settings(shadow_bias=bias)
    imgui.pop_item_width()
    return state
