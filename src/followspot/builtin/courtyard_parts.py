"""Things that stand about in the courtyard, each a function that returns its parts."""

from collections.abc import Sequence

import numpy as np

from followspot.arrays import Floats
from followspot.builtin.courtyard_materials import Materials
from followspot.levelbuilder import (
    Brush,
    Material,
    Mesh,
    Patch,
    arc,
    box,
    fitted,
    flipped,
    hull,
    lathe,
    polyline,
    prism,
    quads,
    ruled,
)

Part = Brush | Patch | Mesh
Point = tuple[float, float, float]

COLUMN_HEIGHT = 112.0
"""From the floor to where the arches spring, in units."""


def column(m: Materials, x: float, y: float) -> list[Part]:
    """Return a column with plinth, Attic base, swelling shaft, bell capital and abacus."""
    profile = np.array(
        [
            (14.0, 6.0), (17.5, 9.0), (14.0, 12.0),  # torus
            (12.0, 12.5), (12.0, 16.0),  # scotia
            (12.0, 55.0), (10.4, 88.0),  # shaft
            (13.2, 90.0), (10.6, 92.0),  # necking ring
            (10.6, 98.0), (16.5, 102.0),  # bell
        ]
    )  # fmt: skip
    return [
        box((x - 17, y - 17, 0), (x + 17, y + 17, 6), m.stone, detail=True),
        lathe(m.stone, (x, y, 0), profile),
        box((x - 17, y - 17, 102), (x + 17, y + 17, 107), m.stone, detail=True),
        box((x - 18, y - 18, 107), (x + 18, y + 18, COLUMN_HEIGHT), m.stone, detail=True),
    ]


def archivolt(
    m: Materials, spring: Point, across: Point, outward: Point, rise: float
) -> list[Part]:
    """Return the raised ring of stone round an arch's front: its face and its outer edge.

    Args:
        m: The materials.
        spring: Left springing point on the wall's face.
        across: Vector to the right springing point.
        outward: Vector from the wall's face to the ring's.
        rise: Of the arch.
    """
    foot, width, out = np.array(spring), np.array(across), np.array(outward)
    half = arc(180, 0)
    up = np.array([0.0, 0.0, 1.0])

    def ring(factor: float, shift: Floats) -> Floats:
        along = (half[:, :1] * factor + 1) / 2 * width
        curve: Floats = foot + along + half[:, 1:] * rise * factor * up + shift
        return curve

    return [
        ruled(m.stone, ring(1.0, out), ring(1.17, out)),
        ruled(m.stone, ring(1.17, out), ring(1.17, 0 * out)),
        ruled(m.stone, ring(1.0, 0 * out), ring(1.0, out)),
    ]


def balustrade(m: Materials, start: Point, end: Point, spacing: float = 19.0) -> list[Part]:
    """Return rails, posts at both ends and turned balusters along a level line on a floor."""
    a, b = np.array(start), np.array(end)
    length = float(np.linalg.norm(b - a))
    along = (b - a) / length
    side = np.array([-along[1], along[0], 0.0])

    def bar(begin: float, finish: float, half: float, low: float, high: float) -> Brush:
        corners = np.stack([a + along * begin - side * half, a + along * finish + side * half])
        corners[:, 2] = a[2] + low, a[2] + high
        return box(corners.min(axis=0), corners.max(axis=0), m.stone, detail=True)

    parts: list[Part] = [bar(0, length, 5, 0, 4), bar(0, length, 6, 27, 32)]
    for place in (0.0, length):
        parts += [bar(place - 8, place + 8, 8, 0, 34), bar(place - 10, place + 10, 10, 34, 38)]
    profile = np.array([(2.6, 4), (2.6, 7), (4.8, 10), (5.6, 15), (2.2, 20), (1.8, 24), (3.2, 27)])
    count = max(1, round((length - 16) / spacing))
    for k in range(count):
        foot = a + along * (8 + (length - 16) * (k + 0.5) / count)
        parts.append(lathe(m.stone, foot, profile, pieces=4))
    return parts


