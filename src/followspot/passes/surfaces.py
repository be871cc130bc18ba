"""The surface pass: every visible face, shaded as one stage's view asks."""

import moderngl
import numpy as np

from followspot.assets.shader_values import Sides
from followspot.gpu import blocks, program
from followspot.gpu.gpu_scene import GpuScene
from followspot.passes.drawlist import Batch, DrawList
from followspot.passes.materials import Variant, alpha_test_vector, blend_factors, variant_of
from followspot.passes.view import SURFACE_VIEWS, View
from followspot.scene.material import Material
from followspot.scene.mesh import VERTEX

BASE_IMAGE, SHADOW_ATLAS = 0, 1
"""Texture units."""

_VIEWS: dict[str, int | str] = {f"VIEW_{v.name}": n for n, v in enumerate(SURFACE_VIEWS)}
_CULLED_SIDE = {Sides.FRONT: "back", Sides.BACK: "front"}


MAX_PROGRAMS = 128
"""Programs kept for views and settings that come back; more than one frame needs at once."""


class SurfacePass:
    """Programs and vertex arrays for the views that have been asked for.

    A program is compiled for each view, variant of material, number of lights and sky, so that no
    pixel pays for a choice that is the same in the whole frame.
    """

    def __init__(self, context: moderngl.Context, gpu_scene: GpuScene) -> None:
        self._context = context
        self._gpu_scene = gpu_scene
        size = max(gpu_scene.scene.mesh.indices.nbytes, 4)
        self._indices = context.buffer(reserve=size, dynamic=True)
        self._variants = [variant_of(m) for m in gpu_scene.scene.materials]
        self._arrays: dict[object, moderngl.VertexArray] = {}
        self._common: dict[str, int | str] = {}
        self._ready: dict[Variant, moderngl.VertexArray] = {}

    def prepare(
        self, view: View, lights: int, shadows: int, constants: dict[str, int | str]
    ) -> None:
        """Choose the programs for the next frames, compiling what is new. Not inside a frame.

        Args:
            view: The stage that is written.
            lights: How many there are.
            shadows: How many of them have a shadow map; they come first.
            constants: Macros of surface.frag; see `lighting.constants`.
        """
        common = {
            **_VIEWS,
            **constants,
            "VIEW": f"VIEW_{view.name}",
            "LIGHTS": lights,
            "SHADOWS": shadows,
        }
        if common == self._common:
            return
        self._common = common
        for variant in set(self._variants):
            key = (*common.items(), variant)
            array = self._arrays.pop(key, None) or self._compile(common | variant.defines)
            self._arrays[key] = self._ready[variant] = array  # the last one used is the last
        while len(self._arrays) > MAX_PROGRAMS:
            _drop(self._arrays.pop(next(iter(self._arrays))))

    def _compile(self, defines: dict[str, int | str]) -> moderngl.VertexArray:
        surface = program.build(self._context, "surface", defines)
        for name, unit in (("base_image", BASE_IMAGE), ("shadow_atlas", SHADOW_ATLAS)):
            if name in surface:
                program.uniform(surface, name).value = unit
        program.uniform(surface, "world_from_object").write(blocks.columns(np.eye(4)))
        used = [f"in_{name}" for name in VERTEX.names or () if f"in_{name}" in surface]
        layout = {"in_position": "3f", "in_normal": "3f", "in_texcoord": "2f"}
        formats = [
            layout[name] if name in used else f"{4 * int(layout[name][0])}x" for name in layout
        ]
        return self._context.vertex_array(
            surface, [(self._gpu_scene.vertices, " ".join(formats), *used)], self._indices
        )

    def upload(self, opaque: DrawList, blended: DrawList) -> None:
        """Put new draw lists into the index buffer, blended behind opaque."""
        self._indices.write(opaque.indices)
        self._indices.write(blended.indices, offset=opaque.indices.nbytes)

    def draw_opaque(self, faces: DrawList) -> None:
        """Draw solid and cut-out faces with depth test and writes."""
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._context.depth_func = "<"
        self._draw(faces.batches, 0)

    def draw_blended(self, faces: DrawList, opaque: DrawList) -> None:
        """Draw blended faces, already sorted back to front, into what stands there."""
        self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
        self._context.depth_func = "<="
        self._draw(faces.batches, len(opaque.indices))

    def _draw(self, batches: tuple[Batch, ...], base: int) -> None:
        """Draw batches, changing only the state in which neighbours differ."""
        materials = self._gpu_scene.scene.materials
        state: object = None
        for batch in batches:
            material = materials[batch.material]
            if material.state != state:
                state = material.state
                self._set_state(material)
            array = self._ready[self._variants[batch.material]]
            if material.alpha_test is not None:
                program.uniform(array.program, "alpha_test").value = alpha_test_vector(material)
            self._gpu_scene.base_images[batch.material].use(BASE_IMAGE)
            array.render(vertices=batch.count, first=base + batch.first)
        self._context.polygon_offset = 0.0, 0.0

    def _set_state(self, material: Material) -> None:
        if material.sides is Sides.BOTH:
            self._context.disable(moderngl.CULL_FACE)
        else:
            self._context.enable(moderngl.CULL_FACE)
            self._context.cull_face = _CULLED_SIDE[material.sides]
        self._context.polygon_offset = (-1.0, -2.0) if material.polygon_offset else (0.0, 0.0)
        if material.blend is not None:
            self._context.blend_func = blend_factors(material)

    def release(self) -> None:
        """Give the GL objects back."""
        for array in self._arrays.values():
            _drop(array)
        self._indices.release()


def _drop(array: moderngl.VertexArray) -> None:
    array.program.release()
    array.release()
