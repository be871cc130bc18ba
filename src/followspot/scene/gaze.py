"""Where a camera looks on its way: at much of the level, and still mostly where it goes.

From places along the way lines of sight go out all around. What a camera sees that looks some way
is what they meet within its picture: walls near to it are worth little, and the sky not much more.
A sequence of directions is sought that sees the most and turns the least (dynamic programming over
time: Bellman, Dynamic Programming, 1957), and is made smooth.
"""

from itertools import product

import numpy as np

from followspot.arrays import Floats
from followspot.scene import bsp_tree
from followspot.scene.level import Level
from followspot.scene.open_space import opaque
from followspot.scene.smooth_way import blurred_evenly
from followspot.scene.triangle_tree import TriangleTree

MAX_TURN = 50.0
"""Degrees a second of yaw that the camera turns by at most."""

PITCHES = (-15.0, 45.0)
"""Degrees below the horizon that it looks at least and at most."""

_STEP = 15.0  # degrees from one line of sight, or direction to look in, to the next
_YAWS = np.arange(0.0, 360.0, _STEP)
_PITCHES = np.arange(PITCHES[0], PITCHES[1] + 1, _STEP)
_WIDE, _HIGH = 3, 2  # lines of sight within a picture, to either side of its middle
_BELOW = np.arange(PITCHES[0] - _HIGH * _STEP, PITCHES[1] + _HIGH * _STEP + 1, _STEP)

_GAP = 2 * _STEP / MAX_TURN  # seconds from one look around to the next
_MOST_LOOKS = 240
_REACH = 4096.0  # units that lines of sight go
_SLACK = 16.0  # units that what is drawn may lie behind the solid leaf it belongs to
_FAR_ENOUGH = 350.0  # units from which a surface is worth 1; nearer ones less, in proportion
_SKY = 0.05  # worth of the sky
_FIRST = 6.0  # times as much as any other look the first one counts: films are known by it
_BACK = 0.6  # what it costs to look back instead of ahead
_TILT = 0.04  # to look 30 degrees higher or lower than the way goes
_TURN = 0.02  # and to turn by a step from one look to the next, squared

_MOVES = tuple(product((0, -1, 1, -2, 2), (0, -1, 1)))
"""Steps of yaw and of pitch from one look to the next; of equally good ones the first is taken."""

_BLUR = 0.6  # seconds, a standard deviation


class Lookout:
    """Tells what is worth seeing from places in a level.

    Args:
        level: Its opaque triangles are seen, and its tree of planes ends where the sky is.
    """

    def __init__(self, level: Level) -> None:
        self._bsp = level.bsp
        self._tree = TriangleTree(level.mesh, opaque(level))

    def best_view(self, eyes: Floats) -> Floats:
        """(n,) what the best view from each of (n, 3) places is worth, from 0 to 1."""
        return np.asarray(_worth_of_views(self._worth_around(eyes)).max(axis=(1, 2)))

    def directed(self, eyes: Floats, ahead: Floats, step: float) -> Floats:
        """(n, 2) yaw and pitch in degrees of a camera on its way.

        Args:
            eyes: (n, 3) world places, `step` seconds apart.
            ahead: (n, 3) which way the camera goes; if it goes nowhere, it looks around.
            step: Seconds.
        """
        every = np.arange(len(eyes))
        if not ahead[:, :2].any():
            return np.stack([MAX_TURN / 2 * step * every, 0.0 * every], axis=1)
        count = min(int(every[-1] * step / _GAP) + 1, _MOST_LOOKS)
        looks = np.linspace(0, every[-1], count).astype(np.int64)
        worth = _worth_of_views(self._worth_around(eyes[looks]))
        worth[0] *= _FIRST
        chosen = _best(worth - _cost_of_turning_away(ahead[looks]))
        angles = np.stack([np.interp(every, looks, column) for column in chosen.T], axis=1)
        return blurred_evenly(angles, _BLUR / step)

    def _worth_around(self, eyes: Floats) -> Floats:
        """(n, yaws, rows) what lines of sight all around (n, 3) places are worth, from 0 to 1."""
        yaw, below = np.radians(_YAWS)[:, np.newaxis], np.radians(_BELOW)
        flat = np.cos(below)
        axes = np.cos(yaw) * flat, np.sin(yaw) * flat, -np.sin(below) + 0 * yaw
        ways = np.stack(axes, axis=-1).reshape(-1, 3)
        start = np.repeat(eyes, len(ways), axis=0)
        way = np.tile(ways * _REACH, (len(eyes), 1))
        # The tree of planes ends a line where the sky does, behind which there may be other rooms.
        open_to = bsp_tree.trace(self._bsp, start, start + way) + _SLACK / _REACH
        met = self._tree.first_hits(start, start + way * open_to[:, np.newaxis])
        near = np.minimum(met * open_to * _REACH / _FAR_ENOUGH, 1)
        worth = np.where(met < 1, near, _SKY)
        return np.asarray(worth.reshape(len(eyes), len(_YAWS), len(_BELOW)))


def _worth_of_views(around: Floats) -> Floats:
    """(n, yaws, pitches) roots of the means over what is within a picture around each direction.

    Of the roots the sum is sought: to lose sight of all is worse than to see twice as much is good.
    """
    wide = np.mean([np.roll(around, k, axis=1) for k in range(-_WIDE, _WIDE + 1)], axis=0)
    high = [wide[..., k : k + len(_PITCHES)] for k in range(2 * _HIGH + 1)]
    return np.asarray(np.sqrt(np.mean(high, axis=0)))


def _cost_of_turning_away(ahead: Floats) -> Floats:
    """(n, yaws, pitches) what it costs to look elsewhere than (n, 3) vectors ahead lead."""
    flat = np.hypot(ahead[:, 0], ahead[:, 1])
    yaw = np.arctan2(ahead[:, 1], ahead[:, 0])[:, np.newaxis] - np.radians(_YAWS)
    below = np.degrees(np.arctan2(-ahead[:, 2], flat))
    tilt = (_PITCHES - np.clip(0.7 * below, *PITCHES)[:, np.newaxis]) / 30
    aside = (1 - np.cos(yaw)) / 2 * (flat > 0)[:, np.newaxis]
    return np.asarray(_BACK * aside[..., np.newaxis] + _TILT * tilt[:, np.newaxis] ** 2)


def _best(gain: Floats) -> Floats:
    """(n, 2) yaw and pitch from look to look, of the sequence with the greatest sum.

    Args:
        gain: (n, yaws, pitches) of each direction at each look.
    """
    total, came = gain[0], []
    for gained in gain[1:]:
        padded = np.pad(total, ((0, 0), (1, 1)), constant_values=-np.inf)
        options = np.stack(
            [
                np.roll(padded, turn, axis=0)[:, 1 - tilt : 1 - tilt + len(_PITCHES)]
                - _TURN * (turn**2 + tilt**2)
                for turn, tilt in _MOVES
            ]
        )
        came.append(options.argmax(axis=0))
        total = options.max(axis=0) + gained
    yaw, pitch = divmod(int(total.argmax()), len(_PITCHES))
    steps = [(yaw, pitch)]
    for moves in reversed(came):
        turn, tilt = _MOVES[moves[yaw % len(_YAWS), pitch]]
        yaw, pitch = yaw - turn, pitch - tilt
        steps.append((yaw, pitch))
    return np.array(steps[::-1]) * _STEP + (0.0, PITCHES[0])