def torch(m: Materials, wall: Point, outward: tuple[float, float]) -> tuple[list[Part], Point]:
    """Return an iron torch on a wall and where its flame is.

    Args:
        m: The materials.
        wall: Point on the wall at the height of its bracket.
        outward: Unit vector (x, y) away from the wall.
    """
    out = np.array([*outward, 0.0])
    foot = np.array(wall)
    side = np.array([out[1], -out[0], 0.0])
    plate = np.stack([foot - side * 4 - [0, 0, 10], foot + side * 4 + out * 1.5 + [0, 0, 10]])
    arm = np.stack([foot - side * 1.5 - [0, 0, 2], foot + side * 1.5 + out * 13 + [0, 0, 1]])
    cup = foot + out * 13
    bowl = np.array([(1.5, -5.0), (5.0, -2.0), (6.0, 6.0)])
    flame = cup + np.array([0.0, 0.0, 14.0])
    parts: list[Part] = [
        box(plate.min(axis=0), plate.max(axis=0), m.iron, detail=True),
        box(arm.min(axis=0), arm.max(axis=0), m.iron, detail=True),
        lathe(m.iron, cup, bowl, pieces=4),
        flipped(lathe(m.iron, cup, bowl * [0.9, 1.0], pieces=4)),
        crossed(m.flame, flame, 16, 30),
    ]
    return parts, (float(flame[0]), float(flame[1]), float(flame[2]))


def crossed(material: Material, centre: Floats, width: float, height: float) -> Mesh:
    """Return two upright quads that cross at right angles: a flame, a tuft."""
    corners = np.array([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]) / 2
    flat = np.stack([corners[:, 0] * width, 0 * corners[:, 0], corners[:, 1] * height], axis=1)
    turned = flat[:, [1, 0, 2]]
    return quads(material, np.stack([flat, turned]) + centre)


def crate(m: Materials, x: float, y: float, z: float, size: float, turn: float) -> list[Part]:
    """Return a wooden crate of boards with a frame, turned by some degrees."""
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))

    def block(half: Floats, centre: Floats) -> Brush:
        signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
        local = signs * half + centre
        points = np.column_stack(
            [x + cos * local[:, 0] - sin * local[:, 1], y + sin * local[:, 0] + cos * local[:, 1]]
        )
        cloud = np.column_stack([points, z + size / 2 + local[:, 2]])
        return hull(cloud, m.wood, detail=True)

    h, beam = size / 2, size / 14
    parts: list[Part] = [block(np.full(3, h - 1.0), np.zeros(3))]
    for axis in range(3):
        half = np.full(3, beam / 2)
        half[axis] = h
        for u in (-1, 1):
            for v in (-1, 1):
                centre = np.insert(np.array([u, v]) * (h - beam / 2), axis, 0.0)
                parts.append(block(half, centre))
    return parts


def barrel(m: Materials, x: float, y: float, z: float = 0.0) -> list[Part]:
    """Return a barrel of staves with three iron hoops and a lid."""
    staves = np.array([(13.0, 0.0), (19.0, 20.0), (13.0, 40.0)])
    parts: list[Part] = [lathe(m.wood, (x, y, z), staves, repeats=1)]
    for low in (4.0, 17.5, 31.0):
        radii = [16.25 - 3.0 * ((h - 20) / 20) ** 2 for h in (low, low + 4)]
        hoop = polyline([(radii[0], low), (radii[0] + 0.6, low), (radii[1] + 0.6, low + 4)])
        parts.append(lathe(m.iron, (x, y, z), hoop))
    circle = arc(0, 360, 8)[::2][:-1] * 12.6 + [x, y]
    parts.append(prism([tuple(p) for p in circle.tolist()], z + 1, z + 38, m.wood, detail=True))
    return parts


