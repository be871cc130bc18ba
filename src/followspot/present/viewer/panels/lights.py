"""The lights: which there are, which are on, and what the selected one is like."""

import math
from dataclasses import replace

import numpy as np
from imgui_bundle import imgui

from followspot import spaces
from followspot.assets.image import linear_to_srgb, srgb_to_linear
from followspot.present.viewer import lamps
from followspot.present.viewer.state import Seen, State, Tool
from followspot.scene.entry import FARTHEST
from followspot.scene.light import Light, PointLight, SpotLight
from followspot.scene.light_file import MAX_POWER

_CLAMPED = imgui.SliderFlags_.always_clamp
_WEAKEST = 1e-3
"""Watts from which the power's field grows by factors."""


def show(state: State, seen: Seen) -> State:
    """Draw the panel."""
    state = _list(state)
    if imgui.button("Add (L)"):
        state = lamps.added(state)
    imgui.same_line()
    if imgui.button("Add point"):
        state = lamps.added(state, is_point=True)
    if state.selected is None:
        imgui.same_line()
        imgui.text_disabled("Select one to change it.")
        return state
    number = state.selected
    imgui.same_line()
    if imgui.button("Remove"):
        return lamps.removed(state, number)
    lamp = state.lamps[number]
    imgui.same_line()
    light = lamps.at_eye(state, lamp.light) if imgui.button("Here is my eye") else lamp.light
    light = _edited(state, light)
    if light is not lamp.light:
        state = state.with_lamp(number, replace(lamp, light=light))
    for tool in Tool:
        imgui.same_line() if tool is not Tool.MOVE else None
        if imgui.radio_button(f"{tool.value} (G)", state.tool is tool):
            state = replace(state, tool=tool)
    return state


def _list(state: State) -> State:
    for number, lamp in enumerate(state.lamps):
        imgui.push_id(number)
        changed, is_on = imgui.checkbox("##on", lamp.is_on)
        if changed:
            state = state.with_lamp(number, replace(lamp, is_on=is_on))
        imgui.same_line()
        kind = "point" if isinstance(lamp.light, PointLight) else "spot"
        label = f"{lamp.light.name or kind}  ({kind}, {_watts(lamp.light.power.max())})"
        if imgui.selectable(f"{label}###lamp", number == state.selected)[0]:
            state = replace(state, selected=None if number == state.selected else number)
        imgui.pop_id()
    return state


def _watts(power: float, value: str = "") -> str:
    """Power in words, or the format of a field for it."""
    digits = ".0f" if power >= 100 else ".3g"
    return f"{value}{digits} W" if value else f"{power:{digits}} W"


def _edited(state: State, light: Light) -> Light:
    """The light as its fields say; the same one if nobody touched them."""
    imgui.push_item_width(imgui.get_content_region_avail().x * 0.62)
    changed, position = imgui.drag_float3(
        "position", light.position.tolist(), 1, -FARTHEST, FARTHEST, "%.0f", _CLAMPED
    )
    if changed:
        light = replace(light, position=spaces.vec3(position))
    light = _power(light)
    if isinstance(light, SpotLight):
        light = _cone(light)
    has_room = isinstance(light, PointLight) or light.casts_shadow or lamps.may_cast(state)
    imgui.begin_disabled(not has_room)
    changed, casts = imgui.checkbox("casts shadow", light.casts_shadow)
    imgui.end_disabled()
    imgui.pop_item_width()
    return replace(light, casts_shadow=casts) if changed else light


def _power(light: Light) -> Light:
    """Watts of the strongest channel, and the colour that has it at 1, shown as sRGB."""
    watts = float(light.power.max())
    changed, new_watts = imgui.drag_float(
        "power", watts, max(watts, _WEAKEST) * 0.005, 0, MAX_POWER, _watts(watts, "%"), _CLAMPED
    )
    tint = light.power / watts if watts > 0 else np.ones(3)
    if changed:
        return replace(light, power=tint * new_watts)
    shown = linear_to_srgb(tint).tolist()
    changed, chosen = imgui.color_edit3("colour", shown, imgui.ColorEditFlags_.float)
    linear = srgb_to_linear(np.array(chosen[:3], np.float64))
    if changed and linear.max() > 0:
        return replace(light, power=linear / linear.max() * watts)
    return light


def _cone(light: SpotLight) -> SpotLight:
    yaw, pitch = spaces.angles_from_forward(light.direction)
    changed, angles = imgui.drag_float2(
        "yaw, pitch", [yaw, pitch], 0.5, -360, 360, "%.1f°", _CLAMPED
    )
    if changed:
        light = replace(light, direction=spaces.forward_from_angles(*angles))
    degrees = math.degrees(light.half_angle)
    changed, degrees = imgui.slider_float("half-angle", degrees, 1, 85, "%.1f°", _CLAMPED)
    if changed:
        light = replace(light, half_angle=math.radians(degrees))
    changed, softness = imgui.slider_float("soft rim", light.softness, 0, 1, "%.2f", _CLAMPED)
    return replace(light, softness=softness) if changed else light
