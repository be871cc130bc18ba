"""What somebody asks the panels, and what they find out; part of `scenarios`."""

from dataclasses import replace

import numpy as np
from driver import Condition, Finger
from gl_calls import live_objects
from imgui_bundle import imgui
from numpy.typing import NDArray

from followspot.passes.shadow_reading import read_distance
from followspot.passes.shadow_tiles import Tile
from followspot.passes.view import View
from followspot.present.pixel import PixelReport, inspect_pixel
from followspot.present.viewer.asking import Found
from followspot.present.viewer.state import Look
from followspot.scene.fog import Fog
from followspot.scene.light import SpotLight
from followspot.scene.material import Laid, Layer
from followspot.scene.settings import CullFace
from followspot.spaces import vec3


def found(finger: Finger) -> Found:
    result: Found = finger.viewer._seen.found
    return result


def mapping(finger: Finger) -> None:
    """The shadow map's panel: what it reads, and every widget."""
    context = finger.context

    def choose(combo: str, choice: str) -> None:
        finger.click(f"//Shadow map/{combo}", f"//##Combo_00/{choice}")

    finger.viewer.state = replace(finger.state, look=Look(View.NORMALS))  # which is soon drawn
    context.yield_(2)
    assert found(finger).shadow_map is None, "nobody looks at it"
    context.window_focus("//Shadow map")
    finger.wait(lambda _: found(finger).shadow_map is not None)
    assert found(finger).key_maps == ()
    context.mouse_move("//Shadow map/map")
    finger.wait(lambda _: found(finger).texel is not None)
    assert read_as_in_the_map(finger, number=0)
    point_at_the_near_tile(finger)
    assert read_as_in_the_map(finger, number=0)
    texel = found(finger).texel
    assert texel is not None
    assert texel.is_near
    context.mouse_move("//Shadow map/map")
    for _ in range(3):
        context.mouse_wheel_y(4)
    finger.wait(lambda state: state.map_view[2] > 5)
    before = finger.state.map_view
    context.mouse_drag_with_delta((30, -20))
    moved = np.subtract(finger.state.map_view, before)
    assert moved[0] < 0 < moved[1]
    assert moved[2] == 0
    assert read_as_in_the_map(finger, number=0)

    shadow = finger.viewer.renderer.pipeline.shadow
    for setting, change in (
        ("size", lambda: choose("texels", "$$1/512")),
        ("culled faces", lambda: choose("culled", "$$1/back")),
        ("slope bias", lambda: context.item_input_value("//Shadow map/slope bias", 2.0)),
        ("fit", lambda: finger.click("//Shadow map/fit")),
    ):
        version = shadow.version
        change()
        context.yield_(2)
        assert shadow.version > version, f"another {setting} has it drawn again"
    version = shadow.version
    finger.wait(lambda _: found(finger).map_age > 5)
    assert shadow.version == version, "it is kept"
    finger.viewer.state = finger.state.with_settings(shadow_slope_bias=3.0)
    finger.wait(lambda _: found(finger).map_age == 0, frames=2)
    context.item_input_value("//Shadow map/taps", 3)
    context.item_input_value("//Shadow map/normal offset, texels", 1.5)
    context.item_input_value("//Shadow map/bias, units", -0.75)
    now = finger.state.settings
    assert (now.shadow_map_size, now.shadow_cull) == (512, CullFace.BACK)
    assert (now.shadow_slope_bias, now.shadow_fit, now.shadow_taps) == (3, False, 3)
    assert (now.shadow_normal_offset, now.shadow_bias) == (1.5, -0.75)

    sun = finger.state.lamps[0].light
    second = SpotLight(finger.state.camera.position, finger.state.camera.forward, 0.6, sun.power)
    finger.put_light(replace(second, name="second"))
    looks = Look(View.SHADOW_MAP), Look(View.SHADOW_MAP)
    finger.viewer.state = replace(finger.state, look=looks[0], right=looks[1])
    choose("##light", "$$1/second")
    context.mouse_move("//Shadow map/map")
    finger.wait(lambda state: state.map_light == 1 and found(finger).texel is not None)
    context.yield_(2)
    assert read_as_in_the_map(finger, number=1)
    (key,), own = found(finger).key_maps, found(finger).shadow_map
    assert key is not None
    assert own is not None
    assert finger.in_frame(lambda: key.read() != own.read())


