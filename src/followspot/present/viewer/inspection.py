"""What panels want to know about the picture, and how it is found out: only while they are seen."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.assets.image import linear_to_srgb, srgb_to_linear
from followspot.passes.view import View
from followspot.present.pixel import PixelReport, inspect_pixel
from followspot.present.renderer import Renderer
from followspot.scene.sky import CubeMap

if TYPE_CHECKING:
    from followspot.present.viewer.state import State

THUMBNAIL = 48
"""Pixels along an edge of a material's picture."""

FACE = 96
"""Pixels along an edge of a sky's face."""

CROSS = ("", "+Z", "", "", "+Y", "+X", "-Y", "-X", "", "-Z", "", "")
"""Where each face is, row by row: what meets in the cross meets in the sky, seen from inside."""

_PER_FRAME = 4
"""Thumbnails that are made in a frame: each reads a texture back."""

_EVERY = 20
"""Frames after which a pixel that is followed is looked at again."""


@dataclass(frozen=True)
class Asked:
    """What is wanted; panels say it anew in every frame that they are seen in.

    Attributes:
        shadow_map: Number of a light with a map, to show that.
        texel: Column and row in it, from the top left.
        pixel: Column and row of the picture, from the top left; stays until another is picked.
        follows: Whether that is looked at again and again.
        sky_level: MIP level of the sky's faces.
        thumbnails: Whether materials are shown.
    """

    shadow_map: int | None = None
    texel: tuple[int, int] | None = None
    pixel: tuple[int, int] | None = None
    follows: bool = False
    sky_level: int | None = None
    thumbnails: bool = False

    @property
    def standing(self) -> "Asked":
        """What is still wanted when nobody says it again."""
        return Asked(pixel=self.pixel, follows=self.follows)


@dataclass(frozen=True, eq=False)
class Texel:
    """A shadow map's texel.

    Attributes:
        place: Column and row, from the top left.
        depth: In [0, 1]; 1 is nothing.
        distance: Units along the light's axis.
        position: (3,) world units of what is there.
    """

    place: tuple[int, int]
    depth: float
    distance: float
    position: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Found:
    """What was found of what was asked.

    Attributes:
        shadow_map: As greys.
        texel: Of it.
        pixel: How it came about.
        sky: Its six faces as a cross; see `CROSS`.
        thumbnails: By the material's image.
    """

    shadow_map: moderngl.Texture | None = None
    texel: Texel | None = None
    pixel: PixelReport | None = None
    sky: moderngl.Texture | None = None
    thumbnails: Mapping[str | None, moderngl.Texture] = field(default_factory=dict)


