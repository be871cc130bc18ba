"""The present view as text: to paste into a scene file, or to render again without a window."""

import shlex
from collections.abc import Iterable

import msgspec

from followspot.passes.overlay import Overlay
from followspot.passes.view import View
from followspot.present.viewer.state import State
from followspot.scene.camera import Camera
from followspot.scene.light import Light, PointLight, SpotLight
from followspot.scene.settings import CullFace, Settings


def as_toml(camera: Camera, name: str = "here") -> str:
    """The view as a table of a scene file."""
    x, y, z = camera.position.tolist()
    return (
        f"[cameras.{name}]\nposition = [{x}, {y}, {z}]\n"
        f"yaw = {camera.yaw}\npitch = {camera.pitch}\nfov = {camera.fov}\n"
    )


def as_command(state: State, size: tuple[int, int]) -> str:
    """The ``followspot render`` that draws the view, or the left half's, as it is shown.

    What it has no words for is left out; see `untold`.
    """
    camera, look = state.camera, state.look
    words = ["followspot", "render", state.scene.name]
    words += [f"--assets={folder}" for folder in state.assets]
    if state.items:
        words.append("--items")
    if state.scene.level.traced is not None:
        words.append("--bake")
    if state.animation is not None:
        words.append(f"--animation={state.animation}")
    words.append(f"--camera={_place(camera)}")
    words += [f"--fov={camera.fov!r}", f"--size={size[0]}x{size[1]}"]
    if look.view is not View.FINAL:
        words.append(f"--view={look.view}")
    overlays = state.overlays
    if state.culled_from is None:  # whose frustum there is none of then, nor a command for it
        overlays -= {Overlay.CAMERA_FRUSTUM}
    if overlays:
        words.append(f"--overlay={','.join(sorted(overlays))}")
    if state.culled_from is not None:
        words.append(f"--culled-from={_place(state.culled_from)}")
    if _has_own_lights(state):
        words += [f"--light={_light(lamp.light)}" for lamp in state.lamps if lamp.is_on]
    exposure = state.exposure_of(look.view)
    settings = msgspec.structs.replace(look.settings(state.settings), exposure=exposure)
    words += [f"--set={change}" for change in _changes(state.scene.settings, settings)]
    if state.scene.moves:
        words.append(f"--time={state.time!r}")
    return shlex.join([*words, "-o", "view.png"])


def untold(state: State) -> list[str]:
    """What of the view `as_command` cannot tell."""
    lights = [lamp.light for lamp in state.lamps if lamp.is_on]
    spots = [light for light in lights if isinstance(light, SpotLight)]
    reasons = []
    decider = state.culled_from or state.camera
    if {state.camera.near, decider.near} != {Camera.near}:
        reasons.append("the near plane")
    if decider.fov != state.camera.fov:
        reasons.append("the angle of view that is culled from")
    if state.environment_constant != state.scene.environment_constant:
        reasons.append("the environment constant")
    if _has_own_lights(state):
        if not lights:
            reasons.append("that all lights are off")
        if any(light.softness > 0 for light in spots):
            reasons.append("soft rims of lights")
        if not all(light.casts_shadow for light in lights):
            reasons.append("lights without shadow")
        if state.scene.lights_chosen and state.scene.ambient > 0:
            reasons.append("the light from all around")
    return reasons


def _has_own_lights(state: State) -> bool:
    """Whether the lights are others than those which the scene has from every camera."""
    return state.scene.lights_chosen or state.lit.lights != state.scene.lights


def _changes(before: Settings, now: Settings) -> Iterable[str]:
    for name in Settings.__struct_fields__:
        value = getattr(now, name)
        if value != getattr(before, name):
            yield f"{name}={value.value if isinstance(value, CullFace) else value}".lower()


def _light(light: Light) -> str:
    position, power = (_numbers(*values.tolist()) for values in (light.position, light.power))
    if isinstance(light, PointLight):
        return f"point:{position}:{power}"
    direction = _numbers(*light.direction.tolist())
    return f"spot:{position}:{direction}:{light.half_angle!r}:{power}"


def _place(camera: Camera) -> str:
    return _numbers(*camera.position.tolist(), camera.yaw, camera.pitch)


def _numbers(*values: float) -> str:
    return ",".join(f"{value!r}" for value in values)
