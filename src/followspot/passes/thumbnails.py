"""Small pictures of materials, all in one texture."""

from typing import NamedTuple

import moderngl

from followspot.gpu import program
from followspot.gpu.gpu_scene import GpuScene
from followspot.gpu.program import ShaderFolder
from followspot.gpu.targets import encode_srgb, release_framebuffer
from followspot.passes.programs import BASE_IMAGE, over_picture
from followspot.scene.material import Material

EDGE = 64
"""Pixels of a thumbnail, whatever its image's shape."""

ACROSS = 16
"""Thumbnails in a row of the texture, and rows."""


class Thumbnail(NamedTuple):
    """A material's.

    Attributes:
        size: (width, height) of the whole image in texels.
        top_left: (u, v) in the texture, whose edges are at 0 and 1; its top row comes first.
        bottom_right: Likewise.
    """

    size: tuple[int, int]
    top_left: tuple[float, float]
    bottom_right: tuple[float, float]


class Thumbnails:
    """As many as fit; the one that was longest not asked for makes room for a new one.

    Args:
        context: Where they live.

    Attributes:
        texture: RGBA as displayed; transparent are the holes of cut-out materials.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self.texture = context.texture((ACROSS * EDGE, ACROSS * EDGE), 4)
        self._framebuffer = context.framebuffer([self.texture])
        self._shader = over_picture(context, ShaderFolder(), "thumbnail")
        self._places: dict[Material, int] = {}  # the last asked for is the last

    def __contains__(self, material: Material) -> bool:
        """Whether it is there, and need not be drawn first."""
        return material in self._places

    def of(self, material: Material, gpu_scene: GpuScene) -> Thumbnail:
        """A material's, which is drawn if it is not there yet."""
        image = gpu_scene.image_of(material)
        is_new = material not in self._places
        if not is_new:
            place = self._places.pop(material)
        elif len(self._places) < ACROSS**2:
            place = len(self._places)
        else:
            place = self._places.pop(next(iter(self._places)))
        self._places[material] = place
        row, column = divmod(place, ACROSS)
        if is_new:
            self._draw(image, (column * EDGE, row * EDGE), material.alpha_test is not None)
        corners = (column / ACROSS, row / ACROSS), ((column + 1) / ACROSS, (row + 1) / ACROSS)
        return Thumbnail(image.size, *corners)

    def forget(self) -> None:
        """Make room for those of another scene."""
        self._places.clear()

    def _draw(self, image: moderngl.Texture, corner: tuple[int, int], has_holes: bool) -> None:
        of = self._shader.program
        program.set_uniform(of, "corner", corner)
        program.set_uniform(of, "edge", float(EDGE))
        program.set_uniform(of, "holes", float(has_holes))
        self._framebuffer.use()
        self._framebuffer.viewport = *corner, EDGE, EDGE
        encode_srgb(self._context, False)
        self._context.enable_only(moderngl.NOTHING)
        image.use(BASE_IMAGE)
        self._shader.arrays[0].render(vertices=3)

    def release(self) -> None:
        """Give the GL objects back."""
        release_framebuffer(self._framebuffer)
        self.texture.release()
        self._shader.release()
