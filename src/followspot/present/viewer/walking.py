"""Walking in place of flying: the camera as the eye of a `Walker` in the scene's level."""

from dataclasses import replace

import numpy as np

from followspot.present.viewer.flight import Flight, Steering
from followspot.present.viewer.state import State
from followspot.scene.camera import Camera
from followspot.scene.collision import CollisionWorld
from followspot.scene.level import Level
from followspot.scene.walker import Walker, Wish
from followspot.spaces import Vec3

DEEPEST_FALL = 256.0
"""Units below the level after which nothing will stop a fall."""

NO_ROOM = "There is no room to walk here: flying on."


class Walking:
    """Whoever walks. What is solid is found in a level when somebody wants to walk in it."""

    def __init__(self) -> None:
        self._level: Level | None = None
        self._walker: Walker
        self._eye = np.full(3, np.nan)

    def after(self, state: State, seconds: float, steering: Steering) -> State:
        """The state after a frame's walk.

        A camera that is not where the last walk left it has been taken somewhere else; the walk
        goes on there, or nearby, or ends if there is no room.

        Args:
            state: One that walks.
            seconds: Length of the frame.
            steering: Up is to jump, down to crouch, a pace below 1 to walk instead of run.
        """
        level = state.scene.level
        if level is not self._level:
            self._level, self._walker = level, Walker(CollisionWorld(level.bsp))
            self._eye = np.full(3, np.nan)
        eye = state.camera.position
        if not (np.array_equal(eye, self._eye) or self._walker.place(eye)):
            return replace(state, walks=False, notice=NO_ROOM)
        turning = Steering(yaw=steering.yaw, pitch=steering.pitch, notches=steering.notches)
        flight = replace(state.flight, velocity=np.zeros(3)).after(seconds, turning)
        yaw = self._walker.step(seconds, _wish(steering), flight.camera.yaw)
        if yaw != flight.camera.yaw:  # by a teleporter, which ends all turning
            flight = flight.at(replace(flight.camera, yaw=yaw))
        if self._walker.position[2] < level.bsp.models["mins"][0][2] - DEEPEST_FALL:
            return state.jumped(_spawn(state))
        self._eye = self._walker.eye
        return replace(state, flight=_moved(flight, self._eye))


def _wish(steering: Steering) -> Wish:
    pace = min(steering.pace, 1.0)
    return Wish(
        forward=steering.forward * pace,
        side=-steering.left * pace,
        jump=steering.up > 0,
        crouch=steering.up < 0,
    )


def _moved(flight: Flight, eye: Vec3) -> Flight:
    """The camera's place, which is no named one any more once it has moved."""
    if np.array_equal(flight.camera.position, eye):
        return flight
    return replace(flight, camera=replace(flight.camera, position=eye, name=""))


def _spawn(state: State) -> Camera:
    """A place to begin again."""
    cameras = state.scene.cameras
    return cameras.get("spawn0", state.scene.camera())
