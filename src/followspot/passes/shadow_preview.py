"""A light's shadow map as a picture that can be looked at while it changes."""

import moderngl
import numpy as np

from followspot.gpu import program
from followspot.gpu.program import ShaderFolder
from followspot.gpu.targets import encode_srgb, release_framebuffer
from followspot.passes.programs import SHADOW_ATLAS, over_picture
from followspot.passes.shadow import ShadowPass
from followspot.passes.shadow_fit import ShadowFrustum
from followspot.passes.shadow_reading import read_distance
from followspot.scene.light import CubeSide

_THINNEST = 1.0
"""Units between the distances that are darkest and lightest, at least."""

_AROUND = (-1.0, 256.0)
"""Of the sides of point lights' cubes, which are looked at together: 256 units are half-way."""


class ShadowPreview:
    """Greys for distances from the nearest to the farthest, in a texture of a tile's own size.

    Args:
        context: Where it lives.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._framebuffer: moderngl.Framebuffer | None = None
        self._texture: moderngl.Texture | None = None
        self._numbers = context.sampler(compare_func="")  # the atlas compares by itself
        self._shader = over_picture(context, ShaderFolder(), "distance")
        self._drawn: object = None
        self._frustum: ShadowFrustum | None = None
        self._between = (0.0, 1.0)

    def draw(self, shadow: ShadowPass, number: int) -> moderngl.Texture:
        """Show the map of light or side `number` as it is now. Not inside a frame.

        What is nearest and farthest is looked for where the map covers something new; that waits
        for the GPU.

        Returns:
            (size, size) RGBA, its top row first; the same texture while maps keep their size.
        """
        (tile, *finer), size = shadow.tiles_of(number), shadow.size
        texture, framebuffer = self._resized(size)
        wanted = (tile, *finer, size, shadow.version)
        if wanted == self._drawn:
            return texture
        if tile.frustum is not self._frustum:
            self._frustum, self._between = tile.frustum, _between(shadow, number)
        of = self._shader.program
        program.set_uniform(of, "shadow_depths", SHADOW_ATLAS)
        scale, shift = tile.finer_from_here if finer else ((0.0, 0.0), (-1.0, -1.0))
        program.set_uniform(of, "corner", tuple(size * at for at in tile.place))
        program.set_uniform(of, "near_from_wide", (*scale, *shift))
        program.set_uniform(of, "size", size)
        program.set_uniform(of, "planes", (tile.frustum.near, tile.frustum.far))
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
        if self._framebuffer is not None:
            release_framebuffer(self._framebuffer)
        if self._texture is not None:
            self._texture.release()

    def release(self) -> None:
        """Give the GL objects back."""
        self._drop_texture()
        self._numbers.release()
        self._shader.release()


def _between(shadow: ShadowPass, number: int) -> tuple[float, float]:
    """Distances along light `number`'s axis, in units, of what is nearest and farthest."""
    if isinstance(shadow.layout.lights[number], CubeSide):
        return _AROUND
    distance = read_distance(shadow, number)
    hit = distance[np.isfinite(distance)]
    if not hit.size:
        frustum = shadow.tiles_of(number)[0].frustum
        return frustum.near, frustum.far
    nearest, farthest = float(hit.min()), float(hit.max())
    return nearest, max(farthest, nearest + _THINNEST)