def point_at_the_near_tile(finger: Finger) -> None:
    """With the mouse, to the middle of where the key light's map shows it."""
    shadow, context = finger.viewer.renderer.pipeline.shadow, finger.context
    scale, shift = shadow.tiles_of(0)[0].finer_from_here
    x, y = (0.5 - shift) / scale
    shown = context.item_info("//Shadow map/map").rect_full
    corner, width, height = shown.min, shown.get_width(), shown.get_height()
    context.mouse_move_to_pos((corner.x + x * width, corner.y + (1 - y) * height))
    context.yield_(3)


def read_as_in_the_map(finger: Finger, number: int) -> bool:
    """Whether the texel under the mouse is the one in the whole map, in the world where it says."""
    texel = found(finger).texel
    assert texel is not None
    shadow = finger.viewer.renderer.pipeline.shadow
    whole = finger.in_frame(lambda: read_distance(shadow, number))
    assert whole.shape == (shadow.size, shadow.size)
    assert whole[texel.place[::-1]] == np.float32(texel.distance)
    light = finger.state.frame(finger.state.look).shadowed[number]
    place = texel.position - light.position
    assert np.isclose(place @ light.direction, texel.distance, rtol=1e-3)
    wide, *near = shadow.tiles_of(number)
    shown = texels_of(texel.position, wide, shadow.size)
    if not near:
        assert not texel.is_near
        assert found(finger).finer is None
        return bool(np.allclose(shown, texel.place, atol=1e-2))
    # In the near tile it is in the middle of the texel that holds the wide one's middle.
    scale, shift = wide.finer_from_here
    place = (np.array(texel.place) + 0.5) / shadow.size
    there = np.array([place[0], 1 - place[1]]) * scale + shift
    assert texel.is_near == bool(((there >= 0) & (there < 1)).all())
    finer = found(finger).finer
    assert finer is not None
    assert np.isclose(finer**2, scale.prod())
    if not texel.is_near:
        return bool(np.allclose(shown, texel.place, atol=1e-2))
    exact = texels_of(texel.position, near[0], shadow.size)
    assert np.allclose(exact, np.round(exact), atol=1e-2)
    return bool((np.abs(shown - texel.place) < 0.5 / scale + 1e-2).all())


def texels_of(position: NDArray[np.float64], tile: Tile, size: int) -> NDArray[np.float64]:
    """(2,) column and row that a place has in a tile; whole numbers in texels' middles."""
    x, y, w = (tile.frustum.clip_from_world @ [*position, 1])[[0, 1, 3]]
    return np.array([x / w + 1, 1 - y / w]) / 2 * size - 0.5


def asking(finger: Finger) -> None:
    """Pixels, in both halves, asked again and followed."""
    context = finger.context
    left, right = (300, 400), (600, 400)

    def ask(pixel: tuple[int, int]) -> PixelReport:
        before = found(finger).pixel
        context.mouse_move_to_pos(pixel)
        context.mouse_click(imgui.MouseButton_.middle)
        finger.wait(lambda _: found(finger).pixel is not before)
        report = found(finger).pixel
        assert report is not None
        assert (report.x, report.y) == pixel
        return report

    def is_told(report: PixelReport, look: Look) -> bool:
        frame = finger.state.frame(look)
        again = finger.in_frame(
            lambda: inspect_pixel(finger.viewer.renderer, frame, report.x, report.y)
        )
        names = ("radiance", "rho", "direct", "environment", "position", "displayed")
        same = [np.array_equal(getattr(report, name), getattr(again, name)) for name in names]
        return all(same) and report.surface == again.surface

    report = ask(right)
    assert is_told(report, finger.state.look)
    assert report.surface is not None
    assert len(report.shadows) == 1
    assert context.item_exists("//Pixel/follow"), "its panel comes to the front"
    other = Look(View.NORMALS, shadows=False, textures=False)
    finger.viewer.state = replace(finger.state, right=other)
    finger.wait(lambda _: found(finger).pixel_is_old)
    report = ask(right)
    assert is_told(report, other)
    assert not report.shadows
    assert np.allclose(report.rho, 0.5, atol=1e-3)
    report = ask(left)
    assert is_told(report, finger.state.look)
    assert report.surface is not None
    finger.wait(lambda _: found(finger).thumbnails)
    assert [material.name for material in found(finger).thumbnails] == [report.surface.material]

    there = finger.state.scene.cameras["arcade"]
    finger.viewer.state = finger.state.jumped(there)
    finger.wait(lambda _: found(finger).pixel_is_old)
    old = found(finger).pixel
    context.yield_(30)
    assert found(finger).pixel is old, "nobody has asked for it"
    report = ask(left)
    assert not found(finger).pixel_is_old
    finger.click("//Pixel/follow")
    context.yield_(30)
    assert found(finger).pixel is report, "nothing has changed"
    finger.viewer.state = finger.state.with_settings(exposure=0.25)
    finger.wait(lambda _: found(finger).pixel is not report)
    followed = found(finger).pixel
    assert followed is not None
    assert np.allclose(followed.exposed, followed.radiance * 0.25)

    context.mouse_move_to_pos(right)
    finger.viewer.state = replace(finger.state, right=Look(View.SHADOW_MAP))
    context.yield_(3)
    context.mouse_click(imgui.MouseButton_.middle)
    context.yield_(3)
    assert finger.state.asked.pixel == left, "a map is no picture"
    finger.click("//Pixel/Forget")
    finger.wait(lambda state: state.asked.pixel is None and found(finger).pixel is None)


