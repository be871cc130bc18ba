"""A light's shadow map as a picture that can be looked at while it changes."""

import moderngl

from followspot.gpu import program
from followspot.gpu.program import ShaderFolder
from followspot.gpu.targets import encode_srgb
from followspot.passes.programs import SHADOW_ATLAS, Shader
from followspot.passes.shadow import ShadowPass


class ShadowPreview:
    """Greys for distances, in a texture of the map's own size; nothing is read back.

    Args:
        context: Where it lives.
        size: Texels along an edge of a light's map.

    Attributes:
        texture: (size, size) RGBA, its top row first.
    """

    def __init__(self, context: moderngl.Context, size: int) -> None:
        self._context = context
        self.size = size
        self.texture = context.texture((size, size), 4)
        self.texture.filter = moderngl.LINEAR, moderngl.NEAREST
        self._framebuffer = context.framebuffer([self.texture])
        self._numbers = context.sampler(compare_func="")  # the atlas compares by itself
        self._shader = Shader(
            context,
            ShaderFolder(),
            "distance",
            lambda distance: [context.vertex_array(distance, [])],
            vertex="average",
        )

    def draw(
        self, shadow: ShadowPass, number: int, between: tuple[float, float] | None = None
    ) -> moderngl.Texture:
        """Show the map of light `number` as it is now.

        Args:
            shadow: Has drawn maps of this size.
            number: Of the light among those with a map.
            between: Distances along the axis, in units, that are darkest and lightest; by default
                those of the map's near and far planes.
        """
        tile, of = shadow.tiles[number], self._shader.program
        program.set_uniform(of, "shadow_depths", SHADOW_ATLAS)
        program.set_uniform(of, "corner", (number * self.size, 0))
        program.set_uniform(of, "size", self.size)
        program.set_uniform(of, "planes", (tile.near, tile.far))
        program.set_uniform(of, "shown", between or (tile.near, tile.far))
        self._framebuffer.use()
        encode_srgb(self._context, False)
        self._context.enable_only(moderngl.NOTHING)
        shadow.atlas.use(SHADOW_ATLAS)
        self._numbers.use(SHADOW_ATLAS)
        self._shader.arrays[0].render(vertices=3)
        self._numbers.clear(SHADOW_ATLAS)
        return self.texture

    def release(self) -> None:
        """Give the GL objects back."""
        for each in (self._framebuffer, self.texture, self._numbers):
            each.release()
        self._shader.release()
