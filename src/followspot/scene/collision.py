"""A box on its way through a level: how far it gets, and what stops it.

What stops a player are the level's solid brushes and those that are there for players alone
("clip"), doors and platforms where they stand, and curved patches, cut into triangles. Models
stop nobody, as in the game: authors put clip brushes round them.

Sources: ``cm_trace.c`` and ``cm_patch.c`` of Quake III Arena, whose rules for touching and for
starting inside of something are kept, since the rules of movement rely on them.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints
from followspot.assets.binary import run_members
from followspot.assets.bsp import BspFile, FaceType
from followspot.assets.surface_flags import Contents
from followspot.game import FLOOR_BELOW_PLAYER
from followspot.scene import bsp_tree, patch, solids
from followspot.scene.level import entity_vector, model_number
from followspot.scene.mesh import VERTEX
from followspot.scene.solids import Solids
from followspot.spaces import Vec3, vec3

STOPS_PLAYERS = Contents.SOLID | Contents.PLAYERCLIP | Contents.BODY
"""``MASK_PLAYERSOLID`` of the game."""

SOLID_MODELS = frozenset(
    (
        "func_static",
        "func_door",
        "func_button",
        "func_plat",
        "func_bobbing",
        "func_pendulum",
        "func_rotating",
        "func_train",
    )
)
"""Classes of entities whose brush models are solid; those of triggers are not."""

PATCH_TOLERANCE = 2.0
"""Units by which a patch's triangles may miss the curve: what is bumped into is what is seen."""

GAP = 0.125
"""Units of air that a moving box leaves before what stops it (``SURFACE_CLIP_EPSILON``)."""

_REGION = 96.0
"""Units around a box in which solids are looked up at a time."""


@dataclass(frozen=True, eq=False)
class Box:
    """An upright box that moves about, by its corners relative to its position.

    Attributes:
        mins: (3,) units.
        maxs: (3,) units.
    """

    mins: Vec3
    maxs: Vec3
    centre: Vec3 = field(init=False)
    half: Vec3 = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", vec3((self.mins + self.maxs) / 2))
        object.__setattr__(self, "half", vec3((self.maxs - self.mins) / 2))


STANDING = Box(vec3((-15, -15, -FLOOR_BELOW_PLAYER)), vec3((15, 15, 32)))
"""A player, round the origin (``playerMins``, ``playerMaxs``)."""
CROUCHING = Box(vec3((-15, -15, -FLOOR_BELOW_PLAYER)), vec3((15, 15, 16)))


@dataclass(frozen=True, eq=False)
class Trace:
    """How far a box gets on a straight line.

    Attributes:
        fraction: Of the way; 1 where nothing is in it, 0 where it cannot move.
        end: (3,) the position there.
        normal: (3,) of the plane that stops it, towards the box; None where none does.
        starts_solid: Whether it overlaps something at the start. That stops it only if it does
            so all the way.
        all_solid: Whether there is one solid that it overlaps all the way; then it stays.
    """

    fraction: float
    end: Vec3
    normal: Vec3 | None = None
    starts_solid: bool = False
    all_solid: bool = False


class CollisionWorld:
    """Everything in a level that stops a player.

    Which solids are near is kept from one question to the next, so that a box which moves on by
    little steps is cheap; the answers do not depend on it.
    """

    def __init__(self, bsp: BspFile) -> None:
        self.bsp = bsp
        self.solids = solids.joined([_solid_brushes(bsp), _solid_patches(bsp)])
        self._probe = Probe(self.solids)

    def trace(self, start: Vec3, end: Vec3, box: Box = STANDING) -> Trace:
        """Move a box along a straight line until something stops it.

        Args:
            start: (3,) its position, world space, units.
            end: (3,) where it is to go; the same as `start` to ask only for `starts_solid`.
            box: What moves.
        """
        return self._probe.trace(start, end, box)

    def is_free(self, position: Vec3, box: Box = STANDING) -> bool:
        """Whether a box overlaps nothing at a (3,) position, and is within the level."""
        if self.trace(position, position, box).starts_solid:
            return False
        leaf = bsp_tree.point_leafs(self.bsp, position[np.newaxis])[0]
        return bool(self.bsp.leafs["cluster"][leaf] >= 0)

    def nearest_free(self, position: Vec3, box: Box = STANDING) -> Vec3 | None:
        """The place closest to a (3,) position where a box is free, or None within 128 units.

        A star of places is tried: 26 directions, and twelve distances along each.
        """
        for offset in _STAR:
            if self.is_free(position + offset, box):
                return vec3(position + offset)
        return None


def _star() -> Floats:
    """(n, 3) offsets from the closest on; of those equally far the highest first."""
    steps = np.array(np.meshgrid(*[[1, 0, -1]] * 3)).reshape(3, -1).T
    steps = steps[steps.any(axis=1)]
    directions = steps / np.linalg.norm(steps, axis=1, keepdims=True)
    distances = np.array([0.25, 1, 2, 4, 8, 16, 24, 32, 48, 64, 96, 128])
    offsets = (distances[:, np.newaxis, np.newaxis] * directions).reshape(-1, 3)
    order = np.lexsort((-offsets[:, 2], np.repeat(distances, len(directions))))
    return np.concatenate([np.zeros((1, 3)), offsets[order]])


_STAR = _star()


