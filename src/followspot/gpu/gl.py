"""What of OpenGL moderngl has no names for, under the names of its specification."""

import ctypes
from collections.abc import Callable, Iterable

import moderngl
import numpy as np
from numpy.typing import NDArray

SRC_ALPHA_SATURATE = 0x0308
LINE_SMOOTH = 0x0B20
TEXTURE_2D = 0x0DE1
UNSIGNED_BYTE = 0x1401
RGBA = 0x1908
RGBA8 = 0x8058
DEPTH_CLAMP = 0x864F
TEXTURE_CUBE_MAP_SEAMLESS = 0x884F
RGB9_E5 = 0x8C3D
SRGB8_ALPHA8 = 0x8C43
SRC1_COLOR = 0x88F9
ONE_MINUS_SRC1_COLOR = 0x88FA
FRAMEBUFFER_SRGB = 0x8DB9


def flush_function(context: moderngl.Context) -> Callable[[], None]:
    """A context's glFlush: what has been drawn so far is begun with now.

    moderngl has no name for it.
    """
    return ctypes.CFUNCTYPE(None)(_address(context, "glFlush"))


def write_levels(
    context: moderngl.Context,
    texture: moderngl.Texture,
    internal_format: int,
    levels: Iterable[NDArray[np.uint8]],
) -> None:
    """Give a texture all MIP levels below its largest one, each (h, w, 4), the larger ones first.

    moderngl writes only into levels that glGenerateMipmap has made.
    """
    enum, integer = ctypes.c_uint, ctypes.c_int
    kinds = (enum, *[integer] * 5, enum, enum, ctypes.c_void_p)
    tex_image = ctypes.CFUNCTYPE(None, *kinds)(_address(context, "glTexImage2D"))
    texture.use(context.max_texture_units - 1)  # moderngl, too, binds there what it writes to
    for number, level in enumerate(levels, 1):
        height, width = level.shape[:2]
        texels = np.ascontiguousarray(level)
        what = RGBA, UNSIGNED_BYTE, texels.ctypes.data
        tex_image(TEXTURE_2D, number, internal_format, width, height, 0, *what)


def _address(context: moderngl.Context, name: str) -> int:
    """Where one of OpenGL's functions is.

    moderngl gives its loader of functions to nobody. Made by hand, a loader would have to be handed
    to moderngl with each of the ways to a context.
    """
    address: int = context.mglo._context.load(name)
    return address
