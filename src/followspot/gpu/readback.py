"""Reading pictures back without waiting for them: through pixel buffers."""

from collections import deque
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.gpu.targets import Target

IN_FLIGHT = 2
"""Pictures that may be on their way while the next one is drawn."""


class Readback:
    """A queue of displayed pictures of one size on their way from the GPU."""

    def __init__(self, context: moderngl.Context, size: tuple[int, int]) -> None:
        self._shape = (*size[::-1], 3)
        length = size[0] * size[1] * 3
        self._free = [context.buffer(reserve=length, dynamic=True) for _ in range(IN_FLIGHT)]
        self._waiting: deque[moderngl.Buffer] = deque()

    @property
    def count(self) -> int:
        """How many pictures are on their way."""
        return len(self._waiting)

    @property
    def is_full(self) -> bool:
        """Whether one has to be fetched before the next can start."""
        return not self._free

    def start(self, target: Target) -> None:
        """Send off what a display target shows; it may be drawn into again at once."""
        buffer = self._free.pop()
        target.framebuffer.read_into(buffer, components=3, alignment=1)
        self._waiting.append(buffer)

    def fetch(self) -> NDArray[Any]:
        """(h, w, 3) uint8, top row first: the picture that was sent off first."""
        buffer = self._waiting.popleft()
        self._free.append(buffer)
        return np.frombuffer(buffer.read(), "u1").reshape(self._shape)[::-1]

    def release(self) -> None:
        """Give the GL objects back."""
        for buffer in (*self._free, *self._waiting):
            buffer.release()
