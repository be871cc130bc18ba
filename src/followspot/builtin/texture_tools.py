"""Tools for textures made by script: noise, layouts of blocks, wear and dirt from height.

Every field is an (h, w) float64 array that tiles without a seam: noise and blurs are made in
the frequency domain, and layouts wrap. Lengths are in texels.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from followspot.arrays import Floats


def _frequencies(shape: tuple[int, int]) -> Floats:
    """Return the distance from zero of each frequency of a field, in cycles a texel."""
    rows, columns = np.fft.fftfreq(shape[0]), np.fft.rfftfreq(shape[1])
    distance: Floats = np.hypot(rows[:, None], columns[None])
    return distance


def noise(
    shape: tuple[int, int],
    seed: int,
    *,
    slope: float = 1.5,
    coarsest: float = np.inf,
    stretch: tuple[float, float] = (1.0, 1.0),
) -> Floats:
    """Return noise of unit deviation whose amplitude falls as frequency to the power ``-slope``.

    Args:
        shape: Height and width.
        seed: Of the random numbers.
        slope: 0 is white, 1 rough, 2 cloudy.
        coarsest: Longest wave kept, in texels.
        stretch: Factors on the waves' length down and across: wood grain, streaks of rain.
    """
    white = np.random.default_rng(seed).standard_normal(shape)
    rows, columns = np.fft.fftfreq(shape[0]), np.fft.rfftfreq(shape[1])
    frequency = np.hypot(rows[:, None] * stretch[0], columns[None] * stretch[1])
    frequency[0, 0] = np.inf
    weight = frequency**-slope * (frequency >= 1 / coarsest)
    field = np.fft.irfft2(np.fft.rfft2(white) * weight, shape)
    scaled: Floats = field / field.std()
    return scaled


def blur(field: Floats, radius: float) -> Floats:
    """Return the field under a Gaussian of standard deviation ``radius``."""
    weight = np.exp(-2 * (np.pi * radius * _frequencies(field.shape)) ** 2)
    smooth: Floats = np.fft.irfft2(np.fft.rfft2(field) * weight, field.shape)
    return smooth


def smoothstep(low: float, high: float, value: ArrayLike) -> Floats:
    """Return the smooth ramp from 0 at ``low`` to 1 at ``high``; ``low`` may be the greater."""
    t = np.clip((np.asarray(value, dtype=np.float64) - low) / (high - low), 0, 1)
    ramp: Floats = t * t * (3 - 2 * t)
    return ramp


def masonry(
    size: int, courses: Sequence[int], lengths: tuple[int, int], seed: int, wobble: float = 0.0
) -> tuple[Floats, Floats, Floats]:
    """Lay blocks in courses.

    Args:
        size: Side of the texture.
        courses: Height of each course; they sum to ``size``.
        lengths: Shortest and longest block.
        seed: Of the random numbers.
        wobble: How far joints stray from straight.

    Returns:
        Distance to the nearest joint; a random number a block, -1 to 1; and another.
    """
    rng = np.random.default_rng(seed)
    y, x = (grid + 0.5 for grid in np.mgrid[0:size, 0:size].astype(np.float64))
    if wobble:
        y = y + wobble * noise((size, size), seed + 1, slope=1.6, coarsest=size / 4)
        x = x + wobble * noise((size, size), seed + 2, slope=1.6, coarsest=size / 4)
    tops = np.concatenate([[0], np.cumsum(courses)])
    course = np.clip(np.searchsorted(tops, y % size, "right") - 1, 0, len(courses) - 1)
    from_bed = np.minimum(y % size - tops[course], tops[course + 1] - y % size)
    distance, first, second = np.empty_like(x), np.empty_like(x), np.empty_like(x)
    for row in range(len(courses)):
        count = max(1, round(size / rng.uniform(*lengths)))
        widths = rng.uniform(*lengths, count)
        joints = np.concatenate([[0], np.cumsum(widths / widths.sum() * size)])
        inside = course == row
        place = (x[inside] + rng.uniform(0, size)) % size
        block = np.clip(np.searchsorted(joints, place, "right") - 1, 0, count - 1)
        distance[inside] = np.minimum(place - joints[block], joints[block + 1] - place)
        first[inside] = rng.uniform(-1, 1, count)[block]
        second[inside] = rng.uniform(-1, 1, count)[block]
    return np.minimum(distance, from_bed), first, second


def cracks(size: int, seed: int, width: float) -> Floats:
    """Return thin lines, 1 on them and 0 elsewhere, along the zeros of a noise, here and there."""
    field = noise((size, size), seed, slope=2.3, coarsest=size / 3)
    steep = np.hypot(*np.gradient(field)) + 1e-6
    here = smoothstep(0.7, 1.5, noise((size, size), seed + 1, slope=2.0, coarsest=size / 2))
    line: Floats = (1 - smoothstep(0, width, np.abs(field) / steep)) * here
    return line


def mix(colour: Floats, other: ArrayLike, share: Floats) -> Floats:
    """Return one colour field, (h, w, 3), gone over to another colour by a share, (h, w)."""
    target = np.asarray(other, dtype=np.float64)
    mixed: Floats = colour + (target - colour) * np.clip(share, 0, 1)[..., None]
    return mixed


def tinted(colour: ArrayLike, *shades: Floats) -> Floats:
    """Return a colour, (3,) or (h, w, 3), brightened by the sum of relative shades, (h, w)."""
    factor = 1 + np.sum(shades, axis=0)
    field: Floats = np.asarray(colour, dtype=np.float64) * factor[..., None]
    return field


def weathered(colour: Floats, height: Floats, *, wear: float, dirt: float, reach: float) -> Floats:
    """Lighten what stands out and darken what lies in pits, as feet and rain do.

    Args:
        colour: (h, w, 3), sRGB 0 to 1.
        height: Height field, about 1 from joint to face.
        wear: How much edges lighten.
        dirt: How much pits darken.
        reach: Over how many texels a place compares itself with its surroundings.
    """
    relief = height - blur(height, reach)
    shade = wear * np.clip(relief, 0, 0.5) - dirt * np.clip(-relief, 0, 0.7)
    return tinted(colour, shade)


def to_image(colour: Floats, alpha: Floats | None = None) -> NDArray[np.uint8]:
    """Return a colour field, sRGB 0 to 1, as an image, with alpha where given."""
    planes = colour if alpha is None else np.dstack([colour, alpha])
    return (np.clip(planes, 0, 1) * 255 + 0.5).astype(np.uint8)
