"""Times of the last frames, for a plot."""

import numpy as np
from numpy.typing import NDArray

LENGTH = 240
"""Frames that are remembered: four seconds' worth at 60 a second."""

KINDS = ("whole", "CPU", "submission", "GPU")


class History:
    """Milliseconds of the last frames, by kind; `count` have been added.

    Whole frames are from one to the next, with what the limit waits; the CPU's share is that
    of the interface and of submission, which is the scene's alone.
    """

    def __init__(self) -> None:
        self._ms = np.zeros((len(KINDS), 2 * LENGTH), np.float32)
        self.count = 0

    def add(self, whole: float, cpu: float, submission: float, gpu: float) -> None:
        """Remember a frame. Numbers are kept twice, LENGTH apart, so that `of` copies nothing."""
        at = self.count % LENGTH
        self._ms[:, at] = self._ms[:, at + LENGTH] = whole, cpu, submission, gpu
        self.count += 1

    def of(self, kind: str) -> NDArray[np.float32]:
        """(n,) the last n <= LENGTH frames' milliseconds, oldest first."""
        count = min(self.count, LENGTH)
        end = self.count % LENGTH + LENGTH if self.count >= LENGTH else count
        return self._ms[KINDS.index(kind), end - count : end]

    def median(self, kind: str) -> float:
        """Of what is remembered; 0 if that is nothing."""
        return float(np.median(self.of(kind))) if self.count else 0.0

    @property
    def frame_rate(self) -> float:
        """Frames a second."""
        return 1e3 / self.median("whole") if self.count else 0.0
