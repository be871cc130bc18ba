"""What a frame is drawn into, and reading it back.

There are two kinds. A *display* target is 8-bit sRGB: shaders write it encoded, since software
rasterisers decode and encode whole blocks of pixels where GL does that; but where surfaces are
blended, GL does, in linear light. It is the fast one: no float picture is written and read again
to be encoded. A *linear* target holds float32, for the numbers themselves.
"""

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.errors import UsageError
from followspot.gpu import gl

Part = tuple[int, int, int, int]
"""A rectangle of a picture: x, y, width, height in pixels, y counted from the top row."""


class Target:
    """A picture of one size with a depth buffer of 24 bits.

    Attributes:
        size: (width, height) in pixels.
        is_linear: Whether it holds float32 values instead of displayed ones.
        framebuffer: To draw into.

    Raises:
        UsageError: GL can make no picture of that size.
    """

    def __init__(
        self, context: moderngl.Context, size: tuple[int, int], *, is_linear: bool
    ) -> None:
        self.size = size
        self.is_linear = is_linear
        if is_linear:
            self._picture = context.texture(size, 4, dtype="f4")
        else:
            self._picture = context.texture(size, 4, internal_format=gl.SRGB8_ALPHA8)
        self._depth = context.depth_renderbuffer(size)
        try:
            self.framebuffer = context.framebuffer([self._picture], self._depth)
            self._picture_alone = context.framebuffer([self._picture])
        except moderngl.Error:
            self._picture.release()
            self._depth.release()
            text = f"a size of {size[0]}x{size[1]} cannot be drawn here: it is too large for OpenGL"
            raise UsageError(text) from None

    def box(self, part: Part) -> Part:
        """A part with y counted as GL does, from the bottom row."""
        x, y, width, height = part
        return x, self.size[1] - y - height, width, height

    def read(self, components: int = 3, part: Part | None = None) -> NDArray[Any]:
        """(h, w, components) float32 or uint8 of the whole picture or a part, top row first.

        The fourth component is 1 where the picture shows a surface and 0 where it shows the sky.
        """
        gl_type, dtype = ("f4", "<f4") if self.is_linear else ("f1", "u1")
        x, y, width, height = self.box(part or (0, 0, *self.size))
        data = self.framebuffer.read(
            (x, y, width, height), components=components, dtype=gl_type, alignment=1
        )
        return np.frombuffer(data, dtype).reshape(height, width, components)[::-1].copy()

    def show(self) -> None:
        """Copy a display target's picture, byte for byte, into the window of its context.

        The window's framebuffer is bound then, and takes what is written as it is.
        """
        context = self.framebuffer.ctx
        encode_srgb(context, False)
        # Without depth, whose format would have to be the window's.
        context.copy_framebuffer(context.screen, self._picture_alone)
        context.screen.use()

    def release(self) -> None:
        """Give the GL objects back."""
        release_framebuffer(self.framebuffer)
        release_framebuffer(self._picture_alone)
        for thing in (self._picture, self._depth):
            thing.release()


def encode_srgb(context: moderngl.Context, wanted: bool) -> None:
    """Let GL turn what shaders write into sRGB, where pictures are in it, or write it as it is."""
    if wanted:
        context.enable_direct(gl.FRAMEBUFFER_SRGB)
    else:
        context.disable_direct(gl.FRAMEBUFFER_SRGB)


def release_framebuffer(framebuffer: moderngl.Framebuffer) -> None:
    """Give one back; moderngl binds the one that was used last again, so that must not be it."""
    context = framebuffer.ctx
    if context.fbo is framebuffer:
        (context.screen or context.detect_framebuffer(0)).use()
    framebuffer.release()
