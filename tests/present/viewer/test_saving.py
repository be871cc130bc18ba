"""What is saved of the viewer's state: only changed keys, and all of them."""

import math
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from difflib import unified_diff
from pathlib import Path

import msgspec
import numpy as np
import pytest
from driver import display, play

from followspot import spaces
from followspot.present.viewer import lamps, saving
from followspot.present.viewer.copying import as_toml
from followspot.present.viewer.saving import saved
from followspot.present.viewer.scene_text import Document
from followspot.present.viewer.state import Look, State
from followspot.scene import scene_file
from followspot.scene.light import SpotLight
from followspot.scene.load import load
from followspot.scene.path import CameraPath, Key
from followspot.scene.scene import Scene
from followspot.scene.search import BUILTIN
from followspot.scene.settings import CullFace, Settings

COURTYARD = (BUILTIN / "courtyard.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def courtyard() -> Scene:
    return load("courtyard")


def reopened(scene: Scene, path: Path) -> State:
    """What a scene file opens to, without its level being built again; see `load`."""
    file = scene_file.read(path)
    own = {name: entry.camera(name) for name, entry in file.cameras.items()}
    spawns = {name: c for name, c in scene.cameras.items() if name.startswith("spawn")}
    new = replace(
        scene,
        name=str(path),
        lights=tuple(entry.light() for entry in file.lights or ()),
        cameras=own | {name: c for name, c in spawns.items() if name not in own},
        paths={name: entry.path() for name, entry in file.paths.items()},
        settings=file.settings,
        ambient=file.ambient,
        environment_constant=file.environment_constant,
    )
    return State.of(new, new.camera())


@pytest.fixture
def opened(courtyard: Scene, tmp_path: Path) -> State:
    """The courtyard's scene file, in a folder of our own."""
    path = tmp_path / "mine.toml"
    path.write_text(COURTYARD, encoding="utf-8")
    state = reopened(courtyard, path)
    return state.with_recording(folder=str(tmp_path))


def file_of(state: State) -> Path:
    return Path(state.scene.name)


def changed_lines(state: State) -> list[str]:
    """Lines that saving takes away, with -, and adds, with +."""
    before = file_of(state).read_text(encoding="utf-8").splitlines()
    after = saved(state)
    assert "is saved" in after.notice
    now = file_of(state).read_text(encoding="utf-8").splitlines()
    diff = list(unified_diff(before, now, lineterm="", n=0))[2:]
    return [line for line in diff if not line.startswith("@@")]


def values(state: State) -> dict[str, object]:
    """All that a scene file says of a state, exactly."""
    lights = [
        {name: np.asarray(value).tolist() for name, value in vars(lamp.light).items()}
        for lamp in state.lamps
    ]
    paths = {
        name: [(key.time, key.position.tolist(), key.yaw, key.pitch, key.fov) for key in path.keys]
        for name, path in state.scene.paths.items()
        if isinstance(path, CameraPath)
    }
    return {
        "settings": state.look.settings(state.settings),
        "look": replace(state.look, view=Look().view),
        "lights": lights,
        "cameras": {name: as_toml(camera) for name, camera in state.scene.cameras.items()},
        "paths": paths,
        "sky": (state.lit.environment_constant, state.lit.ambient),
    }


def with_sun(state: State, **changes: object) -> State:
    sun = replace(state.lamps[0].light, **changes)  # type: ignore[arg-type]
    return state.with_lamp(0, replace(state.lamps[0], light=sun))


def test_nothing_changed_is_the_same_file_byte_for_byte(opened: State) -> None:
    path = file_of(opened)
    odd = COURTYARD.replace("yaw = 36", "yaw=36.0   # odd").replace("\n", "\r\n") + "\r\n\r\n"
    path.write_bytes(odd.encode())
    time = path.stat().st_mtime_ns
    assert saved(opened).notice == f"{path} is saved."
    assert path.read_bytes() == odd.encode()
    assert path.stat().st_mtime_ns == time


def test_a_changed_setting_is_a_changed_line(opened: State) -> None:
    assert changed_lines(opened.with_settings(shadow_taps=4)) == [
        "-shadow_taps = 2",
        "+shadow_taps = 4",
    ]


def test_a_new_setting_is_a_new_line(opened: State) -> None:
    assert changed_lines(opened.with_settings(exposure=1.25)) == ["+exposure = 1.25"]
    assert changed_lines(opened.with_settings(exposure=None)) == ["-exposure = 1.25"]
    culled = opened.with_settings(shadow_cull=CullFace.NONE)
    assert changed_lines(culled) == ['+shadow_cull = "none"']


def test_a_setting_that_the_file_leaves_open_stays_so_until_it_is_changed(opened: State) -> None:
    path = file_of(opened)
    text = COURTYARD.replace("[settings]", '[settings]\nexposure = "auto"  # to suit')
    path.write_text(text, encoding="utf-8")
    assert saved(opened).notice == f"{path} is saved."
    assert path.read_text(encoding="utf-8") == text
    assert changed_lines(opened.with_settings(exposure=1.25)) == [
        '-exposure = "auto"  # to suit',
        "+exposure = 1.25  # to suit",
    ]
    assert scene_file.read(path).settings == opened.with_settings(exposure=1.25).settings
    assert changed_lines(opened.with_settings(exposure=None)) == ["-exposure = 1.25  # to suit"]
    assert scene_file.read(path).settings == opened.settings


def test_the_switches_of_the_stages_are_settings(opened: State) -> None:
    look = replace(opened.look, shadows=False, textures=False)
    lines = changed_lines(replace(opened, look=look))
    assert lines == ["+shadows = false", "+albedo = 0.5"]


def test_a_moved_light_keeps_its_lines_comments(opened: State) -> None:
    sun = opened.lamps[0].light
    moved = with_sun(opened, position=np.add(sun.position, (0, 0, 100.5)))
    assert changed_lines(moved) == [
        "-position = [-2845, -4218, 3280] # far away, so that its light is nearly parallel",
        "-target = [0, 0, 100]",
        "+position = [-2845, -4218, 3380.5] # far away, so that its light is nearly parallel",
        "+target = [0, 0, 200.5]",
    ]


def test_each_property_of_a_light_is_a_line(opened: State) -> None:
    assert changed_lines(with_sun(opened, half_angle=math.radians(12))) == [
        "-half_angle_degrees = 9.5",
        "+half_angle_degrees = 12",
    ]
    assert changed_lines(with_sun(opened, power=(7, 7, 7)))[-1] == "+power = 7"
    assert "+casts_shadow = false" in changed_lines(with_sun(opened, casts_shadow=False))


def test_removed_and_added_lights(opened: State) -> None:
    one = lamps.removed(opened, 0)
    two = lamps.added(one)
    path = file_of(opened)
    after = saved(two)
    assert [lamp.number for lamp in after.lamps] == [0, 1]
    text = path.read_text(encoding="utf-8")
    assert '\n\n[[lights]]\nname = "torch"                  # in the low passage' in text
    assert '\n\n[[lights]]\nname = "light 1"\ntype = "spot"\n' in text
    assert "softness = 0.2\npower = " in text
    assert "\n\n[cameras.title]\n" in text
    assert "\n\n\n" not in text
    assert values(reopened(opened.scene, path)) == values(after)
    none = saved(lamps.removed(lamps.removed(after, 1), 0))
    file = scene_file.read(path)
    assert file.lights == ()
    again = saved(lamps.added(lamps.added(none), is_point=True))
    assert values(reopened(opened.scene, path)) == values(again)
    dark = replace(again.lamps[1].light, casts_shadow=False)
    again = saved(again.with_lamp(1, replace(again.lamps[1], light=dark)))
    assert "casts_shadow = false" in path.read_text(encoding="utf-8")
    assert values(reopened(opened.scene, path)) == values(again)


def test_all_lights_in_exchange_for_others(opened: State) -> None:
    """Nothing is left then of the lights' tables that a new one could be put after."""
    before = file_of(opened).read_text(encoding="utf-8")
    none = lamps.removed(lamps.removed(opened, 1), 0)
    after = saved(lamps.added(lamps.added(none), is_point=True))
    assert "is saved" in after.notice and [lamp.number for lamp in after.lamps] == [0, 1]
    text = file_of(opened).read_text(encoding="utf-8")
    assert "torch" in before and "torch" not in text and text.count("[[lights]]") == 2
    assert values(reopened(opened.scene, file_of(opened))) == values(after)


def test_a_light_that_is_off_is_kept_and_that_is_told(opened: State) -> None:
    off = opened.with_lamp(1, replace(opened.lamps[1], is_on=False))
    after = saved(off)
    assert "with its lights on" in after.notice
    assert file_of(opened).read_text(encoding="utf-8") == COURTYARD
    assert [lamp.is_on for lamp in after.lamps] == [True, False]


def test_views_and_paths(opened: State) -> None:
    there = opened.jumped(replace(opened.camera, position=spaces.vec3((1.25, 2, 3)), yaw=-12.5))
    path = CameraPath((Key(0.0, spaces.vec3((1, 2.125, 3)), 4, 5, 80), Key(1.0375, np.ones(3))))
    scene = replace(there.scene, paths={**there.scene.paths, "flight1": path})
    kept = replace(there, scene=scene).with_view("by the well").with_view("title")
    assert changed_lines(kept) == [
        "-position = [-352, -118, 78]", "-yaw = 36",
        "+position = [1.25, 2, 3]", "+yaw = -12.5",
        "+", '+[cameras."by the well"]', "+position = [1.25, 2, 3]",
        "+yaw = -12.5", "+pitch = -5", "+fov = 80",
        "+", "+[paths.flight1]", "+keys = [",
        "+    {time = 0, position = [1, 2.125, 3], yaw = 4, pitch = 5, fov = 80},",
        "+    {time = 1.0375, position = [1, 1, 1], yaw = 0, pitch = 0, fov = 90},", "+]",
    ]  # fmt: skip
    assert values(reopened(opened.scene, file_of(opened))) == values(saved(kept))


@pytest.mark.parametrize("seed", range(10))
def test_a_saved_file_opens_to_the_same_state(opened: State, seed: int) -> None:
    path, courtyard, rng = file_of(opened), opened.scene, np.random.default_rng(seed)
    small, scale = rng.uniform(1e-6, 1), float(10 ** rng.uniform(-6, 6))
    state = opened.with_settings(exposure=scale, shadow_bias=-small, albedo=small)
    state = replace(state, look=replace(state.look, textures=False))
    spot = SpotLight(
        rng.normal(0, scale, 3), rng.normal(0, 1, 3), rng.uniform(0.01, 1.5),
        rng.uniform(0, scale, 3), small,
    )  # fmt: skip
    state = with_sun(lamps.added(state), direction=spot.direction, half_angle=spot.half_angle)
    state = state.with_lamp(2, replace(state.lamps[2], light=spot))
    state = state.jumped(replace(state.camera, position=spot.position, yaw=scale)).with_view("x")
    after = saved(state)
    assert values(reopened(courtyard, path)) == values(after)
    text = path.read_bytes()
    saved(after)
    assert path.read_bytes() == text
    wanted = msgspec.structs.asdict(state.look.settings(state.settings))
    for name, value in msgspec.structs.asdict(after.settings).items():
        exact = not isinstance(value, float)
        assert value == (wanted[name] if exact else pytest.approx(wanted[name], rel=1e-6)), name
    for lamp, before in zip(after.lamps, state.lamps, strict=True):
        for name, value in vars(before.light).items():
            now = getattr(lamp.light, name)
            if isinstance(value, str):
                assert now == value
            else:
                largest = np.abs(value).max()
                assert np.allclose(now, value, rtol=0, atol=1e-6 * largest), name


def test_what_comes_with_the_package_gets_a_file_of_its_own(
    courtyard: Scene, tmp_path: Path
) -> None:
    state = State.of(courtyard, courtyard.camera()).with_recording(folder=str(tmp_path))
    after = saved(state.with_settings(shadow_taps=3))
    text = (tmp_path / "courtyard.toml").read_text(encoding="utf-8")
    assert text == COURTYARD.replace("shadow_taps = 2", "shadow_taps = 3")
    assert saving.own_file(after) == tmp_path / "courtyard.toml"
    again = saved(state)
    assert saving.own_file(again) == tmp_path / "courtyard-1.toml"
    named = saved(replace(state, save_as="name"))
    assert saving.own_file(named) == tmp_path / "name.toml"
    assert "there already" in saved(replace(state, save_as="name.toml")).notice
    assert len(list(tmp_path.iterdir())) == 3


def test_a_level_gets_a_scene_file_with_all_that_it_needs(tmp_path: Path) -> None:
    """Its light was chosen by the program; the file has it, and what goes with it."""
    scene = load(str(BUILTIN / "courtyard.pk3"))
    assert scene.lights_chosen
    start = replace(scene.camera(), position=spaces.vec3((-352, -118, 78)), name="")
    state = State.of(scene, start).with_recording(folder=str(tmp_path))
    after = saved(state)
    text = (tmp_path / "courtyard.toml").read_text(encoding="utf-8")
    assert text.startswith('level = "')
    opened = load(str(tmp_path / "courtyard.toml"))
    back = State.of(opened, opened.camera())
    assert values(back) == values(after)
    assert back.camera.position.tolist() == start.position.tolist()
    assert len(back.lamps) == 1
    assert back.lit.ambient == pytest.approx(state.lit.ambient)
    assert back.lamps[0].light.power == pytest.approx(state.lamps[0].light.power)
    assert "\n\n\n" not in text


def test_what_cannot_be_saved_is_told_in_one_line(opened: State, tmp_path: Path) -> None:
    path = file_of(opened)
    path.write_text('level = "courtyard"\nlights = 3\n')
    broken = saved(opened.with_settings(shadow_taps=4))
    assert "lights" in broken.notice
    path.write_text("level =")
    for text in ("level =", None):
        if text is None:
            path.unlink()
        before = sorted(tmp_path.iterdir())
        after = saved(opened)
        assert str(path) in after.notice
        assert "\n" not in after.notice
        assert after.scene is opened.scene
        assert sorted(tmp_path.iterdir()) == before
    model = replace(opened, scene=replace(opened.scene, name="player:sarge"))
    assert "only levels" in saved(model).notice
    (tmp_path / "file").touch()
    nowhere = replace(opened, scene=replace(opened.scene, name="courtyard"))
    nowhere = nowhere.with_recording(folder=str(tmp_path / "file"))
    assert "cannot be written" in saved(nowhere).notice


def test_a_level_whose_name_no_scene_file_can_hold(courtyard: Scene, tmp_path: Path) -> None:
    level = tmp_path / os.fsdecode(b"b\xffd.bsp")
    level.write_bytes(b"")
    state = State.of(replace(courtyard, name=str(level), lights_chosen=True), courtyard.camera())
    state = replace(state.with_recording(folder=str(tmp_path)), save_as="new.toml")
    told = f"{tmp_path / 'new.toml'}: cannot be written: expected names of UTF-8 text in it, found"
    assert saved(state).notice.startswith(told)
    assert list(tmp_path.iterdir()) == [level]


def test_lights_that_somebody_else_has_added_are_not_lost(opened: State) -> None:
    path = file_of(opened)
    more = COURTYARD + '\n[[lights]]\ntype = "point"\nposition = [0, 0, 0]\npower = 1\n'
    path.write_text(more, encoding="utf-8")
    after = saved(lamps.removed(opened, 0))
    assert "expected 2 lights, as when it was opened, found 3" in after.notice
    assert path.read_text(encoding="utf-8") == more


def test_toml_in_other_words() -> None:
    """Inline tables, dotted keys and tables in pieces are edited where they stand."""
    text = (
        'level="x"\nlights = [\n {type="point", position=[1,2,3], power=1}, # one\n]\n'
        "settings.shadow_taps = 2\ncameras = {a = {position=[1,2,3]}}\n"
    )
    file = scene_file.parse(text, "a")
    assert file.lights is not None
    light = file.lights[0].light()
    document = Document(text, "a")
    document.put_settings(Settings(shadow_taps=3, exposure=2.0), file.settings)
    moved = replace(light, position=spaces.vec3((4, 5, 6)))
    document.put_lights([(moved, 0), (light, None)], [light])
    document.put_camera("b", file.cameras["a"].camera("b"), None)
    after = scene_file.parse(document.text, "a")
    assert after.settings == Settings(shadow_taps=3, exposure=2.0)
    assert after.lights is not None
    assert [entry.position for entry in after.lights] == [(4, 5, 6), (1, 2, 3)]
    assert set(after.cameras) == {"a", "b"}
    assert "# one" in document.text
    pieces = "level = 'x'\n[cameras.a]\nposition = [1, 2, 3]\n# of paths\n[paths.p]\nauto = true\n"
    pieces += "[cameras.b]\nposition = [1, 2, 3]\n"
    camera = scene_file.parse(pieces, "b").cameras["a"].camera("a")
    document = Document(pieces, "b")
    document.put_camera("a", replace(camera, yaw=3), camera)
    document.put_camera("c", camera, None)
    added = "position = [1, 2, 3]\nyaw = 3\n# of paths"
    assert document.text.startswith(pieces.replace("position = [1, 2, 3]\n# of paths", added))
    assert set(scene_file.parse(document.text, "b").cameras) == {"a", "b", "c"}


@pytest.fixture(scope="module")
def screen() -> Iterator[str]:
    with display() as name:
        yield name


@pytest.mark.gl
def test_a_flight_becomes_a_film(screen: str, tmp_path: Path) -> None:
    play("keeping", screen, tmp_path)
    work = tmp_path / "work"
    options = ["--path", "flight1", "--size", "64x48", "--fps", "10", "-o", "film.mp4"]
    command = [sys.executable, "-m", "followspot", "film", "courtyard.toml", *options]
    subprocess.run(command, cwd=work, check=True, timeout=60, capture_output=True)
    assert (work / "film.mp4").stat().st_size > 1000
