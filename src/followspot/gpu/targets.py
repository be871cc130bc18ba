"""What a frame is drawn into: linear radiance with depth, and the displayed picture."""

import moderngl
import numpy as np
from numpy.typing import NDArray


class Targets:
    """The two framebuffers of one picture size.

    Attributes:
        size: (width, height) in pixels.
        radiance: RGBA float texture: W/(m^2 sr), or the values of a stage's view. Half floats
            for display, full floats where the numbers themselves are wanted.
        linear: Framebuffer of `radiance` with a 24-bit depth buffer.
        display: Framebuffer of RGBA8, sRGB-encoded by the tonemap pass.
    """

    def __init__(self, context: moderngl.Context, size: tuple[int, int], *, full: bool) -> None:
        self.size = size
        self.full = full
        self.radiance = context.texture(size, 4, dtype="f4" if full else "f2")
        self.radiance.filter = moderngl.NEAREST, moderngl.NEAREST
        self._depth = context.depth_renderbuffer(size)
        self._picture = context.renderbuffer(size, 4)
        self.linear = context.framebuffer([self.radiance], self._depth)
        self.display = context.framebuffer([self._picture])

    def read_linear(self) -> NDArray[np.float32]:
        """(h, w, 3) float32 of `radiance`, top row first; needs full floats for full precision."""
        data = self.linear.read(components=3, dtype="f4", alignment=1)
        return np.frombuffer(data, "<f4").reshape(*self.size[::-1], 3)[::-1].copy()

    def read_display(self) -> NDArray[np.uint8]:
        """(h, w, 3) uint8 of `display`, top row first."""
        data = self.display.read(components=3, alignment=1)
        return np.frombuffer(data, np.uint8).reshape(*self.size[::-1], 3)[::-1].copy()

    def release(self) -> None:
        """Give the GL objects back."""
        for thing in (self.linear, self.display, self.radiance, self._depth, self._picture):
            thing.release()
