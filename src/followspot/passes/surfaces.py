"""The surface pass: every visible face, shaded as one stage's view asks."""

from typing import NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.program import ShaderFolder
from followspot.passes.drawlist import Batch, DrawList
from followspot.passes.fog import FogInView
from followspot.passes.materials import Variant, set_state, set_uniforms, variant_of
from followspot.passes.motion import Mover, mover_of
from followspot.passes.programs import BASE_IMAGE, LAYER_IMAGE, LIGHTMAPS, Shader, SurfacePrograms
from followspot.scene.material import Material
from followspot.spaces import Vec3


class _Look(NamedTuple):
    """All that drawing faces of a material needs."""

    material: Material
    state: tuple[object, ...]
    variant: Variant
    image: moderngl.Texture
    layer: moderngl.Texture | None
    mover: Mover | None


class SurfacePass:
    """The level's faces, in draw lists that are uploaded when they change."""

    def __init__(
        self, context: moderngl.Context, gpu_scene: GpuScene, folder: ShaderFolder
    ) -> None:
        self._context = context
        self._gpu_scene = gpu_scene
        size = max(gpu_scene.scene.mesh.indices.nbytes, 4)
        self._indices = context.buffer(reserve=size, dynamic=True)
        materials = gpu_scene.scene.materials
        smoothed = gpu_scene.scene.mesh.is_smoothed(len(materials)).tolist()
        self._looks = [
            self._look(material, variant_of(material, is_smoothed=is_smoothed))
            for material, is_smoothed in zip(materials, smoothed, strict=True)
        ]
        variants = {look.variant for look in self._looks}
        self.programs = SurfacePrograms(context, folder, variants, self._array)
        self._shaders: list[Shader] = []
        self._chosen: object = None
        self._through: object = None
        self._faces: object = None

    def _look(self, material: Material, variant: Variant) -> _Look:
        of = self._gpu_scene
        mover = mover_of(material, variant, of)
        image, layer = of.image_of(material), of.layer_of(material)
        return _Look(material, material.state, variant, image, layer, mover)

    def _array(self, surface: moderngl.Program) -> list[moderngl.VertexArray]:
        """The level's one vertex array for a program, which need not look at all of a vertex."""
        content: list[tuple[moderngl.Buffer, str, *tuple[str, ...]]] = [
            (self._gpu_scene.vertices, "3f 3f 2f", "in_position", "in_normal", "in_texcoord")
        ]
        if self._gpu_scene.tints is not None:
            content.append((self._gpu_scene.tints, "4f", "in_tint"))
        if self._gpu_scene.sprites is not None:
            content.append((self._gpu_scene.sprites, "4f 3f 4x", "in_pivot", "in_axis"))
        if self._gpu_scene.baked is not None:
            content.append((self._gpu_scene.baked, "2f 3f", "in_luxel", "in_baked"))
        return [self._context.vertex_array(surface, content, self._indices, skip_errors=True)]

    def upload(self, opaque: DrawList, blended: DrawList) -> None:
        """Put new draw lists into the index buffer, blended behind opaque."""
        self._indices.write(opaque.indices)
        self._indices.write(blended.indices, offset=opaque.indices.nbytes)

    def choose(self, fog: FogInView, eye: Vec3, faces: NDArray[np.void]) -> None:
        """Choose the programs of the next draws: only what fog may cover is drawn through it.

        Args:
            fog: What there is of it in the frame.
            eye: (3,) world units.
            faces: Those that are drawn; the same object as long as they are the same.
        """
        chosen = self.programs.chosen
        through = (fog.key, eye.tobytes()) if len(fog) else None
        is_kept = chosen is self._chosen and through == self._through
        if is_kept and (through is None or faces is self._faces):
            return
        self._chosen, self._through, self._faces = chosen, through, faces
        fogs = np.zeros(len(self._looks), np.intp)
        if len(fog):
            is_covered = fog.may_cover(eye, faces["mins"], faces["maxs"])
            fogs[faces["material"][is_covered]] = len(fog)
        looks = zip(self._looks, fogs.tolist(), strict=True)
        self._shaders = [chosen[count][look.variant] for look, count in looks]

    def draw_opaque(self, faces: DrawList, seconds: float) -> None:
        """Draw solid and cut-out faces as they are at a time, with depth test and writes."""
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._context.depth_func = "<"
        self._draw(faces.batches, 0, seconds)

    def draw_blended(self, faces: DrawList, opaque: DrawList, seconds: float) -> None:
        """Draw blended faces, already sorted back to front, into what stands there."""
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._context.depth_func = "<="
        self._draw(faces.batches, len(opaque.indices), seconds)

    def _draw(self, batches: tuple[Batch, ...], base: int, seconds: float) -> None:
        """Draw batches, changing only the state in which neighbours differ."""
        if self._gpu_scene.lightmaps is not None:
            self._gpu_scene.lightmaps.use(LIGHTMAPS)
        state: object = None
        for batch in batches:
            look = self._looks[batch.material]
            if look.state != state:
                state = look.state
                set_state(self._context, look.material)
            shader = self._shaders[batch.material]
            if look.variant.cut_out or look.variant.blended:
                set_uniforms(shader.program, look.material)
            look.image.use(BASE_IMAGE)
            if look.layer is not None:
                look.layer.use(LAYER_IMAGE)
            if look.mover is not None:
                look.mover.set(shader.program, seconds)
            shader.arrays[0].render(vertices=batch.count, first=base + batch.first)
        self._context.polygon_offset = 0.0, 0.0

    def release(self) -> None:
        """Give the GL objects back."""
        self.programs.release()
        self._indices.release()
