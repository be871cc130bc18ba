"""A camera that flies: how it follows keys and mouse, whatever the frame rate.

Speed and angles follow what is steered like a first-order lag, x' = (wanted - x) / tau, whose
solution over a frame is written down instead of being stepped. Frames of any length thus give the
same flight, but for one thing: the direction within a frame is taken from its middle.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from followspot import spaces
from followspot.game import RUN_SPEED
from followspot.scene.camera import Camera
from followspot.spaces import Vec3

SLOWEST, FASTEST = 10.0, 10_000.0
NOTCH = 1.2
"""What a notch of the wheel multiplies the speed by."""

MOVE_TAU, TURN_TAU = 0.1, 0.03
"""Seconds in which speed and angles come within 1/e of what is wanted."""
STEEPEST = 89.9
"""Degrees up or down."""

_SHORTEST = 1e-6
"""Seconds of a frame in which anything turns."""
_STILL_SPEED, _STILL_ANGLE = 0.05, 1e-3
"""Units a second and degrees that count as none, so that a flight ends."""
_DECIMALS = 3
"""Of the place where it ends, which somebody may want to write down."""


@dataclass(frozen=True)
class Steering:
    """What keys and mouse did in one frame.

    Attributes:
        forward, left, up: Share of full speed, -1 to 1; up is along the world's Z.
        yaw, pitch: Degrees that the mouse turned by, in the camera's sense.
        pace: What the speed is multiplied by for now.
        notches: Of the wheel; they change the speed for good.
    """

    forward: float = 0.0
    left: float = 0.0
    up: float = 0.0
    yaw: float = 0.0
    pitch: float = 0.0
    pace: float = 1.0
    notches: float = 0.0


@dataclass(frozen=True, eq=False)
class Flight:
    """Where a flying camera is, and what it is about to do.

    Attributes:
        camera: As it is now.
        velocity: (3,) units a second in the world.
        turning_to: (yaw, pitch) in degrees that its angles approach.
        speed: Units a second at full forward.
    """

    camera: Camera
    velocity: Vec3 = field(default_factory=lambda: spaces.vec3((0, 0, 0)))
    turning_to: tuple[float, float] = (0.0, 0.0)
    speed: float = RUN_SPEED

    def at(self, camera: Camera) -> "Flight":
        """The flight gone on elsewhere, from rest."""
        return Flight(camera, turning_to=(camera.yaw, camera.pitch), speed=self.speed)

    def after(self, seconds: float, steering: Steering) -> "Flight":
        """The flight a frame later.

        Args:
            seconds: Length of the frame.
            steering: What is steered all through the frame; the mouse moves evenly.
        """
        speed = min(max(self.speed * NOTCH**steering.notches, SLOWEST), FASTEST)
        (old_yaw, old_pitch), camera = self.turning_to, self.camera
        to_yaw = _target(old_yaw, steering.yaw, camera.yaw)
        to_pitch = _target(old_pitch, steering.pitch, camera.pitch)
        if steering.pitch:  # a view may be steeper until somebody turns it
            to_pitch = min(max(to_pitch, -STEEPEST), STEEPEST)
        halfway, whole = (
            (
                _follow(camera.yaw, old_yaw, to_yaw, seconds, share),
                _follow(camera.pitch, old_pitch, to_pitch, seconds, share),
            )
            for share in (0.5, 1.0)
        )
        wanted = _direction(steering, *halfway) * (speed * steering.pace)
        left_over = math.exp(-seconds / MOVE_TAU)
        velocity = wanted + (self.velocity - wanted) * left_over
        moved = wanted * seconds + (self.velocity - wanted) * MOVE_TAU * (1 - left_over)
        position = camera.position + moved
        if not wanted.any() and np.linalg.norm(velocity) < _STILL_SPEED:
            velocity = np.zeros(3)
            position = np.round(position, _DECIMALS) if moved.any() else position
        if moved.any() or whole != (camera.yaw, camera.pitch):
            yaw, pitch = whole
            camera = replace(camera, position=spaces.vec3(position), yaw=yaw, pitch=pitch, name="")
        return Flight(camera, spaces.vec3(velocity), (to_yaw, to_pitch), speed)


def _target(before: float, turned: float, angle: float) -> float:
    """Where an angle goes to; where it ends is a round number, unless it never moved."""
    return before + turned if turned or before == angle else round(before, _DECIMALS)


def _direction(steering: Steering, yaw: float, pitch: float) -> Vec3:
    """(3,) where to, in the world, no longer than 1."""
    forward = spaces.forward_from_angles(yaw, pitch)
    left = spaces.forward_from_angles(yaw + 90, 0)
    direction = steering.forward * forward + steering.left * left
    direction = direction + steering.up * np.array([0.0, 0.0, 1.0])
    return spaces.vec3(direction / max(1.0, float(np.linalg.norm(direction))))


def _follow(value: float, start: float, end: float, seconds: float, share: float) -> float:
    """An angle that lags behind one moving evenly from `start` to `end`, after a share of a frame.

    x' = (w - x) / tau with w = start + rate t has the solution
    x = w - rate tau (1 - exp(-t / tau)) + (x0 - start) exp(-t / tau).
    """
    if seconds < _SHORTEST:
        return value
    behind = (end - start) / seconds * TURN_TAU
    wanted = start + (end - start) * share
    gone = -math.expm1(-seconds * share / TURN_TAU)
    angle = wanted - behind * gone + (value - start) * (1 - gone)
    return end if start == end and abs(angle - end) < _STILL_ANGLE else angle
