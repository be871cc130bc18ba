"""Images as textures that filter linear light; those of clouds, what is displayed.

What needs no alpha is decoded here, once, into GL_RGB9_E5: nine bits a channel below an exponent
that they share (EXT_texture_shared_exponent), in the four bytes that sRGB takes, too. The brightest
channel is kept to 0.2 %, finer than a step of 8-bit sRGB, the others to as much of the brightest
one. A software rasteriser decodes it much faster than the sRGB curve, for eight texels a pixel.

OpenGL makes the MIP levels of those. The bytes of the others are averaged here: llvmpipe would
compile a program for it, which took 0.1 s of every start.
"""

from collections.abc import Iterator

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.assets.image import BYTE_TO_LINEAR
from followspot.gpu import gl, mip_levels
from followspot.gpu.targets import Part
from followspot.scene.sky import CubeMap

_AT_ONCE = 1 << 15
"""Texels that are decoded at once: as floats, and as NumPy's indices, they take far more room."""


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
        gl.write_levels(context, texture, gl.SRGB8_ALPHA8, mip_levels.of_srgb(pixels))
    else:
        texture = context.texture(size, 3, dtype="f4", internal_format=gl.RGB9_E5)
        for part, linear in _decoded(pixels):
            texture.write(linear, part)
        texture.build_mipmaps()
    texture.repeat_x = texture.repeat_y = not clamps
    texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    return texture


def upload_shown(context: moderngl.Context, pixels: NDArray[np.uint8]) -> moderngl.Texture:
    """A trilinear texture that repeats, of (h, w, 4) bytes that are read as they are, over 255."""
    texture = context.texture(pixels.shape[1::-1], 4, pixels)
    gl.write_levels(context, texture, gl.RGBA8, mip_levels.of_bytes(pixels))
    texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    return texture


def upload_lightmaps(context: moderngl.Context, luxels: NDArray[np.float32]) -> moderngl.Texture:
    """(h, w, 3) linear light; without MIP levels, in which faces would run into each other."""
    size = luxels.shape[1::-1]
    texture = context.texture(size, 3, luxels, dtype="f4", internal_format=gl.RGB9_E5)
    texture.filter = moderngl.LINEAR, moderngl.LINEAR
    return texture


def upload_cube(context: moderngl.Context, sky: CubeMap) -> moderngl.TextureCube:
    """The sky's faces, already in GL's order and orientation."""
    size = sky.faces.shape[1]
    cube = context.texture_cube((size, size), 3, dtype="f4", internal_format=gl.RGB9_E5)
    for number, face in enumerate(sky.faces):
        for part, linear in _decoded(face):
            cube.write(number, linear, part)
    cube.build_mipmaps()
    cube.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    return cube


def _decoded(pixels: NDArray[np.uint8]) -> Iterator[tuple[Part, NDArray[np.float32]]]:
    """(h, w, 4) sRGB as (rows, w, 3) linear light, piece by piece, with where each belongs."""
    height, width = pixels.shape[:2]
    rows = max(_AT_ONCE // width, 1)
    for top in range(0, height, rows):
        piece = pixels[top : top + rows, :, :3]
        yield (0, top, width, len(piece)), BYTE_TO_LINEAR.take(piece)
