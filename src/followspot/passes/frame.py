"""The whole frame, in order."""

import time
from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot import spaces
from followspot.assets.shader_values import Sides
from followspot.gpu import blocks
from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.targets import Target
from followspot.passes import drawlist, lighting
from followspot.passes.drawlist import NOTHING
from followspot.passes.shadow import ShadowPass
from followspot.passes.shadow_fit import Boxes
from followspot.passes.sky import SkyPass
from followspot.passes.surfaces import SHADOW_ATLAS, SurfacePass
from followspot.passes.view import View
from followspot.scene.camera import Camera
from followspot.scene.light import Light, SpotLight
from followspot.scene.mesh import FLAT
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.spaces import Mat4

_FRAMEBUFFER_SRGB = 0x8DB9
_SORT_CELL = 256.0
"""Units: opaque faces are sorted as seen from the middle of the cell that the eye is in, so that
their order stays while the eye moves a little, and yet follows from where it is alone."""


@dataclass(frozen=True, eq=False)
class FrameInput:
    """All that a frame depends on beside the scene in GPU memory.

    Attributes:
        scene: Its level is the one in GPU memory; units, ambient and sky's strength are read here.
        camera: Where the picture is taken from.
        lights: Any number up to `blocks.MAX_LIGHTS`; spot lights with shadows come first.
        settings: The switches.
        exposure: Display value per radiance.
        view: The stage to draw.
    """

    scene: Scene
    camera: Camera
    lights: tuple[Light, ...]
    settings: Settings
    exposure: float
    view: View = View.FINAL

    @property
    def shadowed(self) -> tuple[SpotLight, ...]:
        """The lights that have a shadow map in this frame."""
        return lighting.shadowed(self.lights, self.settings)


@dataclass(frozen=True)
class FrameReport:
    """What a frame did and what it cost the CPU."""

    submit_ms: float
    draws: int
    triangles: int
    triangles_in_scene: int
    shadow_redrawn: bool
    shadow_draws: int
    shadow_triangles: int


