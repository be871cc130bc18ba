"""A light's shadow map as it is now, texel by texel, and what decides how it is drawn and read."""

from dataclasses import replace

from imgui_bundle import imgui

from followspot.passes import lighting
from followspot.present.viewer.state import Seen, State
from followspot.scene.settings import CullFace

SIZES = (256, 512, 1024, 2048, 4096)
_CLAMPED = imgui.SliderFlags_.always_clamp
_ZOOM = 1.25
"""Of a notch of the wheel."""


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    lights = lighting.shadowed(
        lighting.in_order(state.lit.lights), state.look.settings(state.settings)
    )
    if not lights:
        imgui.text_wrapped("No spot light casts shadows here.")
        return _settings(state)
    number = min(state.map_light, len(lights) - 1)
    names = [light.name or f"spot {k}" for k, light in enumerate(lights)]
    imgui.push_item_width(imgui.get_content_region_avail().x * 0.5)
    _, number = imgui.combo("light", number, names)
    imgui.pop_item_width()
    state = replace(state, map_light=number, asked=replace(state.asked, shadow_map=number))
    state = _picture(state, seen)
    report = seen.report
    imgui.text(
        f"Drawn in this frame: {report.shadow_triangles:,} triangles in {report.shadow_draws} draws"
        if report.shadow_redrawn
        else "Kept from an earlier frame"
    )
    return _settings(state)


def _picture(state: State, seen: Seen) -> State:
    """The map, which the wheel zooms and dragging moves; what the texel under the mouse holds."""
    edge = min(imgui.get_content_region_avail().x, 260.0)
    texture = seen.found.shadow_map
    if texture is None:
        imgui.dummy((edge, edge))
        return state
    x, y, zoom = state.map_view
    half = 0.5 / zoom
    corner = imgui.get_cursor_screen_pos()
    reference = imgui.ImTextureRef(texture.glo)
    imgui.image(reference, (edge, edge), (x - half, y - half), (x + half, y + half))
    imgui.set_cursor_screen_pos(corner)
    imgui.invisible_button("map", (edge, edge))
    io = imgui.get_io()
    imgui.set_item_key_owner(imgui.Key.mouse_wheel_y)
    if imgui.is_item_active():
        x -= io.mouse_delta.x / edge / zoom
        y -= io.mouse_delta.y / edge / zoom
    texel = seen.found.texel
    if imgui.is_item_hovered():
        u = x - half + (io.mouse_pos.x - corner.x) / edge / zoom
        v = y - half + (io.mouse_pos.y - corner.y) / edge / zoom
        size = texture.width
        place = int(u * size), int(v * size)
        state = replace(state, asked=replace(state.asked, texel=place))
        if io.mouse_wheel:  # what is under the pointer stays there
            closer = min(max(zoom * _ZOOM**io.mouse_wheel, 1.0), size / 8)
            x, y, zoom = u + (x - u) * zoom / closer, v + (y - v) * zoom / closer, closer
    half = 0.5 / zoom
    state = replace(
        state, map_view=(min(max(x, half), 1 - half), min(max(y, half), 1 - half), zoom)
    )
    if texel is None:
        imgui.text_disabled("Point at a texel; the wheel zooms, dragging moves.")
    elif texel.depth < 1:
        where = ", ".join(f"{value:.0f}" for value in texel.position)
        told = f"{texel.place}: depth {texel.depth:.6f}, {texel.distance:.1f} units, at {where}"
        imgui.text_wrapped(told)
    else:
        imgui.text(f"{texel.place}: nothing is there")
    return state


def _settings(state: State) -> State:
    now = state.settings
    imgui.push_item_width(imgui.get_content_region_avail().x * 0.5)
    sizes = sorted({*SIZES, now.shadow_map_size})
    changed, index = imgui.combo(
        "texels", sizes.index(now.shadow_map_size), [str(s) for s in sizes]
    )
    if changed:
        state = state.with_settings(shadow_map_size=sizes[index])
    faces = list(CullFace)
    changed, index = imgui.combo("culled", faces.index(now.shadow_cull), [f.value for f in faces])
    if changed:
        state = state.with_settings(shadow_cull=faces[index])
    changed, taps = imgui.slider_int("filter taps", now.shadow_taps, 1, 4, "%d", _CLAMPED)
    if changed:
        state = state.with_settings(shadow_taps=taps)
    for name, label, least, most in (
        ("shadow_normal_offset", "normal offset, texels", 0.0, 4.0),
        ("shadow_bias", "bias, units", -4.0, 4.0),
        ("shadow_slope_bias", "slope bias", 0.0, 8.0),
    ):
        value = getattr(now, name)
        changed, value = imgui.slider_float(label, value, least, most, "%.2f", _CLAMPED)
        if changed:
            state = state.with_settings(**{name: value})
    imgui.pop_item_width()
    changed, fits = imgui.checkbox("fitted to what is seen", now.shadow_fit)
    return state.with_settings(shadow_fit=fits) if changed else state
