"""One OpenGL 3.3 core context without a window."""

import sys

import moderngl

from followspot.errors import ContextError

REQUIRED_VERSION = 330

HEADLESS_PACKAGES = "libegl1 libgl1 libglx-mesa0 libgl1-mesa-dri"
"""Debian's names for a software OpenGL that needs neither GPU nor display."""


def backends() -> tuple[dict[str, str], ...]:
    """Arguments of moderngl.create_standalone_context to try, the best first."""
    if sys.platform.startswith("linux"):
        egl = {"backend": "egl"}
        mesa = {"backend": "egl", "libgl": "libGL.so.1", "libegl": "libEGL.so.1"}
        return egl, mesa, {}
    return ({},)


def create_context() -> moderngl.Context:
    """The first context that can be had, made current in this thread.

    Raises:
        ContextError: none can; says what to install and names ``followspot doctor``.
    """
    reasons = []
    for arguments in backends():
        try:
            context = moderngl.create_standalone_context(require=REQUIRED_VERSION, **arguments)
        except Exception as error:  # glcontext raises bare Exception for every cause
            reasons.append(f"{arguments.get('backend', 'default')}: {error}")
            continue
        context.gc_mode = None
        return context
    raise ContextError(
        "no OpenGL 3.3 context can be had here (" + "; ".join(dict.fromkeys(reasons)) + "). "
        f"On Debian, install a software one: apt-get install {HEADLESS_PACKAGES}. "
        "`followspot doctor` tries each way and tells more."
    )
