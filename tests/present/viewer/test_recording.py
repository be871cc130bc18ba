"""What the viewer records: screenshots, films, and flights as paths."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import av
import numpy as np
import pytest
from driver import display, play
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from followspot.arrays import Floats
from followspot.errors import UsageError
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.present.viewer import canvas, handles, recording
from followspot.present.viewer.flight import Flight, Steering
from followspot.present.viewer.flown import DEGREES, SHORTEST, UNITS, Flown, thinned
from followspot.present.viewer.reel import WAITING, Reel
from followspot.present.viewer.state import LONGEST_FRAME, Look, Recording, State
from followspot.scene.camera import Camera
from followspot.scene.path import CameraPath
from followspot.scene.settings import CullFace
from synthetic import box, camera, floor, make_scene, point, spot


def errors(path: CameraPath, moments: Floats) -> tuple[Floats, Floats]:
    """(n,) units and (n, 3) degrees that a path is off at the moments of a flight, worked out
    moment by moment.
    """
    cameras = [path.camera(time) for time in moments[:, 0]]
    units = [np.linalg.norm(c.position - m[1:4]) for c, m in zip(cameras, moments, strict=True)]
    angles = np.array([(c.yaw, c.pitch, c.fov) for c in cameras]) - moments[:, 4:]
    return np.array(units), np.abs(np.degrees(np.arcsin(np.sin(np.radians(angles / 2)))) * 2)


def flight_of(seconds: float, seed: int = 1) -> Floats:
    """Somebody who flies about, at 60 frames a second."""
    rng = np.random.default_rng(seed)
    flight, gathered = Flight(Camera(np.zeros(3))), Flown()
    for _ in range(round(seconds)):
        forward, left, up = rng.integers(-1, 2, 3).tolist()
        yaw, pitch = rng.normal(0, (2, 0.5)).tolist()
        steering = Steering(forward, left, up, yaw, pitch)
        for _ in range(60):
            flight = flight.after(1 / 60, steering)
            gathered.add(1 / 60, flight.camera)
    return np.array(gathered._moments)


def test_a_path_of_few_keys_follows_a_flight() -> None:
    moments = flight_of(20)
    path = thinned(moments)
    units, degrees = errors(path, moments)
    assert units.max() <= UNITS + 0.001
    assert degrees.max() <= DEGREES + 0.001
    assert path.seconds == pytest.approx(moments[-1, 0] - moments[0, 0], abs=1e-4)
    assert len(path.keys) < len(moments) / 5


def test_a_straight_even_flight_needs_two_keys() -> None:
    times = np.arange(100) / 60
    moments = np.column_stack([times, times * 320, times * 0, times * 50, times * 30, times * 0])
    moments = np.column_stack([moments, np.full(100, 80.0)])
    assert len(thinned(moments).keys) == 2


def test_a_jump_stays_one() -> None:
    moments = flight_of(4)
    moments[120:, 1:4] += 2000
    moments[120:, 4] += 170
    units, degrees = errors(thinned(moments), moments)
    assert units.max() <= UNITS + 0.001
    assert degrees.max() <= DEGREES + 0.001


@given(
    st.lists(
        st.tuples(
            st.floats(SHORTEST, 3), *[st.floats(-1e4, 1e4)] * 3,
            st.floats(-1e3, 1e3), st.floats(-89, 89), st.floats(20, 140),
        ),
        min_size=2, max_size=20,
    )
)  # fmt: skip
def test_whatever_is_flown_is_followed(steps: list[tuple[float, ...]]) -> None:
    moments = np.array(steps)
    moments[:, 0] = np.cumsum(moments[:, 0])
    moments[:, 0] -= moments[0, 0]
    path = thinned(moments)
    times = np.array([key.time for key in path.keys])
    assert (np.diff(times) >= SHORTEST - 2e-4).all()
    moments[:, 0] = np.round(moments[:, 0], 4)  # as keys have it; it would move what is fast
    units, degrees = errors(path, moments)
    assert units.max() <= UNITS + 0.001
    assert degrees.max() <= DEGREES + 0.001


def test_frames_that_come_too_fast_are_left_out() -> None:
    gathered = Flown()
    for number in range(100):
        gathered.add(0.0005, Camera(np.full(3, float(number))))
    assert gathered.seconds == pytest.approx(99 * 0.0005)
    times = np.array(gathered._moments)[:, 0]
    assert np.diff(times) == pytest.approx(0.002)
    assert Flown().path() is None


def test_time_goes_by_the_films_frames_unless_it_is_recorded_by_the_clock() -> None:
    filming = Recording(fps=24, films=True)
    assert filming.seconds(0.5) == 1 / 24
    assert replace(filming, by_clock=True).seconds(0.05) == 0.05
    assert replace(filming, films=False).seconds(0.05) == 0.05
    assert replace(filming, films=False).seconds(5) == LONGEST_FRAME


def greys(path: Path) -> list[int]:
    """The mean grey of each of a film's frames."""
    with av.open(str(path)) as container:
        return [round(f.to_ndarray(format="gray").mean()) for f in container.decode(video=0)]


