"""Texture projection: how a flat face gets its texture coordinates.

A projection is a function of a side's plane normal, its whole winding and its material. It
returns the (2, 4) matrix that takes (x, y, z, 1) to texture coordinates (s, t), where one is the
width or height of the texture and t grows downwards, as in the image.
"""

from collections.abc import Callable

import numpy as np

from followspot.arrays import Floats
from followspot.levelbuilder.material import Material
from followspot.levelbuilder.winding import plane_axes

Projection = Callable[[Floats, Floats, Material], Floats]


def world_aligned(
    scale: float = 1.0, offset: tuple[float, float] = (0.0, 0.0), turn: float = 0.0
) -> Projection:
    """Lay the texture flat on the face, its origin at the world's: neighbours go on seamlessly.

    Slopes are measured along themselves, so nothing stretches.

    Args:
        scale: Factor on the material's ``units_per_texel``.
        offset: Shift of the picture right and down, in units.
        turn: Turn of the picture in its plane, in degrees, clockwise.
    """

    def axes(normal: Floats, winding: Floats, material: Material) -> Floats:
        right, down = plane_axes(normal)
        cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        vectors = np.stack([cos * right + sin * down, cos * down - sin * right])
        texels = np.array(material.size) * material.units_per_texel * scale
        return np.concatenate([vectors, -np.array(offset)[:, None]], axis=1) / texels[:, None]

    return axes


def fitted(across: float = 1.0, down: float = 1.0) -> Projection:
    """Stretch the texture over the face's rectangle, repeated ``across`` by ``down`` times."""

    def axes(normal: Floats, winding: Floats, material: Material) -> Floats:
        vectors = np.stack(plane_axes(normal))
        flat = winding @ vectors.T
        low, extent = flat.min(axis=0), np.ptp(flat, axis=0)
        times = np.array([across, down]) / extent
        matrix: Floats = np.concatenate([vectors, -low[:, None]], axis=1) * times[:, None]
        return matrix

    return axes


def apply(matrix: Floats, points: Floats) -> Floats:
    """Return texture coordinates, (..., 2), of points, (..., 3), under a projection's matrix."""
    st: Floats = points @ matrix[:, :3].T + matrix[:, 3]
    return st
