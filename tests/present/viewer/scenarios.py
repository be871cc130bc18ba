"""What somebody does in the window; run by `driver` in a process of its own."""

import gc
import json
import math
import os
import shlex
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import moderngl
import numpy as np
from driver import Condition, Finger, Hands
from gl_calls import live_objects
from imgui_bundle import imgui
from imgui_bundle.imguizmo import im_guizmo
from inspection_scenarios import asking as asking
from inspection_scenarios import colouring as colouring
from inspection_scenarios import leaving as leaving
from inspection_scenarios import mapping as mapping
from panel_scenarios import panels as panels
from PIL import Image

from followspot import spaces
from followspot.gpu.program import SHADERS
from followspot.passes.frame import FramePipeline
from followspot.passes.view import View
from followspot.present.viewer import copying
from followspot.present.viewer import window as viewer_window
from followspot.present.viewer.state import Lamp, Look, Mouse, Tool
from followspot.scene import scene_file
from followspot.scene.light import PointLight, SpotLight
from followspot.scene.path import CameraPath
from followspot.spaces import Vec3

MAY_GROW = 30e6
"""Bytes, over four changes of levels of which each takes more than that."""

LARGE = {"asking", "colouring", "leaving", "mapping", "panels", "switching"}
"""Those that need larger panels."""

CLOSING = {"resizing"}
"""Those that close the window, and wait for that to the end."""


def shows(view: View) -> Condition:
    return lambda state: state.look.view is view


def has_moved(start: Vec3, axis: Vec3) -> Condition:
    return lambda state: (state.camera.position - start) @ axis > 20


def has_size(hands: Hands, size: tuple[int, int]) -> Condition:
    return lambda _: hands.viewer.renderer.size == size


def is_open(name: str) -> Condition:
    return lambda state: state.scene.name == name and not state.wanted


def has_failed(reason: str) -> Condition:
    return lambda state: not state.wanted and reason in state.notice


def tells(text: str) -> Condition:
    return lambda state: text in state.notice


def standing(hands: Hands) -> Iterator[None]:
    """Nothing at all."""
    yield from hands.frames(3)
    assert hands.picture().std() > 10


def ending_early(hands: Hands) -> Iterator[None]:
    """A window that closes although nobody asks for it."""
    yield from hands.frames(2)
    hands.viewer.params.app_shall_exit = True
    yield from hands.frames(2)


def flying(hands: Hands) -> Iterator[None]:
    """Every way to move, with real keys and a real mouse."""
    yield from hands.frames(3)
    start = hands.state.camera
    forward, left = start.forward, np.cross((0, 0, 1), start.forward)
    for key, axis in (("w", forward), ("a", left), ("Down", -forward), ("space", (0, 0, 1))):
        before = hands.state.camera.position
        hands.xdotool("keydown", key)
        yield from hands.until(has_moved(before, np.asarray(axis)))
        hands.xdotool("keyup", key)
        yield from hands.until(lambda state: not state.flight.velocity.any())
        moved = hands.state.camera.position - before
        across = np.linalg.norm(moved - (moved @ axis) * np.asarray(axis))
        assert across < 0.02 * np.linalg.norm(moved) + 0.01, key
    assert (hands.state.camera.yaw, hands.state.camera.pitch) == (start.yaw, start.pitch)

    speed = hands.state.flight.speed
    hands.xdotool("mousemove", 160, 120, "click", 4)
    yield from hands.until(lambda state: state.flight.speed > speed)

    yield from hands.press("Tab", lambda state: not state.panels)
    hands.xdotool("mousedown", 3)
    yield from hands.until(lambda state: state.mouse is Mouse.LOOKS_WHILE_HELD)
    hands.xdotool("mousemove_relative", 100, 20)
    yield from hands.until(lambda state: state.camera.yaw == start.yaw - 15)
    assert hands.state.camera.pitch == start.pitch + 3
    hands.xdotool("mouseup", 3)
    yield from hands.until(lambda state: state.mouse is Mouse.POINTS)
    hands.xdotool("mousemove_relative", 50, 0)
    yield from hands.frames(10)
    assert hands.state.camera.yaw == start.yaw - 15

    yield from hands.press("m", lambda state: state.mouse is Mouse.LOOKS)
    for _ in range(12):  # farther than to any edge of the screen
        hands.xdotool("mousemove_relative", "--", -100, 0)
        yield from hands.frames(4)
    yield from hands.until(lambda state: math.isclose(state.camera.yaw, start.yaw - 15 + 180))
    yield from hands.press("Escape", lambda state: state.mouse is Mouse.POINTS)


