"""The sky: six Quake images as one cube map in OpenGL's orientation, and its low MIP levels.

OpenGL looks a cube map up by a direction and has a left-handed idea of each face's rows and
columns (OpenGL 3.3 core specification, table 3.10). The shader looks up by world direction,
Z up, so each image is turned once, here.
"""

from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage

from followspot.arrays import Floats
from followspot.assets.image import Image, srgb_to_linear

SUFFIXES = ("_rt", "_lf", "_bk", "_ft", "_up", "_dn")
"""Quake's image endings for +X -X +Y -Y +Z -Z as seen from inside."""

MAX_FACE = 2048


@dataclass(frozen=True, eq=False)
class CubeMap:
    """Radiance from every direction, up to a scale.

    Attributes:
        name: What it was made from.
        faces: (6, s, s, 4) uint8, sRGB: faces +X -X +Y -Y +Z -Z of world space with rows and
            columns as glTexImage2D takes them.
    """

    name: str
    faces: NDArray[np.uint8]
    _means: dict[int, Floats] = field(default_factory=dict, init=False, repr=False)

    @property
    def top_level(self) -> float:
        """MIP level of a single texel a face: 9.0 for faces of 512 x 512."""
        return float(np.log2(self.faces.shape[1]))

    def towards_axes(self, level: float | None = None) -> Floats:
        """(6, 3) linear values seen along +X -X +Y -Y +Z -Z at a MIP level.

        A look-up along an axis hits the middle of a face, where four texels of a level meet and
        count alike: at the box-filtered level L the mean of the image's central square of 2^(L+1)
        texels along an edge. The `top_level` has one texel, the mean of the whole face. Between
        two whole levels the values are mixed linearly, as trilinear filtering does.

        Args:
            level: 0 is the full image; none is `top_level`.
        """
        level = min(self.top_level if level is None else level, self.top_level)
        lower = int(np.floor(level))
        mix = level - lower
        low = self._central_mean(lower)
        return low if mix == 0 else low * (1 - mix) + self._central_mean(lower + 1) * mix

    def _central_mean(self, level: int) -> Floats:
        """(6, 3) of a whole level, counted once: the viewer asks in every frame."""
        if level not in self._means:
            self._means[level] = self._counted_mean(level)
        return self._means[level]

    def _counted_mean(self, level: int) -> Floats:
        size = self.faces.shape[1]
        width = min(size, 2 ** (level + 1))
        start = (size - width) // 2
        middle = self.faces[:, start : start + width, start : start + width]
        # Counting bytes first: then 256 values a channel are decoded, in place of a million.
        counts = [PillowImage.fromarray(face).histogram() for face in middle]  # 256 R, G, B, A
        shares = np.reshape(counts, (6, 4, 256))[:, :3] / width**2
        return np.asarray(shares @ _linear_table())


@cache
def _linear_table() -> Floats:
    return srgb_to_linear(np.arange(256) / 255.0).astype(np.float64)


def from_quake_images(name: str, images: list[Image]) -> CubeMap:
    """Turn the six images (in the order of SUFFIXES) into GL faces.

    Seen from inside with world +Z upwards, a side image's columns run to the right. With u, v in
    [-1, 1] rightwards and upwards the images show (Quake 3's sky box):
    rt: (1, -u, v), lf: (-1, u, v), bk: (u, 1, v), ft: (-u, -1, v), up: (-v, -u, 1),
    dn: (v, -u, -1). GL's faces, with s and t rightwards and *downwards* in [-1, 1] of the array:
    +X: (1, -t, -s), -X: (-1, -t, s), +Y: (s, 1, t), -Y: (s, -1, -t), +Z: (s, -t, 1),
    -Z: (-s, -t, -1). Equating the two gives the turns below.
    """
    size = min(MAX_FACE, 1 << int(np.ceil(np.log2(max(max(i.size) for i in images)))))
    rt, lf, bk, ft, up, dn = (_square(image, size) for image in images)
    faces = (
        rt.swapaxes(0, 1),  # u = t, v = -s
        lf[::-1, ::-1].swapaxes(0, 1),  # u = -t, v = s
        bk[::-1],  # u = s, v = t
        ft[:, ::-1],  # u = -s, v = -t
        up.swapaxes(0, 1),  # u = t, v = -s
        dn.swapaxes(0, 1),  # u = t, v = -s
    )
    return CubeMap(name, np.ascontiguousarray(np.stack(faces)))


def _square(image: Image, size: int) -> NDArray[np.uint8]:
    if image.size == (size, size):
        return image.pixels
    picture = PillowImage.fromarray(image.pixels)
    return np.asarray(picture.resize((size, size), PillowImage.Resampling.BICUBIC))
