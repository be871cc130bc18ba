"""The courtyard's buildings: walls and wings, arcades, vaulted walks and the gallery on them.

The open yard is 768 by 640 units about the origin, x to the east, y to the north. Arcades stand
on its north and west sides with vaulted walks behind and a gallery above; the east wing hides a
low passage, the gate is in the south.
"""

from collections.abc import Mapping

import numpy as np

from followspot.arrays import Floats
from followspot.builtin.courtyard_materials import Materials
from followspot.builtin.courtyard_parts import (
    COLUMN_HEIGHT,
    Part,
    archivolt,
    balustrade,
    banner,
    column,
    opening,
)
from followspot.levelbuilder import (
    Material,
    arc,
    arch,
    box,
    fitted,
    flat,
    groin_vault,
    hull,
    ruled,
)

BAY = 128
FLOOR = 208
"""Height of the gallery's floor."""

SLAB = 192
"""Height of its underside."""

_WEST, _EAST, _SOUTH, _NORTH, _TOP = -576, 528, -352, 592, 760
_PLINTH = 48


def buildings(m: Materials) -> list[Part]:
    """Return everything that is built, with the ground and the sky round it."""
    parts = _shell(m) + _south(m) + _east(m) + _tower(m) + _north(m) + _west(m)
    return parts + _gallery(m) + _north_arcade(m) + _west_arcade(m) + _walks(m)


def _wall(
    m: Materials,
    x0: float,
    y0: float,
    x1: float,
    y1: float,
    top: float,
    faces: Mapping[str, Material] | None = None,
) -> list[Part]:
    """Return a wall of ochre plaster on a plinth of ashlar."""
    return [
        box((x0, y0, 0), (x1, y1, _PLINTH), m.ashlar),
        box((x0, y0, _PLINTH), (x1, y1, top), m.ochre, faces=faces),
    ]


def _shell(m: Materials) -> list[Part]:
    """Return the ground and the sky round everything.

    The sky stands clear of the outer walls, so that these keep their backs: a shadow map then
    sees them as thick as they are, and no light creeps in along their feet.
    """
    w, e, s, n, top, t = _WEST - 8, _EAST + 8, _SOUTH - 8, _NORTH + 8, _TOP, 16
    return [
        box((w - t, s - t, -t), (e + t, n + t, 0), m.paving),
        box((w - t, s - t, top), (e + t, n + t, top + t), m.sky),
        box((w - t, s - t, 0), (w, n + t, top), m.sky),
        box((e, s - t, 0), (e + t, n + t, top), m.sky),
        box((w, s - t, 0), (e, s, top), m.sky),
        box((w, n, 0), (e, n + t, top), m.sky),
    ]


def _coping(m: Materials, x0: float, y0: float, x1: float, y1: float, z: float) -> Part:
    """Return a stone coping that sheds water to both sides of a wall along x."""
    middle = (y0 + y1) / 2
    points = [(x, y, h) for x in (x0, x1) for y, h in ((y0, z), (y1, z), (y0, z + 5), (y1, z + 5))]
    return hull([*points, (x0, middle, z + 12), (x1, middle, z + 12)], m.stone, detail=True)


