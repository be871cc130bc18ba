"""A scene's geometry, textures and sky in GPU memory."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.assets.image import Image, decode_all
from followspot.errors import AssetError
from followspot.gpu import gl
from followspot.gpu.blocks import FRAME
from followspot.gpu.characters import GpuCrowd
from followspot.scene.material import Material
from followspot.scene.scene import Scene
from followspot.scene.sky import CubeMap


class GpuScene:
    """Everything that stays the same from frame to frame, uploaded once.

    Attributes:
        scene: What was uploaded.
        vertices: The mesh's vertices, one buffer.
        tints: The mesh's tints, where it has any.
        frame_block: Uniform buffer for one `blocks.FRAME`.
        crowd: The characters' figures.
        sky: The sky's cube map with all MIP levels.
        problems: Images that are there but cannot be decoded; white stands in for them.

    Raises:
        AssetError: a figure has more key poses than this OpenGL can hold.
    """

    def __init__(self, context: moderngl.Context, scene: Scene) -> None:
        self.context = context
        self.scene = scene
        self._anisotropy = 1.0
        self.problems: list[AssetError] = []
        self.crowd = GpuCrowd(context, scene.crowd)  # first: it is what may fail
        context.enable_direct(gl.TEXTURE_CUBE_MAP_SEAMLESS)
        self.vertices = context.buffer(scene.mesh.vertices.tobytes() or bytes(32))
        tints = scene.mesh.tints
        self.tints = None if tints is None else context.buffer(tints.tobytes())
        self.frame_block = context.buffer(reserve=FRAME.itemsize, dynamic=True)
        self._white = _upload(context, np.full((1, 1, 4), 255, np.uint8))
        self._images: dict[tuple[str | None, bool], moderngl.Texture] = {}
        wanted = {(m.image, m.clamps) for m in (*scene.materials, *scene.crowd.materials)}
        images = scene.images
        for number, image in decode_all(scene.archive, images):
            if not isinstance(image, Image):
                self.problems.append(image)
                continue
            for clamps in (False, True):  # wrapping belongs to the texture in OpenGL 3.3
                if (key := (images[number], clamps)) in wanted:
                    self._images[key] = _upload(context, image.pixels, clamps=clamps)
        self.sky = _upload_cube(context, scene.sky)

    def image_of(self, material: Material) -> moderngl.Texture:
        """A material's base image, or white; materials with one image and wrapping share it."""
        return self._images.get((material.image, material.clamps), self._white)

    def set_anisotropy(self, samples: float) -> None:
        """Texture samples along the steep direction from now on; 1 is plain trilinear."""
        if samples != self._anisotropy:
            self._anisotropy = samples
            for texture in self._images.values():
                texture.anisotropy = samples

    def release(self) -> None:
        """Give the GL objects back."""
        for texture in (*self._images.values(), self._white):
            texture.release()
        for thing in (self.vertices, self.tints, self.frame_block, self.sky, self.crowd):
            if thing is not None:
                thing.release()


def _upload(
    context: moderngl.Context, pixels: NDArray[np.uint8], *, clamps: bool = False
) -> moderngl.Texture:
    """(h, w, 4) uint8 sRGB as a trilinear texture that repeats; row 0 is t = 0, as in Quake."""
    height, width = pixels.shape[:2]
    texture = context.texture((width, height), 4, pixels, internal_format=gl.SRGB8_ALPHA8)
    texture.repeat_x = texture.repeat_y = not clamps
    texture.build_mipmaps()  # GL averages sRGB textures in linear light
    texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    return texture


def _upload_cube(context: moderngl.Context, sky: CubeMap) -> moderngl.TextureCube:
    """The sky's faces, already in GL's order and orientation."""
    size = sky.faces.shape[1]
    cube = context.texture_cube((size, size), 4, sky.faces, internal_format=gl.SRGB8_ALPHA8)
    cube.build_mipmaps()
    cube.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
    return cube