def walking(hands: Hands) -> Iterator[None]:
    """From the air to the ground, on foot, a jump, and flying again."""
    yield from hands.frames(3)
    hands.xdotool("keydown", "space")
    start = hands.state.camera.position
    yield from hands.until(has_moved(start, np.array((0, 0, 1))))
    hands.xdotool("keyup", "space")
    yield from hands.until(lambda state: not state.flight.velocity.any())
    yield from hands.press("n", lambda state: state.walks)
    yield from hands.until(lambda state: state.camera.position[2] < start[2])
    ground = math.inf
    while hands.state.camera.position[2] != ground:  # on a fast machine many frames fall
        ground = hands.state.camera.position[2]
        yield from hands.frames(20)
    yield from hands.frames(5)
    assert hands.state.camera.position[2] == ground
    for key, axis in (("w", hands.state.camera.forward), ("space", np.array((0, 0, 1)))):
        before = hands.state.camera.position
        hands.xdotool("keydown", key)
        yield from hands.until(has_moved(before, axis))
        hands.xdotool("keyup", key)
    yield from hands.until(lambda state: state.camera.position[2] < ground + 1)
    yield from hands.press("n", lambda state: not state.walks)
    there = hands.state.camera.position
    yield from hands.frames(5)
    assert np.array_equal(hands.state.camera.position, there)


def recording(hands: Hands) -> Iterator[None]:
    """Screenshots and films, with the panels hidden so that what is shown is known."""
    yield from hands.frames(3)
    hands.viewer.state = replace(hands.state, runs=False)  # the courtyard's water
    yield from hands.press("Tab", lambda state: not state.panels)
    yield from hands.frames(2)
    np.save("shown.npy", hands.picture())
    yield from hands.press("F12", lambda state: "courtyard-001.png is written" in state.notice)
    yield from hands.press("F11", lambda state: "001-stages is written" in state.notice)
    hands.viewer.state = replace(hands.state.with_recording(fps=24), runs=True)
    for number, (size, count) in enumerate(((None, 12), ((640, 480), 5)), 1):
        hands.viewer.state = hands.state.with_recording(films=True, size=size)
        yield from hands.until(lambda _: "film" in hands.viewer._seen.recorded)
        start = hands.state.time
        yield from hands.frames(count - 1)
        assert math.isclose(hands.state.time - start, (count - 1) / 24)
        hands.viewer.state = hands.state.with_recording(films=False)
        name = f"courtyard-{number:03}.mp4: {count} frames"
        yield from hands.until(tells(name), frames=2000)
    Path("file").touch()
    hands.viewer.state = hands.state.with_recording(folder="file")
    yield from hands.press("F12", lambda state: "cannot be written" in state.notice)
    hands.viewer.state = replace(hands.state, notice="")
    yield from hands.press("F9", lambda state: "cannot be written" in state.notice)
    assert not hands.state.recording.films
    hands.viewer.state = hands.state.with_recording(folder=".", films=True, size=None)
    yield from hands.frames(3)  # and the window is closed


def keeping(hands: Hands) -> Iterator[None]:
    """A flight recorded as a path and saved, with a view."""
    yield from hands.frames(3)
    yield from hands.press("F10", lambda state: state.recording.flies)
    before = hands.state.camera
    for key, axis in (("w", before.forward), ("space", np.array((0, 0, 1)))):
        start = hands.state.camera.position
        hands.xdotool("keydown", key)
        yield from hands.until(has_moved(start, axis))
        hands.xdotool("keyup", key)
    yield from hands.until(lambda state: not state.flight.velocity.any())
    yield from hands.press("F10", lambda state: "flight1" in state.scene.paths)
    path = hands.state.scene.paths["flight1"]
    assert isinstance(path, CameraPath)
    there = hands.state.camera
    for moment, camera in ((0.0, before), (path.seconds, there)):
        assert np.allclose(path.camera(moment).position, camera.position, atol=0.01)
    hands.viewer.state = hands.state.with_view("here")
    yield from hands.press("F2", lambda state: "courtyard.toml is saved" in state.notice)
    file = scene_file.read(Path("courtyard.toml"))
    assert set(file.paths) == {"tour", "flight1"}
    assert np.allclose(file.cameras["here"].position, there.position, rtol=1e-6)
    assert hands.state.scene.name.endswith("courtyard.toml")
    yield from hands.frames(3)


