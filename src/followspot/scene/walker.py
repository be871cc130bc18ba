"""Somebody who walks through a level by the game's rules, and what he sees it from.

The rules: friction, then acceleration towards the wished velocity, then sliding (`slide`), then
what the place does (`triggers`). Time goes in ticks of fixed length, so that walks do not depend on
the frame rate; between two ticks the position is interpolated.

Source: ``bg_pmove.c`` of Quake III Arena, whose rules and numbers these are. Water is air here, and
nobody gets hurt.
"""

import math
from dataclasses import dataclass

import numpy as np

from followspot.game import EYE_HEIGHT, RUN_SPEED
from followspot.scene.collision import CROUCHING, STANDING, CollisionWorld
from followspot.scene.slide import FLATTEST_WALL, Motion, clip, step_slide
from followspot.scene.triggers import JumpPad, Triggers
from followspot.spaces import Vec3, forward_from_angles, vec3

TICK = 0.008
"""Seconds; the game's own fixed step (``pmove_msec``)."""
LONGEST_FRAME = 0.25
"""Seconds that one call makes up for; a program that stood still longer walks on from there."""

CROUCHED_SPEED = 0.25
"""Share of a run's when crouching."""
JUMP_SPEED = 270.0
"""Units/s upwards."""
TELEPORT_SPEED = 400.0
"""Units/s with which one leaves a teleporter."""
ACCELERATION, AIR_ACCELERATION = 10.0, 1.0
"""1/s: share of the wished speed that is gained in a second."""
FRICTION = 6.0
"""1/s."""
STOP_SPEED = 100.0
"""Units/s: slower than that, friction does not get less."""
CROUCHED_EYE_HEIGHT = 12.0
"""Units above the origin."""

_GROUND_REACH = 0.25  # units below the feet in which the ground is looked for
_KICK_OFF = 10.0  # units/s away from the ground from which on it is left
_FALL = 4096.0  # units that one falls at most when put down
_EYE_SECONDS = 0.06  # in which the eye makes up for all but 1/e of a step
_SMALLEST_STEP = 1.0  # units that the eye makes up for
_EYE_HEIGHTS = {STANDING: EYE_HEIGHT, CROUCHING: CROUCHED_EYE_HEIGHT}


@dataclass(frozen=True)
class Wish:
    """What a walker wants.

    Attributes:
        forward: -1 to 1 of the full speed.
        side: Likewise, positive to the right.
        jump: Whether the key is down; it must be let go before the next jump.
        crouch: Whether to crouch. One who cannot stand up remains crouched.
    """

    forward: float = 0.0
    side: float = 0.0
    jump: bool = False
    crouch: bool = False


