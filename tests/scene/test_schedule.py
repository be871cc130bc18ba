"""When which frame is shown, and that nothing jumps when one animation follows another."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from followspot.assets.animation import Animation
from followspot.scene.schedule import Play, Schedules

animations = st.builds(
    Animation,
    first=st.integers(0, 50),
    count=st.integers(1, 12),
    looping=st.integers(0, 1),
    fps=st.sampled_from([1.0, 7.0, 10.0, 15.0, 24.0]),
    is_reversed=st.booleans(),
).map(lambda a: Animation(a.first, a.count, a.looping * a.count, a.fps, a.is_reversed))
gaps = st.lists(st.floats(0, 4), max_size=3)


def shown(schedules: Schedules, times: NDArray[np.float64], track: int = 0) -> NDArray[np.float64]:
    """(times, 128) share of each key frame in what is shown."""
    pose = schedules.poses(times, np.full(len(times), track))
    shares = np.zeros((len(times), 128))
    np.add.at(shares, (np.arange(len(times)), pose.frame), 1 - pose.blend)
    np.add.at(shares, (np.arange(len(times)), pose.next_frame), pose.blend)
    return shares


@given(animations, st.lists(st.floats(-5, 20), min_size=1, max_size=20))
def test_a_single_animation_is_played_as_it_plays_itself(
    animation: Animation, times: list[float]
) -> None:
    seconds = np.array(times)
    pose = Schedules([[Play(animation, 0.0)]]).poses(seconds, np.zeros(len(seconds), np.intp))
    expected = animation.pose(seconds)
    started = seconds >= 0
    np.testing.assert_array_equal(pose.frame[started], expected.frame[started])
    np.testing.assert_array_equal(pose.next_frame[started], expected.next_frame[started])
    np.testing.assert_allclose(pose.blend[started], expected.blend[started])
    first = int(animation.pose(0.0).frame)
    before = shown(Schedules([[Play(animation, 0.0)]]), seconds[~started])
    np.testing.assert_allclose(before[:, first], 1.0)


@given(st.lists(animations, min_size=2, max_size=4), gaps)
def test_changes_are_smooth(chosen: list[Animation], times: list[float]) -> None:
    """What is shown moves by no more than any of the animations' frames a second allow."""
    starts = np.cumsum([0.0, *times, *[1.0] * 4])[: len(chosen)].tolist()
    schedules = Schedules([[Play(a, at) for a, at in zip(chosen, starts, strict=True)]])
    step = 1e-3
    shares = shown(schedules, np.arange(-0.5, starts[-1] + 2.0, step))
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)
    moved = np.abs(np.diff(shares, axis=0)).sum(axis=1)
    assert moved.max() <= 2 * step * max(a.fps for a in chosen) * (1 + 1e-6)
    # In the end it plays the last one: only that one's frames.
    last = chosen[-1]
    end = shown(schedules, np.array([starts[-1] + 20.0]))
    assert end[0, last.first : last.first + last.count].sum() == pytest.approx(1.0)


def test_a_change_waits_for_the_key_frame() -> None:
    """Four frames a second, told to change at 0.6 s: at 0.75 s frame 3 turns into frame 50."""
    old, new = Animation(0, 8, 8, 4.0), Animation(50, 5, 0, 10.0)
    schedules = Schedules([[Play(old, 0.0), Play(new, 0.6)]])
    pose = schedules.poses(np.array([0.7, 0.75, 0.8, 0.85, 0.9, 9.0]), np.zeros(6, np.intp))
    np.testing.assert_array_equal(pose.frame, [2, 3, 3, 50, 50, 54])
    np.testing.assert_array_equal(pose.next_frame, [3, 50, 50, 51, 51, 54])
    np.testing.assert_allclose(pose.blend[:5], [0.8, 0.0, 0.5, 0.0, 0.5], atol=1e-9)


def test_tracks_are_told_apart() -> None:
    one, two = Animation(0, 2, 2, 1.0), Animation(10, 3, 3, 2.0)
    schedules = Schedules([[Play(one, 0.0)], [Play(two, 1.0), Play(one, 2.0)]])
    pose = schedules.poses(np.array([1.5, 1.5, 0.0]), np.array([1, 0, 1]))
    np.testing.assert_array_equal(pose.frame, [11, 1, 10])
