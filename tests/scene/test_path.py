"""Camera paths: keys hit exactly, smooth in between, at a speed that the keys' times tell."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from followspot.errors import AssetError, UsageError
from followspot.scene.path import AutoPath, CameraPath, Key
from followspot.scene.scene_file import parse
from followspot.spaces import vec3
from synthetic import make_scene

number = st.integers(-16000, 16000).map(lambda eighths: eighths / 8)
place = st.tuples(number, number, number)
gap = st.floats(0.05, 10)


def path_of(places: list[Any], gaps: list[float], yaws: list[float] | None = None) -> CameraPath:
    times = np.cumsum([0.0, *gaps[: len(places) - 1]]).tolist()
    yaws = yaws or [0.0] * len(places)
    keys = zip(times, places, yaws, strict=False)
    return CameraPath(tuple(Key(time, vec3(at), yaw) for time, at, yaw in keys))


CORNER = path_of([(0, 0, 0), (100, 0, 0), (300, 200, 50), (300, 600, 50)], [1.0, 2.0, 3.0])


@given(st.lists(place, min_size=1, max_size=8), st.lists(gap, min_size=8, max_size=8))
def test_every_key_is_hit_exactly(places: list[Any], gaps: list[float]) -> None:
    path = path_of(places, gaps)
    times = np.array([key.time for key in path.keys])
    assert np.array_equal(path.positions(times), np.array(places))
    for key in path.keys:
        camera = path.camera(key.time)
        assert np.array_equal(camera.position, key.position)
        assert (camera.yaw, camera.pitch, camera.fov) == (key.yaw, key.pitch, key.fov)


@given(st.lists(place, min_size=2, max_size=8), st.lists(gap, min_size=8, max_size=8))
def test_it_stays_finite_and_near_its_keys(places: list[Any], gaps: list[float]) -> None:
    """Keys at one place, keys very near each other: nothing blows up."""
    path = path_of(places, gaps)
    positions = path.positions(np.linspace(-1, path.seconds + 1, 200))
    spread = np.ptp(np.array(places), axis=0).max()
    assert np.isfinite(positions).all()
    assert (positions >= np.min(places, axis=0) - spread - 1e-6).all()
    assert (positions <= np.max(places, axis=0) + spread + 1e-6).all()


@pytest.mark.parametrize("time", [0.0, 3.0])
def test_one_key_has_no_speed_to_change(time: float) -> None:
    path = CameraPath((Key(time, vec3((1, 2, 3)), 40),))
    for other in (path.lasting(5), path.at_one_speed(5)):
        assert other.camera(0).position.tolist() == [1, 2, 3] and other.camera(9).yaw == 40


def velocities(path: CameraPath, times: NDArray[np.float64], side: int) -> NDArray[np.float64]:
    """One-sided differences over a step that is longer than a chord of the arc length's table."""
    step = 1e-3 * side
    return (path.positions(times + step) - path.positions(times)) / step


def test_the_velocity_has_no_jumps() -> None:
    times = np.array([key.time for key in CORNER.keys[1:-1]])
    before, after = velocities(CORNER, times, -1), velocities(CORNER, times, 1)
    assert np.abs(before - after).max() < 0.02 * np.abs(after).max()


def test_angles_have_no_jumps_in_their_speed() -> None:
    path = path_of([(k, 0, 0) for k in range(5)], [1.0, 0.5, 2.0, 1.0], [0, 50, 70, 200, 190])
    times = np.array([key.time for key in path.keys[1:-1]])
    step = 1e-6
    before = (path.angles(times) - path.angles(times - step)) / step
    after = (path.angles(times + step) - path.angles(times)) / step
    assert np.abs(before - after).max() < 1e-2


def test_speed_does_not_depend_on_where_the_keys_are() -> None:
    """Keys at odd places of a line, at times that fit: one speed all the way."""
    places = [0.0, 5.0, 200.0, 210.0, 600.0]
    path = path_of([(x, 0, 0) for x in places], np.diff(places).tolist())
    path = path.lasting(6.0)
    times = np.linspace(0, 6, 500)
    assert np.allclose(path.positions(times)[:, 0], times * 100, atol=0.05)


