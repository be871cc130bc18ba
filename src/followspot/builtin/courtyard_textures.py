"""The courtyard's textures: each a recipe from a height field to a worn, dirty albedo.

Colours are sRGB from 0 to 1. No light is painted in: the renderer brings its own.
"""

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.builtin.texture_tools import (
    blur,
    cracks,
    masonry,
    mix,
    noise,
    smoothstep,
    tinted,
    to_image,
    weathered,
)

Image = NDArray[np.uint8]

_LIMESTONE = np.array([0.74, 0.68, 0.57])
_MOSS = np.array([0.37, 0.36, 0.25])
_SOOT = np.array([0.25, 0.22, 0.19])


def _grain(size: int, seed: int) -> Floats:
    """Return fine and middling mottle together, unit deviation or so."""
    fine = noise((size, size), seed, slope=0.5, coarsest=24)
    return 0.6 * fine + 0.8 * noise((size, size), seed + 1, slope=1.4, coarsest=size / 3)


def _joints(distance: Floats, joint: float, bevel: float, seed: int) -> Floats:
    """Return 0 in the joints and 1 on the blocks, their edges broken by noise."""
    size = distance.shape[0]
    ragged = distance + 0.7 * noise((size, size), seed, slope=1.0, coarsest=40)
    return smoothstep(joint, joint + bevel, ragged)


def dressed_stone() -> Image:
    """Ashlar of pale limestone in eight courses, tooled faces, drafted edges."""
    size = 512
    distance, tint, warm = masonry(size, [64] * 8, (104, 190), 11)
    face = _joints(distance, 1.0, 3.5, 12)
    tooling = noise((size, size), 13, slope=0.6, coarsest=14, stretch=(0.3, 2.2))
    pits = smoothstep(1.4, 2.4, noise((size, size), 14, slope=0.8, coarsest=30))
    height = face - 0.25 * pits + 0.05 * tooling
    colour = tinted(_LIMESTONE, 0.07 * tint, 0.030 * _grain(size, 15), 0.022 * tooling)
    colour = mix(colour, [0.72, 0.58, 0.42], 0.28 * np.clip(warm, 0, 1))
    colour = mix(colour, [0.63, 0.58, 0.50], 0.9 * (1 - face))
    colour = weathered(colour, height, wear=0.22, dirt=0.36, reach=9)
    stain = smoothstep(0.3, 2.2, noise((size, size), 17, slope=1.5, coarsest=250, stretch=(2, 0.7)))
    return to_image(mix(colour, _SOOT, 0.22 * stain + 0.2 * cracks(size, 18, 1.2)))


def trim_stone() -> Image:
    """Fine limestone without joints, for columns, steps, copings and balusters."""
    size = 512
    height = noise((size, size), 21, slope=1.1, coarsest=90)
    pits = smoothstep(1.7, 2.6, noise((size, size), 22, slope=0.7, coarsest=16))
    veins = noise((size, size), 23, slope=1.4, coarsest=200, stretch=(0.45, 1.5))
    colour = tinted([0.79, 0.735, 0.63], 0.020 * height, 0.028 * veins, 0.02 * _grain(size, 24))
    colour = mix(colour, [0.45, 0.40, 0.33], 0.55 * pits)
    rust = smoothstep(1.0, 2.6, noise((size, size), 26, slope=1.7, coarsest=200))
    return to_image(mix(colour, [0.62, 0.47, 0.31], 0.4 * rust))


def brick() -> Image:
    """Long flat bricks in lime mortar, some burnt dark, some chipped."""
    size = 512
    distance, tint, burnt = masonry(size, [16] * 32, (46, 56), 31, wobble=0.5)
    face = _joints(distance, 1.0, 2.2, 32)
    chips = smoothstep(1.2, 2.0, noise((size, size), 33, slope=1.0, coarsest=24))
    face = face * (1 - 0.8 * chips * (distance < 5))
    colour = tinted([0.57, 0.36, 0.27], 0.13 * tint, 0.05 * _grain(size, 34))
    colour = mix(colour, [0.34, 0.22, 0.20], 0.7 * smoothstep(0.55, 1.0, burnt))
    colour = mix(colour, [0.71, 0.50, 0.36], 0.6 * smoothstep(-0.6, -1.0, burnt))
    mortar = tinted([0.66, 0.60, 0.51], 0.07 * _grain(size, 36))
    colour = mix(colour, mortar, 1 - face)
    colour = weathered(colour, face, wear=0.16, dirt=0.35, reach=5)
    lime = smoothstep(0.8, 2.4, noise((size, size), 38, slope=1.6, coarsest=300))
    return to_image(mix(colour, [0.76, 0.70, 0.62], 0.35 * lime))


