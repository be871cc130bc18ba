"""GLFW's mouse pointer, which ImGui can neither hide nor free of the screen's edge."""

import ctypes
import sys
from pathlib import Path

import imgui_bundle
from imgui_bundle import hello_imgui, imgui

_LIBRARY = {"darwin": "libglfw.3.dylib", "win32": "glfw3.dll"}.get(sys.platform, "libglfw.so.3")
_CURSOR, _CURSOR_NORMAL, _CURSOR_DISABLED = 0x33001, 0x34001, 0x34003  # names as in glfw3.h


class Pointer:
    """Caught, it is hidden and moves without end, and nothing under it is hovered."""

    def __init__(self) -> None:
        # The library that ImGui's own module has loaded, so that they share its state.
        glfw = ctypes.CDLL(str(Path(imgui_bundle.__file__).parent / _LIBRARY))
        self._set_input_mode = glfw.glfwSetInputMode
        self._set_input_mode.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_int]
        self._caught_at: imgui.ImVec2 | None = None

    def catch(self, *, is_caught: bool) -> None:
        """Catch it, or let it go where it was caught; nothing happens if that is so already."""
        if is_caught == (self._caught_at is not None):
            return
        io = imgui.get_io()
        mode = _CURSOR_DISABLED if is_caught else _CURSOR_NORMAL
        window = hello_imgui.get_glfw_window_address()  # type: ignore[attr-defined]  # not in its stubs
        self._set_input_mode(window, _CURSOR, mode)
        if self._caught_at is None:
            io.config_flags |= imgui.ConfigFlags_.no_mouse
            self._caught_at = imgui.ImVec2(*io.mouse_pos)
        else:
            io.config_flags &= ~imgui.ConfigFlags_.no_mouse
            io.add_mouse_pos_event(*self._caught_at)  # GLFW tells only of the next motion
            self._caught_at = None
