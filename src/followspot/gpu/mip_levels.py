"""The smaller MIP levels of images of bytes, averaged over area.

Where a size is odd, a texel of the next level covers two texels and a part of a third, by the
weights of Guthe and Heckbert, "Non-Power-of-Two Mipmap Creation" (2005).
"""

from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
from numpy.typing import NDArray

from followspot.assets.image import linear_to_srgb, to_linear

_AT_ONCE = 1 << 16
"""Texels that are decoded at once."""

_STEPS = 1 << 16
"""Of linear light, where it is encoded by a table: 20 of them to the darkest byte."""


def of_srgb(pixels: NDArray[np.uint8]) -> Iterator[NDArray[np.uint8]]:
    """All levels below one of (h, w, 4) sRGB with straight alpha, means of linear light."""
    for level in _below(pixels, to_linear):
        encoded = _srgb_bytes().take((level * (_STEPS - 1) + 0.5).astype(np.uint16))
        encoded[..., 3] = level[..., 3] * 255 + 0.5
        yield encoded


def of_bytes(pixels: NDArray[np.uint8]) -> Iterator[NDArray[np.uint8]]:
    """All levels below one of (h, w, c) bytes, means of the bytes themselves."""
    for level in _below(pixels, lambda part: part.astype(np.float32)):
        yield (level + 0.5).astype(np.uint8)


def _below(
    pixels: NDArray[np.uint8], decoded: Callable[[NDArray[np.uint8]], NDArray[np.float32]]
) -> Iterator[NDArray[np.float32]]:
    """Each next level of decoded (h, w, c) pixels, down to one texel."""
    height, width = pixels.shape[:2]
    if max(height, width) == 1:
        return
    # As floats, pixels take far more room: so piece by piece, where none lies in two.
    rows = height if height % 2 else 2 * max(_AT_ONCE // (2 * width), 1)
    tops = range(0, height, rows)
    level = np.concatenate([_next(decoded(pixels[top : top + rows])) for top in tops])
    yield level
    while max(level.shape[:2]) > 1:
        level = _next(level)
        yield level


def _next(level: NDArray[np.float32]) -> NDArray[np.float32]:
    for axis in range(2):
        if level.shape[axis] > 1:
            level = np.moveaxis(_halved(np.moveaxis(level, axis, 0)), 0, axis)
    return level


def _halved(rows: NDArray[np.float32]) -> NDArray[np.float32]:
    """Means over the first axis, which becomes half as long, rounded down."""
    size = len(rows)
    half = size // 2
    if size == 2 * half:
        return (rows[0::2] + rows[1::2]) * np.float32(0.5)
    number = np.arange(half, dtype=np.float32).reshape(-1, *[1] * (rows.ndim - 1))
    weighted = (half - number) * rows[0:-1:2] + half * rows[1::2] + (number + 1) * rows[2::2]
    return (weighted / size).astype(np.float32)


@cache
def _srgb_bytes() -> NDArray[np.uint8]:
    """(_STEPS,) bytes of equal steps of linear light from 0 to 1."""
    return np.rint(linear_to_srgb(np.linspace(0, 1, _STEPS)) * 255).astype(np.uint8)
