"""Films: the right frames, the same however they are made, whole or not there at all."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from followspot.errors import FollowspotError, UsageError
from followspot.passes.view import View
from followspot.present import files, film, film_plan, video, workers
from followspot.present.film_plan import FilmWish, Output
from followspot.present.frames import Film, FilmCamera, exposures_for
from followspot.present.interrupt import Interrupt
from followspot.present.renderer import Renderer
from followspot.present.still import Wish
from followspot.present.video import Shape
from followspot.scene.load import load_figure
from followspot.scene.path import CameraPath, Key
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.spaces import vec3
from synthetic import box, floor, make_scene, spot, srgb_decoded, srgb_encoded

Pictures = NDArray[np.uint8]

SIZE = (64, 48)
PATH = CameraPath(
    (
        Key(0.0, vec3([-300, 0, 60]), 0, 10),
        Key(1.0, vec3([-200, 80, 60]), -30, 10),
        Key(2.0, vec3([-50, 150, 90]), -80, 20),
    )
)


def scene() -> Scene:
    pieces = [floor(), *box((-40, -40, 0), (40, 40, 80)), *box((60, 60, 0), (90, 120, 150))]
    lamp = spot((-300, 200, 300), (0, 0, 30), 40, 900)
    return make_scene(pieces, lamp, settings=Settings(exposure=0.7))


def film_of(**changes: object) -> Film:
    fields: dict[str, object] = {"exposures": (0.7,), "frame_count": 40, **changes}
    return Film(PATH, SIZE, Fraction(30), **fields)  # type: ignore[arg-type]


def draw(film_: Film, numbers: range | list[int]) -> list[Pictures]:
    with FilmCamera(scene(), film_) as camera:
        return [np.array(picture) for picture in camera.pictures(numbers)]


def decoded(path: Path) -> Pictures:
    """(n, h, w, 3) frames of a film's file."""
    with av.open(str(path)) as container:
        return np.array([frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)])


def noise(count: int, size: tuple[int, int] = SIZE) -> Iterator[Pictures]:
    generator = np.random.default_rng(7)
    for _ in range(count):
        yield generator.integers(0, 256, (*size[::-1], 3), np.uint8)


def never() -> bool:
    return False


# ---- frames


@pytest.mark.gl
@pytest.mark.parametrize("changes", [{}, {"samples": 3}, {"supersample": 2, "view": View.NORMALS}])
def test_a_frame_depends_on_its_number_alone(changes: dict[str, object]) -> None:
    film_ = film_of(**changes)
    together = draw(film_, range(40))
    assert len(together) == 40
    (alone,) = draw(film_, [37])
    assert np.array_equal(alone, together[37])
    assert not np.array_equal(together[36], together[37])
    backwards = draw(film_, list(range(39, 34, -1)))
    assert np.array_equal(backwards[::-1], together[35:])


@pytest.mark.gl
def test_a_frame_is_what_render_draws_there() -> None:
    (frame,) = draw(film_of(), [12])
    with Renderer(SIZE) as renderer:
        still = renderer.render(scene(), PATH.camera(12 / 30))[View.FINAL]
    assert np.array_equal(frame, still)


@pytest.mark.gl
def test_exposures_are_those_of_moments_at_their_own_time_smoothed() -> None:
    """Somebody close by, who moves, is as bright in them as in the film."""
    robot = load_figure("models/robot/robot.md2", (), "run")
    eye = vec3([50, 0, 0])
    path = CameraPath((Key(0.0, eye, 180, 5), Key(1.3, eye, 180, 5)))
    with Renderer((160, 120)) as renderer:
        a, b, c = (renderer.exposure(robot, path.camera(0), time=t) for t in (0, 0.65, 1.3))
    assert len({a, b, c}) == 3
    mixed = [(a**3 * b) ** 0.25, (a * b**2 * c) ** 0.25, (b * c**3) ** 0.25]
    np.testing.assert_allclose(exposures_for(robot, path, View.FINAL), mixed, rtol=1e-12)
    assert exposures_for(robot, path, View.NORMALS) == (1.0,)


