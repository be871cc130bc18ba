"""The frames of a film, each of which depends on its number alone."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.gpu.readback import Readback
from followspot.gpu.targets import Target
from followspot.passes.average import AveragePass
from followspot.passes.frame import FrameInput
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene import bounce
from followspot.scene.load import with_chosen_light
from followspot.scene.path import CameraPath
from followspot.scene.scene import Scene

Picture = NDArray[Any]
"""(h, w, 3) uint8 as displayed, top row first."""

SHUTTER = 0.5
"""Share of a frame's time that the shutter is open where there is motion blur: a film camera's 180
degrees."""

LOOKS = 16
"""Moments of a path at which is looked at what a light is chosen for."""

ADAPTING = 1.0
"""Seconds from one exposure of a film to the next, about what an eye takes from light to shade."""


@dataclass(frozen=True, eq=False)
class Film:
    """All that a film's frames depend on beside the scene.

    Attributes:
        path: Where the camera is at which time.
        size: (width, height) in pixels.
        fps: Frames a second.
        frame_count: How many frames there are.
        view: The stage that they show.
        exposures: Display values per radiance at equal steps of the path's time, the first at its
            start, the last at its end; a single one holds all along.
        samples: Moments that are averaged for each frame; 1 has no motion blur.
        supersample: Pixels that are drawn along an edge of each of the film's.
    """

    path: CameraPath
    size: tuple[int, int]
    fps: Fraction
    frame_count: int
    view: View = View.FINAL
    exposures: tuple[float, ...] = (1.0,)
    samples: int = 1
    supersample: int = 1

    def times(self, number: int) -> list[float]:
        """Seconds at which a frame's samples are taken, around ``number / fps``."""
        shifts = ((k + 0.5) / self.samples - 0.5 for k in range(self.samples))
        return [(number + SHUTTER * shift) / float(self.fps) for shift in shifts]

    def exposure(self, time: float) -> float:
        """Display value per radiance at a time in seconds, between those that are given."""
        if len(self.exposures) == 1:
            return self.exposures[0]
        steps = np.linspace(0, self.path.seconds, len(self.exposures))
        return float(np.exp(np.interp(time, steps, np.log(self.exposures))))


class FilmCamera:
    """Draws frames of a film in this process.

    Use it as a context manager, or call `close`.

    Raises:
        ContextError: no OpenGL context can be had.
        UsageError: frames of that size cannot be drawn.
    """

    def __init__(self, scene: Scene, film: Film) -> None:
        self._scene, self._film = scene, film
        width, height = film.size
        self._renderer = Renderer((width * film.supersample, height * film.supersample))
        self._renderer.open(scene)
        drawn = self._renderer.target()
        context = drawn.framebuffer.ctx
        self._readback = Readback(context, film.size)
        self._mean: Target | None = None
        if film.samples > 1 or film.supersample > 1:
            self._mean = Target(context, film.size, is_linear=False)
            self._average = AveragePass(context, film.supersample, film.samples, self._mean)

    def pictures(self, numbers: Iterable[int]) -> Iterator[Picture]:
        """Draw frames by their numbers; the next ones are drawn while one is on its way here."""
        for number in numbers:
            self._readback.start(self._draw(number))
            if self._readback.is_full:
                yield self._readback.fetch()
        while self._readback.count:
            yield self._readback.fetch()

    def _draw(self, number: int) -> Target:
        encoded = self._film.view.is_encoded
        if self._mean is not None:
            self._average.begin()
        for time in self._film.times(number):
            self._renderer.draw(self._frame(time))
            if self._mean is not None:
                self._average.add(self._renderer.target(), encoded=encoded)
        if self._mean is None:
            return self._renderer.target()
        self._average.finish(encoded=encoded)
        return self._mean

    def _frame(self, time: float) -> FrameInput:
        """Everything that moves is put in its place here: the camera, characters by the time."""
        film, scene = self._film, self._scene
        return FrameInput(
            scene,
            film.path.camera(time),
            scene.settings,
            film.exposure(time),
            film.view,
            time,
        )

    def close(self) -> None:
        """Give back everything on the GPU."""
        self._readback.release()
        if self._mean is not None:
            self._average.release()
            self._mean.release()
        self._renderer.close()

    def __enter__(self) -> "FilmCamera":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def lit_along(scene: Scene, path: CameraPath, *, bake: bool) -> Scene:
    """The scene; where its light was chosen, under one that is chosen for all of a path.

    Args:
        scene: What is filmed.
        path: Of the camera.
        bake: Whether light between walls is traced.
    """
    if scene.lights_chosen:
        looks = np.linspace(0, path.seconds, LOOKS)
        scene = with_chosen_light(scene, [path.camera(time) for time in looks])
    return bounce.bake(scene) if bake else scene


def exposures_for(scene: Scene, path: CameraPath, view: View) -> tuple[float, ...]:
    """A film's exposures: those of moments along its path, each mixed with those next to it.

    So pictures follow from light into shade slowly, and nothing pumps.
    """
    if scene.settings.exposure is not None or not view.is_light:
        return (scene.settings.exposure or 1.0,)
    count = max(2, math.ceil(path.seconds / ADAPTING) + 1)
    with Renderer((160, 120)) as renderer:
        measured = [
            renderer.exposure(scene, path.camera(time), view=view.metered, time=time)
            for time in np.linspace(0, path.seconds, count).tolist()
        ]
    before, here, behind = (np.pad(np.log(measured), 1, "edge")[k : k + count] for k in range(3))
    return tuple(np.exp((before + 2 * here + behind) / 4).tolist())
