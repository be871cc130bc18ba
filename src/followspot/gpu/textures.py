"""Images as textures that filter linear light.

What needs no alpha is decoded here, once, into GL_RGB9_E5: nine bits a channel below an exponent
that they share (EXT_texture_shared_exponent), in the four bytes that sRGB takes, too. The brightest
channel is kept to 0.2 %, finer than a step of 8-bit sRGB, the others to as much of the brightest
one. A software rasteriser decodes it much faster than the sRGB curve, for eight texels a pixel.
"""

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.assets.image import BYTE_TO_LINEAR
from followspot.gpu import gl
from followspot.scene.sky import CubeMap

_AT_ONCE = 1 << 15
"""Texels that are decoded at once: NumPy makes indices of eight bytes first."""


def upload(
    context: moderngl.Context,
    pixels: NDArray[np.uint8],
    *,
    with_alpha: bool = False,
    clamps: bool = False,
) -> moderngl.Texture:
    """A trilinear texture whose texels are read as linear light; row 0 is t = 0, as in Quake.

    Args:
        context: Where it lives.
        pixels: (h, w, 4) sRGB with straight alpha.
        with_alpha: Whether alpha is read, too; else it is 1.
        clamps: Whether it ends at its border instead of repeating.
    """
    size = pixels.shape[1::-1]
    if with_alpha:
        texture = context.texture(size, 4, pixels, internal_format=gl.SRGB8_ALPHA8)
    else:
        linear = _decoded(pixels)
        texture = context.texture(size, 3, linear, dtype="f4", internal_format=gl.RGB9_E5)
    texture.repeat_x = texture.repeat_y = not clamps
    texture.build_mipmaps()  # GL averages in linear light
    texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    return texture


def upload_cube(context: moderngl.Context, sky: CubeMap) -> moderngl.TextureCube:
    """The sky's faces, already in GL's order and orientation."""
    size = sky.faces.shape[1]
    linear = _decoded(sky.faces)
    cube = context.texture_cube((size, size), 3, linear, dtype="f4", internal_format=gl.RGB9_E5)
    cube.build_mipmaps()
    cube.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    return cube


def _decoded(pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    """(..., 4) sRGB to (..., 3) linear light."""
    texels = pixels.reshape(-1, 4)
    linear = np.empty((len(texels), 3), np.float32)
    for start in range(0, len(texels), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        linear[part] = BYTE_TO_LINEAR.take(texels[part, :3])
    return linear.reshape(*pixels.shape[:-1], 3)
