"""Ctrl-C and kill -TERM: as exceptions, or as something to ask about."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn


class Terminated(KeyboardInterrupt):
    """What kill -TERM raises within `interruptible`."""


@contextmanager
def interruptible() -> Iterator[None]:
    """Let kill -TERM unwind as Ctrl-C does, so that nothing half-made stays behind.

    Ctrl-C itself is asked for, too: a process started in the background may be deaf to it. Only in
    a process's main thread.
    """
    handlers = {signal.SIGTERM: _terminate, signal.SIGINT: signal.default_int_handler}
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _terminate(*_: object) -> NoReturn:
    raise Terminated


class Interrupt:
    """Ctrl-C and kill -TERM as something to ask about, while it is a context.

    Attributes:
        signal: The one that came last; none so far if None.
        count: How many have come: one ends the drawing, two end it all.
    """

    def __init__(self) -> None:
        self.signal: int | None = None
        self.count = 0

    def again(self) -> None:
        """After the context: let whoever waits for the signal have it, if one came."""
        if self.signal is not None:
            signal.raise_signal(self.signal)

    def _come(self, number: int, _: FrameType | None) -> None:
        self.signal, self.count = number, self.count + 1

    def __enter__(self) -> "Interrupt":
        numbers = (signal.SIGINT, signal.SIGTERM)
        self._before = [(number, signal.signal(number, self._come)) for number in numbers]
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before:
            signal.signal(number, handler)
