"""Lamps for a level that has none: where they stand, how far they reach, what stops them.

They are all alike: a white surface GREY_AT units away is shown as middle grey. A lamp counts where
it changes the displayed linear value of a white surface by CUT_OFF or more, so that the reach of
all is the same whatever the exposure is.
"""

import math
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats, Mask
from followspot.passes import drawlist
from followspot.scene import bsp_tree
from followspot.scene.level import entity_vector
from followspot.scene.mesh import FLAT
from followspot.scene.scene import Scene
from followspot.spaces import directions_around, vec3

LAMPS = 32
GREY, GREY_AT = 0.18, 100.0
"""A lamp shows a white surface that faces it so many units away at this linear display value."""

CUT_OFF = 1 / 255
"""Of the linear display value of a white surface. Near middle grey one step of 8-bit sRGB is a
little less, 0.0033; on black, where one sees the most, it is a thirteenth of this."""

LEAST_CUT_OFF = 1e-4
"""Of those that the numbers of lamps are plotted for."""

REACH = GREY_AT * math.sqrt(GREY / CUT_OFF)
"""Units at which a lamp that shines squarely is at the cut-off."""

_APART = 64.0  # units between lamps, at least
_LIFT = 128.0  # units that lamps at things on the floor are lifted at most
_DIRECTIONS = 1024  # in which lamps' light is followed


@dataclass(frozen=True, eq=False)
class Lamps:
    """Where they are.

    Attributes:
        position: (n, 3) world units.
        sources: How many stand at the level's own lights, at things and spawn points, and in the
            middle of open leafs.
    """

    position: Floats
    sources: tuple[int, int, int]


def place_lamps(scene: Scene) -> Lamps:
    """Lamps at the level's own lights, then above things and spawn points, then in open leafs.

    Compiled levels mostly come without their lights: those were baked and left out.
    """
    bsp = scene.level.bsp
    lights: list[Floats] = []
    things: list[Floats] = []
    for entity in bsp.entities:
        origin = entity_vector(entity, "origin")
        if origin is not None:
            is_light = entity.get("classname", "").lower() == "light"
            (lights if is_light else things).append(origin)
    places = np.array(things, np.float64).reshape(-1, 3)
    up = np.array([0.0, 0.0, _LIFT])
    places = places + up * (bsp_tree.trace(bsp, places, places + up) * 0.8)[:, np.newaxis]
    open_leafs = bsp.leafs[~bsp_tree.leaf_is_solid(bsp)]
    middles = (open_leafs["mins"].astype(np.float64) + open_leafs["maxs"]) / 2
    chosen, counts = np.empty((0, 3)), []
    for candidates in (np.array(lights, np.float64).reshape(-1, 3), places, middles):
        is_open = ~bsp_tree.leaf_is_solid(bsp)[bsp_tree.point_leafs(bsp, candidates)]
        before = len(chosen)
        chosen = _spread(chosen, candidates[is_open])
        counts.append(len(chosen) - before)
    return Lamps(chosen, (counts[0], counts[1], counts[2]))


def _spread(chosen: Floats, candidates: Floats) -> Floats:
    """Add candidates, each time the one farthest from all others, while there is room."""
    distance = np.full(len(candidates), np.inf)
    for place in chosen:
        distance = np.minimum(distance, np.linalg.norm(candidates - place, axis=1))
    while len(chosen) < LAMPS and len(candidates) and distance.max() >= _APART:
        place = candidates[distance.argmax()]
        chosen = np.concatenate([chosen, place[np.newaxis]])
        distance = np.minimum(distance, np.linalg.norm(candidates - place, axis=1))
    return chosen


def shown_at(lamps: Floats, position: Floats, normal: Floats) -> Floats:
    """(lamps, places) linear display value of white surfaces, walls not being asked."""
    way = lamps[:, np.newaxis] - position
    distance = np.maximum(np.linalg.norm(way, axis=2), 1.0)
    cos = np.maximum((way * normal).sum(axis=2) / distance, 0)
    return np.asarray(GREY * (GREY_AT / distance) ** 2 * cos)


def reached_faces(scene: Scene, lamps: Floats) -> dict[str, Mask]:
    """By how one asks: (lamps, faces) which faces a lamp may light."""
    faces = scene.mesh.faces
    gap = np.maximum(faces["mins"] - lamps[:, np.newaxis], 0)
    gap = gap + np.maximum(lamps[:, np.newaxis] - faces["maxs"], 0)
    in_reach = np.linalg.norm(gap, axis=2) < REACH
    by_leaf = in_reach & np.array([scene.visibility.faces_from(lamp) for lamp in lamps])
    two_sided = np.array([m.is_two_sided for m in scene.materials])[faces["material"]]
    height = np.array([drawlist.height_above(faces, vec3(lamp)) for lamp in lamps])
    return {
        "every lamp": np.ones_like(in_reach),
        "within its reach": in_reach,
        "and leafs see each other": by_leaf,
        "facing it": by_leaf & (two_sided | (height >= -FLAT)),
    }


def traced_ends(scene: Scene, lamps: Floats) -> Floats:
    """(lamps, directions, 3) how far their light gets before a structural wall or their reach."""
    start = np.repeat(lamps, _DIRECTIONS, axis=0)
    way = np.tile(directions_around(_DIRECTIONS) * REACH, (len(lamps), 1))
    fraction = bsp_tree.trace(scene.level.bsp, start, start + way)
    ends = start + way * fraction[:, np.newaxis]
    return np.asarray(ends.reshape(len(lamps), _DIRECTIONS, 3))
