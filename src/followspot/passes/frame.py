"""The whole frame, in order."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path

import moderngl
import numpy as np

from followspot.errors import UsageError
from followspot.gpu import blocks, gl
from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.program import SHADERS, ShaderError, ShaderFolder
from followspot.gpu.targets import Part, Target, encode_srgb
from followspot.passes import lighting, programs, shadow_tiles
from followspot.passes.characters import CharacterPass
from followspot.passes.drawlist import NOTHING
from followspot.passes.fog import NO_FOG, LitFog
from followspot.passes.overlay import Overlay, OverlayPass
from followspot.passes.programs import SHADOW_ATLAS, Shader
from followspot.passes.shadow import ShadowPass
from followspot.passes.sky import SkyPass
from followspot.passes.surfaces import SurfacePass
from followspot.passes.view import View
from followspot.passes.visible import VisibleFaces
from followspot.scene.camera import Camera
from followspot.scene.light import Light, SpotLight
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.spaces import Mat4

PASSES = ("shadow", "clear", "surfaces", "characters", "sky", "blended", "overlay")
LONGEST = 1e9
"""Seconds of a frame's time at most, either way."""

TimedPass = Callable[[str], AbstractContextManager[object]]


def _untimed(_: str) -> AbstractContextManager[object]:
    return nullcontext()


@dataclass(frozen=True, eq=False)
class FrameInput:
    """All that a frame depends on beside the level in GPU memory.

    Attributes:
        scene: Its level is the one in GPU memory; lights, units and the sky's strength are read
            here.
        camera: Where the picture is taken from.
        settings: The switches.
        exposure: Display value per radiance.
        view: The stage to draw.
        time: Seconds, by which characters and surfaces move.
        overlays: What is drawn over the picture, where that is displayed.
        culled_from: A camera that decides in place of `camera` what is drawn and what shadow maps
            cover, so that one can fly on and see what is left out.
        lights: The scene's, in the order of `lighting.in_order`.
        shadowed: What its shadow maps look into; see `lighting.shadowed`.

    Raises:
        UsageError: there are more lights than a frame holds, or no such time.
    """

    scene: Scene
    camera: Camera
    settings: Settings
    exposure: float
    view: View = View.FINAL
    time: float = 0.0
    overlays: frozenset[Overlay] = frozenset()
    culled_from: Camera | None = None
    lights: tuple[Light, ...] = field(init=False)
    shadowed: tuple[SpotLight, ...] = field(init=False)

    def __post_init__(self) -> None:
        if not abs(self.time) <= LONGEST:
            raise UsageError(f"expected a time of at most {LONGEST:,.0f} s, found {self.time}")
        lights = lighting.in_order(self.scene.lights)
        object.__setattr__(self, "lights", lights)
        object.__setattr__(self, "shadowed", lighting.shadowed(lights, self.settings))


@dataclass(frozen=True)
class FrameReport:
    """What a frame did and what it cost the CPU.

    Attributes:
        submit_ms: CPU time of `FramePipeline.draw`: culling, sorting and calls into GL.
        draws: Draw calls into the picture.
        triangles: Drawn in the picture.
        triangles_in_scene: Those and what was left out.
        characters: In the camera's view.
        shadow_redrawn: Whether the level's part of the shadow maps was drawn anew.
        shadow_draws: Draw calls that this took, and 0 if it was not.
        shadow_triangles: Likewise.
    """

    submit_ms: float
    draws: int
    triangles: int
    triangles_in_scene: int
    characters: int
    shadow_redrawn: bool
    shadow_draws: int
    shadow_triangles: int


