"""The courtyard's textures for things: water, flames, leaves, cloth, windows and doors."""

import numpy as np

from followspot.builtin.courtyard_textures import Image, iron, planks
from followspot.builtin.texture_tools import mix, noise, smoothstep, tinted, to_image


def water() -> Image:
    """Shallow water over stone, for an additive glaze: dark, with ripples."""
    size = 256
    ripple = noise((size, size), 141, slope=1.5, coarsest=90)
    glint = smoothstep(0.9, 2.6, noise((size, size), 142, slope=1.3, coarsest=50))
    return to_image(mix(tinted([0.20, 0.31, 0.33], 0.16 * ripple), [0.55, 0.62, 0.62], 0.4 * glint))


def flames() -> list[Image]:
    """Four frames of a lamp's flame on black, to be added to what is behind it."""
    frames = []
    y, x = (np.mgrid[0:128, 0:64] + 0.5) / 64
    for frame in range(4):
        sway = noise((128, 64), 151 + frame, slope=1.8, coarsest=64)
        side = x - 0.5 - 0.05 * sway * (2 - y)
        height = np.clip((1.8 - y) / 1.6, 0, 1)
        width = 0.30 * np.sqrt(height) * (1 - height) ** 0.75 + 1e-6
        body = np.clip(1 - (side / (1.9 * width)) ** 2, 0, 1) * smoothstep(1.86, 1.7, y)
        core = np.clip(1 - (side / width) ** 2, 0, 1) * smoothstep(1.86, 1.6, y)
        colour = body[..., None] ** 1.5 * np.array([0.95, 0.42, 0.08])
        colour += core[..., None] * np.array([0.30, 0.45, 0.30])
        frames.append(to_image(colour * smoothstep(0.0, 0.25, y)[..., None]))
    return frames


def leaves(seed: int = 161, blossom: float = 0.0) -> Image:
    """A spray of leaves, their outline in the alpha channel; a share of them is in blossom.

    Each leaf is an ellipse with a lighter midrib, a narrow one where nothing blossoms; later
    leaves lie over earlier ones.
    """
    size, count = 256, 120
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:size, 0:size] + 0.5
    colour = np.broadcast_to(np.array([0.33, 0.37, 0.20]), (size, size, 3)).copy()
    alpha = np.zeros((size, size))
    radius = size * 0.44 * np.sqrt(rng.uniform(0.0, 1.0, count))
    turn = rng.uniform(0, 2 * np.pi, count)
    for k in np.argsort(rng.uniform(size=count)):
        cx, cy = size / 2 + radius[k] * np.cos(turn[k]), size / 2 + radius[k] * np.sin(turn[k])
        angle = turn[k] + rng.normal(0, 0.9)
        along = (x - cx) * np.cos(angle) + (y - cy) * np.sin(angle)
        across = -(x - cx) * np.sin(angle) + (y - cy) * np.cos(angle)
        length = size * rng.uniform(0.055, 0.085)
        width = length * (0.36 if not blossom else 0.62)
        shape = 1 - (along / length) ** 2 - (across / width) ** 2
        tone = rng.uniform(0.75, 1.25)
        petal = rng.uniform() < blossom
        hue = np.array([0.74, 0.20, 0.43]) if petal else np.array([0.36, 0.42, 0.20])
        leaf = tone * hue + rng.uniform(0, 0.09)
        rib = 0.25 * np.exp(-((across / (0.05 * length)) ** 2))
        colour = mix(colour, leaf[None, None] * (1 + rib)[..., None], (shape > 0).astype(float))
        alpha = np.maximum(alpha, smoothstep(-0.12, 0.12, shape))
    return to_image(colour, alpha)


def banner() -> Image:
    """Red cloth with a gold sun and border, its foot cut in two tails."""
    height, width = 512, 256
    y, x = np.mgrid[0:height, 0:width] + 0.5
    u, v = x / width - 0.5, y / width
    weave = noise((height, width), 171, slope=0.4, coarsest=6)
    fold = noise((height, width), 172, slope=2.0, coarsest=200, stretch=(3.0, 0.5))
    colour = tinted([0.50, 0.10, 0.09], 0.05 * weave, 0.07 * fold)
    gold = tinted([0.80, 0.61, 0.24], 0.06 * weave, 0.07 * fold)
    r, angle = np.hypot(u, v - 0.72), np.arctan2(v - 0.72, u)
    rays = smoothstep(0.012, -0.012, r - 0.27 - 0.06 * np.cos(12 * angle)) * (r > 0.20)
    sun = np.maximum(smoothstep(0.17, 0.16, r), rays)
    foot = 1.80 - 0.32 * (0.5 - np.abs(u)) * 2  # the lower edge: two points
    border = smoothstep(0.44, 0.445, np.abs(u)) * smoothstep(0.475, 0.47, np.abs(u))
    hem = smoothstep(0.05, 0.047, np.abs(v - foot + 0.09))
    colour = mix(colour, gold, np.maximum(np.maximum(sun, border), hem * (np.abs(u) < 0.475)))
    faded = smoothstep(0.2, 2.2, noise((height, width), 173, slope=1.6, coarsest=180))
    colour = mix(colour, [0.62, 0.36, 0.28], 0.22 * faded)
    return to_image(colour, smoothstep(0.006, -0.006, v - foot))


def window() -> Image:
    """A barred window: dark panes in lead, frame of stone."""
    size = 256
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size
    frame = np.maximum(np.abs(x - 0.5), np.abs(y - 0.5)) > 0.43
    diagonal_1, diagonal_2 = (x + y) * 9 % 1, (x - y) * 9 % 1
    lead = np.minimum(np.abs(diagonal_1 - 0.5), np.abs(diagonal_2 - 0.5)) < 0.06
    pane = np.random.default_rng(181).uniform(-1, 1, (40, 40))
    which = pane[((x + y) * 9 + 0.5).astype(int), ((x - y) * 9 + 20.5).astype(int)]
    colour = tinted([0.14, 0.17, 0.18], 0.35 * which)
    colour = mix(colour, [0.10, 0.10, 0.10], lead.astype(float))
    wood = planks()[:size, :size] / 255.0 * 0.75
    return to_image(mix(colour, wood, frame.astype(float)))


def door() -> Image:
    """A plank door with iron straps and studs; fits a leaf once."""
    image = planks((0.40, 0.27, 0.165)) / 255.0
    size = image.shape[0]
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size
    metal = np.repeat(np.repeat(iron() / 255.0, 2, axis=0), 2, axis=1)
    strap = np.min([np.abs(y - place) for place in (0.14, 0.5, 0.86)], axis=0)
    band = (strap < 0.032) & (x > 0.02) & (x < 0.98)
    studs = np.hypot((x * 8 % 1 - 0.5) / 8, strap) < 0.014
    shade = 0.45 * smoothstep(0.05, 0.03, strap) * ~band
    colour = mix(tinted(image, -shade), metal, band.astype(float))
    return to_image(tinted(colour, 0.5 * (studs & band)))