def picture(grey: int) -> np.ndarray:
    return np.full((32, 48, 3), grey, np.uint8)


def test_a_reel_has_a_frame_for_each_picture(tmp_path: Path) -> None:
    with ThreadPoolExecutor() as writers:
        reel = Reel(tmp_path / "a.mp4", (48, 32), 30, by_clock=False, writers=writers)
        for number in range(20):
            reel.add(picture(40 + 10 * number), reel.due(number * 1.7))
        reel.finish()
        assert reel.written.result().startswith(f"{tmp_path / 'a.mp4'}: 20 frames, 0.7 s")
    assert len(greys(tmp_path / "a.mp4")) == 20
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]


def test_by_the_clock_pictures_are_repeated_and_left_out(tmp_path: Path) -> None:
    with ThreadPoolExecutor() as writers:
        reel = Reel(tmp_path / "a.mp4", (48, 32), 10, by_clock=True, writers=writers)
        shown = []
        for number, seconds in enumerate((0.0, 0.35, 0.02, 0.02, 0.02, 0.08, 0.5)):
            frames = reel.due(seconds)
            shown.append(frames)
            if frames:
                reel.add(picture(40 + 30 * number), frames)
        reel.finish()
        reel.written.result()
    assert shown == [1, 3, 0, 0, 1, 0, 5]
    steps = np.unique(greys(tmp_path / "a.mp4"), return_counts=True)[1]
    assert steps.tolist() == [1, 3, 1, 5]


def test_by_the_clock_a_film_begins_with_its_first_picture(tmp_path: Path) -> None:
    with ThreadPoolExecutor() as writers:
        reel = Reel(tmp_path / "a.mp4", (48, 32), 30, by_clock=True, writers=writers)
        shown = []
        for seconds in (0.4, 0.1, 0.1):
            shown.append(reel.due(seconds))
            reel.add(picture(40), shown[-1])
        reel.finish()
        reel.written.result()
    assert shown == [1, 3, 3]


