"""Walking in the viewer: when it begins and ends, and where the camera is meanwhile."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driver import display, play

import synthetic
from followspot.game import EYE_HEIGHT, RUN_SPEED
from followspot.levelbuilder.brush import box, room
from followspot.levelbuilder.compiler import compile_level
from followspot.levelbuilder.level import Level
from followspot.levelbuilder.material import Material
from followspot.present.viewer.flight import Steering
from followspot.present.viewer.state import State
from followspot.present.viewer.walking import DEEPEST_FALL, NO_ROOM, Walking
from followspot.scene.load import load
from followspot.scene.scene import Scene
from followspot.spaces import vec3

STONE = Material("textures/test/stone")
EYE = 24.125 + EYE_HEIGHT
"""Of one who stands on the floor, a gap above it."""
AHEAD = Steering(forward=1)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    """A hall with a step before its spawn point and a teleporter behind that; no sky below it."""
    level = Level()
    level.add(room((-512, -512, 0), (512, 512, 512), STONE))
    level.add(box((100, -60, 0), (300, 60, 16), STONE, detail=True))
    level.spawn(0, 0, 0)
    level.entity("trigger_teleport", box((-120, -60, 0), (-100, 60, 80), STONE), target="there")
    level.entity("misc_teleporter_dest", origin=(-300, 200, 24), targetname="there", angle=90)
    file = tmp_path_factory.mktemp("maps") / "hall.bsp"
    file.write_bytes(compile_level(level))
    return load(str(file))


@pytest.fixture
def state(scene: Scene) -> State:
    return replace(State.of(scene, scene.cameras["spawn0"]), walks=True)


def walk(walking: Walking, state: State, seconds: float, steering: Steering) -> State:
    for _ in range(round(seconds * 60)):
        state = walking.after(state, 1 / 60, steering)
    return state


def test_somebody_who_flies_falls_to_the_floor_runs_and_climbs_steps(state: State) -> None:
    walking = Walking()
    aloft = state.jumped(replace(state.camera, position=vec3((0, 0, 200))))
    standing = walk(walking, aloft, 1.5, Steering())
    assert standing.camera.position == pytest.approx((0, 0, EYE), abs=0.2)
    ahead = walk(walking, standing, 0.7, AHEAD)
    assert ahead.camera.position[2] == pytest.approx(EYE + 16, abs=0.5)
    assert 0.7 * RUN_SPEED * 0.75 < ahead.camera.position[0] < 0.7 * RUN_SPEED
    assert ahead.camera.name == ""
    slow = walk(walking, standing, 0.7, replace(AHEAD, pace=0.25))
    assert slow.camera.position[0] < 0.7 * RUN_SPEED * 0.26
    jumped = [walk(Walking(), standing, t, Steering(up=1)).camera.position[2] for t in (0.1, 0.3)]
    assert min(jumped) > EYE + 15
    crouched = walk(walking, standing, 1, Steering(up=-1))
    assert crouched.camera.position[2] == pytest.approx(EYE - 14, abs=0.2)


def test_the_mouse_turns_and_walls_stop(state: State) -> None:
    walking = Walking()
    turned = walking.after(state, 1 / 60, Steering(yaw=90, pitch=20))
    turned = walk(walking, turned, 1, Steering())
    turned = walk(walking, turned, 3, AHEAD)
    assert (turned.camera.yaw, turned.camera.pitch) == (90, 20)
    assert turned.camera.position == pytest.approx((0, 512 - 15, EYE), abs=0.3)


def test_a_teleporters_exit_turns_the_camera(state: State) -> None:
    back = replace(AHEAD, forward=-1)
    walking = Walking()
    for _ in range(60):
        state = walking.after(state, 1 / 60, back)
        if state.camera.yaw != 0:
            break
    assert (state.camera.yaw, state.flight.turning_to[0]) == (90, 90)
    assert state.camera.position == pytest.approx((-300, 200, EYE), abs=10)


def test_walking_goes_on_where_the_camera_was_taken(state: State) -> None:
    walking = Walking()
    walked = walk(walking, state, 0.5, AHEAD)
    elsewhere = walked.jumped(replace(state.camera, position=vec3((-200, -300, EYE)), yaw=-90))
    there = walking.after(elsewhere, 1 / 60, Steering())
    assert there.camera.position == pytest.approx((-200, -300, EYE), abs=0.2)
    assert there.camera.yaw == -90
    zoomed = replace(there, flight=there.flight.at(replace(there.camera, fov=50)))
    after = walking.after(zoomed, 1 / 60, Steering())
    assert after.camera.fov == 50


def test_without_room_it_is_told_and_one_flies_on(state: State) -> None:
    outside = state.jumped(replace(state.camera, position=vec3((3000, 0, 0))))
    after = Walking().after(outside, 1 / 60, AHEAD)
    assert not after.walks
    assert after.notice == NO_ROOM
    assert after.camera is outside.camera
    flat = synthetic.make_scene([synthetic.floor()], cameras={"here": state.camera})
    nowhere = replace(State.of(flat, state.camera), walks=True)
    assert Walking().after(nowhere, 1 / 60, AHEAD).notice == NO_ROOM


def test_who_falls_out_of_the_level_is_back_at_a_spawn_point(state: State) -> None:
    walking = Walking()
    state = walking.after(state, 1 / 60, Steering())
    below = -DEEPEST_FALL - 100.0
    walking._walker._put(np.array((0, 0, below)))
    after = walking.after(state, 1 / 60, Steering())
    assert after.camera is state.scene.cameras["spawn0"]
    assert after.walks


@pytest.fixture(scope="module")
def screen() -> Iterator[str]:
    with display() as name:
        yield name


@pytest.mark.gl
def test_keys_and_panel(screen: str, tmp_path: Path) -> None:
    play("walking", screen, tmp_path)
