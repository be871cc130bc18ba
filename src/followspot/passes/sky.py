"""The sky pass: one triangle over the whole picture, behind everything."""

import moderngl

from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.program import ShaderFolder
from followspot.passes.programs import Shader


class SkyPass:
    """The cube map behind everything: drawn at the far plane where nothing nearer is."""

    def __init__(
        self, context: moderngl.Context, gpu_scene: GpuScene, folder: ShaderFolder
    ) -> None:
        self._context = context
        self._gpu_scene = gpu_scene
        self._shader = Shader(context, folder, "sky", lambda sky: [context.vertex_array(sky, [])])
        self.shaders = [self._shader]

    def draw(self) -> None:
        """Fill what the depth buffer says is empty."""
        self._context.enable_only(moderngl.DEPTH_TEST)
        self._context.depth_func = "<="
        self._gpu_scene.sky.use(0)
        self._shader.arrays[0].render(vertices=3)

    def release(self) -> None:
        """Give the GL objects back."""
        self._shader.release()