def test_one_speed_along_a_curve() -> None:
    path = CORNER.at_one_speed(10.0)
    times = np.linspace(0, 10, 400)
    speed = np.linalg.norm(np.diff(path.positions(times), axis=0), axis=1)
    assert np.ptp(speed) < 0.02 * speed.mean()
    assert path.seconds == 10.0
    assert [key.position.tolist() for key in path.keys] == [
        key.position.tolist() for key in CORNER.keys
    ]


@given(st.lists(place, min_size=3, max_size=6), st.lists(gap, min_size=6, max_size=6))
def test_the_camera_never_goes_back(places: list[Any], gaps: list[float]) -> None:
    """However the times are spread, arc length only grows."""
    path = path_of(places, gaps)
    fine = np.linspace(0, path.seconds, 300)
    arc = np.linalg.norm(np.diff(path.positions(fine), axis=0), axis=1).sum()
    assert arc <= path._arc[-1] * 1.001 + 1e-9  # whose chords are coarser


def test_a_pause_is_a_smooth_stop() -> None:
    path = path_of([(0, 0, 0), (100, 0, 0), (100, 0, 0), (200, 0, 0)], [1.0, 1.0, 1.0])
    still = path.positions(np.linspace(1, 2, 20))
    assert np.array_equal(still, np.tile([100.0, 0, 0], (20, 1)))
    x = path.positions(np.array([0.99, 1.0, 2.0, 2.01]))[:, 0]
    assert 99.9 < x[0] < 100 and 100 < x[3] < 100.1


@pytest.mark.parametrize(("first", "second"), [(170, -170), (-170, 170), (350, 10), (10, 350)])
def test_yaw_takes_the_shorter_turn(first: float, second: float) -> None:
    path = path_of([(0, 0, 0), (1, 0, 0)], [1.0], [first, second])
    yaw = path.angles(np.linspace(0, 1, 50))[:, 0]
    assert abs(yaw[-1] - yaw[0]) == 20
    assert math.isclose(math.cos(math.radians(yaw[-1])), math.cos(math.radians(second)))


@given(st.lists(st.floats(-180, 180), min_size=3, max_size=6))
def test_angles_do_not_overshoot(yaws: list[float]) -> None:
    path = path_of([(k, 0, 0) for k in range(len(yaws))], [1.0] * len(yaws), yaws)
    unwrapped = np.unwrap(yaws, period=360)
    for k in range(len(yaws) - 1):
        yaw = path.angles(np.linspace(k, k + 1, 30))[:, 0]
        low, high = sorted(unwrapped[k : k + 2])
        assert low - 1e-9 <= yaw.min() and yaw.max() <= high + 1e-9


steep = st.sampled_from([-90.0, 90.0]) | st.floats(-90, 90)


@given(st.lists(steep, min_size=2, max_size=6), st.lists(gap, min_size=6, max_size=6))
def test_between_steep_keys_there_is_a_camera_at_every_time(
    pitches: list[float], gaps: list[float]
) -> None:
    times = np.cumsum([0.0, *gaps[: len(pitches) - 1]]).tolist()
    keys = zip(times, pitches, strict=True)
    path = CameraPath(tuple(Key(time, vec3((0, 0, time)), pitch=pitch) for time, pitch in keys))
    for time in np.linspace(0, path.seconds, 40):
        assert abs(path.camera(time).pitch) <= 90


def test_the_horizon_is_level() -> None:
    for time in np.linspace(0, CORNER.seconds, 20):
        right = CORNER.camera(time).view_from_world[0, :3]
        assert right[2] == 0


def test_before_and_after_the_camera_stands_still() -> None:
    late = CameraPath(tuple(replace(key, time=key.time + 2) for key in CORNER.keys))
    assert np.array_equal(late.positions(np.array([-1.0, 0, 2]))[0], CORNER.keys[0].position)
    assert np.array_equal(late.positions(np.array([8.0, 99]))[1], CORNER.keys[-1].position)


def test_a_time_alone_decides() -> None:
    times = np.linspace(0, CORNER.seconds, 37)
    together = CORNER.positions(times)
    again = CameraPath(CORNER.keys)
    for time, position in zip(times[::-1], together[::-1], strict=True):
        assert np.array_equal(again.camera(time).position, position)


