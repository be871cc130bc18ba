"""A scene's geometry, textures and sky in GPU memory."""

from typing import NamedTuple

import moderngl
import numpy as np

from followspot.assets.image import Image, decode_all
from followspot.errors import AssetError
from followspot.gpu import gl, textures
from followspot.gpu.blocks import FRAME
from followspot.gpu.characters import GpuCrowd
from followspot.scene.baked import BakedLight, TracedLight
from followspot.scene.clouds import Clouds
from followspot.scene.material import Laid, Layer, Material
from followspot.scene.scene import Scene


class _Reading(NamedTuple):
    """How a material reads which image; all of it belongs to the texture in OpenGL 3.3."""

    image: str | None
    clamps: bool
    uses_alpha: bool


def _reading(material: Material) -> _Reading:
    return _Reading(material.image, material.clamps, material.uses_alpha)


def _reading_layer(layer: Layer) -> _Reading:
    return _Reading(layer.image, layer.clamps, uses_alpha=layer.laid is Laid.OVER)


def _frames(material: Material) -> list[_Reading]:
    """Those that its base image turns into, the first one first; none where it is always one."""
    return [_reading(material)._replace(image=image) for image in material.motion.frames]


def _layer_frames(layer: Layer) -> list[_Reading]:
    own = _reading_layer(layer)
    return [own._replace(image=image) for image in layer.motion.frames]


def _readings(material: Material) -> list[_Reading]:
    """All that it reads."""
    readings = [_reading(material), *_frames(material)]
    if material.layer is not None:
        readings += [_reading_layer(material.layer), *_layer_frames(material.layer)]
    return readings


class GpuScene:
    """Everything that stays the same from frame to frame, uploaded once.

    Attributes:
        scene: What was uploaded.
        vertices: The mesh's vertices, one buffer.
        tints: The mesh's tints, where it has any.
        sprites: What its sprites turn about, where it has any.
        shown_baked: What was baked or traced, once it has been wanted.
        lightmaps: From then on, all of its lightmaps in one texture.
        baked: From then on, how that lights the mesh's vertices.
        frame_block: Uniform buffer for one `blocks.FRAME`.
        frame_block_holds: What it was last filled from; whoever fills it compares.
        crowd: The characters' figures.
        sky: The sky's cube map with all MIP levels.
        clouds: Images of its clouds, where they move.
        behind_clouds: The cube map behind them, if there is one.
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
        sprites = scene.mesh.sprites
        self.sprites = None if sprites is None else context.buffer(sprites.tobytes())
        self.shown_baked: BakedLight | TracedLight | None = None
        self.lightmaps: moderngl.Texture | None = None
        self.baked: moderngl.Buffer | None = None
        self.frame_block = context.buffer(reserve=FRAME.itemsize, dynamic=True)
        self.frame_block_holds: object = None
        self._white = textures.upload(context, np.full((1, 1, 4), 255, np.uint8))
        self._images: dict[_Reading, moderngl.Texture] = {}
        self._shown_as: dict[_Reading, _Reading] = {}
        wanted: dict[str | None, set[_Reading]] = {}
        for material in scene.worn:
            for reading in _readings(material):
                wanted.setdefault(reading.image, set()).add(reading)
        images = scene.images
        for number, image in decode_all(scene.archive, images):
            if not isinstance(image, Image):
                self.problems.append(image)
                continue
            for reading in wanted.pop(images[number], ()):
                # Without alpha, those who would read it share the texture of those who do not.
                shown = reading._replace(uses_alpha=reading.uses_alpha and image.has_alpha)
                if shown not in self._images:
                    self._images[shown] = textures.upload(
                        context, image.pixels, with_alpha=shown.uses_alpha, clamps=shown.clamps
                    )
                self._shown_as[reading] = shown
        self.sky = textures.upload_cube(context, scene.sky)
        self.clouds: list[moderngl.Texture] = []
        self.behind_clouds: moderngl.TextureCube | None = None
        if scene.clouds is not None and scene.clouds.moves:
            self._upload_clouds(scene.clouds)

    def _upload_clouds(self, clouds: Clouds) -> None:
        for layer in clouds.layers:
            self.clouds.append(textures.upload_shown(self.context, layer.image.pixels))
        if clouds.box is not None:
            self.behind_clouds = textures.upload_cube(self.context, clouds.box)

    def upload_baked(self) -> None:
        """See to it that baked light is there, if the level has any. Not inside a frame."""
        level, vertices = self.scene.level, self.scene.mesh.baked
        baked = level.traced or level.baked
        if self.shown_baked is not None or baked is None or vertices is None:
            return
        self.lightmaps = textures.upload_lightmaps(self.context, baked.image())
        self.baked = self.context.buffer(vertices.tobytes() or bytes(20))
        self.shown_baked = baked

    def image_of(self, material: Material) -> moderngl.Texture:
        """A material's base image, or white; materials that read one image alike share it."""
        return self._texture(_reading(material))

    def layer_of(self, material: Material) -> moderngl.Texture | None:
        """What is laid on a material's base image, if anything is."""
        return None if material.layer is None else self._texture(_reading_layer(material.layer))

    def frames_of(self, material: Material) -> list[moderngl.Texture]:
        """The images that a material's base shows one after the other, if there are several."""
        return [self._texture(reading) for reading in _frames(material)]

    def layer_frames_of(self, layer: Layer) -> list[moderngl.Texture]:
        """The images that a layer shows, likewise."""
        return [self._texture(reading) for reading in _layer_frames(layer)]

    def _texture(self, wanted: _Reading) -> moderngl.Texture:
        reading = self._shown_as.get(wanted)
        return self._white if reading is None else self._images[reading]

    def set_anisotropy(self, samples: float) -> None:
        """Texture samples along the steep direction from now on; 1 is plain trilinear."""
        if samples != self._anisotropy:
            self._anisotropy = samples
            for texture in self._images.values():
                texture.anisotropy = samples

    def release(self) -> None:
        """Give the GL objects back."""
        for texture in (*self._images.values(), *self.clouds, self._white):
            texture.release()
        buffers = self.vertices, self.tints, self.sprites, self.baked, self.frame_block
        for thing in (*buffers, self.lightmaps, self.sky, self.behind_clouds, self.crowd):
            if thing is not None:
                thing.release()
