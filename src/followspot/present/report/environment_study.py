"""Light from a sky on surfaces of every direction: the whole sky against its shortcuts.

Ground truth is the sum over all texels of `present.sky_irradiance`. Against it stand the shader's
sum of six directions and spherical harmonics up to order two (Ramamoorthi and Hanrahan, An
Efficient Representation for Irradiance Environment Maps, 2001).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats
from followspot.assets.archive import Archive
from followspot.assets.image import LUMINANCE
from followspot.errors import AssetError
from followspot.present.sky_irradiance import (
    FACE_SIZE,
    irradiance,
    radiance,
    texel_directions,
    texel_solid_angles,
)
from followspot.scene import sky_files
from followspot.scene.sky import SUFFIXES, CubeMap
from followspot.spaces import directions_around

CUBE_FACE_COSINE = math.log(2 + math.sqrt(3)) - math.pi / 6
"""Mean over a cube's face, all its points alike, of the cosine with the face's axis."""


def known_skies(first: CubeMap, archive: Archive) -> list[CubeMap]:
    """A sky, and every one in an archive of which all six images can be read, by name.

    None is black, and none is there twice under several names.
    """
    right = f"{SUFFIXES[0]}."
    bases = {name.rpartition(right)[0] for name in archive.names() if right in name}
    found = {_fingerprint(first): first}
    for base in sorted(bases - {""}):
        try:
            sky = sky_files.read(archive, base)
        except AssetError:
            continue  # its other sides are missing: something else that has a right side
        found.setdefault(_fingerprint(sky), sky)
    return [sky for sky in found.values() if sky.faces[..., :3].any()]


def _fingerprint(sky: CubeMap) -> bytes:
    step = max(sky.faces.shape[1] // FACE_SIZE, 1)
    return sky.faces[:, ::step, ::step].tobytes()


def six_directions(normals: Floats, towards: Floats, *, normalised: bool = True) -> Floats:
    """(n, 3) irradiance as `radiance_from_environment` in ``common/light.glsl`` has it, times pi.

    Args:
        normals: (n, 3) unit.
        towards: (6, 3) values along +X -X +Y -Y +Z -Z; see `CubeMap.towards_axes`.
        normalised: Whether the sum is divided by its weights'.
    """
    weights = np.maximum(np.stack([normals, -normals], axis=2), 0).reshape(-1, 6)
    if normalised:
        weights = weights / weights.sum(axis=1, keepdims=True)
    return np.asarray(math.pi * weights @ towards)


def basis(directions: Floats) -> Floats:
    """(..., 9) real spherical harmonics up to order two at unit directions (..., 3)."""
    x, y, z = np.moveaxis(directions, -1, 0)
    low, high = math.sqrt(3 / (4 * math.pi)), math.sqrt(15 / (4 * math.pi))
    return np.stack(
        [
            np.full_like(x, math.sqrt(1 / (4 * math.pi))),
            *(low * y, low * z, low * x),
            *(high * x * y, high * y * z, high * (3 * z * z - 1) / math.sqrt(12)),
            *(high * x * z, high * (x * x - y * y) / 2),
        ],
        axis=-1,
    )


def project(sky: Floats) -> Floats:
    """(9, 3) coefficients of a sky (6, size, size, 3), by a sum over all its texels."""
    size = sky.shape[1]
    weighted = basis(texel_directions(size)) * texel_solid_angles(size)[..., np.newaxis]
    return np.asarray(weighted.reshape(-1, 9).T @ sky.reshape(-1, 3))


def harmonics(normals: Floats, coefficients: Floats) -> Floats:
    """(n, 3) irradiance from a sky's coefficients (9, 3).

    The cosine dims the orders 0, 1 and 2 by pi, 2 pi / 3 and pi / 4.
    """
    dimming = np.repeat([math.pi, 2 * math.pi / 3, math.pi / 4], [1, 3, 5])
    return np.asarray(basis(normals) * dimming @ coefficients)


def sphere(count: int) -> Floats:
    """(count + 14, 3) unit vectors: evenly spread ones, the axes, and the cube's corners.

    Corners and axes are where six directions are farthest off.
    """
    signs = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, 8).T / math.sqrt(3)
    return np.concatenate([directions_around(count), np.eye(3), -np.eye(3), signs])


def grid(rows: int) -> Floats:
    """(rows * 2 rows, 3) unit vectors by elevation from +90 degrees down, azimuth from -180 up."""
    up = np.pi / 2 - (np.arange(rows) + 0.5) * np.pi / rows
    round_z = (np.arange(2 * rows) + 0.5) * np.pi / rows - np.pi
    e, a = (values.ravel() for values in np.meshgrid(up, round_z, indexing="ij"))
    return np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=1)


def relative_error(approximate: Floats, exact: Floats) -> Floats:
    """(n,) signed relative differences of the luminance of colours (n, 3)."""
    truth = exact @ LUMINANCE
    return np.asarray((approximate @ LUMINANCE - truth) / truth)


SIX, LITERAL, TRUE_SIX, HARMONICS = "six directions", "not normalised", "true axes", "harmonics"
"""The shader's sum; the same without dividing by the weights' sum; with the true irradiance along
each axis in place of the face's mean; spherical harmonics up to order two."""


