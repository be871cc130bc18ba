"""Which frames many figures show at a time, each by what it plays and when.

One animation changes into another as in the game (``CG_RunLerpFrame`` of ``cg_players.c``): the
old one goes on to its next key frame, and from there the figure moves into the first frame of the
new one within that one's time of a frame. So nothing jumps, and no pose is between more than two
frames.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from followspot.assets.animation import Animation, Pose, frame_in_run


class Play(NamedTuple):
    """An animation and the second at which it is begun."""

    animation: Animation
    at: float


_ENTRY = np.dtype(
    [
        ("begin", "f8"),  # seconds: from here on it is played
        ("zero", "f8"),  # seconds: here it is in its first frame
        ("lead", "i8"),  # frame that it comes from
        ("first", "i8"),
        ("count", "i8"),
        ("looping", "i8"),
        ("fps", "f8"),
        ("is_reversed", "?"),
    ]
)


class Schedules:
    """What n tracks play; asked for all of them at once.

    Args:
        tracks: For each track what it plays, at least one thing, in the order of time. The first
            one holds its first frame until it begins.
    """

    def __init__(self, tracks: Sequence[Sequence[Play]]) -> None:
        longest = max(map(len, tracks), default=1)
        self._entries = np.zeros((len(tracks), longest), _ENTRY)
        self._entries["begin"] = np.inf
        for row, plays in zip(self._entries, tracks, strict=True):
            row[: len(plays)] = _entries(plays)
        self._never_changes = longest == 1

    def poses(self, seconds: NDArray[np.float64], which: NDArray[np.intp]) -> Pose:
        """Find the frames that some tracks show.

        Args:
            seconds: (m,) each one's own time.
            which: (m,) numbers of tracks.

        Returns:
            A pose of m figures.
        """
        now = np.zeros(len(which), np.intp)
        if not self._never_changes:
            begun = self._entries["begin"][which] <= seconds[:, np.newaxis]
            now = np.maximum(begun.sum(axis=1) - 1, 0)
        entry = self._entries[which, now]
        step = np.maximum((seconds - entry["zero"]) * entry["fps"], -1.0)
        whole = np.floor(step)
        frame, next_frame = _frame(entry, np.stack([whole, whole + 1]))
        return Pose(frame, next_frame, step - whole)


def _frame(entry: NDArray[np.void], step: NDArray[np.float64]) -> NDArray[np.intp]:
    place = frame_in_run(step, entry["count"], entry["looping"], entry["is_reversed"])
    return np.where(step < 0, entry["lead"], entry["first"] + place)


def _entries(plays: Sequence[Play]) -> NDArray[np.void]:
    entries = np.zeros(len(plays), _ENTRY)
    for k, (animation, at) in enumerate(plays):
        entry = entries[k]
        for name in ("first", "count", "looping", "fps", "is_reversed"):
            entry[name] = getattr(animation, name)
        if k == 0:
            entry["begin"], entry["zero"] = -np.inf, at
            entry["lead"] = int(_frame(entries[:1], np.zeros(1))[0])
            continue
        before = entries[k - 1]
        steps = max(math.ceil((at - before["zero"]) * before["fps"] - 1e-9), 0)
        entry["begin"] = before["zero"] + steps / before["fps"]
        entry["zero"] = entry["begin"] + 1 / animation.fps
        entry["lead"] = int(_frame(entries[k - 1 : k], np.full(1, float(steps)))[0])
    return entries
