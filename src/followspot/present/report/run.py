"""``followspot report``: steps one after another, and the page made of them."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from followspot.errors import FollowspotError, UnwritableError, UsageError
from followspot.present import arguments, files, film_plan
from followspot.present.console import as_json, open_console, working
from followspot.present.film_plan import FilmWish
from followspot.present.renderer import Renderer
from followspot.present.report.making import making
from followspot.present.report.material import Material
from followspot.present.report.page import Failure, page
from followspot.present.report.publish import FIGURES, INDEX, check, published
from followspot.present.report.section import Section
from followspot.present.report.stages import DETAIL
from followspot.present.report.steps import Step, all_steps
from followspot.present.still import Wish, open_scene
from followspot.scene import figure_file


@dataclass
class _Work:
    """What has been done so far, in the order of the steps."""

    parts: list[Section | Failure] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def failed(self) -> list[str]:
        """Titles of the steps that failed."""
        return [part.title for part in self.parts if isinstance(part, Failure)]


def run(
    name: str,
    folder: Path,
    wish: Wish,
    film_wish: FilmWish | None,
    steps: Sequence[Step] | None = None,
) -> int:
    """Make the report of a scene; the process's exit code, 1 if a step failed.

    Args:
        name: Scene or level.
        folder: Where it goes; an earlier report there is replaced when this one is whole.
        wish: Camera, size, lights and settings.
        film_wish: What film is wanted, if one is.
        steps: In place of all; the first one makes the title picture.

    Raises:
        AssetError: the scene cannot be opened.
        ContextError: there is no OpenGL.
        UnwritableError: the folder cannot be written.
        UsageError: something in the wishes makes no sense.
    """
    check(folder)
    size = arguments.parse_size(wish.size)
    if max(size) * DETAIL > arguments.LARGEST_EDGE:
        raise UsageError(
            f"--size: expected edges of at most {arguments.LARGEST_EDGE // DETAIL} pixels, since "
            f"a report's pictures have {DETAIL} times as many, found {wish.size!r}"
        )
    if film_wish is not None:
        if figure_file.is_model(name):
            raise UsageError(f"--film: expected a level to fly through, found a model: {name}")
        film_plan.check(size, film_wish)
    console = open_console(on_stderr=True)
    with working(console, f"opening {name}"):
        scene, camera = open_scene(name, wish)
    if scene.settings.baked_light:
        raise UsageError(
            "setting baked_light: expected 0 in a report, which explains the sky's light"
        )
    if film_wish is not None:
        scene.path(film_wish.path)  # a mistake in its name is told before anything takes time
    steps = all_steps(wish, film_wish) if steps is None else steps
    work = _Work()
    fine = size[0] * DETAIL, size[1] * DETAIL
    with (
        Renderer(fine) as renderer,  # what OpenGL cannot draw is told before anything is made
        published(folder) as made,
        _bar(console) as bar,
    ):
        renderer.resize(size)
        task = bar.add_task(name, total=len(steps))
        material = Material(
            name, scene, camera, size, tuple(wish.assets), renderer, made, lambda *_: None
        )
        for number, step in enumerate(steps):
            bar.update(task, description=step.title, completed=number)
            material = replace(material, on_progress=_teller(bar, task, step, number))
            _do(step, material, work, bar.console)
        bar.update(task, description=name, completed=len(steps))
        with files.writing(folder):
            _write(material, work)
    _tell(console, folder, work)
    return 1 if work.failed else 0


def _do(step: Step, material: Material, work: _Work, console: Console) -> None:
    """One step: its section, or why there is none."""
    start = time.perf_counter()
    part: Section | Failure
    try:
        part = step.make(material)
        for name, content in part.files.items():
            path = material.folder / name
            if path.exists():
                raise FileExistsError(f"{name} is another step's")
            with files.writing(path):
                path.write_bytes(content)
    except UnwritableError:  # nor could the rest of the report be written
        raise
    except Exception as error:  # the rest of the report is still worth making
        is_ours = not isinstance(error, FollowspotError)
        problem = f"{type(error).__name__}: {error}" if is_ours else str(error)
        part = Failure(step.anchor, step.title, problem)
        if is_ours:
            console.print_exception()
    taken = time.perf_counter() - start
    work.parts.append(part)
    work.seconds[part.title] = taken
    outcome = f"failed: {part.problem}" if isinstance(part, Failure) else f"{taken:.1f} s"
    console.print(f"{part.title}: {outcome}", soft_wrap=True)


def _write(material: Material, work: _Work) -> None:
    """The page itself and all figures."""
    title, *parts = work.parts
    made = making(material, work.seconds, work.failed)
    has_film = bool(parts) and parts[0].anchor == "film"
    parts.insert(1 if has_film else 0, made)
    folder, camera = material.folder, material.camera
    text = page(title, parts, material.name)
    # Names that are no text have it escaped, as wherever they are told.
    (folder / INDEX).write_text(text, encoding="utf-8", errors="backslashreplace")
    names = sorted([FIGURES, *(path.name for path in folder.iterdir())])
    everything = (title, *parts)
    told: dict[str, Any] = {
        "scene": material.name,
        "camera": [*camera.position.tolist(), camera.yaw, camera.pitch, camera.fov],
        "size": material.size,
        "gl_renderer": material.renderer.gl_renderer,
        "seconds": work.seconds,
        "failed": {part.anchor: part.problem for part in everything if isinstance(part, Failure)},
        "figures": {
            part.anchor: {name: float(value) for name, value in part.figures.items()}
            for part in everything
            if isinstance(part, Section)
        },
        "files": names,
    }
    (folder / FIGURES).write_bytes(as_json(told))


def _teller(bar: Progress, task: TaskID, step: Step, number: int) -> Callable[[float, str], None]:
    def tell(share: float, text: str) -> None:
        bar.update(task, description=f"{step.title}: {text}", completed=number + share)

    return tell


def _bar(console: Console) -> Progress:
    columns = BarColumn(), TimeElapsedColumn(), TextColumn("{task.description}", markup=False)
    return Progress(*columns, console=console)


def _tell(console: Console, folder: Path, work: _Work) -> None:
    total = sum(work.seconds.values())
    failed = f"; failed: {', '.join(work.failed)}" if work.failed else ""
    text = f"{folder / INDEX}: made in {total:.0f} s{failed}"
    console.print(text, soft_wrap=True)
