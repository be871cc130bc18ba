"""The MIP levels that are averaged here: means of what texels stand for, whatever the size."""

import numpy as np
import pytest
from numpy.typing import NDArray

from followspot.gpu import mip_levels
from synthetic import srgb_decoded


def noise(height: int, width: int) -> NDArray[np.uint8]:
    """Straight alpha beside colour, both from 0 to 255."""
    shape = height, width, 4
    return np.random.default_rng(height).integers(0, 256, shape, dtype=np.uint8)


def area_means(values: NDArray[np.float64], height: int, width: int) -> NDArray[np.float64]:
    """(height, width, c) means over equal areas, texels cut where they have to be."""
    for axis, count in enumerate((height, width)):
        size = values.shape[axis]
        sums = np.concatenate([np.zeros_like(values.take([0], axis)), values.cumsum(axis)], axis)
        at = np.arange(count + 1) * size / count
        below = np.minimum(at.astype(int), size - 1)
        part = np.expand_dims(at - below, tuple(range(1, values.ndim))).swapaxes(0, axis)
        whole = sums.take(below, axis) + part * values.take(below, axis)
        values = np.diff(whole, axis=axis) * count / size
    return values


@pytest.mark.parametrize("size", [(1, 1), (64, 64), (16, 1), (1, 9), (7, 12), (5, 3), (33, 100)])
def test_levels_halve_down_to_one_texel(size: tuple[int, int]) -> None:
    shapes = [level.shape[:2] for level in mip_levels.of_srgb(noise(*size))]
    count = max(size).bit_length()
    assert shapes == [tuple(max(n >> k, 1) for n in size) for k in range(1, count)]


@pytest.mark.parametrize("size", [(64, 64), (16, 1), (1, 9), (7, 12), (33, 100)])
def test_levels_are_means_over_area(size: tuple[int, int]) -> None:
    pixels = noise(*size)
    light = srgb_decoded(pixels / 255)
    light[..., 3] = pixels[..., 3] / 255
    shown = pixels.astype(np.float64)
    for srgb, plain in zip(mip_levels.of_srgb(pixels), mip_levels.of_bytes(pixels), strict=True):
        light = area_means(light, *srgb.shape[:2])
        shown = area_means(shown, *plain.shape[:2])
        assert np.abs(plain - shown).max() <= 0.5 + 1e-3
        assert np.abs(srgb[..., 3] / 255 - light[..., 3]).max() <= 0.5 / 255 + 1e-6
        # Half a byte, in linear light, whose bytes lie close together where it is dark.
        low, high = (srgb_decoded((srgb[..., :3] + off) / 255) for off in (-0.51, 0.51))
        assert (low <= light[..., :3]).all()
        assert (light[..., :3] <= high).all()


def test_one_colour_stays_itself() -> None:
    for byte in range(256):
        pixels = np.full((4, 3, 4), byte, np.uint8)
        for level in (*mip_levels.of_srgb(pixels), *mip_levels.of_bytes(pixels)):
            assert (level == byte).all()
