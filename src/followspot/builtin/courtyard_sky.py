"""The courtyard's sky: six images of an analytic daylight sky with clouds."""

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.builtin.texture_tools import noise, smoothstep

SUFFIXES = ("rt", "lf", "bk", "ft", "up", "dn")
"""Images of +X -X +Y -Y +Z -Z as seen from inside, by the game's names."""

TURBIDITY = 2.8
"""Haziness of the air: 2 is very clear, 10 is hazy."""

EXPOSURE = 0.045
"""White, in 1 / (kcd/m2): the zenith comes out mid blue, sunlit cloud nearly white."""


def face_directions(suffix: str, size: int) -> Floats:
    """Return the unit direction, (size, size, 3), that each pixel of a sky image shows.

    Pixel centres; rows from the top of the image down. With s rightwards and t upwards in
    [-1, 1] the game's images look along these vectors before normalisation.
    """
    s = (np.arange(size) + 0.5) / size * 2 - 1
    s, t = np.meshgrid(s, -s)
    one = np.ones_like(s)
    vectors = {
        "rt": (one, -s, t),
        "lf": (-one, s, t),
        "bk": (s, one, t),
        "ft": (-s, -one, t),
        "up": (-t, -s, one),
        "dn": (t, -s, -one),
    }
    directions = np.stack(vectors[suffix], axis=2)
    unit: Floats = directions / np.linalg.norm(directions, axis=2, keepdims=True)
    return unit


def daylight(directions: Floats, sun: Floats, turbidity: float) -> Floats:
    """Return the clear sky's colour, (..., 3) linear sRGB in kcd/m2, towards unit vectors above.

    The model of Preetham, Shirley and Smits, "A Practical Analytic Model for Daylight" (SIGGRAPH
    1999), with the coefficients of its appendix A.2; symbols are the paper's.
    """
    T, theta_s = turbidity, np.arccos(sun[2])
    distribution = np.array(
        [  # A B C D E for Y, x, y
            [0.1787 * T - 1.4630, -0.0193 * T - 0.2592, -0.0167 * T - 0.2608],
            [-0.3554 * T + 0.4275, -0.0665 * T + 0.0008, -0.0950 * T + 0.0092],
            [-0.0227 * T + 5.3251, -0.0004 * T + 0.2125, -0.0079 * T + 0.2102],
            [0.1206 * T - 2.5771, -0.0641 * T - 0.8989, -0.0441 * T - 1.6537],
            [-0.0670 * T + 0.3703, -0.0033 * T + 0.0452, -0.0109 * T + 0.0529],
        ]
    )
    chi = (4 / 9 - T / 120) * (np.pi - 2 * theta_s)
    powers = np.array([theta_s**3, theta_s**2, theta_s, 1.0])
    turbid = np.array([T**2, T, 1.0])
    zenith_x = [
        [0.00166, -0.00375, 0.00209, 0.0],
        [-0.02903, 0.06377, -0.03202, 0.00394],
        [0.11693, -0.21196, 0.06052, 0.25886],
    ]
    zenith_y = [
        [0.00275, -0.00610, 0.00317, 0.0],
        [-0.04214, 0.08970, -0.04153, 0.00516],
        [0.15346, -0.26756, 0.06670, 0.26688],
    ]
    zenith = np.array(
        [
            (4.0453 * T - 4.9710) * np.tan(chi) - 0.2155 * T + 2.4192,
            turbid @ np.array(zenith_x) @ powers,
            turbid @ np.array(zenith_y) @ powers,
        ]
    )

    def perez(cos_theta: Floats, gamma: Floats) -> Floats:
        A, B, C, D, E = distribution
        above = np.maximum(cos_theta, 0.01)[..., None]
        angle = gamma[..., None]
        gradation = 1 + A * np.exp(B / above)
        indicatrix = 1 + C * np.exp(D * angle) + E * np.cos(angle) ** 2
        value: Floats = gradation * indicatrix
        return value

    gamma = np.arccos(np.clip(directions @ sun, -1, 1))
    ratio = perez(directions[..., 2], gamma) / perez(np.ones(1), np.array([theta_s]))
    Y, x, y = np.moveaxis(zenith * ratio, -1, 0)
    xyz = np.stack([x / y * Y, Y, (1 - x - y) / y * Y], axis=-1)
    colour: Floats = np.maximum(xyz @ _SRGB_FROM_XYZ.T, 0)
    return colour


_SRGB_FROM_XYZ = np.array(  # IEC 61966-2-1
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)


_EARTH = np.array([1.9, 2.3, 2.4])
"""Radiance of distant ground in the sun, linear sRGB in kcd/m2."""


def _sample(field: Floats, u: Floats, v: Floats) -> Floats:
    """Return a tiling field at places in tiles, between texels linearly."""
    size = field.shape[0]
    u, v = u * size, v * size
    i, j = np.floor(u).astype(int), np.floor(v).astype(int)
    a, b = u - i, v - j
    i0, j0, i1, j1 = i % size, j % size, (i + 1) % size, (j + 1) % size
    top = field[j0, i0] * (1 - a) + field[j0, i1] * a
    mixed: Floats = top * (1 - b) + (field[j1, i0] * (1 - a) + field[j1, i1] * a) * b
    return mixed


