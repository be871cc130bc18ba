"""Shaders compiled anew when their files change, and what is wrong with them told over the picture.

What compiled last stays in use until they compile again.
"""

import time

from imgui_bundle import imgui

from followspot.gpu.program import ShaderError
from followspot.passes.frame import FramePipeline

INTERVAL = 0.25
"""Seconds between two looks at the files' times."""

_RED, _WHITE = imgui.ImVec4(0.55, 0.06, 0.06, 0.95), imgui.ImVec4(1, 1, 1, 1)
_WIDTH = 0.4
"""Of the window, in its middle, where no panel is at first."""


class Reloader:
    """Looks after the shaders of whatever pipeline there is.

    Attributes:
        error: What is wrong with their files as they are; none if that is nothing.
    """

    def __init__(self) -> None:
        self.error: ShaderError | None = None
        self._looked = time.perf_counter()

    def look(self, pipeline: FramePipeline, *, at_once: bool = False) -> None:
        """Have changed shaders compiled, now and then or `at_once`. Not inside a frame."""
        now = time.perf_counter()
        if now < self._looked + INTERVAL and not at_once:
            return
        self._looked = now
        if pipeline.shaders_changed():
            self.error = pipeline.reload()

    def show(self) -> None:
        """Draw the error, if there is one: file, line, and what the driver says."""
        if self.error is None:
            return
        across, _ = imgui.get_io().display_size
        width = across * _WIDTH
        imgui.set_next_window_pos(((across - width) / 2, 30))
        imgui.set_next_window_size((width, 0))
        imgui.push_style_color(imgui.Col_.window_bg, _RED)
        imgui.push_style_color(imgui.Col_.text, _WHITE)
        flags = imgui.WindowFlags_
        imgui.begin(
            "##shader error",
            None,
            flags.no_decoration | flags.no_docking | flags.no_move | flags.no_saved_settings
            | flags.no_focus_on_appearing | flags.no_nav,
        )  # fmt: skip
        where = self.error.file
        where += "" if self.error.line is None else f", line {self.error.line}"
        imgui.text_wrapped(f"{where} (what compiled last stays in use)")
        imgui.separator()
        imgui.text_wrapped(self.error.message)
        imgui.end()
        imgui.pop_style_color(2)
