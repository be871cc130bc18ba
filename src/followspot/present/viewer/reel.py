"""A film that is being recorded: pictures go in from the window's thread, another writes them."""

import math
from collections.abc import Iterator
from concurrent.futures import Executor, Future
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from queue import Full, Queue

from followspot.errors import UsageError
from followspot.present import files
from followspot.present.frames import Picture

WAITING = 8
"""Pictures that may wait to be encoded."""

_PATIENCE = 0.1  # seconds after which to see whether somebody still encodes


class Reel:
    """A film's file on its way.

    Args:
        path: Of the file, whose ending is one of `video.CODECS`; it is there when all of it is.
        size: (width, height) in pixels; both are even.
        fps: Frames a second.
        by_clock: Whether pictures are repeated, or left out, as time goes by, so that a second of
            the film takes a second; else each picture is one frame.
        writers: Run what writes it.

    Attributes:
        size: (width, height).
        count: Frames so far.
        written: Gets a line that tells of the file, or what went wrong with it.
    """

    def __init__(
        self, path: Path, size: tuple[int, int], fps: int, by_clock: bool, writers: Executor
    ) -> None:
        self.size = size
        self.count = 0
        self._fps = fps
        self._by_clock = by_clock
        self._seconds = 0.0
        self._waiting: Queue[tuple[Picture, int] | None] = Queue(WAITING)
        self.written: Future[str] = writers.submit(self._write, path)

    def due(self, seconds: float) -> int:
        """How many frames a picture is for that comes so many seconds after the one before.

        None of them, by the clock, if encoding does not keep up; later ones make up for it. The
        film's time begins with the first picture that is taken.
        """
        if not self._by_clock:
            return 1
        self._seconds += seconds if self.count else 0.0
        wanted = math.floor(self._seconds * self._fps + 1e-6) + 1 - self.count
        return 0 if self._waiting.full() else wanted

    def add(self, picture: Picture, frames: int) -> None:
        """Let a picture be so many frames; waits while too many others do."""
        self.count += frames
        self._put((picture, frames))

    def finish(self) -> None:
        """Let the film end here."""
        self._put(None)

    def _put(self, item: tuple[Picture, int] | None) -> None:
        is_in = False
        while not is_in and not self.written.done():  # which an error does before the end
            with suppress(Full):
                self._waiting.put(item, timeout=_PATIENCE)
                is_in = True

    def _pictures(self) -> Iterator[Picture]:
        while (item := self._waiting.get()) is not None:
            picture, frames = item
            for _ in range(frames):
                yield picture

    def _write(self, path: Path) -> str:
        import av  # a tenth of a second, which nobody waits for here

        from followspot.present import video

        shape = video.Shape(self.size, Fraction(self._fps))

        def write(part: Path) -> None:
            video.write_video(part, self._pictures(), shape, None, stopped=lambda: False)

        try:
            files.write_whole(path, write)
        except av.FFmpegError as error:
            raise UsageError(f"{path}: cannot be written: {error.strerror}") from None
        seconds = self.count / self._fps
        return f"{path}: {self.count} frames, {seconds:.1f} s, {path.stat().st_size:,} bytes"