def colouring(finger: Finger) -> None:
    """The sky and the materials."""
    context = finger.context
    assert found(finger).sky is None
    context.window_focus("//Environment")
    finger.wait(lambda _: found(finger).sky is not None)
    context.item_input_value("//Environment/MIP level shown", 7)
    assert finger.state.sky_level == finger.state.asked.sky_level == 7
    context.item_input_value("//Environment/constant", 2.5)
    context.item_input_value("//Environment/MIP level used", 4.0)
    finger.click("//Environment/Sky light")
    assert finger.state.lit.environment_constant == 2.5
    finger.wait(lambda state: state.settings.environment_mip == 4)
    finger.wait(lambda state: not state.look.sky_light)
    context.item_input_value("//Environment/MIP level used", 20.0)
    finger.wait(lambda state: state.settings.environment_mip is None)
    scene = finger.state.scene
    assert not context.item_exists("//Environment/fog")
    mins, maxs = map(vec3, scene.bounds)
    fog = Fog(mins, maxs, np.full(3, 0.5), 0.001)
    level = replace(scene.level, fogs=(fog,))
    finger.viewer.state = replace(finger.state, scene=replace(scene, level=level))
    finger.wait(lambda state: state.settings.fog and context.item_exists("//Environment/fog"))
    finger.click("//Environment/fog")
    finger.wait(lambda state: not state.settings.fog)

    assert not found(finger).thumbnails
    context.window_focus("//Assets")
    finger.wait(lambda _: found(finger).thumbnails)
    assert not context.item_exists("//Assets/grain")
    scene = finger.state.scene
    rough = replace(scene.materials[0], layer=Layer("a.png", Laid.GRAIN))
    level = replace(scene.level, materials=(rough, *scene.materials[1:]))
    finger.viewer.state = replace(finger.state, scene=replace(scene, level=level))
    finger.wait(lambda state: context.item_exists("//Assets/grain"))
    finger.click("//Assets/grain")
    finger.wait(lambda state: state.settings.grain)
    finger.viewer.state = replace(finger.state, scene=scene)
    finger.wait(lambda _: not context.item_exists("//Assets/grain"))
    gpu_scene = finger.in_frame(lambda: finger.viewer.renderer.open(finger.state.scene))
    for material, thumbnail in found(finger).thumbnails.items():
        assert thumbnail.size == gpu_scene.image_of(material).size
    context.item_input_value("//Assets/##find", "ASHLAR")
    ashlar = {m for m in finger.state.scene.materials if "ashlar" in m.name}
    finger.wait(lambda _: set(found(finger).thumbnails) == ashlar)


def is_open(name: str) -> Condition:
    return lambda state: state.scene.name == name and not state.wanted


def leaving(finger: Finger) -> None:
    """Levels closed while panels look at them."""
    context, counts = finger.context, []
    for window in ("//Shadow map", "//Assets", "//Environment"):
        context.window_focus(window)
    for name in ("castle", "courtyard") * 3:
        finger.viewer.state = replace(finger.state, wanted=name)
        finger.wait(is_open(name))
        assert finger.state.asked.pixel is None
        asked = replace(finger.state.asked, pixel=(450, 400))
        finger.viewer.state = replace(finger.state, asked=asked)
        finger.wait(lambda _: found(finger).pixel is not None and found(finger).thumbnails)
        materials = {*finger.state.scene.materials, *finger.state.scene.crowd.materials}
        assert set(found(finger).thumbnails) <= materials
        context.yield_(5)
        counts.append(finger.in_frame(live_objects))
    assert counts[2] == counts[4]
    assert counts[3] == counts[5]