def _south(m: Materials) -> list[Part]:
    """Return the south wall and the gatehouse with its doors."""
    y0, y1, front = _SOUTH, -320, -308
    parts = _wall(m, _WEST, y0, -120, y1, 160) + _wall(m, 120, y0, 384, y1, 160)
    parts += [_coping(m, -400, y0, -120, y1 + 6, 160), _coping(m, 120, y0, 384, y1 + 6, 160)]
    for x0, x1 in ((-120, -60), (60, 120)):
        parts.append(box((x0, y0, 0), (x1, front, 176), m.ashlar))
        parts.append(box((x0 - 4, y1, 0), (x1 + 4, front + 4, 14), m.stone, detail=True))
        parts.append(box((x0 - 3, y1, 72), (x1 + 3, front + 4, 80), m.stone, detail=True))
    parts.append(box((-120, y0, 176), (120, front, 216), m.ashlar))
    parts.append(box((-60, y0, 0), (60, -346, 176), m.ashlar))
    parts += arch((60, front, 80), (-120, 0, 0), (0, -38, 0), 60, m.ashlar, top=176)
    parts += archivolt(m, (60, front, 80), (-120, 0, 0), (0, 3, 0), 60)
    for x0, x1 in ((-60, 0), (0, 60)):
        parts += [box((x0, -346, 0), (x1, -341, 80), m.door, projection=fitted(), detail=True)]
    half = arc(180, 0)
    lunette = np.column_stack([-60 * half[:, 0], np.full(len(half), -342.0), 80 + 60 * half[:, 1]])
    sill = lunette * [1, 1, 0] + [0, 0, 80.0]
    parts.append(flat(m.wood, lunette, sill, np.array([0.0, 1.0, 0.0])))
    parts.append(box((-128, y0, 216), (128, front + 8, 226), m.stone))
    eave = [(x, y, 226) for x in (-136, 136) for y in (y0, front + 18)]
    parts.append(hull([*eave, (-136, y0, 262), (136, y0, 262)], m.tiles, faces={"-z": m.wood}))
    for x in (-90, 90):
        parts += banner(m, (x, front + 2, 168), (-1, 0), 36)
    return parts


def _east(m: Materials) -> list[Part]:
    """Return the east wing: its wall, the low vaulted passage within, its roof."""
    parts: list[Part] = []
    for y0, y1 in ((_SOUTH, -170), (-110, 336)):
        parts += _wall(m, 384, y0, 416, y1, 100, {"+x": m.vault})
    parts.append(box((384, _SOUTH, 100), (_EAST, 336, 300), m.ochre))
    parts.append(box((384, -170, 88), (416, -110, 100), m.ochre))
    parts += arch(
        (384, -170 + 60, 58), (0, -60, 0), (32, 0, 0), 30, m.stone, spandrel=m.ochre, top=100
    )
    parts += archivolt(m, (384, -110, 58), (0, -60, 0), (-3, 0, 0), 30)
    parts.append(box((416, _SOUTH, 0), (_EAST, -170, 100), m.brick))
    parts.append(box((488, -170, 0), (_EAST, 560, 100), m.brick))
    curve = arc(180, 0)
    x, z = 452 + 36 * curve[:, 0], 70 + 24 * curve[:, 1]
    for south, north in ((-170.0, 140.0), (140.0, 452.0)):
        ends = [np.column_stack([x, np.full(len(x), y), z]) for y in (north, south)]
        parts.append(ruled(m.vault, ends[0], ends[1]))
    parts.append(box((416, -170, 66), (420, 452, 70), m.stone, detail=True))
    parts.append(box((484, -170, 66), (488, 452, 70), m.stone, detail=True))
    eave = [(x, y, 300) for x in (366, _EAST) for y in (_SOUTH, 336)]
    ridge = [(_EAST, y, 376) for y in (_SOUTH, 336)]
    parts.append(hull(eave + ridge, m.tiles, faces={"-z": m.wood, "-x": m.tiles}))
    parts.append(box((378, _SOUTH, 288), (384, 336, 300), m.stone, detail=True))
    parts.append(box((380, _SOUTH, _PLINTH - 4), (384, -112, _PLINTH + 2), m.stone, detail=True))
    for y in (-250, -20, 130, 260):
        parts += opening(m, m.window, (384, y, 232 if y > -100 else 190), (-1, 0), (36, 48))
    for y in (-135, 55, 195):
        parts += banner(m, (382, y, 284 if y > 0 else 250), (0, -1), 42)
    return parts


