"""The sky pass: one triangle over the whole picture, behind everything."""

from collections.abc import Sequence

import moderngl
import numpy as np

from followspot.assets.shader_values import BlendFactor
from followspot.gpu import program
from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.program import ShaderFolder
from followspot.passes.programs import CLOUDS, Shader, over_picture
from followspot.scene.clouds import Clouds, Layer


class SkyPass:
    """The cube map behind everything, drawn at the far plane where nothing nearer is.

    Where clouds move, theirs take the place of the one that holds them as they are at first.
    """

    def __init__(
        self, context: moderngl.Context, gpu_scene: GpuScene, folder: ShaderFolder
    ) -> None:
        self._context = context
        self._gpu_scene = gpu_scene
        self._folder = folder
        self._clouds = gpu_scene.scene.clouds if gpu_scene.clouds else None
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
            defines: dict[str, int | str] = {"FOGS": fogs}
            if encoded:
                defines["ENCODED"] = 1
            if self._clouds is not None:
                defines |= _cloud_macros(self._clouds)
            self._made[wanted] = over_picture(
                self._context, self._folder, "sky", defines, vertex="sky"
            )
        self._chosen = self._made[wanted]

    @property
    def shaders(self) -> list[Shader]:
        """All that have been compiled."""
        return list(self._made.values())

    def draw(self, seconds: float) -> None:
        """Fill what the depth buffer says is empty with the sky as it is at a time."""
        assert self._chosen is not None, "not prepared"
        self._context.enable_only(moderngl.DEPTH_TEST)
        self._context.depth_func = "<="
        of = self._gpu_scene
        if self._clouds is None:
            of.sky.use(0)
        else:
            if of.behind_clouds is not None:
                of.behind_clouds.use(0)
            for unit, texture in enumerate(of.clouds, CLOUDS):
                texture.use(unit)
            _move(self._chosen.program, self._clouds.layers, seconds)
        self._chosen.arrays[0].render(vertices=3)

    def release(self) -> None:
        """Give the GL objects back."""
        for shader in self.shaders:
            shader.release()


def _cloud_macros(clouds: Clouds) -> dict[str, int | str]:
    """Macros of clouds.glsl."""
    macros: dict[str, int | str] = {
        "CLOUDS": len(clouds.layers),
        "CLOUD_HEIGHT": f"float({clouds.height:.9g})",
    }
    if clouds.box is None:
        macros["NO_BOX"] = 1
    for number, layer in enumerate(clouds.layers):
        formula = "texel.rgb"
        if layer.stage.blend is not None:
            source, target = (_FACTORS[factor] for factor in layer.stage.blend)
            formula = f"texel.rgb * {source} + shown * {target}"
        macros[f"CLOUD_BLEND_{number}"] = f"({formula})"
    return macros


def _move(to: moderngl.Program, layers: Sequence[Layer], seconds: float) -> None:
    """Tell a program how clouds lie at a time; turbulence would need vertices, and is left out."""
    terms = [layer.motion.terms(seconds)[:3] for layer in layers]
    program.set_uniform(to, "cloud_from_place", np.array(terms, np.float32))
    colors = [layer.color_at(seconds) for layer in layers]
    program.set_uniform(to, "cloud_color", np.array(colors, np.float32))


_FACTORS = {
    BlendFactor.ONE: "1.0",
    BlendFactor.ZERO: "0.0",
    BlendFactor.SRC_COLOR: "texel.rgb",
    BlendFactor.ONE_MINUS_SRC_COLOR: "(1.0 - texel.rgb)",
    BlendFactor.DST_COLOR: "shown",
    BlendFactor.ONE_MINUS_DST_COLOR: "(1.0 - shown)",
    BlendFactor.SRC_ALPHA: "texel.a",
    BlendFactor.ONE_MINUS_SRC_ALPHA: "(1.0 - texel.a)",
    BlendFactor.DST_ALPHA: "1.0",  # the game's picture has no alpha: it counts as 1
    BlendFactor.ONE_MINUS_DST_ALPHA: "0.0",
    BlendFactor.SRC_ALPHA_SATURATE: "0.0",
}
