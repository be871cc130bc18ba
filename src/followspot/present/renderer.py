"""Pictures of a scene as NumPy arrays: the Python API, and what every command draws with."""

from collections.abc import Iterable
from dataclasses import replace
from types import TracebackType
from typing import Any, Self, TypeVar

import moderngl
import msgspec
import numpy as np
from numpy.typing import NDArray

from followspot.errors import UsageError
from followspot.gpu.context import create_context, is_software
from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.program import ShaderError
from followspot.gpu.targets import Part, Target
from followspot.gpu.timers import PassTimers
from followspot.passes.frame import PASSES, FrameInput, FramePipeline, FrameReport
from followspot.passes.overlay import Overlay
from followspot.passes.shadow_preview import ShadowPreview
from followspot.passes.shadow_reading import read_cube, read_distance
from followspot.passes.view import View
from followspot.present.exposure import automatic
from followspot.scene.camera import Camera
from followspot.scene.light import CubeSide
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings

Pictures = dict[str, NDArray[Any]]
"""By view; a view's value is as good a key: ``pictures["final"]``."""

Choice = TypeVar("Choice", View, Overlay)


class Renderer:
    """Draws one scene at a time, without a window or for one.

    Use it as a context manager, or call `close`. It belongs to the thread that made it.

    Args:
        size: (width, height) of pictures in pixels.
        context: An OpenGL context to draw in, a window's, which stays open; by default one of its
            own.

    Raises:
        ContextError: no OpenGL context can be had.
        UsageError: the size is not one that can be drawn; by methods, the renderer is closed.
    """

    def __init__(
        self, size: tuple[int, int] = (640, 480), context: moderngl.Context | None = None
    ) -> None:
        self._context = create_context() if context is None else context
        self._is_lent = context is not None
        self._is_closed = False
        try:
            self.size = self._checked(size)
        except UsageError:
            self._release_context()
            raise
        self._targets: dict[bool, Target] = {}
        self._gpu_scene: GpuScene | None = None
        self._pipeline: FramePipeline | None = None
        self._previews: dict[int, ShadowPreview] = {}
        self._timers: PassTimers | None = None

    @property
    def gl_renderer(self) -> str:
        """What draws, as GL tells it."""
        self._make_current()
        return str(self._context.info["GL_RENDERER"])

    @property
    def pipeline(self) -> FramePipeline:
        """The passes of the scene that is open."""
        assert self._pipeline is not None, "open a scene first"
        return self._pipeline

    def _make_current(self) -> None:
        """Point GL at this renderer's context: there may be several, used in turn."""
        if self._is_closed:
            raise UsageError("the renderer is closed: expected an open one to draw with")
        self._context.__enter__()  # type: ignore[no-untyped-call]  # moderngl's exit would leave another one, or none, current

    def open(self, scene: Scene) -> GpuScene:
        """Upload a scene, in place of the one before. `render` does so by itself.

        Raises:
            AssetError: a figure of it is too large for this OpenGL.
        """
        now = self._gpu_scene
        if now is not None and all(
            getattr(now.scene, part) is getattr(scene, part)
            for part in ("level", "sky", "clouds", "crowd")
        ):
            return now
        self._drop_scene()
        self._make_current()
        opened = GpuScene(self._context, scene)
        try:
            self._pipeline = FramePipeline(self._context, opened)
        except ShaderError:  # somebody is editing one: nothing is open then
            opened.release()
            raise
        self._gpu_scene = opened
        return opened

    def render(
        self,
        scene: Scene,
        camera: Camera | str | None = None,
        views: Iterable[View | str] = (View.FINAL,),
        *,
        settings: Settings | None = None,
        time: float = 0.0,
        linear: bool = False,
        overlays: Iterable[Overlay | str] = (),
        culled_from: Camera | str | None = None,
    ) -> Pictures:
        """Take pictures of several stages from one place.

        Args:
            scene: What to draw; opened if it is not the one drawn last.
            camera: A camera, the name of one of the scene's, or none for where the scene starts.
            views: Stages, as `View` or by its value: ``"normals"``; one alone will do.
            settings: In place of the scene's own.
            time: Seconds since the start, by which characters and surfaces move.
            linear: Whether values come as they are instead of as displayed.
            overlays: What to draw over displayed pictures, as `Overlay` or by value: ``"boxes"``.
            culled_from: Another camera, which decides what is drawn and what shadow maps cover.

        Returns:
            For each view an array with the top row first. Displayed: (h, w, 3) uint8. Linear:
            float32, (h, w, 3) radiance in W/(m^2 sr), or the stage's own values; ``shadow``,
            ``depth`` and ``shadow-map`` are (h, w). The shadow map has its own size.

        Raises:
            UsageError: no such camera, view or overlay, an overlay that cannot be drawn here, or
                too many lights.
        """
        camera = scene.camera(camera) if not isinstance(camera, Camera) else camera
        settings = scene.settings if settings is None else settings
        wanted = [named(View, view) for view in ([views] if isinstance(views, str) else views)]
        shown = frozenset(named(Overlay, overlay) for overlay in overlays)
        if isinstance(culled_from, str):
            culled_from = scene.camera(culled_from)
        if shown and linear:
            raise UsageError("overlays are drawn in displayed colours, not over float values")
        if Overlay.CAMERA_FRUSTUM in shown and culled_from is None:
            raise UsageError("camera-frustum needs a camera to cull from other than the picture's")
        frame = FrameInput(
            scene, camera, settings, 1.0, time=time, overlays=shown, culled_from=culled_from
        )
        self.open(scene)
        by_exposure = settings.emission is None and any(m.shines for m in scene.worn)
        metered = {
            view.metered
            for view in wanted
            if view.is_light and (not linear or (view is View.FINAL and by_exposure))
        }
        exposures = {view: self.exposure(scene, camera, settings, view, time) for view in metered}
        self._make_current()
        return {
            view: self._picture(
                replace(frame, view=view, exposure=exposures.get(view.metered, 1.0)), linear
            )
            for view in wanted
        }

    def _picture(self, frame: FrameInput, linear: bool) -> NDArray[Any]:
        if frame.view is View.SHADOW_MAP:
            frame = replace(frame, view=View.SHADOW, overlays=frozenset())
            return self._shadow_map(frame, linear)
        self.draw(frame, linear)
        values = self._targets[linear].read()
        is_scalar = linear and frame.view in (View.SHADOW, View.DEPTH)
        return values[..., 0] if is_scalar else values

    def draw(
        self, frame: FrameInput, linear: bool = False, part: Part | None = None
    ) -> FrameReport:
        """Draw one frame of the open scene, or a part of it, without reading it back."""
        self._make_current()
        pipeline = self.pipeline
        target = self.target(linear)
        pipeline.prepare(frame, target)
        return pipeline.draw(frame, target, part=part)

    def target(self, linear: bool = False) -> Target:
        """What `draw` draws into, for those who read it in a way of their own."""
        if linear not in self._targets:
            self._make_current()
            self._targets[linear] = Target(self._context, self.size, is_linear=linear)
        return self._targets[linear]

    def pass_times(self, frame: FrameInput) -> dict[str, float]:
        """Draw one frame of the open scene and tell each pass's GPU time in ms.

        Draw one like it before, at another time: drivers compile in the first, and characters that
        stand as they did are neither posed nor cast anew.
        """
        self._make_current()
        pipeline = self.pipeline
        target = self.target()
        pipeline.prepare(frame, target)
        if self._timers is None:
            waits = is_software(self.gl_renderer)
            self._timers = PassTimers(self._context, PASSES, waits=waits)
        pipeline.draw(frame, target, self._timers)
        return self._timers.read_ms()

    def resize(self, size: tuple[int, int]) -> None:
        """Draw pictures of another size from now on.

        Raises:
            UsageError: the size is not one that can be drawn.
        """
        size = self._checked(size)
        if size != self.size:
            self.size = size
            self._drop_targets()

    def _checked(self, size: tuple[int, int]) -> tuple[int, int]:
        self._make_current()
        limit = min(self._context.info["GL_MAX_RENDERBUFFER_SIZE"], 16384)
        edges = [edge for edge in size if isinstance(edge, int | np.integer) and 1 <= edge <= limit]
        if len(edges) != 2 or len(size) != 2:
            shown, expected = "x".join(map(str, size)), f"1 to {limit}, in whole pixels"
            raise UsageError(f"a size of {shown} cannot be drawn; edges are {expected}")
        return int(edges[0]), int(edges[1])

    def finish(self) -> None:
        """Wait until the GPU has done everything."""
        self._make_current()
        self._context.finish()

    def _shadow_map(self, frame: FrameInput, linear: bool) -> NDArray[Any]:
        if not frame.shadowed:
            raise UsageError("there is no shadow map: no light casts shadows here")
        self.draw(frame)
        shadow, is_cube = self.pipeline.shadow, isinstance(frame.shadowed[0], CubeSide)
        distance = read_cube(shadow) if is_cube else read_distance(shadow, 0)
        return distance if linear else _stretched(distance)

    def shadow_map_texture(self, number: int = 0) -> moderngl.Texture | None:
        """A light's shadow map as the last frame left it, as greys in a texture, top row first.

        Args:
            number: Of the light, among those with a shadow map.

        Returns:
            The same texture every time while maps keep their size; none if there is no such map.
        """
        self._make_current()
        shadow = self.pipeline.shadow
        if not shadow.tiles_of(number):
            return None
        if number not in self._previews:
            self._previews[number] = ShadowPreview(self._context)
        return self._previews[number].draw(shadow, number)

    def exposure(
        self,
        scene: Scene,
        camera: Camera,
        settings: Settings | None = None,
        view: View = View.FINAL,
        time: float = 0.0,
    ) -> float:
        """The display value per radiance: the settings' own, or one that suits a view.

        What shows as it is painted by any exposure does not count.
        """
        settings = scene.settings if settings is None else settings
        if settings.exposure is not None:
            return settings.exposure
        self.open(scene)
        if settings.emission is None:
            settings = msgspec.structs.replace(settings, emission=0.0)
        self.draw(FrameInput(scene, camera, settings, 1.0, view, time), linear=True)
        return automatic(self._targets[True].read(components=4))

    def close(self) -> None:
        """Give back everything on the GPU; a second time, nothing."""
        if self._is_closed:
            return
        self._drop_scene()
        self._drop_targets()
        self._is_closed = True
        self._release_context()

    def _release_context(self) -> None:
        if not self._is_lent:
            self._context.release()

    def _drop_targets(self) -> None:
        self._make_current()
        for target in self._targets.values():
            target.release()
        self._targets.clear()

    def _drop_scene(self) -> None:
        self._make_current()
        for preview in self._previews.values():
            preview.release()
        self._previews.clear()
        if self._pipeline is not None:
            self._pipeline.release()
        if self._gpu_scene is not None:
            self._gpu_scene.release()
        self._pipeline = self._gpu_scene = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self.close()


def named(kind: type[Choice], value: str) -> Choice:
    """A view or overlay by its value.

    Raises:
        UsageError: there is none; lists those that exist.
    """
    try:
        return kind(value)
    except ValueError:
        names = ", ".join(one.value for one in kind)
        raise UsageError(
            f"no {kind.__name__.lower()} is named {value!r}; there are {names}"
        ) from None


def _stretched(distance: NDArray[np.float32]) -> NDArray[np.uint8]:
    """(h, w, 3) greys from near, dark, to far, light; white where there is nothing."""
    hit = np.isfinite(distance)
    nearest, farthest = (distance[hit].min(), distance[hit].max()) if hit.any() else (0, 1)
    share = np.where(hit, distance - nearest, 0) / max(farthest - nearest, 1e-6)
    grey = np.where(hit, 0.05 + 0.85 * share, 1)
    return np.repeat((grey * 255).astype(np.uint8)[..., np.newaxis], 3, axis=2)