def _tower(m: Materials) -> list[Part]:
    """Return the tower in the north-east; the passage runs through its foot into the walk."""
    x0, x1, y0, y1, top = 384, _EAST, 336, _NORTH, 512
    parts: list[Part] = [
        box((x0, y0, 0), (416, 380, 100), m.ashlar),
        box((x0, 452, 0), (416, y1, 100), m.ashlar),
        box((416, 452, 0), (488, y1, 100), m.ashlar),
        box((x0, y0, 100), (x1, y1, top), m.ashlar),
        box((x0, 380, 88), (416, 452, 100), m.ashlar),
        box((488, 560, 0), (x1, y1, 100), m.brick),
    ]
    for z in (FLOOR + 150, top - 12):
        parts.append(box((x0 - 6, y0 - 6, z), (x1, y1, z + 12), m.stone, detail=True))
    eave = [(x, y, top) for x in (x0 - 20, x1) for y in (y0 - 20, y1)]
    parts.append(hull([*eave, (470, 470, top + 130)], m.tiles, faces={"-z": m.wood}))
    for z in (262, 430):
        parts += opening(m, m.window, (x0, 408 if z > 400 else 400, z), (-1, 0), (32, 52))
        parts += opening(m, m.window, (452, y0, z + 90 * (z < 300)), (0, -1), (32, 52))
    parts += banner(m, (452, y0 - 2, 330), (1, 0), 44)
    return parts


def _north(m: Materials) -> list[Part]:
    """Return the north wing: back wall of the walk and of the gallery, doors, roof."""
    y = 480
    parts: list[Part] = [
        box((_WEST, y, 0), (384, _NORTH, _PLINTH), m.ashlar),
        box((_WEST, y, _PLINTH), (384, _NORTH, SLAB), m.vault),
        box((_WEST, y, SLAB), (384, _NORTH, 372), m.rose),
        box((_WEST, y - 6, 356), (384, y, 372), m.stone, detail=True),
        box((_WEST, y - 4, FLOOR), (384, y, FLOOR + 14), m.stone, detail=True),
    ]
    eave = [(x, v, 372) for x in (_WEST, 384) for v in (y - 22, _NORTH)]
    ridge = [(x, _NORTH, 430) for x in (_WEST, 384)]
    parts.append(hull(eave + ridge, m.tiles, faces={"-z": m.wood, "-y": m.tiles}))
    for x in (-224, 128):
        parts += opening(m, m.door, (x, y, FLOOR), (0, -1), (50, 94))
    for x in (-448, -336, -112, 16, 300):
        parts += opening(m, m.window, (x, y, FLOOR + 44), (0, -1), (40, 56))
    return parts


def _west(m: Materials) -> list[Part]:
    """Return the west wing's outer wall with the parapet of its terrace."""
    parts: list[Part] = [
        box((_WEST, _SOUTH, 0), (-544, 480, _PLINTH), m.ashlar),
        box((_WEST, _SOUTH, _PLINTH), (-544, 480, SLAB), m.vault),
        box((_WEST, _SOUTH, SLAB), (-544, 480, 244), m.ochre),
        box((-544, _SOUTH, 160), (-384, -320, 244), m.ochre),
        box((_WEST, _SOUTH, 244), (-538, 480, 252), m.stone),
        box((-538, _SOUTH, 244), (-384, -314, 252), m.stone),
    ]
    return parts


def _gallery(m: Materials) -> list[Part]:
    """Return the gallery's floor, its cornice and its balustrades."""
    top = {"+z": m.paving}
    parts: list[Part] = [
        box((-544, 312, SLAB), (384, 480, FLOOR), m.stone, faces=top),
        box((-544, -320, SLAB), (-376, 312, FLOOR), m.stone, faces=top),
        box((-384, 315, 182), (384, 320, SLAB), m.stone, detail=True),
        box((-384, -320, 182), (-379, 315, SLAB), m.stone, detail=True),
    ]
    for k in range(5):
        x, y = -384 + k * BAY, -320 + k * BAY
        last = 292 if k == 4 else x + BAY
        parts += balustrade(m, (x, 320, FLOOR), (last, 320, FLOOR))
        parts += balustrade(m, (-384, y + 16 * (k == 0), FLOOR), (-384, y + BAY, FLOOR))
    return parts


