"""What the window shows, kept: screenshots, films, and the way that the camera flew.

Files are written by threads of their own. They get free names, and nothing is ever overwritten.
"""

import re
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from itertools import count
from os.path import lexists
from pathlib import Path

import numpy as np
from moderngl import Texture
from PIL import Image, ImageOps

from followspot.errors import FollowspotError
from followspot.gpu.program import ShaderError
from followspot.gpu.targets import Target
from followspot.passes.view import View
from followspot.present import pictures
from followspot.present.frames import Picture
from followspot.present.renderer import Renderer
from followspot.present.viewer import canvas, handles
from followspot.present.viewer.flown import Flown
from followspot.present.viewer.inspection import arranged, key_maps
from followspot.present.viewer.reel import Reel
from followspot.present.viewer.state import Shot, State
from followspot.scene.level import Level

_THREADS = 2
"""That write: one may have a film, and there is still one for screenshots."""


class Recorder:
    """Records what a state asks for; call `close` in the end."""

    def __init__(self) -> None:
        self._writers = ThreadPoolExecutor(_THREADS)
        self._writing: dict[Path, Future[str]] = {}
        self._reel: Reel | None = None
        self._target: Target | None = None  # for a film of another size than the window's
        self._flown: tuple[Level, Flown] | None = None

    def record(self, renderer: Renderer, state: State, seconds: float, passed: float) -> State:
        """Add the frame that has just been drawn to what is being recorded.

        Args:
            renderer: Its target has the picture.
            state: What was drawn.
            seconds: What the frame counted as.
            passed: Seconds since the one before, by the clock.
        """
        state = self._told(state)
        state = self._fly(state, seconds)
        if not state.recording.films:
            self._finish_film()
        else:
            if self._reel is None:
                self._start_film(renderer, state)
            self._film(renderer, state, passed)
        return state

    def line(self) -> str:
        """What is being recorded, in words; empty if that is nothing."""
        parts = []
        if self._reel is not None:
            parts.append(f"film: {self._reel.count} frames")
        if self._flown is not None:
            parts.append(f"flight: {self._flown[1].seconds:.1f} s")
        return ", ".join(parts)

    def shoot(self, renderer: Renderer, state: State) -> State:
        """Take the screenshot that is wanted. The renderer's target is another one then."""
        shot = state.recording.shot
        state = state.with_recording(shot=None)
        if shot is None:
            return state
        try:
            if shot is Shot.PICTURE:
                path = self._free(state, ".png")
                canvas.draw(renderer, state)
                self._save({path: taken(renderer, state, renderer.target())}, path)
            else:
                folder, found = self._free(state, "-stages"), stages(renderer, state)
                self._save({folder / f"{view}.png": found[view] for view in found}, folder)
        except (FollowspotError, ShaderError) as error:
            state = replace(state, notice=str(error).splitlines()[0])
        return state

    def close(self) -> None:
        """Finish what is being recorded, and wait until it is written.

        Raises:
            FollowspotError: it cannot be written.
        """
        self._finish_film()
        self._writers.shutdown()
        for written in self._writing.values():
            written.result()

    def _fly(self, state: State, seconds: float) -> State:
        """Gather the camera's flight; give the scene the path when it ends."""
        level = state.scene.level
        if state.recording.flies:
            if self._flown is None or self._flown[0] is not level:
                self._flown = level, Flown()
            self._flown[1].add(seconds, state.camera)
            return state
        flown, self._flown = self._flown, None
        path = flown[1].path() if flown is not None and flown[0] is level else None
        if path is None:
            return state
        name = next(n for k in count(1) if (n := f"flight{k}") not in state.scene.paths)
        scene = replace(state.scene, paths={**state.scene.paths, name: path})
        told = f"The path {name} has {len(path.keys)} keys; saving the scene keeps it."
        return replace(state, scene=scene, notice=told)

    def _start_film(self, renderer: Renderer, state: State) -> None:
        recording = state.recording
        width, height = recording.size or renderer.size
        even = max(width - width % 2, 2), max(height - height % 2, 2)
        path = self._free(state, ".mp4")
        self._reel = Reel(path, even, recording.fps, recording.by_clock, self._writers)
        self._writing[path] = self._reel.written

    def _film(self, renderer: Renderer, state: State, passed: float) -> None:
        assert self._reel is not None
        frames = self._reel.due(passed)
        if frames < 1:
            return
        width, height = self._reel.size
        target = renderer.target()
        if not (0 <= target.size[0] - width <= 1 and 0 <= target.size[1] - height <= 1):
            if self._target is None:
                context = target.framebuffer.ctx
                self._target = Target(context, self._reel.size, is_linear=False)
            target = self._target
            canvas.draw(renderer, state, target)
        self._reel.add(taken(renderer, state, target)[:height, :width], frames)

    def _finish_film(self) -> None:
        if self._reel is not None:
            self._reel.finish()
        if self._target is not None:
            self._target.release()
        self._reel = self._target = None

    def _free(self, state: State, ending: str) -> Path:
        """A path that nothing has, below the folder that was chosen."""
        folder = state.recording.place
        stem = re.sub(r"[^\w.-]", "-", Path(state.scene.name).stem)
        paths = (folder / f"{stem}-{number:03}{ending}" for number in count(1))
        return next(p for p in paths if p not in self._writing and not lexists(p))

    def _save(self, files: dict[Path, Picture], told: Path) -> None:
        def write() -> str:
            for path, picture in files.items():
                pictures.save(path, picture)
            return f"{told} is written."

        self._writing[told] = self._writers.submit(write)

    def _told(self, state: State) -> State:
        """Tell what has been written, or why not."""
        for path in [path for path, written in self._writing.items() if written.done()]:
            try:
                line = self._writing.pop(path).result()
            except FollowspotError as error:
                line = str(error)
            state = replace(state, notice=line)
        if self._reel is not None and self._reel.written.done():  # by an error
            state = state.with_recording(films=False)
        return state


def stages(renderer: Renderer, state: State) -> dict[View, Picture]:
    """All stages from where the camera is, each as large as the window."""
    looks = [replace(state.look, view=view) for view in View]
    state = canvas.prepared(renderer, replace(state, look=looks[0], right=None))
    found = {}
    for look in looks:
        shown = replace(state, look=look)
        canvas.draw(renderer, shown)
        found[look.view] = taken(renderer, shown, renderer.target())
    return found


def taken(renderer: Renderer, state: State, target: Target) -> Picture:
    """(h, w, 3) uint8 of what was drawn into a target, with shadow maps as the window has them."""
    picture: Picture = target.read()
    for look, part in zip(state.looks, canvas.halves(state, target.size), strict=True):
        if look.view is View.SHADOW_MAP:
            x, y, width, height = part or (0, 0, *target.size)
            shown = _unfolded(key_maps(renderer, state), (width, height))
            picture[y : y + height, x : x + width] = np.asarray(shown)
    return picture


def _unfolded(maps: tuple[Texture, ...], size: tuple[int, int]) -> Image.Image:
    """The maps of `key_maps` as large as fits into so many pixels, what is behind them beside."""
    if not maps:
        return Image.new("RGB", size, handles.BEHIND)
    (columns, rows), cells = arranged(maps)
    edge = maps[0].width
    greys = Image.new("RGB", (columns * edge, rows * edge), handles.BEHIND)
    for texture, (row, column) in zip(maps, cells, strict=True):
        side = Image.frombytes("RGBA", texture.size, texture.read()).convert("RGB")
        greys.paste(side, (column * edge, row * edge))
    return ImageOps.pad(greys, size, color=handles.BEHIND)
