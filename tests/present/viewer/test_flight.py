"""Flying, without a window."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot import spaces
from followspot.game import RUN_SPEED
from followspot.present.viewer import flight
from followspot.present.viewer.flight import Flight, Steering
from followspot.scene.camera import Camera

START = Flight(Camera(spaces.vec3((10, 20, 30))))
AHEAD = Steering(forward=1)


def fly(start: Flight, rate: float, seconds: float, steering: Steering) -> Flight:
    """Steer the same at so many frames a second; the mouse turns by so many degrees a second."""
    count = round(seconds * rate)
    each = replace(steering, yaw=steering.yaw / rate, pitch=steering.pitch / rate)
    for _ in range(count):
        start = start.after(1 / rate, each)
    return start


def test_a_straight_flight_is_the_same_at_any_frame_rate() -> None:
    ends = [
        fly(fly(START, rate, 2, Steering(forward=1, up=0.5)), rate, 1, Steering(left=1, pace=4))
        for rate in (10, 30, 144)
    ]
    for end in ends[1:]:
        assert np.allclose(end.camera.position, ends[0].camera.position, rtol=0, atol=1e-6)
        assert np.allclose(end.velocity, ends[0].velocity, rtol=0, atol=1e-6)


def test_a_curve_at_30_and_144_frames_a_second_ends_within_a_unit() -> None:
    turning = Steering(forward=1, yaw=90, pitch=5)
    slow, fast = (fly(START, rate, 5, turning) for rate in (30, 144))
    flown = RUN_SPEED * 5
    assert np.linalg.norm(slow.camera.position - START.camera.position) > 100
    assert np.linalg.norm(slow.camera.position - fast.camera.position) < 1 < flown / 1000
    assert slow.camera.yaw == pytest.approx(fast.camera.yaw, abs=1e-6)
    assert slow.camera.pitch == pytest.approx(fast.camera.pitch, abs=1e-6)


def test_it_reaches_full_speed_smoothly_and_comes_to_rest() -> None:
    speeds = []
    now = START
    for _ in range(60):
        now = now.after(1 / 60, AHEAD)
        speeds.append(float(np.linalg.norm(now.velocity)))
    assert speeds == sorted(speeds)
    assert speeds[0] < 0.2 * RUN_SPEED
    assert speeds[5] == pytest.approx(RUN_SPEED * (1 - math.exp(-1)), rel=0.01)  # after MOVE_TAU
    assert speeds[-1] == pytest.approx(RUN_SPEED, rel=1e-3)
    after = fly(now, 60, 2, Steering())
    assert not after.velocity.any()
    gone = after.camera.position - now.camera.position
    assert np.linalg.norm(gone) == pytest.approx(RUN_SPEED * flight.MOVE_TAU, rel=1e-3)
    assert (
        after.after(1 / 60, Steering()).camera.position.tolist() == after.camera.position.tolist()
    )


def test_directions_are_the_cameras_but_up_is_the_worlds() -> None:
    down_left = START.at(Camera(spaces.vec3((0, 0, 0)), yaw=90, pitch=30))
    for steering, expected in (
        (AHEAD, (0, math.cos(math.radians(30)), -0.5)),
        (Steering(left=1), (-1, 0, 0)),
        (Steering(up=-1), (0, 0, -1)),
    ):
        velocity = fly(down_left, 60, 3, steering).velocity
        assert velocity == pytest.approx(np.array(expected) * RUN_SPEED, abs=0.1)


def test_a_diagonal_is_no_faster() -> None:
    diagonal = fly(START, 60, 3, Steering(forward=1, left=1)).velocity
    assert np.linalg.norm(diagonal) == pytest.approx(RUN_SPEED, rel=1e-3)


def test_the_angles_arrive_where_the_mouse_turned_to() -> None:
    turned = START.after(1 / 60, Steering(yaw=40, pitch=-10))
    assert 0 < turned.camera.yaw < 40
    rest = fly(turned, 60, 1, Steering())
    assert (rest.camera.yaw, rest.camera.pitch) == (40, -10)


def test_the_wheel_changes_the_speed_within_limits() -> None:
    assert START.after(0.01, Steering(notches=2)).speed == pytest.approx(RUN_SPEED * 1.44)
    assert START.after(0.01, Steering(notches=100)).speed == flight.FASTEST
    assert START.after(0.01, Steering(notches=-100)).speed == flight.SLOWEST


def test_a_jump_ends_a_flight() -> None:
    there = fly(START, 60, 1, AHEAD).at(Camera(spaces.vec3((1, 2, 3)), 45, 6, name="there"))
    later = fly(there, 60, 1, Steering())
    assert later.camera.position.tolist() == [1, 2, 3]
    assert (later.camera.yaw, later.camera.pitch) == (45, 6)
    assert later.camera.name == "there"
    assert there.after(1 / 60, AHEAD).camera.name == ""


@given(
    st.floats(0, 0.25),
    *[st.floats(-1, 1)] * 3,
    *[st.floats(-1e4, 1e4)] * 2,
    st.floats(0.1, 10),
    st.floats(-50, 50),
)
def test_whatever_is_steered_the_camera_stays_one(
    seconds: float, forward: float, left: float, up: float,
    yaw: float, pitch: float, pace: float, notches: float,
) -> None:  # fmt: skip
    steering = Steering(forward, left, up, yaw, pitch, pace, notches)
    now = START.after(seconds, steering).after(seconds, steering)
    assert np.isfinite(now.camera.position).all()
    assert math.isfinite(now.camera.yaw)
    assert abs(now.camera.pitch) <= flight.STEEPEST + 1e-9
    reach = flight.FASTEST * pace * 2 * seconds + 1e-6
    assert np.linalg.norm(now.camera.position - START.camera.position) <= reach
    assert spaces.normalised(now.camera.forward) == pytest.approx(now.camera.forward)