class Walker:
    """A player's body in a level; `place` it before anything else.

    Attributes:
        velocity: (3,) units/s.
        on_ground: Whether it stands on something that is flat enough.
    """

    def __init__(self, world: CollisionWorld) -> None:
        self.velocity: Vec3 = vec3((0, 0, 0))
        self.on_ground = False
        self._world, self._triggers = world, Triggers(world.bsp)
        self._now: Vec3 = vec3((0, 0, 0))
        self._before: Vec3 = self._now  # a tick ago
        self._box = STANDING
        self._ground: Vec3 | None = None  # normal of what it touches, be it too steep to stand on
        self._jump_held = False
        self._eye_height = self._eye_height_before = EYE_HEIGHT  # it takes time for steps
        self._owed = 0.0  # seconds since the last tick

    @property
    def position(self) -> Vec3:
        """(3,) the origin, world space, units: 24 above the feet."""
        return vec3(self._before + (self._now - self._before) * (self._owed / TICK))

    @property
    def eye(self) -> Vec3:
        """(3,) where it sees from; steps and crouching take the eye along smoothly."""
        gained = (self._eye_height - self._eye_height_before) * (self._owed / TICK)
        return self.position + vec3((0, 0, self._eye_height_before + gained))

    def place(self, eye: Vec3, *, drop: bool = False) -> bool:
        """Put it at rest where there is room, as near as possible to where its eye should be.

        Args:
            eye: (3,) world space, units: a camera's position.
            drop: Whether it is to stand on the floor at once instead of falling there.

        Returns:
            Whether there is room; else nothing has changed.
        """
        place = self._world.nearest_free(eye - vec3((0, 0, EYE_HEIGHT)))
        if place is None:
            return False
        if drop:
            floor = self._world.trace(place, place - vec3((0, 0, _FALL)))
            place = floor.end if floor.normal is not None else place
        self._box, self.velocity = STANDING, vec3((0, 0, 0))
        self._put(place)
        self._owed = 0.0
        self._find_ground()
        return True

    def step(self, seconds: float, wish: Wish, yaw: float) -> float:
        """Walk on.

        Args:
            seconds: Since the last call; at most `LONGEST_FRAME` are made up for.
            wish: What it wants all that time.
            yaw: Degrees that it looks along.

        Returns:
            The yaw to look along from now on: the same, unless a teleporter has turned it.
        """
        self._owed += min(seconds, LONGEST_FRAME)
        while self._owed > TICK - 1e-9:  # sums of frames round
            self._owed = max(self._owed - TICK, 0.0)
            yaw = self._tick(wish, yaw)
        return yaw

    def _tick(self, wish: Wish, yaw: float) -> float:
        self._before, self._eye_height_before = self._now, self._eye_height
        self._crouch(wish.crouch)
        self._jump(wish.jump)
        self._move(wish, yaw)
        touched = self._triggers.touched(self._now, self._box)
        if isinstance(touched, JumpPad):
            self.velocity = touched.velocity
        elif touched is not None:
            yaw = touched.yaw
            self.velocity = TELEPORT_SPEED * forward_from_angles(yaw, 0)
            above = touched.destination + vec3((0, 0, 1))
            place = self._world.nearest_free(above, self._box)
            self._put(above if place is None else place)
        self._find_ground()
        return yaw

    def _put(self, place: Vec3) -> None:
        """Be somewhere else, without a way between."""
        self._now = self._before = place
        self._eye_height = self._eye_height_before = _EYE_HEIGHTS[self._box]

    def _crouch(self, wanted: bool) -> None:
        if wanted:
            self._box = CROUCHING
        elif self._box is CROUCHING and self._world.is_free(self._now, STANDING):
            self._box = STANDING
        lag = _EYE_HEIGHTS[self._box] - self._eye_height
        self._eye_height += lag * (1 - math.exp(-TICK / _EYE_SECONDS))

    def _jump(self, wanted: bool) -> None:
        if wanted and self.on_ground and not self._jump_held:
            self.velocity = vec3((*self.velocity[:2], JUMP_SPEED))
            self._ground, self.on_ground = None, False
            self._jump_held = True
        self._jump_held &= wanted

    def _move(self, wish: Wish, yaw: float) -> None:
        ahead, right = forward_from_angles(yaw, 0), forward_from_angles(yaw - 90, 0)
        if self.on_ground and self._ground is not None:
            self._slow_down()
            ahead, right = (_unit(clip(way, self._ground)) for way in (ahead, right))
        wanted = RUN_SPEED * (wish.forward * ahead + wish.side * right)
        speed = min(float(np.linalg.norm(wanted)), RUN_SPEED)
        if self.on_ground and self._box is CROUCHING:
            speed = min(speed, RUN_SPEED * CROUCHED_SPEED)
        self._accelerate(_unit(wanted), speed)
        if self._ground is not None:
            clipped = clip(self.velocity, self._ground)
            if self.on_ground:  # slopes do not change the speed
                clipped = _unit(clipped) * np.linalg.norm(self.velocity)
            self.velocity = clipped
        if self.on_ground and not self.velocity[:2].any():
            return
        before = Motion(self._now, self.velocity)
        falls = not self.on_ground
        after = step_slide(self._world, before, self._box, TICK, self._ground, falls=falls)
        climbed = after.position[2] - before.position[2] - max(before.velocity[2], 0) * TICK
        if climbed > _SMALLEST_STEP:
            self._eye_height -= climbed
        self._now, self.velocity = after.position, after.velocity

    def _slow_down(self) -> None:
        """Friction, of which slow things feel more for their speed."""
        speed = float(np.linalg.norm(self.velocity[:2]))
        if speed < 1:
            self.velocity = vec3((0, 0, self.velocity[2]))
            return
        lost = max(speed, STOP_SPEED) * FRICTION * TICK
        self.velocity = self.velocity * max(1 - lost / speed, 0.0)

    def _accelerate(self, direction: Vec3, speed: float) -> None:
        """Gain speed in a direction for as long as there is less of it than wished."""
        lacking = speed - float(self.velocity @ direction)
        if lacking > 0:
            rate = ACCELERATION if self.on_ground else AIR_ACCELERATION
            self.velocity = self.velocity + direction * min(rate * TICK * speed, lacking)

    def _find_ground(self) -> None:
        trace = self._world.trace(self._now, self._now - vec3((0, 0, _GROUND_REACH)), self._box)
        self._ground, self.on_ground = trace.normal, False
        if trace.normal is None:
            return
        leaves = self.velocity[2] > 0 and self.velocity @ trace.normal > _KICK_OFF
        if leaves:
            self._ground = None
        else:
            self.on_ground = bool(trace.normal[2] >= FLATTEST_WALL)


def _unit(vector: Vec3) -> Vec3:
    """A (3,) vector's direction; none where it has none."""
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0 else vector
