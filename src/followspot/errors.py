"""The errors that a user can cause, as one small tree.

    FollowspotError          one clear line on stderr, exit code 2, never a traceback
    ├── AssetError           a file is missing, truncated, oversized or lies
    ├── UsageError           an argument or setting makes no sense
    │   └── UnwritableError  a file or folder cannot be written
    └── ContextError         no OpenGL context can be had on this machine

Anything else that escapes is a bug of ours and keeps its traceback.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


class FollowspotError(Exception):
    """Base of every error whose cause lies outside the program.

    Its text is one line: what does not print, in names that others gave, is escaped.
    """

    def __str__(self) -> str:
        return printable(super().__str__())


def printable(text: str) -> str:
    """Text with line ends, control characters and the like as Python would write them."""
    return "".join(
        c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text
    )


class AssetError(FollowspotError):
    """A file that cannot be used, told as file, place, expected and found.

    Args:
        source: The file, with its pak where it lies in one: ``pak0.pk3:maps/q.bsp``.
        expected: What a good file would hold there.
        found: What this one holds.
        place: Byte offset, line, lump, field or key; empty for the file as a whole.
    """

    def __init__(self, source: str, *, expected: str, found: str, place: str = "") -> None:
        self.source = source
        self.place = place
        self.expected = expected
        self.found = found
        where = ": ".join(part for part in (source or "''", place) if part)
        super().__init__(f"{where}: expected {expected}, found {found}")


@contextmanager
def asked_by(source: str, key: str, **others: str) -> Iterator[None]:
    """Tell of what is wrong with an asset, within, where it was asked for.

    Args:
        source: The file that asks for it.
        key: By which it does.
        others: Keys in its stead for an error's place: ``skin="characters[0].skin"``.
    """
    try:
        yield
    except AssetError as error:
        its_key = others.get(error.place, key)
        place = "" if its_key.endswith(f".{error.place}") else error.place
        place = ": ".join(part for part in (its_key, error.source or "''", place) if part)
        raise AssetError(source, place=place, expected=error.expected, found=error.found) from None


class UsageError(FollowspotError):
    """An argument, camera name or setting that cannot be used as given."""


class UnwritableError(UsageError):
    """A file or folder that cannot be written where somebody wants it.

    Args:
        path: The file or folder.
        reason: What the system says, or what was expected and found.
    """

    def __init__(self, path: Path | str, reason: str) -> None:
        self.reason = reason
        super().__init__(f"{path}: cannot be written: {reason}")


class ContextError(FollowspotError):
    """No OpenGL context could be created; the message says what to install."""
