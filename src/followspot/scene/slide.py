"""How a moving box slides along walls and climbs steps.

Source: ``bg_slidemove.c`` of Quake III Arena, whose rules and numbers these are.
"""

from dataclasses import dataclass, replace

import numpy as np

from followspot.game import GRAVITY, STEP_HEIGHT
from followspot.scene.collision import Box, CollisionWorld
from followspot.spaces import Vec3, vec3

FLATTEST_WALL = 0.7
"""Height of a unit normal from which on it is a floor's (``MIN_WALK_NORMAL``): 45.6 degrees."""

_OVERBOUNCE = 1.001
"""Share of the velocity into a plane that is taken away, so that rounding leads out of it."""
_PUSH = 0.1
"""Units/s into a plane that are let pass as none."""
_SAME_PLANE = 0.99
"""Cosine between the normals of planes that count as one."""
_MAX_BUMPS = 4
_MAX_PLANES = 5
_UP = vec3((0, 0, 1))


@dataclass(frozen=True, eq=False)
class Motion:
    """Where a box is and how it moves.

    Attributes:
        position: (3,) world space, units.
        velocity: (3,) units/s.
    """

    position: Vec3
    velocity: Vec3


def clip(velocity: Vec3, normal: Vec3) -> Vec3:
    """A (3,) velocity without what leads into a plane of unit normal `normal`."""
    into = float(velocity @ normal)
    return velocity - normal * (into * _OVERBOUNCE if into < 0 else into / _OVERBOUNCE)


def step_slide(
    world: CollisionWorld,
    motion: Motion,
    box: Box,
    seconds: float,
    ground: Vec3 | None,
    *,
    falls: bool,
) -> Motion:
    """Move a box for some time; what is low enough it climbs, along everything else it slides.

    Args:
        world: What is in the way.
        motion: At the start.
        box: What moves.
        seconds: How long.
        ground: (3,) normal of what it stands on, if it does.
        falls: Whether gravity acts.

    Returns:
        The motion at the end.
    """
    slid, bumped = _slide(world, motion, box, seconds, ground, falls=falls)
    if not bumped:
        return slid
    step = _UP * STEP_HEIGHT
    if motion.velocity[2] > 0:  # on the way up only what is stood on counts as a step
        below = world.trace(motion.position, motion.position - step, box)
        if below.normal is None or below.normal[2] < FLATTEST_WALL:
            return slid
    above = world.trace(motion.position, motion.position + step, box)
    if above.all_solid:
        return slid
    higher = replace(motion, position=above.end)
    climbed, _ = _slide(world, higher, box, seconds, ground, falls=falls)
    height = above.end[2] - motion.position[2]
    below = world.trace(climbed.position, climbed.position - _UP * height, box)
    velocity = climbed.velocity if below.normal is None else clip(climbed.velocity, below.normal)
    return Motion(climbed.position if below.all_solid else below.end, velocity)


def _slide(
    world: CollisionWorld,
    motion: Motion,
    box: Box,
    seconds: float,
    ground: Vec3 | None,
    *,
    falls: bool,
) -> tuple[Motion, bool]:
    """Move a box along whatever it meets; tells whether it met anything.

    While falling it moves with the mean of the velocities at the start and the end, which is exact
    for a parabola.
    """
    position, velocity = motion.position, motion.velocity
    final = velocity  # at the end of the time, turned by planes as `velocity` is
    if falls:
        final = velocity - _UP * (GRAVITY * seconds)
        velocity = (velocity + final) / 2
        if ground is not None:
            velocity = clip(velocity, ground)
    # Nothing that it is turned by may turn it back against these.
    planes = [] if ground is None else [ground]
    speed = float(np.linalg.norm(velocity))
    if speed > 0:
        planes.append(velocity / speed)

    left = seconds
    for bump in range(_MAX_BUMPS):
        trace = world.trace(position, position + velocity * left, box)
        if trace.all_solid:
            return Motion(position, vec3((final[0], final[1], 0))), True
        position = trace.end
        if trace.normal is None:
            return Motion(position, final), bump > 0
        left -= left * trace.fraction
        if len(planes) >= _MAX_PLANES:
            return Motion(position, vec3((0, 0, 0))), True
        normal = trace.normal
        if any(normal @ plane > _SAME_PLANE for plane in planes):
            velocity = velocity + normal  # a plane met twice: rounding, so away from it
            continue
        planes.append(normal)
        velocity, final = _turned(velocity, final, planes)
        if not velocity.any():
            return Motion(position, velocity), True
    return Motion(position, final), True


def _turned(velocity: Vec3, final: Vec3, planes: list[Vec3]) -> tuple[Vec3, Vec3]:
    """Turn two velocities, by the first one, so that no plane is moved into.

    Against one plane they lose what leads into it; where that leads into a second one, they go
    along the crease of the two; where that leads into a third one, they stop.
    """
    for i, plane in enumerate(planes):
        if velocity @ plane >= _PUSH:
            continue
        turned, turned_final = clip(velocity, plane), clip(final, plane)
        for j, other in enumerate(planes):
            if j == i or turned @ other >= _PUSH:
                continue
            turned, turned_final = clip(turned, other), clip(turned_final, other)
            if turned @ plane >= 0:
                continue
            crease = np.cross(plane, other)
            crease /= max(float(np.linalg.norm(crease)), 1e-6)  # 0 between opposite planes: stop
            turned, turned_final = crease * (crease @ velocity), crease * (crease @ final)
            rest = (p for k, p in enumerate(planes) if k not in (i, j))
            if any(turned @ third < _PUSH for third in rest):
                return vec3((0, 0, 0)), vec3((0, 0, 0))
        return turned, turned_final
    return velocity, final
