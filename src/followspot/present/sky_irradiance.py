"""Light from a whole sky on surfaces of every direction, walls not being asked.

It is the irradiance E(n) = sum of L_j max(0, n.d_j) w_j over all texels j of a cube map, with their
directions d_j and exact solid angles w_j.
"""

from collections.abc import Sequence

import numpy as np

from followspot.arrays import Floats
from followspot.assets.image import to_linear
from followspot.scene.sky import CubeMap

FACE_SIZE = 64
"""Texels along the edge of faces that skies are summed over."""

_CHUNK = 512  # normals at a time, whose cosines with all texels are held in memory


def texel_directions(size: int) -> Floats:
    """(6, size, size, 3) unit world directions of the middles of a cube map's texels.

    OpenGL 3.3 core specification, table 3.10; see `scene/sky.py`.
    """
    t, s = np.meshgrid(*[(np.arange(size) + 0.5) * 2 / size - 1] * 2, indexing="ij")
    one = np.ones_like(s)
    faces = [
        (one, -t, -s), (-one, -t, s), (s, one, t), (s, -one, -t), (s, -t, one), (-s, -t, -one)
    ]  # fmt: skip
    directions = np.stack([np.stack(face, axis=-1) for face in faces])
    return np.asarray(directions / np.linalg.norm(directions, axis=-1, keepdims=True))


def texel_solid_angles(size: int) -> Floats:
    """(size, size) steradians of the texels of one face, exactly.

    A rectangle from the face's middle to (s, t) covers atan(s t / sqrt(1 + s^2 + t^2)), by Gauss'
    and Bonnet's theorem; a texel is what four of them leave.
    """
    edge = np.linspace(-1, 1, size + 1)
    s, t = edge[np.newaxis], edge[:, np.newaxis]
    covered = np.arctan2(s * t, np.sqrt(1 + s * s + t * t))
    return np.asarray(np.diff(np.diff(covered, axis=0), axis=1))


def radiance(sky: CubeMap, size: int = FACE_SIZE) -> Floats:
    """(6, size, size, 3) linear values, every one the mean of a square of texels.

    Faces that are smaller are made larger, every texel a square. Sizes are powers of two.
    """
    linear = to_linear(sky.faces)[..., :3]
    times = max(size // linear.shape[1], 1)
    linear = linear.repeat(times, axis=1).repeat(times, axis=2)
    edge = linear.shape[1] // size
    rows = linear.reshape(6, size, edge, -1).mean(axis=2, dtype=np.float64)
    return np.asarray(rows.reshape(6, size, size, edge, 3).mean(axis=3))


def irradiance(normals: Floats, skies: Sequence[Floats]) -> Floats:
    """Irradiance by a sum over all texels, for many skies of one size at once.

    Args:
        normals: (n, 3) unit.
        skies: Each (6, size, size, 3).

    Returns:
        (skies, n, 3) in the skies' unit times steradians.
    """
    size = skies[0].shape[1]
    directions = texel_directions(size).reshape(-1, 3).astype(np.float32)
    light = np.stack(skies, axis=3) * texel_solid_angles(size)[..., np.newaxis, np.newaxis]
    light = light.reshape(len(directions), -1).astype(np.float32)
    result = np.empty((len(normals), light.shape[1]))
    for start in range(0, len(normals), _CHUNK):
        cosines = normals[start : start + _CHUNK].astype(np.float32) @ directions.T
        result[start : start + _CHUNK] = np.maximum(cosines, 0, out=cosines) @ light
    return np.moveaxis(result.reshape(len(normals), len(skies), 3), 1, 0)