def test_exposure_goes_evenly_from_one_to_the_next() -> None:
    film_ = film_of(exposures=(0.5, 2.0, 2.0))
    half = PATH.seconds / 2
    shown = [film_.exposure(share * half) for share in (-1, 0, 0.25, 0.5, 1, 1.7, 3)]
    np.testing.assert_allclose(shown, [0.5, 0.5, 0.5**0.5, 1, 2, 2, 2])
    assert film_of(exposures=(0.7,)).exposure(1.0) == 0.7


@pytest.mark.gl
@pytest.mark.parametrize("view", [View.FINAL, View.NORMALS])
def test_motion_blur_is_the_mean_in_linear_light(view: View) -> None:
    """Of pictures around the frame's time; of plain values, where the view shows no light."""
    film_ = film_of(samples=4, view=view)
    (blurred,) = draw(film_, [20])
    with Renderer(SIZE) as renderer:
        sharp = [
            renderer.render(scene(), PATH.camera(time), [view])[view] for time in film_.times(20)
        ]
    assert np.isclose(np.mean(film_.times(20)), 20 / 30)
    assert np.isclose(np.ptp(film_.times(20)), 0.5 / 30 * 3 / 4)
    values = np.array(sharp) / 255
    mean = np.mean(srgb_decoded(values), axis=0) if view.is_encoded else values.mean(axis=0)
    expected = srgb_encoded(mean) if view.is_encoded else mean
    assert np.abs(blurred / 255 - expected).max() < 1.01 / 255
    assert not np.array_equal(blurred, sharp[1])


@pytest.mark.gl
def test_supersampling_is_the_mean_in_linear_light() -> None:
    (small,) = draw(film_of(supersample=3), [20])
    with Renderer((SIZE[0] * 3, SIZE[1] * 3)) as renderer:
        large = renderer.render(scene(), PATH.camera(20 / 30))[View.FINAL]
    squares = srgb_decoded(large / 255).reshape(SIZE[1], 3, SIZE[0], 3, 3)
    expected = srgb_encoded(squares.mean(axis=(1, 3)))
    assert np.abs(small / 255 - expected).max() < 1.01 / 255


# ---- files


@pytest.mark.parametrize(("ending", "codec"), [(".mp4", "h264"), (".webm", "vp9")])
def test_a_film_that_plays_everywhere(tmp_path: Path, ending: str, codec: str) -> None:
    pictures = [np.full((48, 64, 3), (200, 30, 90), np.uint8)] * 25
    path = tmp_path / f"film{ending}"
    written = video.write_video(path, pictures, Shape(SIZE, Fraction(30)), None, never)
    assert (written.frames, written.bytes) == (25, path.stat().st_size)
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        context = stream.codec_context
        assert (context.name in (codec, f"lib{codec}")) or codec in context.codec.long_name.lower()
        assert (context.width, context.height, context.pix_fmt) == (64, 48, "yuv420p")
        assert stream.average_rate == 30
        tags = context.colorspace, context.color_primaries, context.color_trc, context.color_range
        assert [int(tag) for tag in tags] == [1, 1, 1, 1]  # BT.709 three times, studio range
        luma = next(container.decode(video=0)).to_ndarray()[:48]
    red, green, blue = np.array([200, 30, 90]) / 255
    expected = 16 + 219 * (0.2126 * red + 0.7152 * green + 0.0722 * blue)
    assert abs(luma.mean() - expected) < 2
    times = [frame.time for frame in av.open(str(path)).decode(video=0)]
    assert np.allclose(times, np.arange(25) / 30, atol=1e-3)
    if ending == ".mp4":
        assert path.read_bytes().index(b"moov") < path.read_bytes().index(b"mdat")


@pytest.mark.parametrize("ending", [".mp4", ".webm"])
@pytest.mark.parametrize("max_bytes", [60_000, 15_000])
def test_max_bytes_is_kept_by_noise(tmp_path: Path, ending: str, max_bytes: int) -> None:
    """The hardest content there is; nearly all that is allowed is used."""
    path = tmp_path / f"film{ending}"
    size = (128, 96)
    pictures = list(noise(20, size))
    written = video.write_video(path, pictures, Shape(size, Fraction(30)), max_bytes, never)
    assert path.stat().st_size == written.bytes <= max_bytes
    assert written.wanted_bytes > max_bytes
    assert len(decoded(path)) == written.frames == 20
    if ending == ".mp4":
        assert written.bytes > 0.6 * max_bytes


