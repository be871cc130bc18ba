"""Several displayed pictures, each finer than wanted, to their mean: in linear light."""

import moderngl

from followspot.gpu import program
from followspot.gpu.program import ShaderFolder
from followspot.gpu.targets import Target, encode_srgb, release_framebuffer
from followspot.passes.programs import BASE_IMAGE, over_picture


class AveragePass:
    """Adds pictures up and writes their mean.

    Args:
        context: Where they are.
        edge: Pixels of theirs, along an edge, that become one.
        count: How many pictures make one.
        target: A display target that gets the mean.
    """

    def __init__(self, context: moderngl.Context, edge: int, count: int, target: Target) -> None:
        self._context = context
        self._edge, self._share = edge, 1 / (edge * edge * count)
        self._target = target
        self._shader = over_picture(context, ShaderFolder(), "average")
        self._sum = context.texture(target.size, 4, dtype="f4")
        self._framebuffer = context.framebuffer([self._sum])

    def begin(self) -> None:
        """Forget what has been added."""
        self._framebuffer.clear()

    def add(self, picture: Target, *, encoded: bool) -> None:
        """Add a display target's picture.

        Args:
            picture: `edge` times as wide and high as the mean.
            encoded: Whether it shows light or reflectance through the sRGB curve; other values
                are averaged as they are shown.
        """
        self._framebuffer.use()
        encode_srgb(self._context, False)
        self._context.enable_only(moderngl.BLEND)
        self._context.blend_func = moderngl.ONE, moderngl.ONE
        (texture,) = picture.framebuffer.color_attachments
        assert isinstance(texture, moderngl.Texture)
        self._draw(texture, self._edge, self._share, not encoded)

    def finish(self, *, encoded: bool) -> None:
        """Write the mean into the target."""
        self._target.framebuffer.use()
        encode_srgb(self._context, encoded)
        self._context.enable_only(moderngl.NOTHING)
        self._draw(self._sum, 1, 1.0, False)

    def _draw(self, texture: moderngl.Texture, edge: int, share: float, decoded: bool) -> None:
        texture.use(BASE_IMAGE)
        program.set_uniform(self._shader.program, "edge", edge)
        program.set_uniform(self._shader.program, "share", share)
        program.set_uniform(self._shader.program, "decoded", decoded)
        self._shader.arrays[0].render(vertices=3)

    def release(self) -> None:
        """Give the GL objects back."""
        release_framebuffer(self._framebuffer)
        self._sum.release()
        self._shader.release()
