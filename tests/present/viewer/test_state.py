"""What the panels and keys change, and the view as text, without a window."""

import math
import shlex
from dataclasses import replace

import numpy as np
import pytest

import synthetic
from followspot import spaces
from followspot.gpu.blocks import MAX_LIGHTS, MAX_SHADOWS
from followspot.passes import lighting
from followspot.passes.overlay import Overlay
from followspot.passes.view import View
from followspot.present import arguments
from followspot.present.still import Wish
from followspot.present.viewer import canvas, copying, lamps, window
from followspot.present.viewer.history import LENGTH, History
from followspot.present.viewer.panels.level import matching
from followspot.present.viewer.state import PLAIN_ALBEDO, Look, State
from followspot.scene import scene_file
from followspot.scene.camera import Camera
from followspot.scene.light import PointLight, SpotLight

CAMERA = Camera(spaces.vec3((1.5, -2.25, 1e-7)), yaw=123.456, pitch=-7.1, fov=81.3)


@pytest.fixture
def state() -> State:
    scene = synthetic.make_scene([synthetic.floor()], cameras={"start": CAMERA})
    return State.of(scene, CAMERA)


def test_a_look_overrides_the_settings_own_switches(state: State) -> None:
    plain = Look(View.DIRECT, shadows=False, sky_light=False, textures=False)
    frame = state.frame(plain)
    assert (frame.view, frame.settings.shadows) == (View.DIRECT, False)
    assert (frame.settings.sky_light, frame.settings.albedo) == (False, PLAIN_ALBEDO)
    assert state.frame(Look()).settings.albedo is None
    dark = state.with_settings(albedo=0.0)
    assert dark.frame(plain).settings.albedo == 0


def test_the_halves_of_a_split_fill_the_picture_without_a_gap(state: State) -> None:
    assert canvas.halves(state, (801, 600)) == (None,)
    split = replace(state, right=Look(View.NORMALS), divider=0.3)
    left, right = canvas.halves(split, (801, 600))
    assert left == (0, 0, 240, 600)
    assert right == (240, 0, 561, 600)


def test_a_lamp_that_is_off_is_no_light(state: State) -> None:
    state = lamps.added(lamps.added(state))
    assert len(state.lit.lights) == 2
    off = state.with_lamp(0, replace(state.lamps[0], is_on=False))
    assert off.lit.lights == (state.lamps[1].light,)
    assert len(lamps.removed(off, 0).lamps) == 1


def test_there_are_never_more_lights_than_a_frame_holds(state: State) -> None:
    for count in range(1, MAX_LIGHTS + 3):
        state = lamps.added(state)
        lights = [lamp.light for lamp in state.lamps]
        assert len(lights) == min(count, MAX_LIGHTS)
        casting = [light for light in lights if isinstance(light, SpotLight) and light.casts_shadow]
        assert len(casting) == min(count, MAX_SHADOWS)
        lighting.in_order(state.lit.lights)
        assert len({light.name for light in lights}) == len(lights)
    assert str(MAX_LIGHTS) in state.notice


def test_a_new_point_light_is_as_bright_as_a_new_spot(state: State) -> None:
    spot, lamp = (each.light for each in lamps.added(lamps.added(state), is_point=True).lamps)
    assert isinstance(lamp, PointLight) and lamp.casts_shadow
    np.testing.assert_allclose(lamp.intensity, spot.intensity)
    np.testing.assert_array_equal(lamp.position, state.camera.position)
    assert lamp.name and lamp.name != spot.name


def test_a_light_goes_to_the_eye(state: State) -> None:
    spot = SpotLight(spaces.vec3((9, 9, 9)), spaces.vec3((0, 0, 1)), 0.5, np.ones(3))
    there = lamps.at_eye(state, spot)
    assert isinstance(there, SpotLight)
    assert np.array_equal(there.position, CAMERA.position)
    assert there.direction == pytest.approx(CAMERA.forward)
    point = PointLight(spaces.vec3((9, 9, 9)), np.ones(3))
    assert np.array_equal(lamps.at_eye(state, point).position, CAMERA.position)


def test_opening_another_scene_keeps_how_it_is_looked_at(state: State) -> None:
    other = synthetic.make_scene([synthetic.floor()], cameras={"there": Camera(np.ones(3))})
    looked = replace(
        state, look=Look(View.DEPTH), frame_limit=30, panels=False, selected=0, wanted="x", time=5.0
    )
    opened = looked.opened(other)
    assert (opened.look.view, opened.frame_limit, opened.panels) == (View.DEPTH, 30, False)
    assert opened.camera is other.camera()
    assert (opened.selected, opened.wanted, opened.time) == (None, None, 0)


def test_a_view_as_toml_is_the_same_view(state: State) -> None:
    file = scene_file.parse('level = "x"\n' + copying.as_toml(CAMERA), "here")
    back = file.cameras["here"].camera("here")
    assert np.array_equal(back.position, CAMERA.position)
    assert (back.yaw, back.pitch, back.fov) == (CAMERA.yaw, CAMERA.pitch, CAMERA.fov)


def options(state: State) -> dict[str, list[str]]:
    """The copied command's options, by name."""
    words = shlex.split(copying.as_command(state, (640, 480)))
    found: dict[str, list[str]] = {}
    for word in words:
        name, equals, value = word.partition("=")
        if equals:
            found.setdefault(name, []).append(value)
    return found


