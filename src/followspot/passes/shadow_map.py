"""A depth texture to draw shadow maps into and to sample them from."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.gpu.targets import Part, release_framebuffer
from followspot.passes.shadow_tiles import Place


class ShadowMap:
    """A depth texture to draw into and to sample, of tiles of some size."""

    def __init__(self, context: moderngl.Context, shape: tuple[int, int], size: int) -> None:
        self._context = context
        self.size = size
        self.texture = context.depth_texture(shape)
        self.texture.compare_func = "<="
        self.texture.filter = moderngl.LINEAR, moderngl.LINEAR
        self.texture.repeat_x = self.texture.repeat_y = False
        self.framebuffer = context.framebuffer(depth_attachment=self.texture)

    def choose(self, place: Place) -> None:
        """Draw into a tile from now on."""
        box = place[0] * self.size, place[1] * self.size, self.size, self.size
        self.framebuffer.viewport = self.framebuffer.scissor = box
        self.framebuffer.use()

    def depths_at(self, place: Place, x: Floats, y: Floats) -> NDArray[np.float32]:
        """(y, x) depths in a tile at (x,) and (y,) places between its edges at 0 and 1."""
        depths = self.read(place, (0, 0, self.size, self.size))[::-1]
        columns, rows = (x * self.size).astype(np.intp), (y * self.size).astype(np.intp)
        return np.asarray(depths[np.ix_(rows, columns)])

    def read(self, place: Place, part: Part) -> NDArray[np.float32]:
        """Read a part of a tile; waits for the GPU.

        Returns:
            (h, w) depths in [0, 1], top row first.
        """
        x, y, width, height = part
        column, row = place
        box = column * self.size + x, (row + 1) * self.size - y - height, width, height
        self._context.finish()  # Mesa's llvmpipe may not wait for what is still being drawn
        raw = self.framebuffer.read(box, components=1, attachment=-1, dtype="f4")
        return np.frombuffer(raw, "<f4").reshape(height, width)[::-1]

    def release(self) -> None:
        """Give the GL objects back."""
        release_framebuffer(self.framebuffer)
        self.texture.release()