@dataclass(frozen=True, eq=False)
class SkyErrors:
    """How far shortcuts miss one sky's irradiance, in luminance, over all normals.

    Attributes:
        name: The sky's.
        truth: (n,) luminance of the irradiance.
        errors: (n,) signed relative errors by the name of the shortcut.
        by_level: Mean error of six directions looked up at the MIP levels 0, 1, ... of the faces,
            as a share of the mean irradiance.
    """

    name: str
    truth: Floats
    errors: Mapping[str, Floats]
    by_level: Floats

    def largest(self, shortcut: str) -> float:
        """Largest relative error."""
        return float(np.abs(self.errors[shortcut]).max())

    def mean(self, shortcut: str) -> float:
        """Mean relative error."""
        return float(np.abs(self.errors[shortcut]).mean())

    def of_mean(self, shortcut: str) -> float:
        """Largest error as a share of the mean irradiance."""
        return float(np.abs(self.errors[shortcut] * self.truth).max() / self.truth.mean())

    def mean_of_mean(self, shortcut: str) -> float:
        """Mean error as a share of the mean irradiance."""
        return float(np.abs(self.errors[shortcut] * self.truth).mean() / self.truth.mean())


def study(skies: Sequence[CubeMap], normals: Floats, *, levels: bool = True) -> list[SkyErrors]:
    """Errors of all shortcuts for skies.

    Args:
        skies: None black.
        normals: (n, 3) unit, evenly spread.
        levels: Whether six directions are tried at every MIP level.
    """
    axes = np.stack([np.eye(3), -np.eye(3)], axis=1).reshape(6, 3)
    whole = [radiance(sky) for sky in skies]
    truths = irradiance(np.concatenate([normals, axes]), whole)
    result = []
    for k, sky in enumerate(skies):
        truth, along_axes = truths[k, :-6], truths[k, -6:]
        towards = sky.towards_axes()
        shortcuts = {
            SIX: six_directions(normals, towards),
            LITERAL: six_directions(normals, towards, normalised=False),
            TRUE_SIX: six_directions(normals, along_axes / math.pi),
            HARMONICS: harmonics(normals, project(whole[k])),
        }
        errors = {name: relative_error(values, truth) for name, values in shortcuts.items()}
        luminance = truth @ LUMINANCE
        by_level = [
            np.abs(six_directions(normals, sky.towards_axes(level)) @ LUMINANCE - luminance).mean()
            for level in (range(int(sky.top_level) + 1) if levels else ())
        ]
        by_level = np.array(by_level) / luminance.mean()
        result.append(SkyErrors(sky.name, luminance, errors, by_level))
    return result