def test_a_film_that_cannot_be_written_keeps_nobody_waiting(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with ThreadPoolExecutor() as writers:
        reel = Reel(tmp_path / "file" / "a.mp4", (48, 32), 30, by_clock=False, writers=writers)
        for _ in range(2 * WAITING):
            reel.add(picture(0), 1)
        reel.finish()
        with pytest.raises(UsageError, match="cannot be written"):
            reel.written.result()


@pytest.fixture(scope="module")
def screen() -> Iterator[str]:
    with display() as name:
        yield name


@pytest.mark.gl
def test_pictures_have_all_sides_of_a_point_lights_cube(renderer: Renderer) -> None:
    """Unfolded as `render` has them: the ends of the cross are white, its corners are behind it."""
    pieces = box((-90, -90, -90), (90, 90, 90), inward=True)
    here = camera((0, 0, 0))
    scene = make_scene(pieces, point((0, 0, 0), 900), cameras={"start": here})
    state = State.of(scene, here).with_settings(shadow_cull=CullFace.NONE)
    renderer.open(scene)
    state = canvas.prepared(renderer, replace(state, look=Look(View.SHADOW_MAP), panels=False))
    canvas.draw(renderer, state)
    shot = recording.taken(renderer, state, renderer.target())
    height, width, _ = shot.shape
    edge = min(width // 4, height // 3)
    cells = (shot[height // 2 - 3 * edge // 2 :, width // 2 - 2 * edge :])[: 3 * edge, : 4 * edge]
    middles = cells[edge // 2 :: edge, edge // 2 :: edge][:3, :4]
    is_behind = (middles == handles.BEHIND).all(axis=2)
    assert is_behind.tolist() == [[True, False, True, True], [False] * 4, [True, False, True, True]]
    greys = middles[~is_behind]
    assert np.ptp(greys.astype(int), axis=0).max() <= 1, "walls as far away in all directions"


@pytest.mark.gl
def test_pictures_have_no_map_where_the_window_has_none(renderer: Renderer) -> None:
    """One is there, of an earlier frame; neither half of a split shows it."""
    here = camera((0, 0, 60), pitch=30)
    scene = make_scene([floor()], spot((0, 0, 200), (0, 0, 0), 40), cameras={"start": here})
    state = replace(State.of(scene, here), look=Look(View.SHADOW_MAP))
    state = canvas.prepared(renderer, state)

    def shown(state: State) -> np.ndarray:
        canvas.draw(renderer, state)
        return recording.taken(renderer, state, renderer.target())

    def is_empty(picture: np.ndarray) -> bool:
        return bool((picture == handles.BEHIND).all())

    off = replace(state, lamps=(replace(state.lamps[0], is_on=False),))
    no_shadows = replace(state.look, shadows=False)
    assert not is_empty(shown(state))
    for bare in (off, replace(state, lamps=()), replace(state, look=no_shadows)):
        assert is_empty(shown(bare))
        assert is_empty(recording.stages(renderer, bare)[View.SHADOW_MAP])
    half = renderer.size[0] // 2
    split = shown(replace(off, right=Look(View.LAMBERTIAN), divider=0.5))
    assert is_empty(split[:, :half]) and not is_empty(split[:, half:])
    one = shown(replace(state, look=no_shadows, right=state.look, divider=0.5))
    assert not is_empty(one[:, :half]), "as the window has it, which shows what there is"


def blocks(picture: np.ndarray) -> np.ndarray:
    """(30, 40, 3) means over a picture's parts, whatever its size."""
    height, width, _ = picture.shape
    parts = picture.reshape(30, height // 30, 40, width // 40, 3)
    return np.asarray(parts.mean(axis=(1, 3)))


@pytest.mark.gl
def test_screenshots_and_films(screen: str, tmp_path: Path) -> None:
    """What is in the files is what the scenario saw in the window."""
    play("recording", screen, tmp_path)
    work = tmp_path / "work"
    shot = np.asarray(Image.open(work / "courtyard-001.png"))
    assert np.array_equal(shot, np.load(work / "shown.npy"))
    folder = work / "courtyard-001-stages"
    assert {path.stem for path in folder.iterdir()} == {view.value for view in View}
    found = {path.stem: np.asarray(Image.open(path)) for path in folder.iterdir()}
    assert np.array_equal(found["final"], shot)
    assert len({picture.tobytes() for picture in found.values()}) == len(View)
    for name, count, size in (
        ("001", 12, (320, 240)), ("002", 5, (640, 480)), ("003", 3, (320, 240)),
    ):  # fmt: skip
        with av.open(str(work / f"courtyard-{name}.mp4")) as container:
            video = container.streams.video[0]
            assert (video.width, video.height) == size
            assert video.average_rate == 24
            frames = [f.to_ndarray(format="rgb24") for f in container.decode(video=0)]
        assert len(frames) == count
        for frame in frames:  # within what a codec and another grid of pixels make of it
            np.testing.assert_allclose(blocks(frame), blocks(shot), rtol=0, atol=20)
    assert np.abs(blocks(shot[::-1]) - blocks(shot)).max() > 100
