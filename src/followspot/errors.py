"""The errors that a user can cause, as one small tree.

    FollowspotError          one clear line on stderr, exit code 2, never a traceback
    ├── AssetError           a file is missing, truncated, oversized or lies
    ├── UsageError           an argument or setting makes no sense
    └── ContextError         no OpenGL context can be had on this machine

Anything else that escapes is a bug of ours and keeps its traceback.
"""


class FollowspotError(Exception):
    """Base of every error whose cause lies outside the program."""


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
        where = f"{source}: {place}" if place else source
        super().__init__(f"{where}: expected {expected}, found {found}")


class UsageError(FollowspotError):
    """An argument, camera name or setting that cannot be used as given."""


class ContextError(FollowspotError):
    """No OpenGL context could be created; the message says what to install."""
