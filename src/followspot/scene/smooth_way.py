"""A way through the open made smooth, and away from walls where there is room.

The zigzag that comes out of a lattice is pulled straight like a rubber band and blurred. Both cut
corners, so that what they lead past is as near as may be; the way is pushed off it beforehand, by
as much as the blurred curve wants (an elastic band: Quinlan and Khatib, Elastic Bands: Connecting
Path Planning and Control, 1993).
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.scene.lattice import ROOM
from followspot.scene.open_space import OpenSpace

STEP = 4.0
"""Units between points of a smooth way."""

ROOMS = (ROOM, 32.0, 48.0)
"""Half-sizes in units of the boxes that are to be free around a way: the first one everywhere, the
others wherever there is room."""

_BLUR = 96.0  # units, a standard deviation
_PUSHES = 8  # times; half as many leave twice as much of a way near to walls
_LOOKED = 4  # every so many points, room is looked for


def _ball(step: float, radius: float) -> Floats:
    """(n, 3) points of a lattice within a radius of 0, the nearest first."""
    axis = np.arange(-radius, radius + step, step)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    distance = np.linalg.norm(points, axis=1)
    order = np.argsort(distance, kind="stable")
    return np.asarray(points[order][distance[order] <= radius])


_NEAR = _ball(4.0, 12 * math.sqrt(3))
_ASIDE = _ball(12.0, 36.0)


def smoothed(space: OpenSpace, points: Floats) -> Floats:
    """(n, 3) points STEP apart on a smooth curve near a way, free of walls.

    First the way is pulled straight; it stays in roomy places once it is there. Then it is pushed
    off what the curve would come near, and blurred, as widely as the walls permit from place to
    place.

    Args:
        space: The level's, for boxes of any size.
        points: (k, 3) places in the open.
    """
    rooms = [space.sized(half) for half in ROOMS]
    tight, roomy = rooms[:2]
    points = _pulled(points, tight, roomy, 100)
    points = _pulled(_freed(_spaced(points, STEP), tight), tight, roomy, 60)
    width = np.full(len(points), _BLUR / STEP)  # standard deviations of the blur, in steps
    points = _pushed(points, width, rooms)
    while True:
        curve = _blurred(points, width)
        blocked = ~tight.is_free(curve)
        if not blocked.any() or width.min() < 0.05:
            return _freed(_spaced(curve, STEP), tight)
        near = _blurred(
            blocked[:, np.newaxis].astype(np.float64), np.full(len(points), _BLUR / STEP)
        )
        # The blur turns signs about an end, so that a blocked point there may count for nothing.
        width *= np.where((near[:, 0] > 0.01) | blocked, 0.7, 1.0)


def _pulled(points: Floats, tight: OpenSpace, roomy: OpenSpace, times: int) -> Floats:
    """(n, 3) points moved halfway to the middle of their neighbours, where there is room."""
    has_room = roomy.is_free(points)
    for _ in range(times):
        moved = points.copy()
        moved[1:-1] += ((points[:-2] + points[2:]) / 2 - points[1:-1]) / 2
        gets_room = roomy.is_free(moved)
        may = gets_room.copy()
        unsure = ~gets_room & ~has_room
        may[unsure] = tight.is_free(moved[unsure])
        points = np.where(may[:, np.newaxis], moved, points)
        has_room = np.where(may, gets_room, has_room)
    return points


def _pushed(points: Floats, width: Floats, rooms: Sequence[OpenSpace]) -> Floats:
    """(n, 3) points moved aside, so that there is more room around them once they are blurred.

    Where the curve has less than all the room, its points move by what leads from it to the
    nearest place with more, across the way; along it they would fold it up. The curve follows
    by a part of that, and so it is done again.
    """
    every = np.arange(len(points))
    looked = every[::_LOOKED]
    if len(looked) < 2:  # too short a way to lead past anything
        return points
    for _ in range(_PUSHES):
        curve = _blurred(points, width, _LOOKED)
        room = _roominess(curve, rooms)
        lacking = np.flatnonzero(room < len(rooms))
        ahead = _unit(np.gradient(curve, axis=0)[lacking])
        place, aside = np.nonzero(np.abs(ahead @ _ASIDE.T) <= 6)
        gets = np.zeros((len(lacking), len(_ASIDE)), np.int64)
        gets[place, aside] = _roominess(curve[lacking[place]] + _ASIDE[aside], rooms)
        shift = np.zeros_like(curve)
        # Where none has more, argmax is 0, which is to stay.
        shift[lacking] = _ASIDE[(gets > room[lacking, np.newaxis]).argmax(axis=1)]
        moved = points + np.stack([np.interp(every, looked, c) for c in shift.T], axis=1)
        points = np.where(rooms[0].is_free(moved)[:, np.newaxis], moved, points)
    return points


def _roominess(points: Floats, rooms: Sequence[OpenSpace]) -> NDArray[np.int64]:
    """(n,) how many of the rooms, from the smallest on, (n, 3) points have around them."""
    count = np.zeros(len(points), np.int64)
    left = np.arange(len(points))
    for room in rooms:
        left = left[room.is_free(points[left])]
        count[left] += 1
    return count


def _freed(points: Floats, tight: OpenSpace) -> Floats:
    """(n, 3) points, those too near to a wall (the band cuts corners) moved to the nearest room."""
    blocked = np.flatnonzero(~tight.is_free(points))
    tries = (points[blocked, np.newaxis] + _NEAR).reshape(-1, 3)
    nearest = tight.is_free(tries).reshape(len(blocked), len(_NEAR)).argmax(axis=1)
    freed = points.copy()
    freed[blocked] += _NEAR[nearest]
    return freed


def _blurred(values: Floats, width: Floats, every: int = 1) -> Floats:
    """(n, c) values under Gaussians whose standard deviation changes along the way.

    Args:
        values: (n, c).
        width: (n,) standard deviations.
        every: Of how many values one is wanted.
    """
    reach = math.ceil(3 * width.max(initial=1))
    shift = np.arange(-reach, reach + 1)
    weight = np.exp(-0.5 * (shift / np.maximum(width[::every], 1e-3)[:, np.newaxis]) ** 2)
    # Ends stay where they are: beyond them, the way goes on as it came, turned about the end.
    index = np.arange(0, len(values), every)[:, np.newaxis] + shift
    inside = np.clip(index, 0, len(values) - 1)
    mirrored = np.clip(2 * inside - index, 0, len(values) - 1)
    taken = 2 * values[inside] - values[mirrored]
    return np.asarray((weight[..., np.newaxis] * taken).sum(axis=1) / weight.sum(axis=1)[:, None])


def blurred_evenly(values: Floats, width: float) -> Floats:
    """(n, c) values under one Gaussian; beyond the ends they go on as they came.

    Args:
        values: (n, c).
        width: A standard deviation.
    """
    reach = math.ceil(3 * width)
    weight = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
    padded = np.pad(values, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    columns = [np.convolve(column, weight / weight.sum(), mode="valid") for column in padded.T]
    return np.stack(columns, axis=1)


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, 1e-9))


def arc_lengths(points: Floats) -> Floats:
    """(n,) units along a polyline up to each of its (n, 3) points."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def at_arc(points: Floats, arc: Floats) -> Floats:
    """(n, 3) points of a polyline at (n,) arc lengths."""
    lengths = arc_lengths(points)
    return np.stack([np.interp(arc, lengths, points[:, k]) for k in range(3)], axis=1)


def _spaced(points: Floats, step: float) -> Floats:
    length = float(arc_lengths(points)[-1])
    return at_arc(points, np.linspace(0, length, max(2, math.ceil(length / step) + 1)))
