"""What a film is to be: what was typed, checked before anything is drawn."""

import os
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from followspot.errors import UnwritableError, UsageError
from followspot.passes.view import View
from followspot.present import arguments, video
from followspot.present.frames import Film, exposures_for, lit_along
from followspot.present.renderer import named
from followspot.present.still import Wish, open_scene
from followspot.scene import auto_path
from followspot.scene.path import AutoPath, CameraPath
from followspot.scene.scene import Scene

MAX_FRAMES = 1_000_000
MAX_SAMPLES = 256
"""Moments that can be averaged for a frame."""
MAX_JOBS = 64
LEAST_SECONDS = 0.001


@dataclass(frozen=True)
class FilmWish:
    """What was typed about a film, beside what it shows.

    Attributes:
        path: Name of the camera's path; none is the scene's first one.
        seconds: Length; none is the path's own.
        fps: Frames a second.
        samples: Moments averaged for each frame.
        supersample: Pixels drawn along an edge of each of the film's.
        max_bytes: Largest file allowed.
        jobs: Processes that draw.
    """

    path: str | None = None
    seconds: float | None = None
    fps: float = 30.0
    samples: int = 1
    supersample: int = 1
    max_bytes: int | None = None
    jobs: int = 1


@dataclass(frozen=True)
class Output:
    """Where a film goes: a file in one of `video.CODECS`, or a folder of pictures."""

    path: Path
    is_folder: bool


def parse_output(text: str, wish: FilmWish) -> Output:
    """Where a film goes, by how the name ends.

    Raises:
        UsageError: no film can have that name, or the wish asks what it cannot hold.
    """
    path = Path(text)
    is_folder = text.endswith(("/", os.sep)) or not path.suffix
    if path.name.lower() in video.CODECS or (
        not is_folder and path.suffix.lower() not in video.CODECS
    ):
        known = ", ".join(video.CODECS)
        raise UsageError(f"{text}: expected a name that ends in {known}, or in / for a folder")
    if is_folder and not path.name:
        raise UsageError(f"{text}: expected the name of a folder that can be made anew")
    if is_folder and wish.max_bytes is not None:
        raise UsageError("--max-bytes: only a film's file can be held to it, not a folder")
    try:
        is_taken = path.is_dir() if not is_folder else path.exists() and _holds_others(path)
    except OSError as error:
        raise UnwritableError(text, error.strerror or str(error)) from None
    if is_taken and is_folder:
        raise UsageError(f"{text}: expected a folder of a film's frames, or nothing yet")
    if is_taken:
        raise UsageError(f"{text}: expected the name of a file, found a folder")
    return Output(path, is_folder)


def _holds_others(folder: Path) -> bool:
    return not folder.is_dir() or any(
        not (f.name.startswith("frame-") and f.suffix == ".png") for f in folder.iterdir()
    )


def check(size: tuple[int, int], wish: FilmWish, *, is_folder: bool = False) -> None:
    """See that a film can be what is wished for, whatever the scene.

    Raises:
        UsageError: it cannot.
    """
    if not 1 <= wish.fps <= 240:
        raise UsageError(f"--fps: expected 1 to 240 frames a second, found {wish.fps}")
    if wish.seconds is not None and not LEAST_SECONDS <= wish.seconds <= 36000:
        raise UsageError(f"--seconds: expected {LEAST_SECONDS} to 36000 s, found {wish.seconds}")
    if not 1 <= wish.samples <= MAX_SAMPLES:
        raise UsageError(f"--samples: expected 1 to {MAX_SAMPLES} moments, found {wish.samples}")
    if not 1 <= wish.jobs <= MAX_JOBS:
        raise UsageError(f"--jobs: expected 1 to {MAX_JOBS} processes, found {wish.jobs}")
    arguments.require_drawable(size, wish.supersample)
    if not is_folder and not video.can_hold(size):
        raise UsageError(f"--size: {size[0]}x{size[1]} is too large for a film; a folder holds it")


def plan(scene_name: str, wish: Wish, film_wish: FilmWish, to: Output) -> tuple[Scene, Film]:
    """The scene and all that the film's frames depend on.

    Raises:
        AssetError, ContextError, UsageError: there is no such scene, or it cannot be drawn as
            wished.
    """
    size, view = arguments.parse_size(wish.size), named(View, wish.view)
    if view is View.SHADOW_MAP:
        raise UsageError("--view: a film shows what a camera sees, not shadow-map")
    even = tuple(edge + edge % 2 for edge in size)
    if not to.is_folder and size != even:
        raise UsageError(
            f"--size: expected even numbers, since the film has a colour for every 2x2 pixels, "
            f"found {wish.size}; {even[0]}x{even[1]} would do"
        )
    check(size, film_wish, is_folder=to.is_folder)
    scene, _ = open_scene(scene_name, wish)
    path = _path(scene, film_wish)
    scene = lit_along(scene, path, bake=wish.bake)
    fps = Fraction(film_wish.fps).limit_denominator(1001)
    count = max(1, round(path.seconds * fps))
    if count > MAX_FRAMES:
        raise UsageError(f"--seconds: {count} frames are more than the {MAX_FRAMES} allowed")
    film = Film(
        path, size, fps, count, view,
        exposures_for(scene, path, view), film_wish.samples, film_wish.supersample,
    )  # fmt: skip
    return scene, film


def _path(scene: Scene, wish: FilmWish) -> CameraPath:
    """The path that was asked for, as long as was asked for."""
    path = scene.path(wish.path)
    if isinstance(path, AutoPath):
        return auto_path.find(scene, wish.seconds or path.seconds)
    return path if wish.seconds is None else path.lasting(wish.seconds)
