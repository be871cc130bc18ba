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
        self._made: dict[tuple[bool, int], Shader] = {}
        self._chosen: Shader | None = None

    def prepare(self, *, encoded: bool, fogs: int) -> None:
        """Compile what the next frames need. Not inside a frame.

        Args:
            encoded: Whether the picture is sRGB that the shader writes.
            fogs: Volumes of fog in view.

        Raises:
            ShaderError: it does not compile.
        """
        wanted = encoded, fogs
        if wanted not in self._made:
            defines = {"FOGS": fogs} | ({"ENCODED": 1} if encoded else {})
            self._made[wanted] = over_picture(
                self._context, self._folder, "sky", defines, vertex="sky"
            )
        self._chosen = self._made[wanted]

    @property
    def shaders(self) -> list[Shader]:
        """All that have been compiled."""
        return list(self._made.values())

    def draw(self) -> None:
        """Fill what the depth buffer says is empty."""
        assert self._chosen is not None, "not prepared"
        self._context.enable_only(moderngl.DEPTH_TEST)
        self._context.depth_func = "<="
        self._gpu_scene.sky.use(0)
        self._chosen.arrays[0].render(vertices=3)

    def release(self) -> None:
        """Give the GL objects back."""
        for shader in self.shaders:
            shader.release()
