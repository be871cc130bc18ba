"""The sky pass: one triangle over the whole picture, behind everything."""

import moderngl

from followspot.gpu import program
from followspot.gpu.gpu_scene import GpuScene


class SkyPass:
    """The cube map behind everything: drawn at the far plane where nothing nearer is."""

    def __init__(self, context: moderngl.Context, gpu_scene: GpuScene) -> None:
        self._context = context
        self._gpu_scene = gpu_scene
        self._program = program.build(context, "sky")
        self._array = context.vertex_array(self._program, [])

    def draw(self) -> None:
        """Fill what the depth buffer says is empty."""
        self._context.enable_only(moderngl.DEPTH_TEST)
        self._context.depth_func = "<="
        self._gpu_scene.sky.use(0)
        self._array.render(vertices=3)

    def release(self) -> None:
        """Give the GL objects back."""
        self._array.release()
        self._program.release()
