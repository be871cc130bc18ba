"""How the robot moves: stand, run, walk, wave and jump, ten frames a second.

Curves are smooth in time and sampled at the frames. In `run` and `walk` a foot on the ground goes
straight back at `RUN_SPEED` or `WALK_SPEED`: a character that is moved forward at that speed does
not slide.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from followspot.arrays import Floats
from followspot.builtin.robot_skeleton import ANKLE, Poses, rotations
from followspot.game import GRAVITY

FPS = 10.0
"""Frames a second, as the game plays MD2 models."""

RUN_SPEED = 100.0
"""Units a second at which `run` carries the robot forward."""

WALK_SPEED = 40.0
"""Units a second at which `walk` carries the robot forward."""

_TOES = np.array([6.6, 0.0, -ANKLE[2]])
_TIP = np.array([7.6, 0.0, 0.59 - ANKLE[2]])
"""From the ankle to the front end of the sole, on which the foot rolls off, and the tip above."""

LEFT, RIGHT = 0, 1


def sine(frames: int, amplitude: float, times: int = 1, shift: float = 0.0) -> Floats:
    """(frames,) a sine that fits so many times into the loop, shifted by a share of its period."""
    return amplitude * np.sin(2 * np.pi * (times * np.arange(frames) / frames - shift))


def keyed(frames: int, keys: Sequence[tuple[float, ArrayLike]]) -> Floats:
    """(frames, ...) values eased from key to key, at rest at each of them.

    Args:
        frames: How many frames to sample, from 0 on.
        keys: (frame, value) in rising order.
    """
    times = np.array([time for time, _ in keys])
    values = np.array([value for _, value in keys], np.float64)
    at = np.clip(np.arange(frames), times[0], times[-1])
    i = np.clip(np.searchsorted(times, at, "right") - 1, 0, len(times) - 2)
    share = (at - times[i]) / (times[i + 1] - times[i])
    share = (share * share * (3 - 2 * share)).reshape(-1, *[1] * (values.ndim - 1))
    eased: Floats = values[i] * (1 - share) + values[i + 1] * share
    return eased


def at_ease(frames: int) -> Poses:
    """Standing with knees and elbows a little bent: where every animation but the gaits begins."""
    poses = Poses(frames)
    poses.hips[:] = [0.4, 0, -0.7]
    poses.shoulders[:] = [9, 4, 0]
    poses.elbows[:] = [-3, -16, 0]
    return poses


def stand(frames: int = 20) -> Poses:
    """Breathe, shift weight, look left and right, blink; the aerial quivers."""
    poses = at_ease(frames)
    breath = sine(frames, 1.0, 1, 0.25)
    poses.hips[:, 1] += sine(frames, 0.5)
    poses.hips[:, 2] += 0.35 * breath
    poses.pelvis[:, 0] = sine(frames, 0.8)
    poses.chest[:, 0] = sine(frames, -1.6)
    poses.chest[:, 1] = 1.5 - 1.5 * breath
    poses.chest[:, 2] = sine(frames, 3, 1, 0.1)
    look = [(0, 0), (3, 0), (5, 24), (8, 24), (11, -22), (15, -22), (18, 0), (20, 0)]
    poses.head[:, 2] = keyed(frames, look)
    poses.head[:, 0] = 0.16 * poses.head[:, 2]
    poses.head[:, 1] = 1.5 * breath
    poses.aerial[:, 1] = sine(frames, 4, 2, 0.2)
    poses.aerial[:, 0] = sine(frames, 3, 1)
    poses.shoulders[:, :, 0] += (1.5 * breath)[:, None]
    poses.shoulders[:, :, 1] += sine(frames, 2.5, 1, 0.1)[:, None] * [-1, 1]
    poses.elbows[:, :, 1] += (-3 * breath)[:, None]
    poses.lids[[9, 18]] = 0.0
    return poses


def _contact(first: float, flat: int, rolling: Sequence[float], speed: float) -> Floats:
    """(n, 3) rows of x, z and pitch of a foot on the ground.

    Args:
        first: The ankle's x as the foot comes down.
        flat: How many frames it is flat.
        rolling: Pitches of the frames behind these, in which it rolls off on its toes.
        speed: Units a second at which the ground goes back.
    """
    pitch = np.concatenate([np.zeros(flat), rolling])
    toes = np.array([first, 0, 0]) + _TOES - np.arange(len(pitch))[:, None] * [speed / FPS, 0, 0]
    angles = np.stack([0 * pitch, pitch, 0 * pitch], axis=1)
    ankle = toes - rotations(angles) @ _TOES
    ankle[:, 2] += np.maximum(0, -(rotations(angles) @ (_TIP - _TOES))[:, 2])
    return np.stack([ankle[:, 0], ankle[:, 2], pitch], axis=1)


def _gait(left: Floats) -> Poses:
    """Take the left foot through (f, 3) rows of x, z and pitch, the right half a cycle later."""
    poses = Poses(len(left))
    for side, rows in ((LEFT, left), (RIGHT, np.roll(left, len(left) // 2, axis=0))):
        poses.feet[:, side, 0], poses.feet[:, side, 2], poses.soles[:, side] = rows.T
    return poses


def run() -> Poses:
    """Run: eight frames, a foot on the ground for four of them, both in the air in between."""
    frames = 8
    swing = [(-13.5, 11.5, 62), (-5, 13.5, 48), (8, 9.5, 5), (14, 4.2, -16)]
    poses = _gait(np.concatenate([_contact(12, 3, [42], RUN_SPEED), swing]))
    poses.hips[:, 0] = 1.0
    poses.hips[:, 2] = -3.95 + sine(frames, 1.0, 2, 0.5)
    swing_of_hips = sine(frames, 1, 1, -0.25)  # 1 as the left foot comes down
    poses.pelvis[:, 0] = sine(frames, 2.5, 1, 0.1)
    poses.pelvis[:, 1] = 8
    poses.pelvis[:, 2] = -7 * swing_of_hips
    poses.chest[:, 1] = 7 + sine(frames, 2.5, 2, 0.1)
    poses.chest[:, 2] = 17 * swing_of_hips
    poses.head[:, 1] = -12 + sine(frames, -2.5, 2, 0.2)
    poses.head[:, 2] = -9 * swing_of_hips
    poses.aerial[:, 1] = -14 + sine(frames, 9, 2, 0.3)
    arms = np.stack([sine(frames, 46, 1, -0.22), sine(frames, -46, 1, -0.22)], axis=1)
    poses.shoulders[:, :, 0] = 10
    poses.shoulders[:, :, 1] = 10 + arms
    poses.elbows[:, :, 1] = -72 + 0.35 * arms
    poses.elbows[:, :, 0] = -12
    return poses


def walk() -> Poses:
    """Walk: twelve frames, a foot on the ground for seven, both for a moment."""
    frames = 12
    swing = [(-10.6, 5.4, 34), (-4, 4.6, 22), (4, 3.0, 2), (10.2, 2.2, -14)]
    poses = _gait(np.concatenate([_contact(10.5, 5, [10, 24, 38], WALK_SPEED), swing]))
    poses.hips[:, 0] = 0.8
    poses.hips[:, 1] = sine(frames, 0.9, 1, 0.0)
    poses.hips[:, 2] = -2.4 + sine(frames, 0.6, 2, 0.45)
    swing_of_hips = sine(frames, 1, 1, -0.25)
    poses.pelvis[:, 0] = sine(frames, -2.0, 1, 0.0)
    poses.pelvis[:, 1] = 2
    poses.pelvis[:, 2] = -5 * swing_of_hips
    poses.chest[:, 0] = sine(frames, 3.0, 1, 0.0)
    poses.chest[:, 2] = 10 * swing_of_hips
    poses.chest[:, 1] = 2 + sine(frames, 1.0, 2, 0.1)
    poses.head[:, 2] = -5 * swing_of_hips
    poses.head[:, 0] = sine(frames, -2.0, 1, 0.05)
    poses.aerial[:, 1] = -4 + sine(frames, 5, 2, 0.3)
    arms = np.stack([sine(frames, 24, 1, -0.22), sine(frames, -24, 1, -0.22)], axis=1)
    poses.shoulders[:, :, 0] = 9
    poses.shoulders[:, :, 1] = 4 + arms
    poses.elbows[:, :, 1] = -24 + 0.4 * arms
    return poses


def wave_hand(frames: int = 20) -> Poses:
    """Lift the right hand, wave it to and fro, and take it down again."""
    poses = at_ease(frames)
    lift = keyed(frames, [(0, 0), (5, 1), (15, 1), (20, 0)])
    swing = sine(frames, 1, 5, 0.25) * keyed(frames, [(4, 0), (6, 1), (14, 1), (16, 0)])
    poses.hips[:, 1] = 1.0 * lift
    poses.pelvis[:, 0] = -1.5 * lift
    poses.chest[:, 0] = -4.5 * lift + 1.5 * swing
    poses.chest[:, 2] = 5 * lift
    poses.head[:, 0] = 9 * lift - 3 * swing
    poses.head[:, 1] = -5 * lift
    poses.aerial[:, 0] = -9 * swing
    poses.shoulders[:, RIGHT] += lift[:, None] * [88, -14, 0]
    poses.shoulders[:, RIGHT, 0] += 7 * swing
    poses.elbows[:, RIGHT] += lift[:, None] * [62, 4, 0]
    poses.elbows[:, RIGHT, 0] += 30 * swing
    poses.wrists[:, RIGHT, 0] = 6 * lift + 16 * swing
    poses.shoulders[:, LEFT, 0] += 8 * lift
    poses.elbows[:, LEFT, 1] -= 14 * lift
    poses.lids[[1, 17]] = 0.0
    return poses


def jump() -> Poses:
    """Crouch, leap for four tenths of a second, land, and straighten up: sixteen frames."""
    frames, takeoff, airborne = 16, 5, 4
    poses = at_ease(frames)
    t = np.clip(np.arange(frames) - takeoff, 0, airborne) / FPS
    leap = GRAVITY / 2 * t * (airborne / FPS - t)
    crouch = keyed(frames, [(0, 0), (3, -7), (5, 0.6), (9, 0.2), (11, -6.5), (15, 0), (16, 0)])
    tuck = keyed(frames, [(5, 0), (7, 5.5), (9, 0)])
    bent = keyed(frames, [(0, 0), (3, 1), (5, -0.25), (7, 0.35), (9, 0.1), (11, 0.9), (15, 0)])
    arms = keyed(frames, [(0, 0), (3, 48), (6, -125), (9, -70), (11, 18), (15, 0)])
    poses.hips[:, 2] += crouch + leap
    poses.hips[:, 0] += -1.4 * bent
    poses.pelvis[:, 1] = 14 * bent
    poses.chest[:, 1] = 16 * bent
    poses.head[:, 1] = -22 * bent
    poses.aerial[:, 1] = keyed(
        frames, [(0, 0), (3, 6), (5, -16), (9, 10), (11, 18), (13, -8), (15, 0)]
    )
    poses.shoulders[:, :, 1] += arms[:, None]
    spread = keyed(frames, [(0, 0), (3, 8), (7, 26), (10, 22), (15, 0)])
    poses.shoulders[:, :, 0] += spread[:, None]
    poses.elbows[:, :, 1] += keyed(frames, [(0, 0), (3, -22), (6, -14), (11, -34), (15, 0)])[
        :, None
    ]
    poses.feet[:, :, 2] = (leap + tuck)[:, None]
    poses.feet[:, :, 0] = -0.45 * tuck[:, None] * [1.2, 0.4]
    poses.soles[:] = keyed(frames, [(5, 0), (6, 34), (7, 28), (9, 0)])[:, None]
    poses.lids[[3, 11]] = 0.0
    return poses


ANIMATIONS = {"stand": stand, "run": run, "walk": walk, "wave": wave_hand, "jump": jump}
"""By name, in the order of the file's frames."""