class Probe:
    """Traces boxes through some solids, and keeps in mind which of them are near."""

    def __init__(self, among: Solids) -> None:
        self._solids = among
        # A box is met if this is below (highest of the other, -lowest of the other), row by row.
        self._bounds = np.concatenate([among.mins, -among.maxs], axis=1).T.copy()
        self._region = np.full(6, -np.inf)
        self._near = np.empty(0, np.int64)
        self._near_bounds = self._bounds[:, :0]

    def trace(self, start: Vec3, end: Vec3, box: Box) -> Trace:
        """See `CollisionWorld.trace`."""
        found = self._meeting(start, end, box)
        if not found.size:
            return Trace(1.0, vec3(end))
        first, count = self._solids.first[found], self._solids.count[found]
        members = run_members(first, count)
        normal = self._solids.normal[members]
        reach = self._solids.distance[members] + np.abs(normal) @ box.half - normal @ box.centre
        before, after = normal @ start - reach, normal @ end - reach  # heights of start and end

        # The interval of fractions in which the box is behind all of a solid's planes; coming in,
        # it counts as behind a plane GAP too early. (Going out the game does so too, and thereby
        # lets corners be cut by as much, and rays through curves.)
        slope = before - after
        divisor = np.where(slope != 0, slope, 1)
        entry = np.where((slope > 0) & (before > 0), np.maximum((before - GAP) / divisor, 0), -1)
        leave = np.where((slope < 0) & (after > 0), before / divisor, 1)
        passes = (before > 0) & ((after >= GAP) | (slope <= 0))

        runs = np.cumsum(count) - count
        enters = np.maximum.reduceat(entry, runs)
        apart = np.logical_or.reduceat(passes, runs)
        inside = ~np.logical_or.reduceat(before > 0, runs) & ~apart
        starts_solid = bool(inside.any())
        if starts_solid and (inside & ~np.logical_or.reduceat(after > 0, runs)).any():
            return Trace(0.0, vec3(start), None, starts_solid=True, all_solid=True)
        hit = ~apart & ~inside & (enters < np.minimum.reduceat(leave, runs))
        if not hit.any():
            return Trace(1.0, vec3(end), None, starts_solid)
        solid = int(np.argmin(np.where(hit, enters, np.inf)))
        run = slice(runs[solid], runs[solid] + count[solid])
        fraction = float(enters[solid])
        stop = vec3(start + fraction * (end - start))
        return Trace(fraction, stop, vec3(normal[run][entry[run].argmax()]), starts_solid)

    def _meeting(self, start: Vec3, end: Vec3, box: Box) -> Ints:
        """(n,) numbers of solids whose boxes meet that of a box's way, in order."""
        low, high = np.minimum(start, end) + box.mins - 1, np.maximum(start, end) + box.maxs + 1
        wanted = np.concatenate([high, -low])
        if (wanted > self._region).any():
            self._region = wanted + _REGION
            near = np.logical_and.reduce(self._bounds < self._region[:, np.newaxis], axis=0)
            self._near = np.flatnonzero(near)
            self._near_bounds = self._bounds[:, self._near]
        meets = np.logical_and.reduce(self._near_bounds < wanted[:, np.newaxis], axis=0)
        return self._near[meets]


def _solid_models(bsp: BspFile) -> tuple[NDArray[np.void], Floats]:
    """(m,) all models that stop players, the world first, and (m, 3) their origins."""
    found = [(0, np.zeros(3))][: len(bsp.models)]
    for entity in bsp.entities:
        number = model_number(bsp, entity)
        if number is not None and entity.get("classname", "").lower() in SOLID_MODELS:
            origin = entity_vector(entity, "origin")
            found.append((number, np.zeros(3) if origin is None else origin))
    numbers = np.array([number for number, _ in found], np.int64)
    return bsp.models[numbers], np.array([origin for _, origin in found]).reshape(-1, 3)


def _solid_brushes(bsp: BspFile) -> Solids:
    models, origins = _solid_models(bsp)
    brushes = run_members(models["first_brush"], models["brush_count"])
    offsets = np.repeat(origins, models["brush_count"], axis=0)
    stops = (bsp.shaders["content_flags"][bsp.brushes["shader"][brushes]] & STOPS_PLAYERS) != 0
    return solids.of_brushes(bsp, brushes[stops], offsets[stops])


def _solid_patches(bsp: BspFile) -> Solids:
    """The triangles of all solid patches, drawn or not."""
    models, origins = _solid_models(bsp)
    faces = bsp.faces[run_members(models["first_face"], models["face_count"])]
    offsets = np.repeat(origins, models["face_count"], axis=0)
    stops = (bsp.shaders["content_flags"][faces["shader"]] & STOPS_PLAYERS) != 0
    stops &= faces["type"] == FaceType.PATCH
    faces, offsets = faces[stops], offsets[stops]
    count = faces["vertex_count"].astype(np.int64)
    source = run_members(faces["first_vertex"], count)
    control = np.zeros(len(source), VERTEX)
    control["position"] = bsp.vertices["position"][source] + np.repeat(offsets, count, axis=0)
    control["normal"] = bsp.vertices["normal"][source]
    made = patch.tessellate(control, np.cumsum(count) - count, faces["patch_size"], PATCH_TOLERANCE)
    corners = made.vertices["position"][made.indices.reshape(-1, 3)].astype(np.float64)
    return solids.of_triangles(corners)