def test_a_small_film_is_not_encoded_again(tmp_path: Path) -> None:
    shape = Shape(SIZE, Fraction(30))
    pictures = list(noise(5))
    free = video.write_video(tmp_path / "a.mp4", pictures, shape, None, never)
    held = video.write_video(tmp_path / "b.mp4", pictures, shape, 10**7, never)
    assert held.wanted_bytes == held.bytes == free.bytes
    assert np.array_equal(decoded(tmp_path / "a.mp4"), decoded(tmp_path / "b.mp4"))


def test_a_limit_that_cannot_be_kept(tmp_path: Path) -> None:
    to = Output(tmp_path / "film.mp4", is_folder=False)
    with pytest.raises(UsageError, match="even at the lowest quality"):
        film.write(to, noise(20), film_of(), 700, Interrupt())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("ending", [".mp4", ".webm"])
@pytest.mark.parametrize(("count", "size"), [(15, (64, 64)), (60, (320, 240))])
def test_every_limit_down_to_the_smallest_film(
    tmp_path: Path, ending: str, count: int, size: tuple[int, int]
) -> None:
    """What the refusal says can be had can be had; so can what lies above."""
    shape, path = Shape(size, Fraction(30)), tmp_path / f"film{ending}"
    y, x = (each[..., np.newaxis] for each in np.mgrid[: size[1], : size[0]])
    waves = [
        np.sin((x + 9 * t) / 7) + np.cos((y * np.array([1, 2, 3]) - 5 * t) / 11)
        for t in range(count)
    ]
    pictures = [(127 + 60 * wave).astype(np.uint8) for wave in waves]
    with pytest.raises(UsageError, match="even at the lowest quality, and 9 are") as caught:
        video.write_video(path, pictures, shape, 9, never)
    (words,) = re.findall(r"frames of \d+x\d+ take ([\d,]+) bytes", str(caught.value))
    smallest = int(words.replace(",", ""))
    for limit in (smallest, smallest + 1, smallest * 11 // 10, smallest * 3 // 2, smallest * 3):
        written = video.write_video(path, pictures, shape, limit, never)
        assert written.bytes == path.stat().st_size <= limit
        assert written.frames == count == len(decoded(path))


def test_stopping_while_it_is_encoded_again(tmp_path: Path) -> None:
    """What comes then is shorter, and plays."""
    asked = []

    def stopped() -> bool:
        asked.append(1)
        return len(asked) == 9

    path = tmp_path / "film.mp4"
    written = video.write_video(path, noise(20), Shape(SIZE, Fraction(30)), 20_000, stopped)
    assert written.frames == 9 and len(decoded(path)) == 9


def test_one_interrupt_keeps_the_frames_that_are_drawn(tmp_path: Path) -> None:
    """They are encoded again all; a second one does not wait for that."""
    to = Output(tmp_path / "film.mp4", is_folder=False)
    for interrupts, kept in ((1, 20), (2, 1)):
        with Interrupt() as interrupt:
            for _ in range(interrupts):
                signal.raise_signal(signal.SIGTERM)
            written = film.write(to, noise(20), film_of(), 20_000, interrupt)
        assert written.frames == kept == len(decoded(to.path))


@pytest.mark.parametrize("name", [os.fsdecode(b"b\xffd/\xff.mp4"), "x" * 250 + ".mp4", "ü.mp4"])
def test_names_of_every_kind(tmp_path: Path, name: str) -> None:
    to = Output(tmp_path / name, is_folder=False)
    assert film.write(to, noise(9), film_of(), 10_000, Interrupt()).frames == 9
    with files.plain(to.path) as path:
        assert len(decoded(path)) == 9
    assert list(to.path.parent.iterdir()) == [to.path]


@pytest.mark.parametrize("is_folder", [False, True])
def test_a_link_stays_and_its_film_is_written(tmp_path: Path, is_folder: bool) -> None:
    to = Output(tmp_path / "link.mp4", is_folder)
    to.path.symlink_to(Path("elsewhere", "film"))
    for count in (2, 3):
        assert film.write(to, noise(count), film_of(), None, Interrupt()).frames == count
    made = tmp_path / "elsewhere" / "film"
    assert to.path.is_symlink() and not made.is_symlink() and made.is_dir() is is_folder
    if is_folder:
        assert len(list(made.iterdir())) == 3
    assert list(made.parent.iterdir()) == [made]


def test_a_failure_leaves_nothing(tmp_path: Path) -> None:
    def failing() -> Iterator[Pictures]:
        yield from noise(10)
        raise RuntimeError("the GPU has melted")

    for name, is_folder in (("film.mp4", False), ("frames", True)):
        with pytest.raises(RuntimeError, match="melted"):
            film.write(Output(tmp_path / name, is_folder), failing(), film_of(), None, Interrupt())
        assert list(tmp_path.iterdir()) == []


def test_what_fails_while_drawing_is_not_told_of_the_file(tmp_path: Path) -> None:
    def failing() -> Iterator[Pictures]:
        yield from noise(2)
        raise OSError("not the film's file")

    to = Output(tmp_path / "film.mp4", is_folder=False)
    with pytest.raises(OSError, match="not the film's file"):
        film.write(to, failing(), film_of(), None, Interrupt())
    assert list(tmp_path.iterdir()) == []


def test_no_frame_makes_no_film(tmp_path: Path) -> None:
    to = Output(tmp_path / "film.mp4", is_folder=False)
    assert film.write(to, iter([]), film_of(), None, Interrupt()).frames == 0
    assert list(tmp_path.iterdir()) == []


def test_a_folder_of_pictures(tmp_path: Path) -> None:
    pictures = list(noise(3))
    with pytest.raises(UsageError, match=r"expected a name that ends in \.mp4"):
        film_plan.parse_output(f"{tmp_path}/.mp4", FilmWish())
    to = film_plan.parse_output(f"{tmp_path}/deep/frames/", FilmWish())
    for _ in range(2):  # the second time, in place of the first
        assert film.write(to, iter(pictures), film_of(), None, Interrupt()).frames == 3
    folder = tmp_path / "deep" / "frames"
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["frame-00000.png", "frame-00001.png", "frame-00002.png"]
    for name, picture in zip(names, pictures, strict=True):
        assert np.array_equal(np.asarray(Image.open(folder / name)), picture)
    assert [path.name for path in folder.parent.iterdir()] == ["frames"]


def test_a_folder_of_other_things_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "precious.txt").write_text("mine")
    with pytest.raises(UsageError, match="a folder of a film's frames"):
        film_plan.parse_output(str(tmp_path), FilmWish())
    (tmp_path / "x.mp4").mkdir()
    with pytest.raises(UsageError, match="found a folder"):
        film_plan.parse_output(f"{tmp_path}/x.mp4", FilmWish())