class Inspector:
    """Finds things out with the renderer, and keeps pictures as long as a scene is open."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._level: object = None
        self._thumbnails: dict[str | None, moderngl.Texture] = {}
        self._ranged: tuple[object, tuple[float, float]] = (None, (0.0, 1.0))
        self._sky: tuple[object, moderngl.Texture | None] = (None, None)
        self._pixel: PixelReport | None = None
        self._pixel_asked: object = None
        self._age = 0

    def before(self, renderer: Renderer, state: "State", size: tuple[int, int]) -> None:
        """Look at the pixel that was picked; the picture is drawn over it afterwards."""
        asked = state.asked
        self._age += 1
        if asked.pixel is None or any(p >= s for p, s in zip(asked.pixel, size, strict=True)):
            self._pixel = self._pixel_asked = None
            return
        is_due = asked.follows and self._age >= _EVERY
        if self._pixel_asked == (asked.pixel, id(state.scene.level)) and not is_due:
            return
        self._pixel_asked, self._age = (asked.pixel, id(state.scene.level)), 0
        is_right = state.right is not None and asked.pixel[0] >= state.divider * size[0]
        frame = replace(state.frame(state.looks[is_right]), view=View.FINAL, overlays=frozenset())
        renderer.pipeline.prepare(frame)
        self._pixel = inspect_pixel(renderer, frame, *asked.pixel)

    def after(self, renderer: Renderer, state: "State") -> Found:
        """What else is asked for, when the frame has been drawn."""
        if state.scene.level is not self._level:
            self.release()
            self._level = state.scene.level
        asked = state.asked
        is_shown = any(look.view is View.SHADOW_MAP for look in state.looks)
        number = asked.shadow_map if asked.shadow_map is not None else 0 if is_shown else None
        shadow_map = None
        if number is not None and number < len(renderer.pipeline.shadow.tiles):
            shadow_map = renderer.shadow_map_texture(number, self._range(renderer, number))
        return Found(
            shadow_map,
            None if shadow_map is None else self._texel(renderer, state, number or 0),
            self._pixel,
            self._sky_at(state.scene.sky, asked.sky_level),
            self._thumbnails_of(renderer, state) if asked.thumbnails else {},
        )

    def _range(self, renderer: Renderer, number: int) -> tuple[float, float]:
        """Distances of what is nearest and farthest in a map, found again when it is another."""
        tile = renderer.pipeline.shadow.tiles[number]
        if self._ranged[0] is not tile:
            size = renderer.pipeline.shadow.atlas.height
            distance = renderer.pipeline.shadow.read_distance(number, size)
            there = distance[np.isfinite(distance)]
            ends = (float(there.min()), float(there.max())) if there.size else (tile.near, tile.far)
            self._ranged = tile, (ends[0], max(ends[1], ends[0] + 1.0))
        return self._ranged[1]

    def _texel(self, renderer: Renderer, state: "State", number: int) -> Texel | None:
        if state.asked.texel is None:
            return None
        x, y = state.asked.texel
        shadow, size = renderer.pipeline.shadow, renderer.pipeline.shadow.atlas.height
        if not (0 <= x < size and 0 <= y < size):
            return None
        depth = float(shadow.read_depths(number, (x, y, 1, 1), size)[0, 0])
        tile = shadow.tiles[number]
        ndc = np.array([(x + 0.5) / size, 1 - (y + 0.5) / size, depth, 1.0]) * 2 - 1
        world = np.linalg.solve(tile.clip_from_world, ndc)
        return Texel((x, y), depth, float(tile.distances(np.array(depth))), world[:3] / world[3])

    def _sky_at(self, sky: CubeMap, level: int | None) -> moderngl.Texture | None:
        if level is None:
            return None
        key = id(sky.faces), level
        if self._sky[0] != key:
            if self._sky[1] is not None:
                self._sky[1].release()
            self._sky = key, _texture(self._context, _sheet(sky, level))
        return self._sky[1]

    def _thumbnails_of(
        self, renderer: Renderer, state: "State"
    ) -> Mapping[str | None, moderngl.Texture]:
        gpu_scene = renderer.open(state.scene)
        worn = {m.image: m for m in (*state.scene.materials, *state.scene.crowd.materials)}
        missing = [material for image, material in worn.items() if image not in self._thumbnails]
        for material in missing[:_PER_FRAME]:
            small = _small(gpu_scene.image_of(material))
            self._thumbnails[material.image] = _texture(self._context, small)
        return self._thumbnails

    def release(self) -> None:
        """Give the GL objects back."""
        for texture in (*self._thumbnails.values(), self._sky[1]):
            if texture is not None:
                texture.release()
        self._thumbnails, self._sky = {}, (None, None)


def _texture(context: moderngl.Context, pixels: NDArray[np.uint8]) -> moderngl.Texture:
    """(h, w, 4) sRGB bytes as they are: ImGui shows bytes."""
    height, width = pixels.shape[:2]
    texture = context.texture((width, height), 4, np.ascontiguousarray(pixels))
    texture.filter = moderngl.LINEAR, moderngl.NEAREST
    return texture


def _small(image: moderngl.Texture) -> NDArray[np.uint8]:
    """The MIP level that is about as large as a thumbnail, its bytes as they are, opaque."""
    width, height = image.size
    level = max(0, int(np.log2(max(width, height) / THUMBNAIL)))
    width, height = max(width >> level, 1), max(height >> level, 1)
    raw = np.frombuffer(image.read(level=level, alignment=1), np.uint8)
    pixels = raw.reshape(height, width, 4).copy()
    pixels[..., 3] = 255
    return pixels


def _sheet(sky: CubeMap, level: int) -> NDArray[np.uint8]:
    """(3 FACE, 4 FACE, 4) the faces of a level, their texels as squares, as a cross."""
    size = sky.faces.shape[1] >> level
    linear = srgb_to_linear(np.arange(256, dtype=np.float32) / 255)[sky.faces[..., :3]]
    means = linear.reshape(6, size, 1 << level, size, 1 << level, 3).mean(axis=(2, 4))
    chosen = np.arange(FACE) * size // FACE
    shown = linear_to_srgb(means)[:, chosen][:, :, chosen]
    sides = dict(zip(("+X", "-X", "+Y", "-Y", "+Z", "-Z"), shown, strict=True))
    seen = {  # GL's rows and columns back to those of a picture; see sky.from_quake_images
        "+X": sides["+X"].swapaxes(0, 1),
        "-X": sides["-X"].swapaxes(0, 1)[::-1, ::-1],
        "+Y": sides["+Y"][::-1],
        "-Y": sides["-Y"][:, ::-1],
        "+Z": sides["+Z"].swapaxes(0, 1),
        "-Z": sides["-Z"].swapaxes(0, 1),
    }
    sheet = np.zeros((3 * FACE, 4 * FACE, 4), np.uint8)
    for number, side in enumerate(CROSS):
        if side:
            row, column = divmod(number, 4)
            part = sheet[row * FACE : (row + 1) * FACE, column * FACE : (column + 1) * FACE]
            part[..., :3] = np.round(seen[side] * 255)
            part[..., 3] = 255
    return sheet
