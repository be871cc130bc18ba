"""What somebody does with the panels; part of `scenarios`."""

from pathlib import Path

import numpy as np
from driver import Finger
from imgui_bundle import imgui

from followspot.passes.overlay import Overlay
from followspot.passes.view import View
from followspot.present.viewer import copying
from followspot.scene import scene_file
from followspot.scene.light import PointLight


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
