"""The sky's cube map unfolded, as a picture."""

import moderngl

from followspot.gpu import program
from followspot.gpu.program import ShaderFolder
from followspot.gpu.targets import encode_srgb, release_framebuffer
from followspot.passes.programs import BASE_IMAGE, over_picture

EDGE = 128
"""Pixels of a face."""

FACES = {"+X": (1, 1), "-X": (3, 1), "+Y": (0, 1), "-Y": (2, 1), "+Z": (1, 0), "-Z": (1, 2)}
"""Column and row of each face in the picture, which has 4 and 3 of them."""


class SkyPreview:
    """The six faces as they are seen from inside, at any MIP level, texel by texel.

    Args:
        context: Where it lives.

    Attributes:
        texture: (4 EDGE, 3 EDGE) RGBA as displayed, its top row first; transparent where there is
            no face.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self.texture = context.texture((4 * EDGE, 3 * EDGE), 4)
        self._framebuffer = context.framebuffer([self.texture])
        self._texels = context.sampler(
            filter=(moderngl.NEAREST_MIPMAP_NEAREST, moderngl.NEAREST),
            repeat_x=False,
            repeat_y=False,
        )
        self._shader = over_picture(context, ShaderFolder(), "cross")

    def draw(self, sky: moderngl.TextureCube, level: int) -> moderngl.Texture:
        """Show a cube map's MIP level."""
        of = self._shader.program
        program.set_uniform(of, "sky", BASE_IMAGE)
        program.set_uniform(of, "level", float(level))
        program.set_uniform(of, "edge", float(EDGE))
        self._framebuffer.use()
        encode_srgb(self._context, False)
        self._context.enable_only(moderngl.NOTHING)
        sky.use(BASE_IMAGE)
        self._texels.use(BASE_IMAGE)
        self._shader.arrays[0].render(vertices=3)
        self._texels.clear(BASE_IMAGE)
        return self.texture

    def release(self) -> None:
        """Give the GL objects back."""
        release_framebuffer(self._framebuffer)
        for each in (self.texture, self._texels):
            each.release()
        self._shader.release()
