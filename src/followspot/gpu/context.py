"""One OpenGL 3.3 core context: without a window, or the one of a window."""

import ctypes
import os
import sys
from typing import Any

import moderngl

from followspot.errors import ContextError

REQUIRED_VERSION = 330

HEADLESS_PACKAGES = "libegl1 libgl1 libglx-mesa0 libgl1-mesa-dri"
"""Debian's names for a software OpenGL that needs neither GPU nor display."""

# The names that run-time packages install; libEGL.so and libGL.so come with compilers' headers.
_EGL, _GL, _X11 = "libEGL.so.1", "libGL.so.1", "libX11.so.6"


def backends() -> dict[str, dict[str, Any]]:
    """Ways to a context, by name, the best first.

    EGL needs no display; it lists GPUs first and Mesa's software last, which is the order here
    too. Where it lists none, the attempt at device 0 tells why. GLX needs a display and comes last.

    Returns:
        Arguments of moderngl.create_standalone_context for each.
    """
    if not sys.platform.startswith("linux"):
        return {"the system's own": {}}
    chosen = os.environ.get("GLCONTEXT_DEVICE_INDEX", "")  # glcontext obeys it before an argument
    indices = [int(chosen)] if chosen.isdecimal() else range(max(1, _egl_devices()))
    egl = {"backend": "egl", "libegl": _EGL, "libgl": _GL}
    ways = {f"EGL device {i}": {**egl, "device_index": i} for i in indices}
    if display := os.environ.get("DISPLAY"):
        ways[f"GLX on display {display}"] = {"libgl": _GL, "libx11": _X11}
    return ways


def _egl_devices() -> int:
    """How many devices EGL lists (EGL_EXT_device_enumeration); 0 where it is not installed."""
    try:
        egl = ctypes.CDLL(_EGL)
    except OSError:
        return 0
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    address = egl.eglGetProcAddress(b"eglQueryDevicesEXT")
    query = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
    count = ctypes.c_int(0)
    return count.value if address and query(address)(0, None, ctypes.byref(count)) else 0


def create_context() -> moderngl.Context:
    """The first context that can be had, made current in this thread.

    Raises:
        ContextError: none can; says what to install and names ``followspot doctor``.
    """
    reasons = []
    for way, arguments in backends().items():
        try:
            context = moderngl.create_standalone_context(require=REQUIRED_VERSION, **arguments)
        except Exception as error:  # glcontext raises bare Exception for every cause
            reasons.append(f"{way}: {error}")
            continue
        return context
    raise ContextError(
        "no OpenGL 3.3 context can be had here (" + "; ".join(reasons) + "). "
        f"On Debian, install a software one: apt-get install {HEADLESS_PACKAGES}. "
        "`followspot doctor` tries each way and tells more."
    )


def has_display() -> bool:
    """Whether a window can be opened here. Only X11 is asked; other systems have a display."""
    if not sys.platform.startswith("linux"):
        return True
    try:
        x11 = ctypes.CDLL(_X11)
    except OSError:
        return False
    x11.XOpenDisplay.restype = ctypes.c_void_p
    display = x11.XOpenDisplay(None)
    if display:
        x11.XCloseDisplay(ctypes.c_void_p(display))
    return bool(display)


def window_context() -> moderngl.Context:
    """The context that a window library has made current in this thread.

    Raises:
        ContextError: it is older than OpenGL 3.3.
    """
    libraries: dict[str, Any] = {}
    if sys.platform.startswith("linux"):
        libraries = {"libgl": _GL, "libx11": _X11}
    try:
        return moderngl.create_context(require=REQUIRED_VERSION, **libraries)
    except Exception as error:  # as in create_context
        raise ContextError(f"the window has no OpenGL 3.3: {error}") from None


def is_software(renderer: str) -> bool:
    """Whether a GL_RENDERER string names a rasteriser that runs on the CPU."""
    names = ("llvmpipe", "lavapipe", "softpipe", "swrast", "software", "swiftshader")
    return any(name in renderer.lower() for name in names)