@pytest.mark.parametrize("times", [[], [0.0, 0.0], [1.0, 0.5]])
def test_times_must_increase(times: list[float]) -> None:
    with pytest.raises(ValueError, match="increasing"):
        CameraPath(tuple(Key(time, vec3([time, 0, 0])) for time in times))


def paths_in(text: str) -> CameraPath | AutoPath:
    return parse('level = "x"\n[paths.tour]\n' + text, "x.toml").paths["tour"].path()


def test_keys_of_a_scene_file() -> None:
    path = paths_in(
        "keys = [{time = 1, position = [0, 0, 50], yaw = 30, pitch = 5, fov = 70},"
        "{time = 4, position = [100, 0, 50], look_at = [100, 100, -50]}]"
    )
    assert isinstance(path, CameraPath)
    first, second = path.keys
    assert (first.time, first.yaw, first.pitch, first.fov) == (1, 30, 5, 70)
    assert (second.time, second.fov) == (4, 90)
    assert np.isclose(second.yaw, 90) and np.isclose(second.pitch, 45)


def test_keys_without_times_share_the_seconds() -> None:
    path = paths_in(
        "seconds = 8\nkeys = [{position = [0, 0, 0]}, {position = [100, 0, 0]}, "
        "{position = [400, 0, 0]}]"
    )
    assert isinstance(path, CameraPath)
    assert np.allclose([key.time for key in path.keys], [0, 2, 8])


def test_automatic_paths_of_a_scene_file() -> None:
    assert paths_in("auto = true\nseconds = 12") == AutoPath(12.0)
    assert paths_in("auto = true") == AutoPath(20.0)


A, B = "{time = 0, position = [0, 0, 0]}", "position = [9, 0, 0]"


@pytest.mark.parametrize(
    ("text", "place", "told"),
    [
        ("", "paths.tour", "either keys or auto = true"),
        (f"auto = true\nkeys = [{A}, {{time = 1, {B}}}]", "paths.tour", "either keys or auto"),
        (f"keys = [{A}]", "paths.tour", "two keys or more"),
        (f"keys = [{A}, {{{B}}}]", "paths.tour", "a time in all keys or in none"),
        (f"keys = [{A}, {{time = 0, {B}}}]", "paths.tour", "keys[1].time at least 0.001 s after 0"),
        (f"seconds = 3\nkeys = [{A}, {{time = 1, {B}}}]", "paths.tour", "seconds or times"),
        (f"keys = [{{{B}}}, {{{B}}}]", "paths.tour", "away from the one before"),
        (f"keys = [{A}, {{time = -1, {B}}}]", "paths.tour.keys[1].time", ">= 0"),
        (f"keys = [{A}, {{time = 1}}]", "paths.tour.keys[1]", "the key position"),
        (f"keys = [{A}, {{time = 1, {B}, roll = 3}}]", "paths.tour.keys[1]", "known keys"),
        (f"keys = [{A}, {{time = 1, {B}, fov = 0}}]", "paths.tour.keys[1].fov", ">= 1"),
        (
            f"keys = [{A}, {{time = 1, {B}, yaw = 3, look_at = [0, 0, 0]}}]",
            "paths.tour.keys[1]",
            "look_at or angles",
        ),
        (f"keys = [{A}, {{time = 1, {B}, look_at = [9, 0, 0]}}]", "paths.tour.keys[1]", "away"),
        ("auto = true\nseconds = 0", "paths.tour.seconds", "0.1"),
        ("auto = true\nspeed = 9", "paths.tour", "known keys"),
    ],
)
def test_mistakes_in_a_scene_file(text: str, place: str, told: str) -> None:
    with pytest.raises(AssetError) as caught:
        paths_in(text)
    assert caught.value.place == place
    assert told in str(caught.value).replace("`", "")


def test_paths_must_be_tables() -> None:
    with pytest.raises(AssetError, match=r"paths: expected a table"):
        parse('level = "x"\npaths = 3', "x.toml")


def test_paths_by_name() -> None:
    scene = make_scene([], paths={"tour": CORNER})
    assert scene.path() is CORNER and scene.path("tour") is CORNER
    assert scene.path("auto") == AutoPath()
    assert make_scene([]).path() == AutoPath()
    with pytest.raises(UsageError, match=r"no path is named 'tuor'; there are tour, auto"):
        scene.path("tuor")
