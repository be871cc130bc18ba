"""The window: ImGui's loop, and in it controls, picture and panels, in this order."""

import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from functools import lru_cache

from imgui_bundle import hello_imgui, imgui, implot
from imgui_bundle.imguizmo import im_guizmo

from followspot.assets.archive import Archive
from followspot.assets.locate import list_levels
from followspot.errors import ContextError, FollowspotError
from followspot.gpu.context import has_display, is_software, window_context
from followspot.gpu.program import ShaderError
from followspot.gpu.timers import FrameTimer
from followspot.present import arguments
from followspot.present.interrupt import Interrupt
from followspot.present.renderer import Renderer
from followspot.present.still import Wish, open_any, open_scene, require_drawable
from followspot.present.viewer import canvas, controls, handles, layout
from followspot.present.viewer.history import History
from followspot.present.viewer.inspection import Inspector
from followspot.present.viewer.layout import Panel
from followspot.present.viewer.pointer import Pointer
from followspot.present.viewer.recording import Recorder
from followspot.present.viewer.reloading import Reloader
from followspot.present.viewer.state import Lamp, Mouse, Seen, State
from followspot.present.viewer.walking import Walking
from followspot.scene import bounce
from followspot.scene.search import builtin_scenes


def run(name: str, wish: Wish) -> None:
    """Open a window on a scene and fly through it until it is closed.

    Raises:
        AssetError: the scene cannot be opened.
        ContextError: no window can be opened.
        UsageError: something in the wish makes no sense.
    """
    if not has_display():
        raise ContextError(
            "there is no display to open a window on; `followspot render` and `followspot film` "
            "draw without one"
        )
    Viewer(start(name, wish), arguments.parse_size(wish.size)).run()


def start(name: str, wish: Wish) -> State:
    """The state that a wish asks for; its scene is as its file says."""
    plain = replace(wish, settings=(), albedo=None, shadows=True, sky_light=True)
    scene, camera = open_any(name, replace(plain, lights=()))
    settings = arguments.parse_settings(
        scene, wish.settings, albedo=wish.albedo, shadows=wish.shadows, sky_light=wish.sky_light
    )
    state = State.of(replace(scene, settings=settings), camera)
    lights = [arguments.parse_light(text) for text in wish.lights]
    lit = scene.with_lights(*lights) if lights else scene
    require_drawable(lit, wish)
    if wish.bake:
        scene = replace(scene, level=bounce.bake(replace(lit, settings=settings)).level)
    return replace(
        state,
        scene=scene,
        lamps=tuple(Lamp(light) for light in lights) or state.lamps,
        assets=tuple(wish.assets),
        time=wish.time,
        items=wish.items,
        animation=wish.animation,
    )


