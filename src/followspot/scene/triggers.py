"""What a level does to those who step into it: jump pads and teleporters.

Sources: ``g_trigger.c`` (``AimAtTarget``), ``g_misc.c`` (``TeleportPlayer``) and ``bg_misc.c``
(``BG_TouchJumpPad``) of Quake III Arena.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats
from followspot.assets.binary import run_members
from followspot.assets.bsp import BspFile
from followspot.game import GRAVITY
from followspot.scene import solids
from followspot.scene.collision import Box, Probe
from followspot.scene.level import (
    entity_angles,
    entity_flags,
    entity_vector,
    model_number,
    target_of,
)
from followspot.scene.solids import Solids
from followspot.spaces import Vec3, vec3

_SPECTATORS_ONLY = 1  # spawn flag of teleporters


@dataclass(frozen=True, eq=False)
class JumpPad:
    """Gives whoever touches it a velocity, (3,) units/s."""

    velocity: Vec3


@dataclass(frozen=True, eq=False)
class Teleporter:
    """Takes whoever touches it to a place, (3,) units, to look along a yaw in degrees."""

    destination: Vec3
    yaw: float


class Triggers:
    """The jump pads and teleporters of a level.

    Those without a target, and pads whose target is not above them, do nothing.
    """

    def __init__(self, bsp: BspFile) -> None:
        found = list(_found(bsp))
        self._triggers = [trigger for trigger, _ in found]
        self._probes = [Probe(volume) for _, volume in found]
        mins = [volume.mins.min(axis=0, initial=np.inf) for _, volume in found]
        maxs = [volume.maxs.max(axis=0, initial=-np.inf) for _, volume in found]
        self._mins, self._maxs = np.reshape(mins, (-1, 3)), np.reshape(maxs, (-1, 3))

    def touched(self, position: Vec3, box: Box) -> JumpPad | Teleporter | None:
        """The first trigger of the level that a box at a (3,) position overlaps."""
        meets = (position + box.mins < self._maxs) & (position + box.maxs > self._mins)
        for number in np.flatnonzero(meets.all(axis=1)):
            if self._probes[number].trace(position, position, box).starts_solid:
                return self._triggers[number]
        return None


def _found(bsp: BspFile) -> Iterator[tuple[JumpPad | Teleporter, Solids]]:
    """All triggers that work, and where they are."""
    for entity in bsp.entities:
        number = model_number(bsp, entity)
        if number is None:
            continue
        origin = entity_vector(entity, "origin")
        offset = np.zeros(3) if origin is None else origin
        model = bsp.models[[number]]
        middle = (model["mins"][0].astype(np.float64) + model["maxs"][0]) / 2 + offset
        trigger = _trigger(entity, middle, target_of(bsp, entity))
        if trigger is not None:
            brushes = run_members(model["first_brush"], model["brush_count"])
            offsets = np.broadcast_to(offset, (len(brushes), 3))
            yield trigger, solids.of_brushes(bsp, brushes, offsets)


def _trigger(
    entity: dict[str, str], middle: Floats, target: dict[str, str]
) -> JumpPad | Teleporter | None:
    """What an entity does to those in its volume, with its middle at a (3,) place."""
    kind, place = entity.get("classname", "").lower(), entity_vector(target, "origin")
    if place is None:
        return None
    if kind == "trigger_push" and place[2] > middle[2]:
        return JumpPad(_launch(middle, place))
    if kind == "trigger_teleport" and not entity_flags(entity) & _SPECTATORS_ONLY:
        return Teleporter(vec3(place), entity_angles(target)[0])
    return None


def _launch(start: Floats, apex: Floats) -> Vec3:
    """(3,) units/s with which a thrown body has its highest point at `apex`.

    It rises by h in the time t with h = g t^2 / 2, and begins with the speed g t upwards.
    """
    time = math.sqrt(2 * (apex[2] - start[2]) / GRAVITY)
    x, y, _ = (apex - start) / time
    return vec3((x, y, GRAVITY * time))
