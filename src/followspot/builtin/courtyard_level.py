"""The courtyard as a level: its buildings, what stands about in them, lights and spawn points."""

import numpy as np

from followspot.builtin.courtyard_buildings import FLOOR, buildings
from followspot.builtin.courtyard_garden import cascade, ivy, olive_tree, pergola, tuft
from followspot.builtin.courtyard_materials import Materials
from followspot.builtin.courtyard_parts import Part, barrel, crate, pot, steps, torch
from followspot.levelbuilder import Level, box, hull, lathe, prism, ruled


def courtyard(m: Materials) -> Level:
    """Return the whole level."""
    level = Level("The Courtyard", ambient=(9.0, 9.0, 10.0))
    level.add(buildings(m), _stair(m), _fountain(m), _furniture(m))
    for wall, outward, value in (
        ((-544, 0, 92), (1, 0), 150.0),
        ((64, 480, 92), (0, -1), 150.0),
        ((-104, -308, 96), (0, 1), 110.0),
        ((488, 120, 66), (-1, 0), 90.0),
        ((200, 480, FLOOR + 76), (0, -1), 110.0),
    ):
        parts, flame = torch(m, wall, outward)
        level.add(parts)
        level.light(flame, value, color=(1.0, 0.62, 0.28))
    level.spawn(120, -200, 0, 110)
    level.spawn(-480, -200, 0, 90)
    level.spawn(-480, 416, 0, 0)
    level.spawn(452, 300, 0, 270)
    level.spawn(-200, 400, FLOOR, 270)
    level.spawn(-460, 40, FLOOR, 0)
    level.entity("info_player_intermission", origin=(300, -280, 96), angles=(6, 132, 0))
    return level


def _stair(m: Materials) -> list[Part]:
    """Return the stair to the gallery with its sloping parapet and newel posts."""
    parts = steps(m, (304, -58, 0), (384, 320, FLOOR), 26)
    foot, head = 34.0, FLOOR + 34.0  # the parapet's top over the first and the last step
    wall = [
        (x, y, z) for x in (296, 304) for y, z in ((-58, 0), (-58, foot), (312, 0), (312, head))
    ]
    rail = [
        (x, y, z + h) for x in (293, 307) for y, z in ((-62, foot - 2), (312, head)) for h in (0, 6)
    ]
    parts += [hull(wall, m.ashlar, detail=True), hull(rail, m.stone, detail=True)]
    parts += [
        box((290, -76, 0), (310, -56, 44), m.stone, detail=True),
        box((287, -79, 44), (313, -53, 50), m.stone, detail=True),
    ]
    parts += pot(m, 300, -66, 50, 20) + tuft(m, 300, -66, 70, 30, 21, blooms=True)
    return parts


def _ring(radius: float) -> list[tuple[float, float]]:
    """Return an octagon about the origin with flat sides to the axes."""
    angles = np.radians(22.5 + 45 * np.arange(8))
    return [(radius * float(np.cos(a)), radius * float(np.sin(a))) for a in angles]


def _fountain(m: Materials) -> list[Part]:
    """Return the eight-sided pool with its bowl on a stem, water in both."""
    outer, inner, cope, lip = _ring(104), _ring(90), _ring(109), _ring(86)
    parts: list[Part] = []
    for k in range(8):
        j = (k + 1) % 8
        parts.append(prism([outer[k], outer[j], inner[j], inner[k]], 6, 26, m.ashlar, detail=True))
        parts.append(prism([cope[k], cope[j], lip[j], lip[k]], 26, 33, m.stone, detail=True))
    parts.append(prism(_ring(122), 0, 6, m.stone, detail=True))
    parts.append(prism(_ring(90), 6, 23, m.water))
    stem = np.array(
        [
            (20.0, 6.0), (22.0, 14.0), (15.0, 18.0),  # foot
            (9.0, 24.0), (9.0, 44.0), (8.0, 58.0), (13.0, 64.0),
            (13.0, 67.0), (30.0, 70.0), (46.0, 74.0), (47.0, 84.0),  # underside of the bowl
        ]
    )  # fmt: skip
    bowl = np.array([(47.0, 84.0), (45.0, 86.0), (43.0, 84.0), (40.0, 75.0), (6.0, 74.0)])
    parts += [
        lathe(m.stone, (0, 0, 0), stem, repeats=2),
        lathe(m.stone, (0, 0, 0), bowl, repeats=2),
    ]
    parts.append(prism(_round(42.5, 16), 76, 81, m.water, detail=True))
    finial = np.array(
        [(7, 74), (5, 84), (5, 92), (5, 96), (10, 97), (11, 104), (4, 108), (3, 114), (0.2, 118)],
        dtype=float,
    )
    parts.append(lathe(m.stone, (0, 0, 0), finial))
    for angle in np.radians([45, 135, 225, 315]):
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        side = np.array([-out[1], out[0], 0.0]) * 2.2
        fall = np.array([out * 47 + [0, 0, 84], out * 62 + [0, 0, 84], out * 66 + [0, 0, 23]])
        sheet = ruled(m.water, fall + side, fall - side)
        parts.append(sheet)
    return parts


def _round(radius: float, count: int) -> list[tuple[float, float]]:
    angles = 2 * np.pi * np.arange(count) / count
    return [(radius * float(np.cos(a)), radius * float(np.sin(a))) for a in angles]


def _furniture(m: Materials) -> list[Part]:
    """Return what is left: tree, pergola, ivy, crates, barrels, pots."""
    parts = olive_tree(m, -236, -150)
    parts += pergola(m, (236, -300), (372, -190))
    parts += ivy(m, (384, -84, 0), (0, -1), (120, 170), 31)
    parts += ivy(m, (-300, -320, 0), (-1, 0), (150, 130), 32)
    parts += ivy(m, (400, 336, FLOOR), (1, 0), (90, 220), 33, 70)
    parts += cascade(m, (168, 311, FLOOR + 32), (1, 0), (170, 96), 34, 130)
    parts += cascade(m, (-376, -60, FLOOR + 32), (0, 1), (180, 90), 35, 110)
    for x, y, z, size, turn in (
        (196, -272, 0, 44, 8), (150, -284, 0, 36, -14), (192, -276, 44, 32, 27),
        (-322, 456, 0, 40, 5), (-362, 458, 0, 30, -12),
    ):  # fmt: skip
        parts += crate(m, x, y, z, size, turn)
    for x, y in ((150, -234), (-342, -288), (-304, -294), (330, 440)):
        parts += barrel(m, x, y)
    for k, (x, y, size) in enumerate(
        ((-140, -292, 30), (146, 300, 34), (-356, 296, 34), (270, 300, 26))
    ):
        parts += pot(m, x, y, 0, size) + tuft(m, x, y, size * 1.15, size * 1.3, 40 + k)
    for k, x in enumerate((-300, 90)):
        parts += pot(m, x, 462, FLOOR, 28) + tuft(m, x, 462, FLOOR + 34, 38, 50 + k, blooms=True)
    return parts