class FramePipeline:
    """The passes of one scene; `draw` is the frame."""

    def __init__(self, context: moderngl.Context, gpu_scene: GpuScene) -> None:
        self._context = context
        self._gpu_scene = gpu_scene
        self._mesh, materials = gpu_scene.scene.mesh, gpu_scene.scene.materials
        self._visibility = gpu_scene.scene.visibility
        context.front_face = "cw"  # as in Quake's files
        self.shadow = ShadowPass(context, gpu_scene)
        self._surfaces = SurfacePass(context, gpu_scene)
        self._sky = SkyPass(context, gpu_scene)
        side = {Sides.FRONT: 1, Sides.BACK: -1, Sides.BOTH: 0}
        self._side = np.array([side[m.sides] for m in materials], np.float32)
        self._is_cut_out = np.array([m.alpha_test is not None for m in materials], bool)
        self._is_blended = np.array([m.blend is not None for m in materials], bool)
        self._opaque, self._blended = NOTHING, NOTHING
        self._listed: object = None
        self._visible = np.zeros(0, bool)
        self._sorted_in: object = None
        self._receivers: Boxes | None = None

    def prepare(self, frame: FrameInput) -> None:
        """Compile and allocate what frames like this one need; `draw` then creates nothing."""
        self._gpu_scene.set_anisotropy(frame.settings.anisotropy)
        shadows = len(frame.shadowed)
        self.shadow.reserve(shadows, frame.settings.shadow_map_size)
        constants = lighting.constants(frame.scene, frame.settings)
        self._surfaces.prepare(frame.view, len(frame.lights), shadows, constants)

    def draw(self, frame: FrameInput, target: Target) -> FrameReport:
        """Draw one frame into `target`. `prepare` has been called for frames like it."""
        start = time.perf_counter()
        aspect = target.size[0] / target.size[1]
        far = frame.camera.far_for(*self._mesh.bounds)
        clip_from_view = frame.camera.clip_from_view(aspect, far)
        clip_from_world = clip_from_view @ frame.camera.view_from_world

        self._update_draw_lists(frame, clip_from_world)
        scale = 1.0 if target.is_linear else _display_scale(frame, far)
        shadow_from_world = self.shadow.draw(frame.shadowed, frame.settings, self._receivers)
        self._write_block(frame, clip_from_world, clip_from_view, shadow_from_world, scale)

        target.framebuffer.depth_mask = True
        target.framebuffer.use()
        self._encode(frame.view.is_encoded and not target.is_linear)
        background = np.inf if frame.view is View.DEPTH else 0.0
        target.framebuffer.clear(background, background, background, 0.0)
        assert self.shadow.atlas is not None
        self.shadow.atlas.use(SHADOW_ATLAS)
        self._surfaces.draw_opaque(self._opaque)
        target.framebuffer.depth_mask = False
        if frame.view is View.FINAL:
            self._sky.draw()
        self._surfaces.draw_blended(self._blended, self._opaque)

        return FrameReport(
            submit_ms=(time.perf_counter() - start) * 1e3,
            draws=len(self._opaque.batches) + len(self._blended.batches) + 1,
            triangles=self._opaque.triangle_count + self._blended.triangle_count,
            triangles_in_scene=self._mesh.triangle_count,
            shadow_redrawn=self.shadow.redrawn,
            shadow_draws=self.shadow.draw_count if self.shadow.redrawn else 0,
            shadow_triangles=self.shadow.triangle_count if self.shadow.redrawn else 0,
        )

    def _update_draw_lists(self, frame: FrameInput, clip_from_world: Mat4) -> None:
        """Cull and sort anew, but only when something that matters has changed."""
        blended_too = frame.view.has_blended and frame.settings.albedo is None
        wanted = (clip_from_world.tobytes(), frame.settings.culling, blended_too)
        if wanted == self._listed:
            return
        self._listed = wanted
        visible = self._visible_faces(frame, clip_from_world)
        self._receivers = self._boxes_in_view(visible, clip_from_world)
        if not frame.settings.culling:
            visible = np.ones_like(visible)
        is_blended = self._is_blended[self._mesh.faces["material"]]
        opaque, blended = visible & ~is_blended, visible & is_blended & blended_too
        eye = frame.camera.position
        cell = np.floor(eye / _SORT_CELL).tolist()
        if self._sorted_in != cell or not np.array_equal(opaque, self._visible):
            self._visible, self._sorted_in = opaque, cell
            self._opaque = drawlist.front_to_back(self._mesh, opaque, eye, self._is_cut_out)
        elif not blended.any() and not self._blended.batches:
            return
        self._blended = drawlist.back_to_front(self._mesh, blended, eye)
        self._surfaces.upload(self._opaque, self._blended)

    def _boxes_in_view(self, visible: NDArray[np.bool_], clip_from_world: Mat4) -> Boxes:
        """The visible faces' boxes, cut down to the box of the camera's frustum."""
        faces = self._mesh.faces[visible]
        cube = spaces.box_corners(spaces.vec3([-1, -1, -1]), spaces.vec3([1, 1, 1]))
        corners = np.linalg.solve(clip_from_world, np.c_[cube, np.ones(8)].T).T
        corners = (corners[:, :3] / corners[:, 3:]).astype(np.float32)
        low, high = corners.min(axis=0), corners.max(axis=0)
        return Boxes(np.clip(faces["mins"], low, high), np.clip(faces["maxs"], low, high))

    def _visible_faces(self, frame: FrameInput, clip_from_world: Mat4) -> NDArray[np.bool_]:
        faces = self._mesh.faces
        planes = drawlist.frustum_planes(clip_from_world)
        inside = drawlist.boxes_in_frustum(planes, faces["mins"], faces["maxs"])
        height = drawlist.height_above(faces, frame.camera.position)
        inside &= height * self._side[faces["material"]] >= -FLAT
        return inside & self._visibility.faces_from(frame.camera.position)

    def _write_block(
        self,
        frame: FrameInput,
        clip_from_world: Mat4,
        clip_from_view: Mat4,
        shadow_from_world: NDArray[np.float32],
        scale: float,
    ) -> None:
        """One upload of everything that a whole frame shares."""
        block = np.zeros((), blocks.FRAME)
        block["clip_from_world"] = blocks.columns(clip_from_world)
        block["direction_from_clip"] = blocks.columns(
            lighting.direction_from_clip(clip_from_view, frame.camera.view_from_world)
        )
        block["shadow_from_world"][: len(shadow_from_world)] = shadow_from_world
        tiles = self.shadow.tiles[: len(frame.shadowed)]
        offsets = [tile.texel * frame.settings.shadow_normal_offset for tile in tiles]
        lighting.write_lights(block, frame.lights, frame.scene.metres_per_unit, offsets)
        block["sky_scale"][0] = frame.scene.environment_constant
        block["output_scale"][0] = scale
        self._gpu_scene.frame_block.write(block.tobytes())
        self._gpu_scene.frame_block.bind_to_uniform_block(0)

    def _encode(self, switch: bool) -> None:
        """Whether GL turns what shaders write into sRGB."""
        (self._context.enable_direct if switch else self._context.disable_direct)(_FRAMEBUFFER_SRGB)

    def release(self) -> None:
        """Give the GL objects back."""
        for each in (self.shadow, self._surfaces, self._sky):
            each.release()


def _display_scale(frame: FrameInput, far: float) -> float:
    """What values are multiplied by for display: exposure, or for depth 1 over the far plane."""
    if frame.view.is_light:
        return frame.exposure
    return 1 / far if frame.view is View.DEPTH else 1.0