def test_a_view_as_a_command_is_the_same_view(state: State) -> None:
    look = Look(View.SHADING, shadows=False, textures=False)
    state = replace(state.with_settings(shadow_taps=4, exposure=0.1), look=look)
    found = options(state)
    assert found["--view"] == ["shading"]
    assert found["--size"] == ["640x480"]
    back = arguments.parse_camera(found["--camera"][0], float(found["--fov"][0]), state.scene)
    assert np.array_equal(back.position, CAMERA.position)
    assert (back.yaw, back.pitch, back.fov) == (CAMERA.yaw, CAMERA.pitch, CAMERA.fov)
    settings = arguments.parse_settings(state.scene, found["--set"])
    assert settings == look.settings(state.settings)
    assert "--light" not in found
    assert copying.untold(state) == []


def test_what_a_scene_was_opened_with_is_in_the_command() -> None:
    robot = window.start("models/robot/robot.md2", Wish(animation="run", time=0.25))
    words = shlex.split(copying.as_command(robot, (640, 480)))
    assert {"--animation=run", "--time=0.25"} <= set(words) and "--items" not in words
    level = window.start("courtyard", Wish(items=True))
    assert "--items" in shlex.split(copying.as_command(level, (640, 480)))
    for state in (robot, level):
        other = state.opened(level.scene)
        assert not other.items and other.animation is None


def test_changed_lights_are_in_the_command_and_what_has_no_words_is_told(state: State) -> None:
    state = lamps.added(state)
    found = options(state)["--light"]
    (light,) = (arguments.parse_light(text) for text in found)
    wanted = state.lamps[0].light
    assert isinstance(light, SpotLight)
    assert isinstance(wanted, SpotLight)
    assert np.array_equal(light.position, wanted.position)
    assert light.direction == pytest.approx(wanted.direction, abs=1e-15)
    assert light.half_angle == wanted.half_angle
    assert np.array_equal(light.power, wanted.power)
    assert copying.untold(state) == ["soft rims of lights"]
    point = PointLight(spaces.vec3((1, 2, 3)), spaces.vec3((4, 5, 6)))
    state = replace(state, overlays=frozenset({Overlay.SCENE, Overlay.BOXES}))
    state = state.with_lamp(0, replace(state.lamps[0], light=point))
    found_all = options(state)
    assert found_all["--light"] == ["point:1.0,2.0,3.0:4.0,5.0,6.0"]
    assert found_all["--overlay"] == ["boxes,scene"]
    assert copying.untold(state) == []


def test_the_frustum_of_a_camera_to_cull_from_is_in_the_command_while_there_is_one(
    state: State,
) -> None:
    """`render` takes the overlay for a mistake without that camera."""
    state = replace(state, overlays=frozenset({Overlay.CAMERA_FRUSTUM}))
    assert not {"--overlay", "--culled-from"} & set(options(state))
    boxes = replace(state, overlays=state.overlays | {Overlay.BOXES})
    assert options(boxes)["--overlay"] == ["boxes"]
    found = options(replace(state, culled_from=CAMERA))
    assert found["--overlay"] == ["camera-frustum"]
    back = arguments.parse_camera(found["--culled-from"][0], CAMERA.fov, state.scene)
    assert np.array_equal(back.position, CAMERA.position)


def test_what_of_cameras_has_no_words_is_told(state: State) -> None:
    """A command's cameras have one angle of view, and levels' near plane, not small models'."""
    wide, near = replace(CAMERA, fov=99.0), replace(CAMERA, near=0.5)
    assert copying.untold(replace(state, culled_from=CAMERA)) == []
    culled = ["the angle of view that is culled from"]
    assert copying.untold(replace(state, culled_from=wide)) == culled
    for each in (replace(state, culled_from=near), state.jumped(near)):
        assert copying.untold(each) == ["the near plane"]


def test_levels_are_found_by_any_part_of_their_names() -> None:
    levels = ("aggressor", "oa_dm1", "oa_dm2", "dm6ish", "castle")
    assert matching("dm", levels) == ["dm6ish", "oa_dm1", "oa_dm2"]
    assert matching(" OA_DM2 ", levels) == ["oa_dm2"]
    assert matching("", levels) == list(levels)
    assert matching("x", levels) == []


def test_history_holds_the_last_frames_in_order() -> None:
    history = History()
    assert len(history.of("CPU")) == 0
    assert (history.frame_rate, history.median("GPU")) == (0, 0)
    for number in range(1, 3 * LENGTH + 8):
        history.add(20, number, 2 * number, math.pi)
        first = max(1, number - LENGTH + 1)
        assert history.of("CPU").tolist() == list(range(first, number + 1))
        assert history.of("submission").tolist() == list(range(2 * first, 2 * number + 1, 2))
    assert history.frame_rate == 50
    assert history.median("GPU") == pytest.approx(math.pi)


def test_light_between_walls_is_that_of_the_lights_that_were_typed() -> None:
    lights = ("point:0,0,100:1000",)
    plain, dark, lit = (
        window.start("courtyard", Wish(bake=bake, lights=typed))
        for bake, typed in ((False, ()), (True, ()), (True, lights))
    )
    assert plain.scene.level.traced is None
    words = [shlex.split(copying.as_command(state, (64, 48))) for state in (plain, lit)]
    assert "--bake" not in words[0] and "--bake" in words[1]
    assert dark.scene.level.traced is not None and lit.scene.level.traced is not None
    assert dark.scene.level.traced.unit != lit.scene.level.traced.unit
    assert [lamp.light.power[0] for lamp in lit.lamps] == [1000]