def plaster(base: tuple[float, float, float], seed: int, size: int = 1024) -> Image:
    """Lime wash over plaster: trowelled, rain-streaked, fallen off the bricks in places."""
    trowel = noise((size, size), seed, slope=1.6, coarsest=140, stretch=(1.0, 0.6))
    cloud = noise((size, size), seed + 1, slope=1.7, coarsest=420)
    streak = noise((size, size), seed + 2, slope=1.1, coarsest=300, stretch=(1.4, 0.2))
    ragged = noise((size, size), seed + 3, slope=1.35, coarsest=260)
    worn = smoothstep(2.35, 2.43, ragged)
    thin = smoothstep(1.5, 2.35, ragged)
    colour = tinted(
        base, 0.016 * trowel, 0.022 * cloud, 0.022 * streak, 0.012 * _grain(size, seed + 4)
    )
    colour = mix(colour, [0.80, 0.76, 0.68], 0.35 * thin)
    colour = mix(
        colour, _SOOT, 0.06 * smoothstep(0.8, 2.8, -cloud) + 0.4 * cracks(size, seed + 6, 1.0)
    )
    below = np.tile(brick() / 255.0, (size // 512, size // 512, 1))
    colour = mix(colour, below * 0.92, worn)
    edge = np.clip(blur(worn, 2.5) - worn, 0, 1)
    return to_image(tinted(colour, 0.12 * np.clip(worn - blur(worn, 3), -0.4, 0) - 0.25 * edge))


def vault_plaster() -> Image:
    """Whitewash under the vaults, smoky and damp in clouds, sound throughout."""
    size = 512
    cloud = noise((size, size), 61, slope=1.8, coarsest=400)
    damp = smoothstep(0.6, 2.4, noise((size, size), 62, slope=1.6, coarsest=300))
    colour = tinted([0.83, 0.775, 0.67], 0.045 * cloud, 0.016 * _grain(size, 63))
    colour = mix(colour, [0.55, 0.49, 0.38], 0.35 * damp + 0.4 * cracks(size, 64, 1.0))
    return to_image(colour)


def paving() -> Image:
    """Flagstones of several lengths, hollowed by feet, with grit and moss in the joints."""
    size = 1024
    courses = [116, 92, 132, 100, 124, 84, 140, 108, 128]
    distance, tint, warm = masonry(size, courses, (96, 210), 71, wobble=1.8)
    face = _joints(distance, 1.6, 5.0, 72)
    hollow = blur(face, 22)
    pits = smoothstep(1.5, 2.5, noise((size, size), 73, slope=0.8, coarsest=26))
    height = face + 0.3 * hollow - 0.25 * pits
    grain = _grain(size, 74)
    colour = tinted([0.60, 0.555, 0.485], 0.11 * tint, 0.045 * grain)
    colour = mix(colour, [0.62, 0.50, 0.40], 0.38 * np.clip(warm, 0, 1))
    colour = mix(colour, [0.48, 0.48, 0.46], 0.35 * np.clip(-warm, 0, 1))
    earth = tinted([0.47, 0.42, 0.34], 0.10 * grain)
    moist = smoothstep(-0.2, 1.4, noise((size, size), 76, slope=1.7, coarsest=500))
    colour = mix(colour, mix(earth, _MOSS, moist), 1 - face)
    colour = weathered(colour, height, wear=0.25, dirt=0.34, reach=10)
    creep = (1 - smoothstep(0, 26, distance)) * moist * smoothstep(-0.3, 1.2, grain)
    return to_image(mix(colour, _MOSS, 0.4 * creep))


def roof_tiles() -> Image:
    """Barrel tiles: sixteen columns, eight rows; lichen, and soot in the troughs."""
    size = 512
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size
    column, row = np.floor(x * 16), np.floor(y * 8)
    rng = np.random.default_rng(81)
    shift = rng.uniform(-0.06, 0.06, (8, 16))[row.astype(int), column.astype(int)]
    down = (y * 8 + shift) % 1
    round_ = np.sin(np.pi * (x * 16 % 1))
    height = round_ * 0.8 + 0.35 * down
    tint = rng.uniform(-1, 1, (8, 16))[row.astype(int), column.astype(int)]
    colour = tinted([0.59, 0.385, 0.285], 0.16 * tint, 0.05 * _grain(size, 82))
    colour = mix(colour, [0.74, 0.55, 0.38], 0.4 * smoothstep(0.4, 1.0, -tint))
    lip = smoothstep(0.88, 1.0, down)
    trough = 1 - smoothstep(0.05, 0.62, round_)
    colour = tinted(colour, -0.62 * trough, -0.45 * smoothstep(0.12, 0.0, down), 0.12 * lip)
    colour = weathered(colour, height, wear=0.15, dirt=0.2, reach=6)
    lichen = smoothstep(1.0, 2.0, noise((size, size), 84, slope=1.3, coarsest=120))
    return to_image(mix(colour, [0.62, 0.60, 0.47], 0.55 * lichen * round_))


def planks(base: tuple[float, float, float] = (0.50, 0.38, 0.26)) -> Image:
    """Eight upright boards with grain, knots and open joints."""
    size = 512
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size
    board = np.floor(x * 8).astype(int)
    rng = np.random.default_rng(91)
    across = x * 8 % 1
    warp = noise((size, size), 92, slope=1.7, coarsest=200, stretch=(1.6, 0.5))
    knots = np.zeros((size, size))
    for _ in range(10):
        ky, kx, radius = rng.uniform(0, 1), (rng.integers(8) + rng.uniform(0.3, 0.7)) / 8, 0.012
        dy, dx = (y - ky + 0.5) % 1 - 0.5, (x - kx + 0.5) % 1 - 0.5
        knots += np.exp(-((dx / radius) ** 2 + (dy / (2.2 * radius)) ** 2))
    phase = x * 8 * 5 + 0.45 * warp + 2.4 * knots + rng.uniform(0, 9, 8)[board]
    rings = np.sin(2 * np.pi * phase)
    fibre = noise((size, size), 93, slope=0.6, coarsest=60, stretch=(1.6, 0.06))
    tint = rng.uniform(-1, 1, 8)[board]
    joint = smoothstep(0.0, 0.05, np.minimum(across, 1 - across))
    colour = tinted(base, 0.13 * tint, 0.06 * rings, 0.07 * fibre, -0.25 * knots)
    colour = mix(colour, [0.52, 0.47, 0.41], 0.25 * smoothstep(0, 2, warp))
    return to_image(tinted(colour, -0.75 * (1 - joint)))


def iron() -> Image:
    """Forged iron, hammered, with rust where water stands."""
    size = 256
    hammer = noise((size, size), 101, slope=1.2, coarsest=40)
    rust = smoothstep(0.5, 2.0, noise((size, size), 102, slope=1.4, coarsest=90))
    colour = tinted([0.235, 0.23, 0.23], 0.10 * hammer, 0.06 * _grain(size, 103))
    return to_image(mix(colour, [0.36, 0.22, 0.14], 0.6 * rust))


def clay() -> Image:
    """Terracotta thrown on a wheel: fine rings, limy bloom."""
    size = 256
    rings = noise((size, size), 111, slope=0.8, coarsest=60, stretch=(0.03, 1.6))
    bloom = smoothstep(0.5, 2.2, noise((size, size), 112, slope=1.6, coarsest=120))
    colour = tinted([0.66, 0.41, 0.28], 0.05 * rings, 0.04 * _grain(size, 113))
    return to_image(mix(colour, [0.78, 0.69, 0.60], 0.45 * bloom))


def bark() -> Image:
    """Olive bark: deep upright furrows."""
    size = 256
    furrow = noise((size, size), 121, slope=1.1, coarsest=60, stretch=(1.7, 0.4))
    height = smoothstep(-0.8, 0.9, furrow)
    colour = tinted([0.44, 0.38, 0.31], 0.08 * _grain(size, 122))
    return to_image(
        weathered(mix(colour, [0.2, 0.165, 0.13], 1 - height), height, wear=0.3, dirt=0.4, reach=6)
    )


def soil() -> Image:
    """Dark garden earth with gravel."""
    size = 256
    lumps = noise((size, size), 131, slope=1.0, coarsest=30)
    gravel = smoothstep(1.5, 2.1, noise((size, size), 132, slope=1.2, coarsest=14))
    colour = tinted([0.30, 0.235, 0.17], 0.2 * lumps)
    return to_image(mix(colour, [0.52, 0.48, 0.42], gravel))
