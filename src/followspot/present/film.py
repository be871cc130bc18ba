"""A film of a scene, from what was typed to the file."""

import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

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

from followspot.errors import UnwritableError
from followspot.present import files, film_plan, folders, video, workers
from followspot.present.console import open_console, working
from followspot.present.film_plan import FilmWish, Output
from followspot.present.frames import Film, FilmCamera, Picture
from followspot.present.interrupt import Interrupt
from followspot.present.still import Wish
from followspot.present.video import Shape, Written
from followspot.scene.scene import Scene


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
        UnwritableError: it cannot be written there.
        UsageError: or not so small.
    """
    not_ours: list[OSError] = []

    def drawn() -> Iterator[Picture]:
        try:
            yield from pictures
        except OSError as error:
            not_ours.append(error)
            raise

    try:
        with files.writing(to.path):
            return _write(to, drawn(), film, max_bytes, interrupt, on_attempt)
    except UnwritableError:
        if not_ours:
            raise not_ours[0] from None
        raise


def _write(
    to: Output,
    pictures: Iterable[Picture],
    film: Film,
    max_bytes: int | None,
    interrupt: Interrupt,
    on_attempt: Callable[[int], object],
) -> Written:
    """As `write`; an OSError is the file's or the pictures' own."""
    path = files.target(to.path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with (
        tempfile.TemporaryDirectory(prefix=files.PREFIX, dir=path.parent) as workshop,
        files.plain(Path(workshop)) as shop,
    ):
        part = shop / f"film{'' if to.is_folder else to.path.suffix}"
        if to.is_folder:
            written = video.write_folder(part, pictures)
        else:
            shape = Shape(film.size, film.fps)
            written = video.write_video(
                part, pictures, shape, max_bytes, lambda: interrupt.count > 1, on_attempt
            )
        if written.frames:
            folders.put(Path(workshop) / part.name, path)
    return written
