"""How that is found out which panels want to know: only while they are seen."""

from collections.abc import Mapping

import moderngl
import numpy as np

from followspot.gpu.blocks import SIDES
from followspot.gpu.gpu_scene import GpuScene
from followspot.passes.shadow_reading import UNFOLDED
from followspot.passes.sky_preview import SkyPreview
from followspot.passes.thumbnails import Thumbnail, Thumbnails
from followspot.passes.view import View
from followspot.present.pixel import PixelReport, inspect_pixel
from followspot.present.renderer import Renderer
from followspot.present.viewer.asking import Asked, Found, Texel
from followspot.present.viewer.state import Look, State
from followspot.scene.light import CubeSide
from followspot.scene.material import Material

_PER_FRAME = 4
"""Thumbnails that are drawn in a frame."""

_EVERY = 20
"""Frames after which a pixel that is followed is looked at again."""


class Inspector:
    """Finds things out with the renderer; its pictures take room once, for all scenes.

    Args:
        context: Where they live.
    """

    def __init__(self, context: moderngl.Context) -> None:
        self._sky = SkyPreview(context)
        self._sky_drawn: object = None
        self._thumbnails = Thumbnails(context)
        self._gpu_scene: GpuScene | None = None
        self._version = -1
        self._map_age = 0
        self._picked: tuple[int, int] | None = None
        self._pixel: PixelReport | None = None
        self._subject: object = None
        self._pixel_age = 0

    def before(self, renderer: Renderer, state: State) -> None:
        """Look at the pixel that was picked; the picture is drawn over it afterwards."""
        self._meet(renderer.open(state.scene))
        pixel, size = state.asked.pixel, renderer.size
        self._pixel_age += 1
        if pixel is None or any(at >= edge for at, edge in zip(pixel, size, strict=True)):
            self._picked = self._pixel = None
            return
        look = state.look_at((pixel[0] + 0.5) / size[0])
        # The same pixel picked again is another tuple.
        is_due = (
            state.asked.follows and self._pixel_age >= _EVERY and self._is_old(state, look, size)
        )
        if pixel is self._picked and not is_due:
            return
        self._pixel = inspect_pixel(renderer, state.frame(look), *pixel)
        subject = _subject(state, look, size, self._pixel)
        self._picked, self._subject, self._pixel_age = pixel, subject, 0

    def _is_old(self, state: State, look: Look, size: tuple[int, int]) -> bool:
        return self._subject != _subject(state, look, size, self._pixel)

    def _meet(self, gpu_scene: GpuScene) -> None:
        """Forget all that was found out of another scene, which can go then."""
        if gpu_scene is not self._gpu_scene:
            self._thumbnails.forget()
            self._gpu_scene = gpu_scene
            self._sky_drawn = self._subject = self._picked = self._pixel = None

    def after(self, renderer: Renderer, state: State) -> Found:
        """What else is asked for, when the frame has been drawn."""
        asked, shadow = state.asked, renderer.pipeline.shadow
        gpu_scene = renderer.open(state.scene)
        self._meet(gpu_scene)
        self._map_age = self._map_age + 1 if shadow.version == self._version else 0
        self._version = shadow.version
        has_maps = _has_maps(state)
        shows_key_map = any(look.view is View.SHADOW_MAP for look in state.looks)
        is_old = False
        if self._picked is not None:
            look = state.look_at((self._picked[0] + 0.5) / renderer.size[0])
            is_old = self._is_old(state, look, renderer.size)
        return Found(
            key_maps=key_maps(renderer, state) if shows_key_map else (),
            shadow_map=None
            if asked.shadow_map is None or not has_maps
            else renderer.shadow_map_texture(asked.shadow_map),
            map_age=self._map_age,
            finer=_finer(renderer, asked) if has_maps else None,
            texel=_texel(renderer, asked) if has_maps else None,
            pixel=self._pixel,
            pixel_is_old=is_old,
            sky=None if asked.sky_level is None else self._sky_at(gpu_scene, asked.sky_level),
            sheet=self._thumbnails.texture,
            thumbnails=self._thumbnails_of(asked.thumbnails, gpu_scene),
        )

    def _sky_at(self, gpu_scene: GpuScene, level: int) -> moderngl.Texture:
        if self._sky_drawn != (gpu_scene, level):
            self._sky.draw(gpu_scene.sky, level)
            self._sky_drawn = gpu_scene, level
        return self._sky.texture

    def _thumbnails_of(
        self, materials: tuple[Material, ...], gpu_scene: GpuScene
    ) -> Mapping[Material, Thumbnail]:
        missing = [material for material in materials if material not in self._thumbnails]
        later = set(missing[_PER_FRAME:])
        return {m: self._thumbnails.of(m, gpu_scene) for m in materials if m not in later}

    def release(self) -> None:
        """Give the GL objects back."""
        self._sky.release()
        self._thumbnails.release()


