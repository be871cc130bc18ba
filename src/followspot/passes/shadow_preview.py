"""A light's shadow map as a picture that can be looked at while it changes."""

import moderngl

from followspot.gpu import program
from followspot.gpu.program import ShaderFolder
from followspot.gpu.targets import encode_srgb
from followspot.passes.programs import SHADOW_ATLAS, Shader
from followspot.passes.shadow import ShadowPass
from followspot.passes.shadow_fit import ShadowFrustum

_THINNEST = 1.0
"""Units between the distances that are darkest and lightest, at least."""


class ShadowPreview:
    """Greys for distances from the nearest to the farthest, in a texture of the map's own size.

    Args:
        context: Where it lives.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._framebuffer: moderngl.Framebuffer | None = None
        self._texture: moderngl.Texture | None = None
        self._numbers = context.sampler(compare_func="")  # the atlas compares by itself
        self._shader = Shader(
            context,
            ShaderFolder(),
            "distance",
            lambda distance: [context.vertex_array(distance, [])],
            vertex="average",
        )
        self._drawn: object = None
        self._tile: ShadowFrustum | None = None
        self._between = (0.0, 1.0)

    def draw(self, shadow: ShadowPass, number: int) -> moderngl.Texture:
        """Show the map of light `number` as it is now. Not inside a frame.

        What is nearest and farthest is looked for where the map covers something new; that waits
        for the GPU.

        Returns:
            (size, size) RGBA, its top row first; the same texture while maps keep their size.
        """
        tile, size = shadow.tiles[number], shadow.atlas.height
        texture, framebuffer = self._resized(size)
        wanted = (tile, number, size, shadow.version)
        if wanted == self._drawn:
            return texture
        if tile is not self._tile:
            self._tile, self._between = tile, _between(shadow, number)
        of = self._shader.program
        program.set_uniform(of, "shadow_depths", SHADOW_ATLAS)
        program.set_uniform(of, "corner", (number * size, 0))
        program.set_uniform(of, "size", size)
        program.set_uniform(of, "planes", (tile.near, tile.far))
        program.set_uniform(of, "shown", self._between)
        framebuffer.use()
        encode_srgb(self._context, False)
        self._context.enable_only(moderngl.NOTHING)
        shadow.atlas.use(SHADOW_ATLAS)
        self._numbers.use(SHADOW_ATLAS)
        self._shader.arrays[0].render(vertices=3)
        self._numbers.clear(SHADOW_ATLAS)
        self._drawn = wanted
        return texture

    def _resized(self, size: int) -> tuple[moderngl.Texture, moderngl.Framebuffer]:
        if self._texture is None or self._framebuffer is None or self._texture.width != size:
            self._drop_texture()
            self._texture = self._context.texture((size, size), 4)
            self._texture.filter = moderngl.LINEAR, moderngl.NEAREST
            self._framebuffer = self._context.framebuffer([self._texture])
        return self._texture, self._framebuffer

    def _drop_texture(self) -> None:
        for each in (self._framebuffer, self._texture):
            if each is not None:
                each.release()

    def release(self) -> None:
        """Give the GL objects back."""
        self._drop_texture()
        self._numbers.release()
        self._shader.release()


def _between(shadow: ShadowPass, number: int) -> tuple[float, float]:
    """Distances along light `number`'s axis, in units, of what is nearest and farthest."""
    tile, size = shadow.tiles[number], shadow.atlas.height
    depths = shadow.read_depths(number, (0, 0, size, size), size)
    hit = depths[depths < 1]
    if not hit.size:
        return tile.near, tile.far
    nearest, farthest = (float(tile.distances(end)) for end in (hit.min(), hit.max()))
    return nearest, max(farthest, nearest + _THINNEST)
