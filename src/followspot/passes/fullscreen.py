"""Passes that cover the whole picture with one triangle: the sky and the tonemap."""

import moderngl

from followspot.gpu import program
from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.targets import Targets
from followspot.passes.view import View


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


class TonemapPass:
    """Linear values to the displayed picture."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program = program.build(context, "tonemap")
        self._array = context.vertex_array(self._program, [])

    def draw(self, targets: Targets, view: View, exposure: float) -> None:
        """Encode ``targets.radiance`` into ``targets.display``.

        Args:
            targets: Both ends.
            view: Decides whether the values are encoded as light or shown as data.
            exposure: Display value per linear value.
        """
        self._context.enable_only(moderngl.NOTHING)
        targets.display.use()
        targets.radiance.use(0)
        program.uniform(self._program, "exposure").value = exposure
        program.uniform(self._program, "encode").value = view.is_encoded
        self._array.render(vertices=3)

    def release(self) -> None:
        """Give the GL objects back."""
        self._array.release()
        self._program.release()
