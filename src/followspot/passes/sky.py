"""The sky pass: one triangle over the whole picture, behind everything."""

import moderngl

from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.program import ShaderFolder
from followspot.passes.programs import Shader, over_picture


class SkyPass:
    """The cube map behind everything: drawn at the far plane where nothing nearer is."""

    def __init__(
        self, context: moderngl.Context, gpu_scene: GpuScene, folder: ShaderFolder
    ) -> None:
        self._context = context
        self._gpu_scene = gpu_scene
        self._folder = folder
        self._made: dict[bool, Shader] = {}

    def prepare(self, *, encoded: bool) -> None:
        """Compile what the next frames need. Not inside a frame.

        Args:
            encoded: Whether the picture is sRGB that the shader writes.

        Raises:
            ShaderError: it does not compile.
        """
        if encoded not in self._made:
            defines = {"ENCODED": 1} if encoded else {}
            self._made[encoded] = over_picture(
                self._context, self._folder, "sky", defines, vertex="sky"
            )

    @property
    def shaders(self) -> list[Shader]:
        """All that have been compiled."""
        return list(self._made.values())

    def draw(self, *, encoded: bool) -> None:
        """Fill what the depth buffer says is empty; `encoded` as it has been prepared."""
        self._context.enable_only(moderngl.DEPTH_TEST)
        self._context.depth_func = "<="
        self._gpu_scene.sky.use(0)
        self._made[encoded].arrays[0].render(vertices=3)

    def release(self) -> None:
        """Give the GL objects back."""
        for shader in self.shaders:
            shader.release()
