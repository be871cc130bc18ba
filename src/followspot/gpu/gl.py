"""What of OpenGL moderngl has no names for, under the names of its specification."""

import ctypes
from collections.abc import Callable

import moderngl

SRC_ALPHA_SATURATE = 0x0308
LINE_SMOOTH = 0x0B20
DEPTH_CLAMP = 0x864F
TEXTURE_CUBE_MAP_SEAMLESS = 0x884F
RGB9_E5 = 0x8C3D
SRGB8_ALPHA8 = 0x8C43
SRC1_COLOR = 0x88F9
ONE_MINUS_SRC1_COLOR = 0x88FA
FRAMEBUFFER_SRGB = 0x8DB9


def flush_function(context: moderngl.Context) -> Callable[[], None]:
    """A context's glFlush: what has been drawn so far is begun with now.

    moderngl has no name for it, and gives its loader of functions to nobody. Made by hand, a loader
    would have to be handed to moderngl with each of the ways to a context.
    """
    address = context.mglo._context.load("glFlush")
    return ctypes.CFUNCTYPE(None)(address)
