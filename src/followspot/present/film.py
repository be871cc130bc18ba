"""A film of a scene, from what was typed to the file."""

import signal
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import FrameType

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from followspot.errors import UsageError
from followspot.present import film_plan, folders, video, workers
from followspot.present.console import open_console, working
from followspot.present.film_plan import FilmWish, Output
from followspot.present.frames import Film, FilmCamera, Picture
from followspot.present.still import Wish
from followspot.present.video import Shape, Written
from followspot.scene.scene import Scene


class Interrupt:
    """Ctrl-C and kill -TERM as something to ask about, while it is a context.

    Attributes:
        signal: The one that came last; none so far if None.
        count: How many have come: one ends the drawing, two end it all.
    """

    def __init__(self) -> None:
        self.signal: int | None = None
        self.count = 0

    def _come(self, number: int, _: FrameType | None) -> None:
        self.signal, self.count = number, self.count + 1

    def __enter__(self) -> "Interrupt":
        numbers = (signal.SIGINT, signal.SIGTERM)
        self._before = [(number, signal.signal(number, self._come)) for number in numbers]
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before:
            signal.signal(number, handler)


def run(scene: str, output: str, wish: Wish, film_wish: FilmWish) -> int:
    """Make a film and tell about it; the process's exit code.

    Raises:
        AssetError: the scene cannot be opened.
        ContextError: there is no OpenGL.
        UsageError: something in the wishes makes no sense, or the film cannot be written.
    """
    to = film_plan.parse_output(output, film_wish)
    console = open_console(on_stderr=True)
    with working(console, f"opening {scene}"):
        opened, film = film_plan.plan(scene, wish, film_wish, to)
    with Interrupt() as interrupt, _bar(console) as bar:
        task = bar.add_task(scene, total=film.frame_count)
        pictures = bar.track(
            draw_frames(scene, opened, wish, film, film_wish.jobs, interrupt), task_id=task
        )

        def on_attempt(size: int) -> None:
            bar.update(task, description=f"{size:,} bytes, encoding again")

        written = write(to, pictures, film, film_wish.max_bytes, interrupt, on_attempt)
    _tell(console, to, film, written)
    return 0 if interrupt.signal is None else 128 + interrupt.signal


class _SpeedColumn(ProgressColumn):
    """Frames a second."""

    def render(self, task: Task) -> Text:
        speed = task.finished_speed or task.speed
        return Text(f"{speed:.1f} frames/s" if speed else "")


def _bar(console: Console) -> Progress:
    name = TextColumn("{task.description}", markup=False)
    columns = name, BarColumn(), MofNCompleteColumn(), _SpeedColumn()
    return Progress(*columns, TextColumn("left"), TimeRemainingColumn(), console=console)


def _tell(console: Console, to: Output, film: Film, written: Written) -> None:
    def say(text: str) -> None:
        console.print(text, soft_wrap=True)

    if not written.frames:
        say(f"interrupted before the first frame: no {to.path}")
        return
    seconds = written.frames / float(film.fps)
    say(f"{to.path}: {written.frames} frames, {seconds:.1f} s, {written.bytes:,} bytes")
    if written.frames < film.frame_count:
        say(f"interrupted: these are the first of {film.frame_count} frames")
    if written.bytes < written.wanted_bytes:
        say(
            f"the quality had to drop to keep to --max-bytes: at full quality the film has "
            f"{written.wanted_bytes:,} bytes"
        )


def draw_frames(
    name: str, scene: Scene, wish: Wish, film: Film, jobs: int, interrupt: Interrupt
) -> Iterator[Picture]:
    """The film's frames in order, up to an interrupt."""
    if jobs > 1:
        yield from workers.pictures(name, wish, film, jobs, lambda: interrupt.count > 0)
        return
    with FilmCamera(scene, film) as camera:
        for picture in camera.pictures(range(film.frame_count)):
            yield picture
            if interrupt.count:
                return


def write(
    to: Output,
    pictures: Iterable[Picture],
    film: Film,
    max_bytes: int | None,
    interrupt: Interrupt,
    on_attempt: Callable[[int], object] = lambda _: None,
) -> Written:
    """Write a film under its final name only when all of it is there; nothing without a frame.

    Frames that have been drawn are encoded again all, where they must, unless a second interrupt
    comes.

    Raises:
        UsageError: it cannot be written there, or not so small.
    """
    not_ours: list[OSError] = []

    def drawn() -> Iterator[Picture]:
        try:
            yield from pictures
        except OSError as error:
            not_ours.append(error)
            raise

    try:
        to.path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(
            prefix=f".{to.path.stem}-", dir=to.path.parent
        ) as workshop:
            part = Path(workshop) / to.path.name
            if to.is_folder:
                written = video.write_folder(part, drawn())
            else:
                shape = Shape(film.size, film.fps)
                written = video.write_video(
                    part, drawn(), shape, max_bytes, lambda: interrupt.count > 1, on_attempt
                )
            if written.frames:
                folders.put(part, to.path)
    except OSError as error:
        if error in not_ours:
            raise
        raise UsageError(f"{to.path}: cannot be written: {error.strerror or error}") from None
    return written
