"""Fog: boxes of a level that hold back what is seen through them and shine in its place.

Inside of a volume there is as much fog everywhere. Of the light from behind, the share
``exp(-extinction * length)`` comes through (Beer and Lambert), and the rest is replaced by what the
fog scatters, which a photographer would call its colour times the light around it.

Quake's scripts tell the depth through which nothing is to be seen. That is taken to be the
meteorologists' optical range, through which a twentieth of the light comes (World Meteorological
Organization, "Guide to Instruments and Methods of Observation", volume I, chapter 9). The game
takes the root of the share of that depth instead. Over the depth's length both hide as much in the
mean.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats, Mask
from followspot.assets.binary import text_until_nul
from followspot.assets.bsp import BspFile
from followspot.assets.image import srgb_to_linear
from followspot.assets.shader_script import ShaderScript
from followspot.spaces import Vec3

_RANGE = -math.log(0.05)
"""Optical depth of the optical range."""

_THINNEST = 1.0
"""Units of depth that a script can ask for at least, as in ioquake3's ``R_LoadFogs``."""

_AXIAL = 0.9999
"""Component of a unit normal from which on it is along an axis."""


@dataclass(frozen=True, eq=False)
class Fog:
    """A box of fog.

    Attributes:
        mins: (3,) corner in world units.
        maxs: (3,) the opposite corner.
        albedo: (3,) share of light that it scatters and does not swallow, linear.
        extinction: Of light that goes through, per unit.
    """

    mins: Vec3
    maxs: Vec3
    albedo: Vec3
    extinction: float


def volumes(bsp: BspFile, find_script: Callable[[str], ShaderScript | None]) -> tuple[Fog, ...]:
    """A level's fog, without volumes whose script is missing or tells of none.

    A volume is a brush, of which only planes along the axes count, as in the game.

    Args:
        bsp: The level's records.
        find_script: A shader's name to its script, if it has one.
    """
    found = []
    for effect in bsp.effects:
        script = find_script(text_until_nul(effect["name"]))
        parms = script.fog if script is not None else None
        if parms is not None:
            mins, maxs = _box(bsp, int(effect["brush"]))
            albedo = srgb_to_linear(np.array(parms.color, np.float64))
            found.append(Fog(mins, maxs, albedo, _RANGE / max(parms.depth, _THINNEST)))
    return tuple(found)


def _box(bsp: BspFile, brush: int) -> tuple[Vec3, Vec3]:
    """What a brush's axial planes leave of the world's box."""
    world = bsp.models[0]
    mins, maxs = world["mins"].astype(np.float64), world["maxs"].astype(np.float64)
    first, count = (int(bsp.brushes[name][brush]) for name in ("first_side", "side_count"))
    planes = bsp.planes[bsp.brush_sides["plane"][first : first + count]]
    for normal, distance in zip(planes["normal"], planes["distance"], strict=True):
        axis = int(np.abs(normal).argmax())
        if normal[axis] > _AXIAL:
            maxs[axis] = min(maxs[axis], distance)
        elif normal[axis] < -_AXIAL:
            mins[axis] = max(mins[axis], -distance)
    return mins, np.maximum(mins, maxs)


def holds(fog: Fog, points: Floats, margin: float = 0.0) -> Mask:
    """(n,) which of (n, 3) world places are in a volume, or at most so many units beside it."""
    return np.asarray(((points > fog.mins - margin) & (points < fog.maxs + margin)).all(axis=1))


def optical_depths(fogs: Sequence[Fog], eye: Floats, places: Floats) -> Floats:
    """How much of each fog is between the eye and some places.

    The way through a box by its slabs (Kay and Kajiya 1986), as ``fog.glsl`` finds it.

    Args:
        fogs: The volumes.
        eye: (3,) world units.
        places: (n, 3) likewise.

    Returns:
        (n, fogs) extinction times units inside.
    """
    ray = places - eye
    depths = np.zeros((len(places), len(fogs)))
    with np.errstate(divide="ignore", invalid="ignore"):
        for k, fog in enumerate(fogs):
            first, second = (fog.mins - eye) / ray, (fog.maxs - eye) / ray
            enters = np.fmin(first, second).max(axis=1, initial=0.0)
            leaves = np.fmax(first, second).min(axis=1, initial=1.0)
            inside = np.maximum(leaves - enters, 0) * np.linalg.norm(ray, axis=1)
            depths[:, k] = fog.extinction * inside
    return depths
