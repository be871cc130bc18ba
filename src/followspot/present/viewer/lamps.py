"""What can be done to a state's lamps."""

import math
from dataclasses import replace

import numpy as np

from followspot.gpu.blocks import MAX_LIGHTS, MAX_SHADOWS
from followspot.present.viewer.state import Lamp, State
from followspot.scene.key_light import IRRADIANCE
from followspot.scene.light import Light, PointLight, SpotLight, casting

NEW_HALF_ANGLE = math.radians(30)
NEW_REACH = 300.0
"""Units at which a new light is as bright as one that the program chooses."""


def added(state: State, *, is_point: bool = False) -> State:
    """A point light where the camera is, or a spot light that shines where it looks; selected."""
    if len(state.lamps) >= MAX_LIGHTS:
        return replace(state, notice=f"There can be {MAX_LIGHTS} lights.")
    camera, name = state.camera, _free_name(state)
    light: Light
    if is_point:
        light = PointLight(camera.position, np.ones(3), name=name)
    else:
        light = SpotLight(
            camera.position,
            camera.forward,
            NEW_HALF_ANGLE,
            np.ones(3),
            softness=0.2,
            casts_shadow=may_cast(state),
            name=name,
        )
    distance = NEW_REACH * state.scene.metres_per_unit
    light = replace(light, power=light.power * (IRRADIANCE * distance**2 / light.intensity[0]))
    return replace(state, lamps=(*state.lamps, Lamp(light)), selected=len(state.lamps))


def removed(state: State, number: int) -> State:
    """One lamp less; none is selected then."""
    return replace(state, lamps=state.lamps[:number] + state.lamps[number + 1 :], selected=None)


def may_cast(state: State) -> bool:
    """Whether one more spot light may have a shadow map."""
    return len(casting([lamp.light for lamp in state.lamps])) < MAX_SHADOWS


def at_eye(state: State, light: Light) -> Light:
    """The light where the camera is, shining where it looks."""
    if isinstance(light, PointLight):
        return replace(light, position=state.camera.position)
    return replace(light, position=state.camera.position, direction=state.camera.forward)


def _free_name(state: State) -> str:
    names = {lamp.light.name for lamp in state.lamps}
    return next(name for n in range(1, MAX_LIGHTS + 2) if (name := f"light {n}") not in names)