def _arches(m: Materials, foot: Floats, along: Floats, inward: Floats, bays: int) -> list[Part]:
    """Return an arcade's wall: arches between blocks over the columns, stone rings in front.

    Args:
        m: The materials.
        foot: Left end of the wall's front on the floor.
        along: Unit vector rightwards as seen from the yard.
        inward: Unit vector from the front through the wall, which is 32 thick.
        bays: Number of arches.
    """
    parts: list[Part] = []
    up = np.array([0.0, 0.0, COLUMN_HEIGHT])
    for k in range(bays):
        spring = foot + along * (k * BAY + 17) + up
        span, depth = along * (BAY - 34), inward * 32
        parts += arch(spring, span, depth, 47, m.stone, spandrel=m.brick, top=SLAB)
        parts += archivolt(m, tuple(spring), tuple(span), tuple(-3 * inward), 47)
    for k in range(bays + 1):
        left = foot + along * (k * BAY - 17 * (k > 0)) + up
        right = foot + along * (k * BAY + 17 * (k < bays)) + inward * 32
        right[2] = SLAB
        corners = np.stack([left, right])
        parts.append(box(corners.min(axis=0), corners.max(axis=0), m.brick))
    return parts


def _north_arcade(m: Materials) -> list[Part]:
    x, y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    parts = _arches(m, np.array([-384.0, 320, 0]), x, y, 5)
    for k in range(1, 5):
        parts += column(m, -384 + k * BAY, 336)
    parts += _pier(m, -416, 320, -367, 352) + _pier(m, 239, 320, 288, 352)
    parts += _wall(m, 288, 320, 384, 352, SLAB)
    for x0, x1 in ((-416, -384), (256, 288)):
        parts.append(box((x0, 320, COLUMN_HEIGHT), (x1, 352, SLAB), m.brick))
    return parts


def _west_arcade(m: Materials) -> list[Part]:
    x, y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    parts = _arches(m, np.array([-384.0, -320, 0]), y, -x, 5)
    for k in range(1, 5):
        parts += column(m, -400, -320 + k * BAY)
    parts += _pier(m, -416, 303, -384, 352) + _pier(m, -416, -320, -384, -303)
    return parts


def _pier(m: Materials, x0: float, y0: float, x1: float, y1: float) -> list[Part]:
    """Return a square pier with base and impost, from the floor to the arches' springing."""
    h = COLUMN_HEIGHT
    return [
        box((x0, y0, 0), (x1, y1, h), m.ashlar),
        box((x0 - 3, y0 - 3, 0), (x1 + 3, y1 + 3, 10), m.stone, detail=True),
        box((x0 - 2, y0 - 2, h - 8), (x1 + 2, y1 + 2, h), m.stone, detail=True),
    ]


def _walks(m: Materials) -> list[Part]:
    """Return the vaults over the walks, with pilasters on the back walls."""
    h, rise = COLUMN_HEIGHT, 64.0
    parts: list[Part] = []
    for k in range(6):
        x = -384 + k * BAY
        parts += groin_vault((x, 352, h), (x + BAY, 480), rise, m.vault)
        parts += _pilaster(m, x, 480, 0)
    for k in range(5):
        y = -320 + k * BAY
        parts += groin_vault((-544, y, h), (-416, y + BAY), rise, m.vault)
        parts += _pilaster(m, -544, y + BAY, 1)
    parts += groin_vault((-544, 352, h), (-416, 480), rise, m.vault)
    parts += arch((-416, 480, h), (0, -BAY, 0), (32, 0, 0), rise, m.stone)
    parts += arch((-544, 320, h), (BAY, 0, 0), (0, 32, 0), rise, m.stone)
    return parts


def _pilaster(m: Materials, x: float, y: float, axis: int) -> list[Part]:
    """Return a flat pilaster with a corbel on a back wall: the vaults spring from it."""
    parts: list[Part] = []
    for half, depth, low, high in ((9, 6, 0, 98), (12, 8, 0, 12), (13, 10, 98, COLUMN_HEIGHT)):
        if axis == 0:
            mins, maxs = (x - half, y - depth, low), (x + half, y, high)
        else:
            mins, maxs = (x, y - half, low), (x + depth, y + half, high)
        parts.append(box(mins, maxs, m.stone, detail=True))
    return parts
