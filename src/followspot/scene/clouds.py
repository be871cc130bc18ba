"""Clouds: the layers that a sky's script draws before its box, or in place of one.

As they stand at first they are part of the sky's cube map, which lights the scene. Where they move,
pictures show them anew: ``clouds.glsl`` says the same for pixels.

Layers and box are put together as they are displayed, as the game does: a sky is a picture that
somebody has painted, light by light.

They lie on a sphere so large that it looks like a flat layer above the eye: `GROUND_RADIUS` units
and the script's height more about a point `GROUND_RADIUS` below. Texture coordinates are the angles
in radians between the X and Y axes and the place's direction from the sphere's middle, as in
``R_InitSkyTexCoords`` of ioquake3's ``tr_sky.c``. Straight below nothing is drawn.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage

from followspot.assets.image import Image
from followspot.assets.shader_motion import Scale, Transform, Turbulence
from followspot.assets.shader_script import Stage
from followspot.assets.shader_values import BlendFactor
from followspot.scene.material import Color
from followspot.scene.motion import Motion, share
from followspot.scene.sky import CubeMap

GROUND_RADIUS = 4096.0
"""Units."""

SIZE = 256
"""Texels along an edge of a face, where there is no box."""

LIGHT_SIZE = 128
"""Likewise of clouds that move: then the cube map lights the scene, and only the window's
panel of the sky shows it."""

MAX_LAYERS = 4
"""Layers that can move; where there are more, all stand still."""

_BELOW = 5
"""Number of the face that looks down."""

_LARGEST = 2048
"""Texels along an edge of an image that is made finer."""

Values = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Layer:
    """One stage of a sky's script.

    Attributes:
        stage: Of the script.
        image: What it shows.
    """

    stage: Stage
    image: Image

    @cached_property
    def motion(self) -> Motion:
        """What the image does as time goes by."""
        return Motion(self.stage.tc_mods, color=self.stage.color_wave)

    @cached_property
    def _color(self) -> Color:
        return self.stage.color or (1.0, 1.0, 1.0)

    def color_at(self, seconds: float) -> Color:
        """What its texels are multiplied by at a time, as displayed."""
        brightness = share(self.motion.color, seconds)
        red, green, blue = self._color
        return red * brightness, green * brightness, blue * brightness


@dataclass(frozen=True, eq=False)
class Clouds:
    """All of a sky's layers.

    Attributes:
        box: What is behind them; none is black.
        layers: In the order in which they are drawn.
        height: Units that they are above the ground; above 0.
    """

    box: CubeMap | None
    layers: tuple[Layer, ...]
    height: float

    @property
    def moves(self) -> bool:
        """Whether they look otherwise as time goes by."""
        still = (Scale, Transform, Turbulence)  # a sky is not turbulent
        motions = [layer.motion for layer in self.layers]
        scrolls = (not isinstance(mod, still) for each in motions for mod in each.tc_mods)
        return len(motions) <= MAX_LAYERS and (any(each.pulses for each in motions) or any(scrolls))

    def sky(self, name: str) -> CubeMap:
        """A sky of this name with its clouds as they are at time 0."""
        box = self.box
        size = (LIGHT_SIZE if self.moves else SIZE) if box is None else box.faces.shape[1]
        faces = np.zeros((6, size, size, 4), np.uint8)
        faces[..., 3] = 255
        if box is not None:
            faces[:] = box.faces
        sheets = [_Sheet(layer, size) for layer in self.layers]
        for face in range(_BELOW):
            places = coordinates(directions(face, size), self.height)
            shown: Values = faces[face, ..., :3].astype(np.float32) / np.float32(255)
            for sheet in sheets:
                shown = _blended(sheet.blend, *sheet.at(places), shown)
            faces[face, ..., :3] = np.rint(shown * 255)
        return CubeMap(name, faces)


def directions(face: int, size: int) -> Values:
    """(size, size, 3) world directions of the middles of a GL face's texels, not normalised."""
    ends = ((np.arange(size, dtype=np.float32) + 0.5) * 2 / size - 1)[np.newaxis]
    s, t, one = np.broadcast_arrays(ends, ends.T, np.float32(1))
    of_face = (
        (one, -t, -s),
        (-one, -t, s),
        (s, one, t),
        (s, -one, -t),
        (s, -t, one),
        (-s, -t, -one),
    )
    found: Values = np.stack(of_face[face], axis=2)
    return found


def coordinates(directions: Values, height: float) -> Values:
    """(..., 2) texture coordinates of the clouds that are seen along (..., 3) directions."""
    unit = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    up = unit[..., 2:] * GROUND_RADIUS
    # |p unit + (0, 0, radius)| = radius + height, for the p before the eye.
    distance = np.sqrt(up**2 + 2 * GROUND_RADIUS * height + height**2) - up
    place = unit * distance + np.array([0, 0, GROUND_RADIUS], np.float32)
    found: Values = np.arccos((place[..., :2] / (GROUND_RADIUS + height)).clip(-1, 1))
    return found.astype(np.float32)


class _Sheet:
    """A layer's image as fine as the faces' texels, so that the nearest of its own will do."""

    def __init__(self, layer: Layer, size: int) -> None:
        (a, b), (c, d), shift = layer.motion.terms(0.0)[:3]
        turn = np.array([(a, b), (c, d)], np.float32)
        step = math.sqrt(abs(a * d - b * c)) / size  # half of a texel in the middle of a face
        wanted = min(max(round(1 / max(step, 1e-6)), 1), _LARGEST)
        picture = PillowImage.fromarray(layer.image.pixels)
        self._texels = np.asarray(picture.resize((wanted, wanted), PillowImage.Resampling.BICUBIC))
        self._turn, self._shift = turn * wanted, np.array(shift, np.float32) * wanted
        self._color = np.array(layer.color_at(0.0), np.float32)
        self.blend = layer.stage.blend

    def at(self, places: Values) -> tuple[Values, Values]:
        """(h, w, 3) colour as displayed and (h, w, 1) alpha at (h, w, 2) texture coordinates."""
        wanted = len(self._texels)
        columns, rows = np.floor(places @ self._turn + self._shift).transpose(2, 0, 1)
        number = (rows % wanted * wanted + columns % wanted).astype(np.intp)
        found = self._texels.reshape(-1, 4).take(number, axis=0)
        texels = found / np.float32(255)
        return texels[..., :3] * self._color, texels[..., 3:]


def _blended(
    blend: tuple[BlendFactor, BlendFactor] | None, color: Values, alpha: Values, behind: Values
) -> Values:
    """What is displayed, 1 at most, where a layer's color (h, w, 3) has been drawn over another."""
    if blend is None:
        return color
    one = np.ones(1, np.float32)
    factors: dict[BlendFactor, Values] = {
        BlendFactor.ONE: one,
        BlendFactor.ZERO: one * 0,
        BlendFactor.SRC_COLOR: color,
        BlendFactor.ONE_MINUS_SRC_COLOR: one - color,
        BlendFactor.DST_COLOR: behind,
        BlendFactor.ONE_MINUS_DST_COLOR: one - behind,
        BlendFactor.SRC_ALPHA: alpha,
        BlendFactor.ONE_MINUS_SRC_ALPHA: one - alpha,
        BlendFactor.DST_ALPHA: one,  # the game's picture has no alpha: it counts as 1
        BlendFactor.ONE_MINUS_DST_ALPHA: one * 0,
        BlendFactor.SRC_ALPHA_SATURATE: one * 0,
    }
    mixed: Values = color * factors[blend[0]] + behind * factors[blend[1]]
    return mixed.clip(0, 1)