class Viewer:
    """One window.

    Attributes:
        state: What a person has chosen so far.
        params: Hello ImGui's; its ``app_shall_exit`` ends the loop.
        renderer: Draws in the window's context, while there is one.
        on_frame: Called at the end of each frame, before that is shown.

    Args:
        state: What it starts with.
        size: (width, height) of the window.
    """

    renderer: Renderer

    def __init__(self, state: State, size: tuple[int, int]) -> None:
        self.state = state
        self.on_frame: Callable[[], None] = lambda: None
        self._size = size
        self.params = layout.runner_params(size, self._show_panel)
        self._history = History()
        self._walking = Walking()
        self._recorder = Recorder()
        self._reloader = Reloader()
        self._drawn: State | None = None
        self._seen: Seen | None = None
        self._opening: str | None = None
        self._failure: Exception | None = None
        self._began = self._ended = time.perf_counter()

    def run(self) -> None:
        """Show the window until it is closed.

        Raises:
            AssetError, ShaderError, UsageError: what it starts with cannot be drawn.
            ContextError: no window can be opened.
        """
        calls = self.params.callbacks
        calls.pre_new_frame = self._begin
        calls.custom_background = self._draw
        calls.show_gui = self._show_handles
        calls.show_status = self._show_status
        calls.before_swap = self._end
        calls.after_swap = self._after_frame
        try:
            hello_imgui.manual_render.setup_from_runner_params(self.params)
        except RuntimeError as error:
            raise ContextError(f"no window can be opened: {error}") from None
        # An exception that a signal raises within ImGui's frame would be buried, too.
        with Interrupt() as interrupt, ExitStack() as to_close:  # all, even if some of it fails
            to_close.callback(hello_imgui.manual_render.tear_down)
            implot.create_context()
            to_close.callback(implot.destroy_context)
            context = window_context()
            to_close.callback(context.release)
            self.renderer = to_close.enter_context(Renderer(self._size, context))
            self._pointer = Pointer()
            self._inspector = Inspector(context)
            to_close.callback(self._inspector.release)
            to_close.callback(self._recorder.close)
            self._timer = FrameTimer(context, waits=is_software(self.renderer.gl_renderer))
            while not self.params.app_shall_exit and not interrupt.count:
                hello_imgui.manual_render.render()
        if self._failure is not None:
            raise self._failure
        interrupt.again()

    def _begin(self) -> None:
        layout.show_bars(self.params, are_shown=self.state.panels)
        self.params.fps_idling.fps_max = self.state.frame_rate_limit

    def _draw(self) -> None:
        """Apply keys and mouse, and draw what comes of it behind all panels."""
        self._began = time.perf_counter()
        im_guizmo.begin_frame()
        size = _framebuffer_size()
        is_minimised = min(size) < 1
        passed = imgui.get_io().delta_time
        seconds = 0.0 if is_minimised else self.state.recording.seconds(passed)
        self.state = controls.apply(self.state, seconds, self._walking)
        self._pointer.catch(is_caught=self.state.mouse is not Mouse.POINTS)
        if is_minimised:
            return
        self.renderer.resize(size)
        try:
            self.state = canvas.prepared(self.renderer, self.state)
            self._reloader.look(self.renderer.pipeline)
            self._inspector.before(self.renderer, self.state)
            with self._timer.frame():
                report = canvas.draw(self.renderer, self.state)
            found = self._inspector.after(self.renderer, self.state)
            self.state = replace(self.state, asked=self.state.asked.standing)
        except (FollowspotError, ShaderError) as error:  # go back to what could be drawn
            if self._drawn is None:  # raised within ImGui's frame, it would be buried
                self._failure = error
                self.params.app_shall_exit = True
                return
            if isinstance(error, ShaderError):
                self._reloader.error = error
            if self._seen is not None:  # shadow maps may have gone with the scene that was open
                found = replace(self._seen.found, key_maps=(), shadow_map=None)
                self._seen = replace(self._seen, found=found)
            told = str(error).partition("\n")[0]
            self.state = replace(self._drawn, wanted=None, notice=told)
            return
        self.state = self._recorder.record(self.renderer, self.state, seconds, passed)
        self._drawn = self.state
        self.renderer.target().show()
        levels = _levels(self.state.scene.archive)
        recorded = self._recorder.line()
        self._seen = Seen(size, report, self._history, recorded, levels, found)

    def _show_handles(self) -> None:
        self._reloader.show()
        if self._seen is not None:
            self.state = handles.show(self.state, self._seen)

    def _show_panel(self, panel: Panel) -> None:
        if self._seen is None or not self.state.panels:
            return
        window = self.params.docking_params.dockable_window_of_name(panel.name)
        is_unfolded, is_open = imgui.begin(panel.name, True)
        window.is_visible = bool(is_open)
        if is_unfolded:
            self.state = panel.show(self.state, self._seen)
        imgui.end()

    def _show_status(self) -> None:
        recorded = self._seen.recorded if self._seen is not None else ""
        texts = (f"{self.state.flight.speed:.0f} units/s", recorded, self.state.notice)
        imgui.text("    ".join(text for text in texts if text))

    def _end(self) -> None:
        now = time.perf_counter()
        if self._seen is not None:
            whole_ms, work_ms = ((now - since) * 1e3 for since in (self._ended, self._began))
            cpu_ms = work_ms - self._timer.waited_ms
            submit_ms = self._seen.report.submit_ms
            self._history.add(whole_ms, cpu_ms, submit_ms, self._timer.ms)
        self._ended = now
        self.on_frame()

    def _after_frame(self) -> None:
        if self._drawn is not None and self.state.recording.shot is not None:
            self.state = self._recorder.shoot(self.renderer, self.state)
        self._open_wanted()

    def _open_wanted(self) -> None:
        """Open what the state wants, a frame after that has been announced."""
        name = self.state.wanted
        if name is None or name != self._opening:
            self._opening = name
            notice = self.state.notice if name is None else f"Opening {name} ..."
            self.state = replace(self.state, notice=notice)
            return
        self._reloader.look(self.renderer.pipeline, at_once=True)
        if self._reloader.error is not None:  # nothing of another level has been compiled yet
            told = "No other scene can be opened while shaders do not compile."
            self.state = replace(self.state, wanted=None, notice=told)
            return
        try:
            scene, _ = open_scene(name, Wish(assets=self.state.assets))
            self.state = self.state.opened(scene)
            self._walking = Walking()
        except FollowspotError as error:
            self.state = replace(self.state, wanted=None, notice=str(error))


@lru_cache(maxsize=1)
def _levels(archive: Archive) -> tuple[str, ...]:
    """All that can be opened by name, where the present scene has been found."""
    return tuple(sorted({*builtin_scenes(), *list_levels(archive)}))


def _framebuffer_size() -> tuple[int, int]:
    """(width, height) of the window in pixels."""
    io = imgui.get_io()
    across, up = io.display_framebuffer_scale
    width, height = io.display_size
    return round(width * across), round(height * up)