def _has_maps(state: State) -> bool:
    """Whether a frame draws shadow maps; else those stay that an earlier one has left."""
    return any(state.frame(look).shadowed for look in state.looks)


def key_maps(renderer: Renderer, state: State) -> tuple[moderngl.Texture, ...]:
    """The key light's shadow map as the last frame left it, as greys; or the six of its cube.

    None where the state, which that frame was of, has no light with a map.
    """
    if not _has_maps(state):
        return ()
    first = renderer.pipeline.shadow.layout.lights[:1]
    is_cube = any(isinstance(light, CubeSide) for light in first)
    found = (renderer.shadow_map_texture(number) for number in range(SIDES if is_cube else 1))
    return tuple(texture for texture in found if texture is not None)


def arranged(
    maps: tuple[moderngl.Texture, ...],
) -> tuple[tuple[int, int], tuple[tuple[int, int], ...]]:
    """Columns and rows of a picture of `key_maps`, and row and column of each of them in it."""
    return ((1, 1), ((0, 0),)) if len(maps) == 1 else ((4, 3), UNFOLDED)


def _subject(
    state: State, look: Look, size: tuple[int, int], pixel: PixelReport | None
) -> tuple[object, ...]:
    """All that the values of a pixel follow from; the picture's size says where it looks."""
    seen = () if pixel is None else (pixel.surface, *pixel.in_front)
    names = {surface.material for surface in seen if surface is not None}
    moving = any(each.moves and each.name in names for each in state.scene.materials)
    time = state.time if moving or len(state.scene.crowd) else 0.0
    lit = state.scene.level, state.environment_constant, state.lamps, state.settings
    return *lit, look, size, state.camera, state.culled_from, state.exposure_of(look.view), time


def _finer(renderer: Renderer, asked: Asked) -> float | None:
    """How much smaller texels are in the near tile, if there is one."""
    if asked.shadow_map is None:
        return None
    tiles = renderer.pipeline.shadow.tiles_of(asked.shadow_map)
    if len(tiles) < 2:
        return None
    wide, near = (tile.frustum.texels.prod() for tile in tiles)
    return float(np.sqrt(wide / near))


def _texel(renderer: Renderer, asked: Asked) -> Texel | None:
    """What a texel holds, which waits for the GPU."""
    shadow, number = renderer.pipeline.shadow, asked.shadow_map
    if asked.texel is None or number is None or not shadow.tiles_of(number):
        return None
    (x, y), size, (tile, *finer) = asked.texel, shadow.size, shadow.tiles_of(number)
    if not (0 <= x < size and 0 <= y < size):
        return None
    middle = np.array([(x + 0.5) / size, 1 - (y + 0.5) / size])
    if finer:  # where it holds the texel's middle, the picture shows that one
        scale, shift = tile.finer_from_here
        near = middle * scale + shift
        if (near >= 0).all() and (near < 1).all():
            middle, tile = near, finer[0]
    column, row = int(middle[0] * size), size - 1 - int(middle[1] * size)
    depth = float(shadow.read_depths(tile, (column, row, 1, 1))[0, 0])
    frustum = tile.frustum
    ndc = np.array([(column + 0.5) / size, 1 - (row + 0.5) / size, depth, 1.0]) * 2 - 1
    world = np.linalg.solve(frustum.clip_from_world, ndc)
    distance = float(frustum.distances(np.array(depth)))
    return Texel((x, y), tile.is_near, depth, distance, world[:3] / world[3])