def _clouds(directions: Floats, sun: Floats) -> tuple[Floats, Floats]:
    """Return how much cloud stands in each direction, 0 to 1, and how sunlit it is, 0 to 1.

    Fair-weather cumulus on a curved layer: thresholded noise, thicker towards the middle, and
    brighter where there is less of it between here and the sun.
    """
    billows = noise((1024, 1024), 301, slope=1.75, coarsest=210)
    wisps = noise((1024, 1024), 302, slope=1.6, coarsest=300, stretch=(0.5, 2.0))
    up = np.maximum(directions[..., 2], 0.0) + 0.10  # the layer curves down to the horizon
    u, v = directions[..., 0] / up * 0.11, directions[..., 1] / up * 0.11
    high = smoothstep(0.06, 0.35, directions[..., 2])

    def thickness(u: Floats, v: Floats) -> Floats:
        return np.maximum(_sample(billows, u, v) - 0.62, 0.0)

    step = sun[:2] / np.hypot(sun[0], sun[1]) * 0.006
    here = thickness(u, v)
    ahead = sum(thickness(u + k * step[0], v + k * step[1]) for k in (1, 2, 4)) / 3
    cover = 1 - np.exp(-3.2 * here * smoothstep(-0.01, 0.12, directions[..., 2]))
    sunlit = np.exp(-1.5 * ahead) * np.exp(-0.35 * here)
    veil = 0.22 * smoothstep(0.4, 2.2, _sample(wisps, u * 0.6 + 0.3, v * 0.6)) * high
    both = cover + veil * (1 - cover)
    return both, np.where(
        both > 0, (cover * sunlit + veil * (1 - cover)) / np.maximum(both, 1e-9), 1
    )


def sky_radiance(directions: Floats, sun: Floats) -> Floats:
    """Return the picture's radiance, (..., 3) linear sRGB, towards unit vectors.

    Clear daylight, clouds over it, the sun's disc and the haze about it; hazy earth below.
    """
    upward = directions.copy()
    upward[..., 2] = np.maximum(upward[..., 2], 0.015)
    upward /= np.linalg.norm(upward, axis=-1, keepdims=True)
    clear = daylight(upward, sun, TURBIDITY)
    cover, sunlit = _clouds(directions, sun)
    toward = np.clip(directions @ sun, 0, 1)[..., None]
    lit = np.array([24.0, 21.5, 18.0]) * (0.75 + 0.9 * toward**12)  # kcd/m2, low warm sun
    shade = np.array([6.6, 7.3, 8.6])
    cloud = shade + (lit - shade) * sunlit[..., None]
    far = np.exp(-np.maximum(directions[..., 2:], 0) / 0.09)
    cloud = cloud + (clear - cloud) * 0.75 * far
    sky = clear + (cloud - clear) * cover[..., None]
    angle = np.degrees(np.arccos(np.clip(directions @ sun, -1, 1)))[..., None]
    disc = 400.0 * smoothstep(0.5, 0.3, angle) + 30.0 * np.exp(-angle / 1.2)
    sky = sky + disc * np.array([1.0, 0.86, 0.66]) * (1 - 0.8 * cover[..., None])
    for share, ridge in _hills(directions):
        below = smoothstep(0.003, -0.003, directions[..., 2] - ridge)[..., None]
        sky = sky + (_EARTH + (clear - _EARTH) * share - sky) * below
    haze = np.exp(np.minimum(directions[..., 2:], 0) / 0.25)
    radiance: Floats = np.where(directions[..., 2:] < 0, _EARTH + (sky - _EARTH) * haze, sky)
    return radiance


def _hills(directions: Floats) -> list[tuple[float, Floats]]:
    """Return ridges, the farther first: how much haze lies before each, and the sine of its top."""
    around = np.arctan2(directions[..., 1], directions[..., 0]) / (2 * np.pi)
    line = noise((256, 256), 303, slope=1.6, coarsest=128)
    return [
        (haze, height * (1 + 0.45 * _sample(line, around, np.full_like(around, row))))
        for haze, height, row in ((0.66, 0.060, 0.2), (0.34, 0.035, 0.6))
    ]


def sky_images(sun: Floats, size: int = 512) -> dict[str, NDArray[np.uint8]]:
    """Return the six images, (size, size, 3) uint8 sRGB, by suffix.

    Values are proportional to radiance up to about half of white and bend towards white above,
    so that decoded images still light a scene nearly as the sky would.

    Args:
        sun: Unit vector towards the sun.
        size: Side of each image.
    """
    images = {}
    for suffix in SUFFIXES:
        linear = sky_radiance(face_directions(suffix, size), sun) * EXPOSURE
        knee = 0.55
        over = np.maximum(linear - knee, 0) / (1 - knee)
        linear = np.minimum(linear, knee) + (1 - knee) * (1 - np.exp(-over))
        encoded = np.where(
            linear < 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0) ** (1 / 2.4) - 0.055
        )
        images[suffix] = (np.clip(encoded, 0, 1) * 255 + 0.5).astype(np.uint8)
    return images