def reloading(hands: Hands) -> Iterator[None]:
    """Shaders changed, broken, and mended, in a folder of our own."""
    viewer, folder = hands.viewer, Path("shaders").absolute()
    shutil.copytree(SHADERS, folder)
    yield from hands.frames(3)
    drawer = viewer.renderer
    drawer.pipeline.release()
    drawer._pipeline = FramePipeline(drawer._context, drawer._gpu_scene, folder)
    yield from hands.press("Tab", lambda state: not state.panels)
    hands.viewer.state = replace(hands.state, frame_limit=40, runs=False)
    yield from hands.frames(3)
    before = hands.picture()
    main = folder / "surface.frag"
    good = main.read_text()
    line = good.splitlines().index(next(x for x in good.splitlines() if "void main" in x))
    lines = good.splitlines()

    def saved(lines: list[str]) -> None:
        main.write_text("\n".join(lines) + "\n")

    def mends() -> Condition:
        return lambda _: viewer._reloader.error is None

    saved([*lines[:line], "float nonsense = ;", *lines[line:]])
    yield from hands.until(lambda _: viewer._reloader.error is not None)
    error = viewer._reloader.error
    assert (error.file, error.line) == ("surface.frag", line + 1)
    yield from hands.frames(2)
    shown = hands.picture()
    if "LOOK" in os.environ:
        Image.fromarray(shown).save(os.environ["LOOK"])
    height, width = shown.shape[:2]
    bar = slice(30, 60), slice(round(width * 0.35), round(width * 0.65))
    assert shown[bar][..., 0].mean() > 2 * shown[bar][..., 1].mean()  # red
    assert np.array_equal(
        shown[height * 3 // 4 :], before[height * 3 // 4 :]
    )  # the last good program
    yield from hands.press("2", shows(View.NORMALS))
    hands.viewer.state = replace(hands.state, wanted="robots")
    yield from hands.until(tells("No other scene can be opened"))
    yield from hands.press("1", shows(View.FINAL))

    saved(lines)
    light = folder / "common" / "light.glsl"
    light.write_text(light.read_text().replace("* output_scale", "* 0.3 * output_scale"))
    yield from hands.until(mends())
    yield from hands.frames(2)
    darker = hands.picture()
    assert darker[height * 3 // 4 :].mean() < 0.9 * before[height * 3 // 4 :].mean()
    shutil.copy(SHADERS / "common" / "light.glsl", light)
    for _ in range(200):
        yield
        if np.array_equal(hands.picture(), before):
            return
    raise AssertionError("the mended shader does not draw as before")


def choosing(hands: Hands) -> Iterator[None]:
    """Every key that chooses something, and what it makes of the picture."""
    yield from hands.frames(3)
    hands.viewer.state = replace(hands.state, runs=False)  # water moves, and pictures are compared
    yield from hands.press("Tab", lambda state: not state.panels)
    seen = set()
    for number, view in reversed(list(enumerate(View, 1))):
        yield from hands.press(str(number), shows(view))
        yield from hands.frames(2)
        seen.add(hands.picture().tobytes())
    assert len(seen) == len(View)

    yield from hands.press("v", lambda state: state.right is not None)
    yield from hands.press("alt+8", lambda state: state.looks[1].view is View.DEPTH)
    assert hands.state.look.view is View.FINAL
    yield from hands.frames(2)
    both = hands.picture()
    yield from hands.press("v", lambda state: state.right is None)
    yield from hands.frames(2)
    final = hands.picture()
    yield from hands.press("8", lambda state: state.look.view is View.DEPTH)
    yield from hands.frames(2)
    depth = hands.picture()
    middle, edge = final.shape[1] // 2, 10  # the divider and its handle are drawn over it
    assert np.array_equal(both[:, : middle - edge], final[:, : middle - edge])
    assert np.array_equal(both[:, middle + edge :], depth[:, middle + edge :])

    yield from hands.press("v", lambda state: state.right is not None)
    hands.xdotool("mousemove", middle, 100)
    yield from hands.frames(3)
    hands.xdotool("mousedown", 1, "mousemove", middle + 80, 110)
    yield from hands.until(lambda state: state.divider == (middle + 80) / final.shape[1])
    hands.xdotool("mouseup", 1)
    yield from hands.frames(2)
    hands.xdotool("mousemove", 20, 20)
    yield from hands.frames(3)
    assert hands.state.divider == (middle + 80) / final.shape[1]

    hands.viewer.state = replace(hands.state, runs=True)
    yield from hands.press("p", lambda state: not state.runs)
    time = hands.state.time
    yield from hands.frames(3)
    assert hands.state.time == time > 0
    yield from hands.press("g", lambda state: state.tool is Tool.TURN)
    yield from hands.press("f", lambda state: state.culled_from is not None)
    lights = len(hands.state.lamps)
    yield from hands.press("l", lambda state: len(state.lamps) > lights)
    new = hands.state.lamps[-1].light
    assert isinstance(new, SpotLight)
    assert np.array_equal(new.position, hands.state.camera.position)
    assert np.allclose(new.direction, hands.state.camera.forward)


def rendering(hands: Hands) -> Iterator[None]:
    """Pictures of the window beside the commands that should draw the same."""
    yield from hands.frames(3)
    yield from hands.press("Tab", lambda state: not state.panels)
    hands.xdotool("keydown", "w")
    yield from hands.frames(5)
    hands.xdotool("keyup", "w")
    yield from hands.until(lambda state: not state.flight.velocity.any())
    commands = {}
    for key, view in (("2", View.NORMALS), ("5", View.DIRECT), ("1", View.FINAL)):
        yield from hands.press(key, shows(view))
        if view is View.DIRECT:
            sun, torch = (lamp.light for lamp in hands.state.lamps)
            assert isinstance(sun, SpotLight)
            sun = replace(sun, softness=0.0, power=sun.power / 2)
            lamps = Lamp(sun), Lamp(replace(torch, casts_shadow=True))
            hands.viewer.state = replace(hands.state, lamps=lamps)
        yield from hands.frames(2)
        np.save(f"{view}.npy", hands.picture())
        assert not copying.untold(hands.state)
        words = shlex.split(copying.as_command(hands.state, hands.viewer.renderer.size))
        commands[view.value] = words
    print(json.dumps(commands))


def resizing(hands: Hands) -> Iterator[None]:
    """Other sizes, out of sight and back, and closed in the end."""
    yield from hands.frames(3)
    (window,) = hands.windows()
    for size in ((900, 500), (200, 600), (1, 1), (320, 240)):
        hands.xdotool("windowsize", window, *size)
        yield from hands.until(has_size(hands, size))
        yield from hands.frames(2)
    hands.xdotool("windowminimize", window, "windowunmap", window)
    yield from hands.frames(5)
    hands.xdotool("windowmap", window)
    yield from hands.frames(5)
    assert hands.picture().std() > 10
    # What GLFW tells where a window manager makes icons of windows.
    framebuffer_size, viewer_window._framebuffer_size = (
        viewer_window._framebuffer_size,
        lambda: (0, 0),
    )
    time = hands.state.time
    hands.viewer.state = hands.state.with_recording(films=True)
    yield from hands.frames(5)
    assert hands.state.time == time
    viewer_window._framebuffer_size = framebuffer_size
    yield from hands.until(lambda state: state.time > time)
    hands.viewer.state = hands.state.with_recording(films=False)
    yield from hands.until(tells(".mp4"), frames=2000)
    assert hands.viewer.renderer.size == (320, 240)
    hands.ask_to_close(int(window))
    yield from hands.frames(30)
    raise AssertionError("it is still open")


def dragging(finger: Finger) -> None:
    """Lights by their gizmos: one moved, one turned."""
    camera, context = finger.state.camera, finger.context
    ahead = camera.position + camera.forward * 200
    white = np.full(3, 50.0)
    finger.put_light(PointLight(ahead, white))
    middle = imgui.get_io().display_size.x / 2, imgui.get_io().display_size.y / 2
    context.mouse_move_to_pos(middle)
    context.mouse_drag_with_delta((30, 0))
    context.yield_(2)
    moved = finger.state.lamps[1].light.position - ahead
    left = np.cross((0, 0, 1), camera.forward)
    assert moved @ left < -5
    assert np.linalg.norm(moved - (moved @ left) * left / (left @ left)) < 3

    finger.put_light(SpotLight(ahead, spaces.vec3((0, 0, -1)), 0.5, white))
    finger.viewer.state = replace(finger.state, tool=Tool.TURN)
    for aside in range(10, 150, 4):
        context.mouse_move_to_pos((middle[0] + aside, middle[1] + 5))
        context.yield_()
        if im_guizmo.is_over():
            break
    context.mouse_drag_with_delta((-3, 25))
    context.yield_(2)
    light = finger.state.lamps[1].light
    assert isinstance(light, SpotLight)
    assert np.allclose(light.position, ahead, atol=1e-3)
    assert 0.3 < light.direction @ (0, 0, -1) < 0.99


def resident_bytes() -> int:
    """Of this process, after all that nobody holds is gone."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


def reopening(hands: Hands) -> Iterator[None]:
    """Ten changes of levels for Mesa's store of compiled shaders to fill, and four more."""
    yield from hands.frames(3)
    used = []
    for name in ("castle", "courtyard") * 7:
        hands.viewer.state = replace(hands.state, wanted=name)
        yield from hands.until(is_open(name))
        yield from hands.frames(3)
        used.append(resident_bytes())
    assert max(used[10:]) < max(used[:10]) + MAY_GROW, used


def switching(finger: Finger) -> None:
    """Ten levels; and names that are none."""
    context = finger.context

    def open_by_name(name: str) -> None:
        context.window_focus("//Level")
        context.item_click("//Level/##search")
        context.key_chars_replace_enter(name)

    counts = []
    for name in ("castle", "courtyard") * 5:
        open_by_name(name)
        finger.wait(is_open(name))
        context.yield_(3)
        assert finger.state.camera is finger.state.scene.camera()
        counts.append(finger.in_frame(live_objects))
    assert counts[2::2] == [counts[2]] * 4
    assert counts[3::2] == [counts[3]] * 4

    now = finger.state.scene
    light = '[[lights]]\ntype = "point"\nposition = [0, 0, 0]\npower = 1\n'
    Path("nine.toml").write_text('level = "courtyard"\n' + 9 * light)
    wrong = {"no_such.toml": "a scene file", "zzzz": "none", "nine.toml": "at most 8 lights"}
    for name, reason in wrong.items():
        open_by_name(name)
        finger.wait(has_failed(reason))
        context.yield_(3)
        assert finger.state.scene is now
        found = finger.in_frame(live_objects)
        # The exposure is known, so what measures it need not have been compiled again.
        assert all(found[kind] <= count for kind, count in counts[-1].items()), (name, found)


def failing(hands: Hands) -> Iterator[None]:
    """A scene that cannot be drawn: nobody looks at textures that went with the one before."""
    viewer = hands.viewer
    light = '[[lights]]\ntype = "point"\nposition = [0, 0, 0]\npower = 1\n'
    Path("nine.toml").write_text('level = "courtyard"\n' + 9 * light)
    viewer.state = replace(hands.state, look=Look(View.SHADOW_MAP))
    yield from hands.until(lambda _: viewer._seen is not None and viewer._seen.found.key_maps)
    viewer.state = replace(hands.state, wanted="nine.toml")
    for _ in hands.until(has_failed("at most 8 lights")):
        yield
        shown = viewer._seen.found.key_maps
        assert not any(isinstance(each.mglo, moderngl.InvalidObject) for each in shown)
    yield from hands.until(lambda _: viewer._seen.found.key_maps)


def hiding(hands: Hands) -> Iterator[None]:
    """A panel closed, all hidden; in that order."""
    yield from hands.frames(5)
    windows = hands.viewer.params.docking_params
    closed = os.environ["WAS_CLOSED"] == "1"
    assert windows.dockable_window_of_name("Keys").is_visible is not closed
    windows.dockable_window_of_name("Keys").is_visible = False
    yield from hands.frames(3)
    shown = hands.picture()
    yield from hands.press("Tab", lambda state: not state.panels)
    yield from hands.frames(3)
    hidden = hands.picture()
    yield from hands.press("Tab", lambda state: state.panels)
    yield from hands.frames(3)
    assert np.abs(shown.astype(int) - hidden).mean() > 5
    again = hands.picture()
    assert np.abs(shown.astype(int) - again).mean() < 1  # the plot goes on