@pytest.mark.parametrize(
    ("wish", "changes", "output", "told"),
    [
        (FilmWish(), {"size": "641x480"}, "x.mp4", "642x480 would do"),
        (FilmWish(), {"size": "64x47"}, "x.webm", "64x48 would do"),
        (FilmWish(), {}, "x.avi", "ends in .mp4, .webm"),
        (FilmWish(max_bytes=9), {}, "frames/", "--max-bytes"),
        (FilmWish(path="tower"), {}, "x.mp4", "no path is named 'tower'; there are tour, auto"),
        (FilmWish(fps=0), {}, "x.mp4", "--fps"),
        (FilmWish(samples=0), {}, "x.mp4", "--samples"),
        (FilmWish(samples=film_plan.MAX_SAMPLES + 1), {}, "x.mp4", "--samples: expected 1 to 256"),
        (FilmWish(fps=float("nan")), {}, "x.mp4", "--fps"),
        (FilmWish(seconds=0), {}, "x.mp4", "--seconds"),
        (FilmWish(seconds=1e-320), {}, "x.mp4", "--seconds: expected 0.001 to 36000 s"),
        (FilmWish(seconds=float("inf")), {}, "x.mp4", "--seconds"),
        (FilmWish(), {"view": "shadow-map"}, "x.mp4", "shadow-map"),
        (FilmWish(), {"size": "16384x16384"}, "x.mp4", "16384x16384 is too large for a film"),
        (FilmWish(supersample=9), {"size": "2000x2"}, "x.mp4", "--supersample: .*found 2000 x 9"),
        (FilmWish(jobs=65), {}, "x.mp4", "--jobs: expected 1 to 64 processes, found 65"),
        (FilmWish(), {"lights": ["point:0,0,9:5"] * 9}, "x.mp4", "at most 8 lights"),
        (FilmWish(), {}, "x" * 300 + ".mp4", "xxx.mp4: cannot be written: File name too long"),
        (FilmWish(), {}, "x" * 300 + "/", "xxx/: cannot be written: File name too long"),
    ],
)
def test_wishes_that_make_no_sense(
    wish: FilmWish, changes: dict[str, str], output: str, told: str
) -> None:
    with pytest.raises(UsageError, match=told):
        film_plan.plan("courtyard", Wish(**changes), wish, film_plan.parse_output(output, wish))  # type: ignore[arg-type]


