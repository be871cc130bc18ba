"""Ctrl-C, kill -TERM and a terminal that is closed: as exceptions, or as something to ask about."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn


class Terminated(KeyboardInterrupt):
    """What kill -TERM and a closed terminal raise within `interruptible`.

    Attributes:
        number: Of the signal.
    """

    def __init__(self, number: int = signal.SIGTERM) -> None:
        super().__init__()
        self.number = number


@contextmanager
def interruptible() -> Iterator[None]:
    """Let kill -TERM and the like unwind as Ctrl-C does, so that nothing half-made stays behind.

    Ctrl-C itself is asked for, too: a process started in the background may be deaf to it. Only in
    a process's main thread.
    """
    handlers = [(signal.SIGINT, signal.default_int_handler)]
    handlers += [(number, _terminate) for number in _terminating()]
    before = [(number, signal.signal(number, handler)) for number, handler in handlers]
    try:
        yield
    finally:
        for number, earlier in before:
            signal.signal(number, earlier)


def _terminating() -> list[signal.Signals]:
    """What ends a process besides Ctrl-C: kill -TERM, and the end of its terminal.

    Nohup makes a process deaf to that, and so it stays; other systems than POSIX do not know it.
    """
    hang_up: signal.Signals | None = getattr(signal, "SIGHUP", None)
    if hang_up is None or signal.getsignal(hang_up) is signal.SIG_IGN:
        return [signal.SIGTERM]
    return [signal.SIGTERM, hang_up]


def _terminate(number: int, _: FrameType | None) -> NoReturn:
    raise Terminated(number)


class Interrupt:
    """Ctrl-C, kill -TERM and the like as something to ask about, while it is a context.

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
        numbers = (signal.SIGINT, *_terminating())
        self._before = [(number, signal.signal(number, self._come)) for number in numbers]
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before:
            signal.signal(number, handler)