def pot(m: Materials, x: float, y: float, z: float, size: float) -> list[Part]:
    """Return a terracotta pot with earth in it."""
    profile = np.array(
        [
            (0.30, 0.0),
            (0.55, 0.3),
            (0.50, 0.8),
            (0.58, 0.8),
            (0.58, 0.92),
            (0.56, 0.96),
            (0.46, 0.96),
        ]
    )
    circle = arc(0, 360, 8)[::2][:-1] * size * 0.47 + [x, y]
    outline = [tuple(p) for p in circle.tolist()]
    return [
        lathe(m.clay, (x, y, z), profile * size, repeats=2),
        prism(outline, z + 0.6 * size, z + 0.88 * size, m.soil, detail=True),
    ]


def banner(m: Materials, top: Point, across: tuple[float, float], width: float) -> list[Part]:
    """Return a hanging banner twice as high as wide, and its rod.

    Args:
        m: The materials.
        top: Middle of its upper edge.
        across: Unit vector (x, y) rightwards as seen from the front.
        width: In units.
    """
    right = np.array([*across, 0.0])
    front = np.array([across[1], -across[0], 0.0])
    head = np.array(top)
    wave = np.array([0.0, 2.5, -1.0, 1.5, 0.0])
    rows = []
    for drop, sway in ((0.0, 0.2), (1.0, 1.0), (2.0, 1.6)):
        place = np.linspace(-0.5, 0.5, 5)[:, None] * width * right
        rows.append(head + place + front * (wave * sway)[:, None] - [0, 0, drop * width])
    s, t = np.meshgrid(np.linspace(0, 1, 5), [0.0, 0.5, 1.0])
    cloth = Patch(m.banner, np.stack(rows[::-1]), np.stack([s, t], axis=2)[::-1])
    rod = np.stack([head - right * (width / 2 + 4), head + right * (width / 2 + 4)])
    low, high = rod.min(axis=0) - 1.2, rod.max(axis=0) + 1.2
    return [cloth, box(low, high, m.iron, detail=True)]


def opening(
    m: Materials,
    face: Material,
    foot: Point,
    outward: tuple[float, float],
    size: tuple[float, float],
) -> list[Part]:
    """Return a door or window in its stone frame, set against a wall.

    Args:
        m: The materials.
        face: Of the leaf or the panes, fitted once.
        foot: Middle of its lower edge on the wall.
        outward: Unit vector (x, y) away from the wall.
        size: Width and height of the leaf.
    """
    out = np.array([*outward, 0.0])
    side = np.array([out[1], -out[0], 0.0])
    base = np.array(foot)
    half, height = size[0] / 2, size[1]

    def corners(extent: tuple[float, float, float, float], depth: float) -> tuple[Floats, Floats]:
        left, right, low, high = extent
        ends = np.stack([base + side * left, base + side * right + out * depth])
        ends[:, 2] = base[2] + low, base[2] + high
        return ends.min(axis=0), ends.max(axis=0)

    low, high = corners((-half, half, 0, height), 2)
    parts: list[Part] = [box(low, high, face, projection=fitted(), detail=True)]
    for extent, depth in (
        ((-half - 8, -half, 0, height), 5),
        ((half, half + 8, 0, height), 5),
        ((-half - 10, half + 10, height, height + 9), 7),
        ((-half - 12, half + 12, -6, 0), 9),
    ):
        low, high = corners(extent, depth)
        parts.append(box(low, high, m.stone, detail=True))
    return parts


def steps(m: Materials, mins: Sequence[float], maxs: Sequence[float], count: int) -> list[Part]:
    """Return a straight stair that rises towards +y in a box from its foot to its head."""
    (x0, y0, z0), (x1, y1, z1) = mins, maxs
    tread, rise = (y1 - y0) / count, (z1 - z0) / count
    return [
        box((x0, y0 + k * tread, z0), (x1, y1, z0 + (k + 1) * rise), m.stone, detail=True)
        for k in range(count)
    ]