# ---- the command, in processes of its own

COMMAND = ["film", "courtyard", "--size", "64x48"]


def start(*arguments: str, cwd: Path) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "followspot", *COMMAND, *arguments],
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.gl
def test_two_processes_make_the_same_film_as_one(tmp_path: Path) -> None:
    for jobs in ("1", "2", "3"):
        process = start("-o", f"{jobs}.mp4", "--seconds", "0.5", "--jobs", jobs, cwd=tmp_path)
        _, error = process.communicate(timeout=120)
        assert process.returncode == 0, error
        assert "15 frames" in error
    one = decoded(tmp_path / "1.mp4")
    assert one.shape == (15, 48, 64, 3)
    assert np.array_equal(one, decoded(tmp_path / "2.mp4"))
    assert np.array_equal(one, decoded(tmp_path / "3.mp4"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["1.mp4", "2.mp4", "3.mp4"]


@pytest.mark.gl
@pytest.mark.parametrize("jobs", ["1", "2"])
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
@pytest.mark.usefixtures("heard_hang_up")
def test_an_interrupt_leaves_the_frames_done_so_far(
    tmp_path: Path, number: signal.Signals, jobs: str
) -> None:
    process = start(
        "-o", "film.mp4", "--seconds", "3000", "--max-bytes", "9999999", "--jobs", jobs,
        "--set", "exposure=1",  # which would be measured for every second first
        cwd=tmp_path,
    )  # fmt: skip
    wait_for(lambda: any(path.stat().st_size > 0 for path in tmp_path.glob(".*/film.mp4")), process)
    process.send_signal(number)
    _, error = process.communicate(timeout=120)
    assert process.returncode == 128 + number, error
    assert "interrupted" in error
    assert [path.name for path in tmp_path.iterdir()] == ["film.mp4"]
    assert (tmp_path / "film.mp4").stat().st_size <= 9999999
    frames = decoded(tmp_path / "film.mp4")
    assert 1 <= len(frames) < 90000
    assert f"{len(frames)} frames" in error


def wait_for(condition: Callable[[], bool], process: "subprocess.Popen[str]") -> None:
    while not condition():
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


@pytest.mark.parametrize("size", [SIZE, (2, 2)])
def test_what_a_worker_finds_wrong_is_told_here(
    size: tuple[int, int], capfd: pytest.CaptureFixture[str]
) -> None:
    frames = workers.pictures("no_such_scene", Wish(), Film(PATH, size, Fraction(30), 9), 2, never)
    with pytest.raises(FollowspotError, match=r"^no_such_scene: expected a bsp .*, found none"):
        next(frames)
    assert capfd.readouterr() == ("", "")


def test_processes_that_cannot_start(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(24, "Too many open files")

    monkeypatch.setattr(subprocess, "Popen", refuse)
    with pytest.raises(FollowspotError, match=r"--jobs: no more .*: Too many open files"):
        next(workers.pictures("courtyard", Wish(), film_of(), 2, never))


@pytest.mark.gl
def test_a_worker_that_dies_is_an_error(tmp_path: Path) -> None:
    film_ = film_of(frame_count=10**5)
    frames = workers.pictures("courtyard", Wish(), film_, 2, never)
    next(frames)
    (tasks,) = Path(f"/proc/{os.getpid()}/task/{os.getpid()}").glob("children")
    for child in tasks.read_text().split():
        os.kill(int(child), signal.SIGKILL)
    with pytest.raises(FollowspotError, match="ended early"):
        for _ in frames:
            pass
    assert tasks.read_text() == ""
