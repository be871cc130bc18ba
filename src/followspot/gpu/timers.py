"""GPU time, by pass or of whole frames, from timer queries made once.

A software rasteriser puts its work off until somebody waits for it, so that queries see next to
nothing of it; there, waiting is what is timed.
"""

import time
from collections import deque
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import cast

import moderngl

_FRAMES_IN_FLIGHT = 4


class PassTimers:
    """One timer query a pass; may not be nested.

    Args:
        context: Where the queries live.
        names: Of the passes.
        waits: Whether each pass is waited for on its own instead: for a software rasteriser.
    """

    def __init__(self, context: moderngl.Context, names: tuple[str, ...], *, waits: bool) -> None:
        self._context = context
        self._waits = waits
        self._queries = {name: context.query(time=True) for name in names}
        self._waited_ms = dict.fromkeys(names, 0.0)

    def __call__(self, name: str) -> AbstractContextManager[object]:
        """Time what is drawn inside the ``with`` block."""
        if self._waits:
            return self._waited(name)
        return cast("AbstractContextManager[object]", self._queries[name])

    @contextmanager
    def _waited(self, name: str) -> Iterator[None]:
        self._context.finish()
        start = time.perf_counter()
        yield
        self._context.finish()
        self._waited_ms[name] = (time.perf_counter() - start) * 1e3

    def read_ms(self) -> dict[str, float]:
        """Milliseconds by pass in the last frame; waits for the GPU."""
        if self._waits:
            return dict(self._waited_ms)
        return {name: query.elapsed / 1e6 for name, query in self._queries.items()}


class FrameTimer:
    """GPU time of whole frames.

    It is read some frames later, when nobody has to wait for it.

    Attributes:
        ms: Milliseconds of a frame, the latest that is known.
        waited_ms: Milliseconds of this thread that measuring took.

    Args:
        context: Where the queries live.
        waits: Whether each frame is waited for: for a software rasteriser.
    """

    def __init__(self, context: moderngl.Context, *, waits: bool) -> None:
        self._context = context
        self._waits = waits
        self._queries = deque(context.query(time=True) for _ in range(_FRAMES_IN_FLIGHT))
        self._started = 0
        self.ms = self.waited_ms = 0.0

    @contextmanager
    def frame(self) -> Iterator[None]:
        """Time what is drawn inside the ``with`` block."""
        if self._waits:
            yield
            submitted = time.perf_counter()
            self._context.finish()
            self.ms = self.waited_ms = (time.perf_counter() - submitted) * 1e3
            return
        self._queries.rotate(-1)
        self._started += 1
        with self._queries[0]:
            yield
        if self._started >= _FRAMES_IN_FLIGHT:
            self.ms = float(self._queries[1].elapsed) / 1e6
