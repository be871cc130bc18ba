"""Which places on leaves and grates are there, asked one ray's hit at a time."""

import numpy as np

from followspot.arrays import Floats, Ints, Mask
from followspot.assets.image import Image, decode_all
from followspot.passes.materials import alpha_test_vector
from followspot.scene.material import Material
from followspot.scene.scene import Scene

_WHITE: Floats = np.ones((1, 1))
"""Stands in for an image that is not there."""


class CutOuts:
    """The alpha of a scene's cut-out materials, looked up as the GPU does at its finest level."""

    def __init__(self, scene: Scene) -> None:
        self._material = scene.mesh.material_of_triangle
        self._materials = scene.materials
        self._corners = scene.mesh.indices.reshape(-1, 3)
        self._texcoords = scene.mesh.vertices["texcoord"].astype(np.float64)
        wanted = sorted({m.image for m in scene.materials if m.alpha_test and m.image})
        self._alpha: dict[str, Floats] = {
            wanted[number]: image.pixels[..., 3] / 255.0
            for number, image in decode_all(scene.archive, wanted)
            if isinstance(image, Image)
        }

    def are_there(self, triangles: Ints, weights: Floats) -> Mask:
        """Which places their material's alpha test keeps.

        Args:
            triangles: (n,) numbers of the mesh's triangles, all cut out.
            weights: (n, 3) of the triangles' corners, in the mesh's order.
        """
        place = (self._texcoords[self._corners[triangles]] * weights[..., np.newaxis]).sum(axis=1)
        material, kept = self._material[triangles], np.zeros(len(triangles), bool)
        for number in np.unique(material):
            here = material == number
            scale, shift = alpha_test_vector(self._materials[number])
            kept[here] = self._look(self._materials[number], place[here]) * scale + shift > 0
        return kept

    def _look(self, material: Material, place: Floats) -> Floats:
        """(n,) alpha at texture coordinates (n, 2), mixed from four texels."""
        alpha = self._alpha.get(material.image or "", _WHITE)
        size = np.array(alpha.shape[::-1])
        low = np.floor(place * size - 0.5)
        mix = place * size - 0.5 - low
        result = np.zeros(len(place))
        for corner in np.array([[0, 0], [1, 0], [0, 1], [1, 1]]):
            texel = low.astype(np.int64) + corner
            texel = np.clip(texel, 0, size - 1) if material.clamps else texel % size
            result += alpha[texel[:, 1], texel[:, 0]] * np.abs(1 - corner - mix).prod(axis=1)
        return result