class FramePipeline:
    """The passes of one level; `draw` is the frame.

    Args:
        context: Where everything lives.
        gpu_scene: The level.
        shaders: The folder of their files.
    """

    def __init__(
        self, context: moderngl.Context, gpu_scene: GpuScene, shaders: Path = SHADERS
    ) -> None:
        self._context = context
        self._gpu_scene = gpu_scene
        self._bounds = gpu_scene.scene.bounds
        self._triangle_count = gpu_scene.scene.triangle_count
        self._flush = gl.flush_function(context)
        context.front_face = "cw"  # as in Quake's files
        self._folder = ShaderFolder(shaders)
        self._visible = VisibleFaces(gpu_scene.scene)
        self._characters = CharacterPass(context, gpu_scene, self._folder)
        self.shadow = ShadowPass(context, gpu_scene, self._characters, self._folder)
        self._surfaces = SurfacePass(context, gpu_scene, self._folder)
        self._sky = SkyPass(context, gpu_scene, self._folder)
        self._overlay: OverlayPass | None = None
        self._macros_for: object = None
        self._macros: dict[str, int | str] = {}
        self._fog: LitFog | None = None
        self._fog_in_view = NO_FOG
        self._is_encoded = False

    def prepare(self, frame: FrameInput, target: Target) -> None:
        """Compile and allocate what a frame needs, and frames like it; `draw` then creates nothing.

        Args:
            frame: The one that is drawn next. In a level without fog, any with its view, settings,
                sky and numbers of lights will do: what fog is in view is looked up here.
            target: What it is drawn into, or one of its kind.

        Raises:
            ShaderError: a shader that has not been needed so far does not compile. Frames like
                those before can still be prepared and drawn.
        """
        self._gpu_scene.set_anisotropy(frame.settings.anisotropy)
        encoded = _is_encoded(frame.view, target)
        self.shadow.reserve(frame.shadowed, frame.settings)
        scene = frame.scene
        if lighting.baked_unit(scene, frame.settings) > 0:
            self._gpu_scene.upload_baked()
        counts = len(frame.lights), len(frame.shadowed), shadow_tiles.spot_count(frame.shadowed)
        wanted = scene.sky, scene.environment_constant, scene.ambient, frame.settings, counts
        if wanted != self._macros_for:
            self._macros_for = wanted
            self._macros = lighting.constants(scene, frame.settings)
            self._macros |= lighting.counts(frame.lights, frame.shadowed, frame.settings)
            self._fog = LitFog(scene, frame.settings) if scene.level.fogs else None
        self._fog_in_view = NO_FOG
        if self._fog is not None and frame.view is View.FINAL:
            clip_from_world = (
                self._clip_from_view(frame.camera, target) @ frame.camera.view_from_world
            )
            self._fog_in_view = self._fog.in_view(frame.camera.position, clip_from_world)
        fogs, has_grain = len(self._fog_in_view), frame.settings.grain
        for each, counts_of_fogs in (
            (self._surfaces.programs, (0, fogs)),
            (self._characters.programs, (fogs,)),
        ):
            each.prepare(
                frame.view, self._macros, counts_of_fogs, encoded=encoded, has_grain=has_grain
            )
        if frame.view is View.FINAL:
            self._sky.prepare(encoded=encoded, fogs=fogs)
        self._is_encoded = encoded
        if frame.overlays and self._overlay is None:
            self._overlay = OverlayPass(self._context, self._gpu_scene.scene, self._folder)

    def draw(
        self,
        frame: FrameInput,
        target: Target,
        timed: TimedPass = _untimed,
        part: Part | None = None,
    ) -> FrameReport:
        """Draw one frame into `target`.

        Args:
            frame: What to draw.
            target: What to draw it into; `prepare` has been called for both.
            timed: Gives for each of `PASSES` a context to draw it in.
            part: Of the target, to draw only there what the whole picture would show; the rest
                stays as it is.
        """
        start = time.perf_counter()
        camera, settings, visible = frame.camera, frame.settings, self._visible
        encoded = _is_encoded(frame.view, target)
        assert encoded is self._is_encoded, "prepared for another kind of target"
        clip_from_view = self._clip_from_view(camera, target)
        clip_from_world = clip_from_view @ camera.view_from_world
        decider, cull_from_world = camera, clip_from_world
        if frame.culled_from is not None:
            decider = frame.culled_from
            cull_from_world = self._clip_from_view(decider, target) @ decider.view_from_world

        has_sky = frame.view is View.FINAL
        if visible.update(
            decider.position,
            cull_from_world,
            cull=settings.culling,
            looked_at_from=camera.position,
        ):
            self._surfaces.upload(visible.opaque, visible.blended)
        self._surfaces.choose(self._fog_in_view, camera.position, visible.faces)
        with_blended = frame.view.has_blended and settings.albedo is None
        blended = visible.blended if with_blended else NOTHING
        with timed("shadow"):
            self.shadow.fit(frame.shadowed, settings, visible.receivers)
            tiles = self.shadow.tiles if frame.shadowed else ()
            may_be_seen = visible.characters if settings.culling else None
            moved = self._characters.update(
                frame.time, camera.position, cull_from_world, tiles, may_be_seen
            )
            self.shadow.draw(settings, is_used=bool(tiles), characters_moved=moved)
        scale = 1.0 if target.is_linear else self._display_scale(frame)
        self._write_block(frame, clip_from_world, clip_from_view, scale)

        with timed("clear"):
            self._begin(target, frame.view, part)
        with timed("surfaces"):
            self._surfaces.draw_opaque(visible.opaque, frame.time)
        if self._characters.seen:
            self._flush()  # a software rasteriser shades the level while it sets characters up
        with timed("characters"):
            self._characters.draw_opaque()
        target.framebuffer.depth_mask = False
        with timed("sky"):
            if has_sky:
                self._sky.draw(frame.time)
        with timed("blended"):
            encode_srgb(self._context, encoded)  # for GL to blend linear light
            self._surfaces.draw_blended(blended, visible.opaque, frame.time)
            if with_blended:
                self._characters.draw_blended()
        with timed("overlay"):
            if self._overlay is not None and frame.overlays and not target.is_linear:
                frustum = None if frame.culled_from is None else cull_from_world
                lights = frame.lights, frame.shadowed
                self._overlay.update(frame.overlays, *lights, tiles, frame.time, frustum)
                self._overlay.draw(clip_from_view, target.size[0])
        if part is not None:
            target.framebuffer.scissor = None  # type: ignore[assignment]  # moderngl's way to end it

        draws, triangles = self._characters.counts(with_blended=with_blended)
        redrawn = self.shadow.redrawn
        return FrameReport(
            submit_ms=(time.perf_counter() - start) * 1e3,
            draws=len(visible.opaque.batches) + len(blended.batches) + draws + has_sky,
            triangles=visible.opaque.triangle_count + blended.triangle_count + triangles,
            triangles_in_scene=self._triangle_count,
            characters=self._characters.seen,
            shadow_redrawn=redrawn,
            shadow_draws=self.shadow.draw_count if redrawn else 0,
            shadow_triangles=self.shadow.triangle_count if redrawn else 0,
        )

    def _clip_from_view(self, camera: Camera, target: Target) -> Mat4:
        return camera.clip_from_view(target.size[0] / target.size[1], camera.far_for(*self._bounds))

    def _display_scale(self, frame: FrameInput) -> float:
        """What values are multiplied by for display: exposure, or depth 1 / the far plane."""
        if frame.view.is_light:
            return frame.exposure
        is_depth = frame.view is View.DEPTH
        return 1 / frame.camera.far_for(*self._bounds) if is_depth else 1.0

    def _own_scale(self, frame: FrameInput, scale: float) -> float:
        """What self-lit texels are multiplied by, in values of a scale."""
        emission = frame.settings.emission
        return scale * (1 / frame.exposure if emission is None else emission)

    def _begin(self, target: Target, view: View, part: Part | None) -> None:
        """Bind and clear the target, which takes what shaders write as it is."""
        target.framebuffer.depth_mask = True
        target.framebuffer.use()
        if part is not None:
            target.framebuffer.scissor = target.box(part)
        encode_srgb(self._context, False)
        background = np.inf if view is View.DEPTH else 0.0
        target.framebuffer.clear(background, background, background, 0.0)
        self.shadow.atlas.use(SHADOW_ATLAS)

    def _write_block(
        self,
        frame: FrameInput,
        clip_from_world: Mat4,
        clip_from_view: Mat4,
        scale: float,
    ) -> None:
        """One upload of everything that a whole frame shares, if any of it has changed."""
        self._gpu_scene.frame_block.bind_to_uniform_block(0)
        settings, tiles = frame.settings, self.shadow.tiles
        shadows = tiles, self.shadow.atlas.size, settings.shadow_normal_offset
        units = frame.scene.metres_per_unit, frame.scene.environment_constant
        scales = scale, self._own_scale(frame, scale)
        fog = self._fog_in_view
        wanted = clip_from_world.tobytes(), units, frame.lights, shadows, scales, fog.key
        if self._gpu_scene.frame_block_holds == wanted:
            return
        block = np.zeros((), blocks.FRAME)
        block["clip_from_world"] = blocks.column_major(clip_from_world)
        block["direction_from_clip"] = blocks.column_major(
            lighting.direction_from_clip(clip_from_view, frame.camera.view_from_world)
        )
        self.shadow.write_tiles(block, settings)
        lighting.write_lights(block, frame.lights, frame.scene.metres_per_unit)
        block["sky_scale"][0] = frame.scene.environment_constant
        block["output_scale"][:2] = scales
        block["eye_position"][:3] = frame.camera.position
        fog.write(block, frame.camera.position, scale)
        self._gpu_scene.frame_block.write(block.tobytes())
        self._gpu_scene.frame_block_holds = wanted

    def shaders_changed(self) -> bool:
        """Whether a shader's file has changed since it was read, by their times alone."""
        return self._folder.has_changed

    def reload(self) -> ShaderError | None:
        """Compile all of the frame's shaders from their files as they are now. Not inside a frame.

        Returns:
            What is wrong, if one of them does not compile; then all stay as they are.
        """
        error = programs.reload(self._folder, self._shaders)
        if error is None:
            self.shadow.forget()
        return error

    @property
    def _shaders(self) -> list[Shader]:
        passes = (self.shadow, self._characters, self._surfaces.programs, self._sky)
        found = [shader for each in passes for shader in each.shaders]
        return found + (self._overlay.shaders if self._overlay is not None else [])

    def release(self) -> None:
        """Give the GL objects back."""
        for each in (self.shadow, self._surfaces, self._characters, self._sky):
            each.release()
        if self._overlay is not None:
            self._overlay.release()


def _is_encoded(view: View, target: Target) -> bool:
    """Whether pixels are sRGB of what is shown."""
    return view.is_encoded and not target.is_linear
