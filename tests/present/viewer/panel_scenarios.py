"""What somebody does with the panels, and what they find out; part of `scenarios`."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from driver import Finger
from imgui_bundle import imgui
from PIL import Image

from followspot.passes.overlay import Overlay
from followspot.passes.view import View
from followspot.present.pixel import inspect_pixel
from followspot.present.viewer import copying
from followspot.present.viewer.inspection import Found
from followspot.scene import scene_file
from followspot.scene.light import PointLight, SpotLight


def panels(finger: Finger) -> None:
    """Widgets of the panels, one after another."""
    finger.click("//Stages/**/7 shadow")
    assert finger.state.look.view is View.SHADOW
    finger.click("//Stages/**/Shadows", "//Stages/boxes", "//Stages/scene", "//Stages/scene")
    assert not finger.state.look.shadows
    assert finger.state.overlays == {Overlay.BOXES}

    finger.context.window_focus("//Lights")
    finger.click("//Lights/Add (L)")
    assert [lamp.light.name for lamp in finger.state.lamps] == ["sun", "torch", "light 1"]
    finger.click("//Lights/Remove")
    assert [lamp.light.name for lamp in finger.state.lamps] == ["sun", "torch"]
    finger.click("//Lights/$$0/##on", "//Lights/$$1/###lamp", "//Lights/Here is my eye")
    assert [lamp.is_on for lamp in finger.state.lamps] == [False, True]
    torch = finger.state.lamps[1].light
    assert isinstance(torch, PointLight)
    assert np.array_equal(torch.position, finger.state.camera.position)
    colour = torch.power / torch.power.max()
    finger.context.item_input_value("//Lights/power", 75.0)
    finger.wait(lambda state: state.lamps[1].light.power.max() == 75)
    assert np.allclose(finger.state.lamps[1].light.power / 75, colour)

    finger.context.window_focus("//Places")
    finger.click("//Places/**/arcade")
    assert finger.state.camera is finger.state.scene.cameras["arcade"]
    finger.click("//Places/Copy as TOML")
    assert imgui_clipboard(finger) == copying.as_toml(finger.state.camera)
    finger.click("//Places/Walk (N)")
    finger.wait(lambda state: state.walks)
    finger.click("//Places/Walk (N)")
    finger.context.window_focus("//Recording")
    finger.click("//Recording/Record a path (F10)", "//Recording/End the path (F10)")
    assert "flight1" in finger.state.scene.paths
    finger.context.window_focus("//Save")
    finger.context.item_input_value("//Save/##view", "here")
    finger.click("//Save/Keep")
    assert finger.state.scene.cameras["here"].name == "here"
    finger.context.item_input_value("//Save/##file", "mine")
    finger.click("//Save/Save (F2)")
    assert scene_file.read(Path("mine.toml")).cameras["here"]
    assert finger.state.scene.name.endswith("mine.toml")
    finger.context.window_focus("//Frame")
    finger.context.item_input_value("//Frame/frames\\/s at most", 144)
    finger.wait(lambda state: state.frame_limit == 144)


def imgui_clipboard(finger: Finger) -> str:
    text: str = finger.in_frame(imgui.get_clipboard_text)
    return text


def inspecting(finger: Finger) -> None:
    """What panels find out, against the same found out by hand."""
    context, viewer = finger.context, finger.viewer

    def found() -> Found:
        result: Found = viewer._seen.found
        return result

    def photograph(name: str) -> None:
        context.yield_(8)
        Image.fromarray(finger.in_frame(finger.picture)).save(f"{name}.png")

    assert found().shadow_map is None and not found().thumbnails  # nobody looks: nothing is done
    context.window_focus("//Shadow map")
    finger.wait(lambda _: found().shadow_map is not None)
    context.mouse_move("//Shadow map/map")
    finger.wait(lambda _: found().texel is not None)
    texel = found().texel
    assert texel is not None
    pipeline = viewer.renderer.pipeline
    size = finger.state.settings.shadow_map_size
    whole = finger.in_frame(lambda: pipeline.shadow.read_distance(0, size))
    assert whole[texel.place[::-1]] == np.float32(texel.distance)
    light = finger.state.lit.lights[0]
    assert isinstance(light, SpotLight)
    away = (texel.position - light.position) @ light.direction
    assert np.isclose(away, texel.distance, rtol=1e-4)
    photograph("shadow-map")
    context.mouse_wheel_y(6)
    finger.wait(lambda state: state.map_view[2] > 2)
    assert found().texel is not None
    photograph("zoomed")
    finger.click("//Shadow map/fitted to what is seen")
    finger.wait(lambda state: not state.settings.shadow_fit)
    finger.click("//Shadow map/fitted to what is seen")

    middle = imgui.get_io().display_size.x * 0.5, imgui.get_io().display_size.y * 0.6
    context.window_focus("//Pixel")
    context.mouse_move_to_pos(middle)
    context.mouse_click(imgui.MouseButton_.middle)
    finger.wait(lambda _: found().pixel is not None)
    told = found().pixel
    assert told is not None
    assert np.array_equal((told.x, told.y), middle)
    frame = replace(finger.state.frame(finger.state.look), view=View.FINAL)
    again = finger.in_frame(lambda: inspect_pixel(viewer.renderer, frame, told.x, told.y))
    assert np.array_equal(told.radiance, again.radiance) and told.radiance.any()
    assert told.surface == again.surface and told.surface is not None
    photograph("pixel")

    context.window_focus("//Environment")
    finger.wait(lambda _: found().sky is not None)
    context.item_input_value("//Environment/level shown", 7)
    finger.wait(lambda state: state.sky_level == 7)
    photograph("environment")
    before = finger.state.scene.environment_constant
    context.item_input_value("//Environment/W\\/(m2 sr)", 2 * before)
    finger.wait(lambda state: state.lit.environment_constant == 2 * before)

    context.window_focus("//Assets")
    images = {m.image for m in (*finger.state.scene.materials, *finger.state.scene.crowd.materials)}
    finger.wait(lambda _: set(found().thumbnails) == images)
    photograph("assets")
    for other in ("//Level", "//Frame"):  # the pixel's panel shows one, too
        context.window_focus(other)
    finger.wait(lambda _: not found().thumbnails)
