"""Which frames many figures show at a time, each by what it plays and when.

One animation changes into another as in the game (``CG_RunLerpFrame`` of ``cg_players.c``): the
old one goes on to its next key frame, and from there the figure moves into the first frame of the
new one within that one's time of a frame. So nothing jumps, and no pose is between more than two
frames.
"""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.assets.animation import Animation, Pose


class Play(NamedTuple):
    """An animation and the second at which it is begun."""

    animation: Animation
    at: float


_ENTRY = np.dtype(
    [
        ("begin", "f8"),  # seconds: from here on it is played
        ("zero", "f8"),  # seconds: here it is in its first frame
        ("fps", "f8"),
        ("first", "f8"),  # row of its first frame in the table of steps
        ("count", "f8"),
        ("looping", "f8"),
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
        steps, rows = [np.empty((0, 2), np.intp)], 0
        for entries, plays in zip(self._entries, tracks, strict=True):
            for k, (animation, begin, zero, lead) in enumerate(_begun(plays)):
                own = _steps(animation, lead)
                entries[k] = (begin, zero, animation.fps, rows + 1, len(own) - 2, animation.looping)
                steps.append(own)
                rows += len(own)
        self._steps = np.concatenate(steps)
        self._never_changes = longest == 1

    def poses(self, seconds: Floats, which: NDArray[np.intp]) -> Pose:
        """Find the frames that some tracks show.

        Args:
            seconds: (m,) each one's own time.
            which: (m,) numbers of tracks.

        Returns:
            A pose of m figures.
        """
        now: int | NDArray[np.intp] = 0
        if not self._never_changes:
            begun = self._entries["begin"][which] <= seconds[:, np.newaxis]
            now = np.maximum(begun.sum(axis=1) - 1, 0)
        entry = self._entries[which, now]
        time = np.maximum((seconds - entry["zero"]) * entry["fps"], -1.0)
        step = np.floor(time)
        count, looping = entry["count"], entry["looping"]
        over = step - count
        repeated = count + over % np.maximum(looping, 1) - looping
        row = entry["first"] + np.where(over < 0, step, repeated)
        frames = self._steps[row.astype(np.intp)]
        return Pose(frames[:, 0], frames[:, 1], time - step)


def _begun(plays: Sequence[Play]) -> Iterator[tuple[Animation, float, float, int]]:
    """What a track plays, when it begins, when it is in its first frame; the frame before that."""
    old, zero = plays[0]
    yield old, -math.inf, zero, int(old.frame_at(0.0))
    for new, at in plays[1:]:
        steps = max(math.ceil((at - zero) * old.fps - 1e-9), 0)
        begin = zero + steps / old.fps
        lead = int(old.frame_at(float(steps)))
        zero = begin + 1 / new.fps
        yield new, begin, zero, lead
        old = new


def _steps(animation: Animation, lead: int) -> NDArray[np.intp]:
    """(count + 2, 2) frames that it moves from and to: before the first, in each, and behind all.

    The last row is what is held by one that does not repeat.
    """
    frames = animation.frame_at(np.arange(animation.count + 2.0))
    return np.column_stack([np.append(lead, frames[:-1]), frames])
