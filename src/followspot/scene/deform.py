"""Surfaces whose vertices move: what of it is worked out when a level is loaded, and by time alone.

As in ioquake3's ``code/renderergl1/tr_shade_calc.c``. Light and shadows stay those of the place
where a surface rests, which is also where it casts its shadow from.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Ints
from followspot.assets.binary import run_members
from followspot.assets.shader_deform import Deform, Move, Sprite, Swell
from followspot.assets.shader_motion import Shape, Wave
from followspot.scene.mesh import Mesh
from followspot.scene.motion import value

CORNERS = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float32)
"""Texture coordinates of a sprite's vertices, from its top left on clockwise."""

_EDGES = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])


@dataclass(frozen=True)
class Deforms:
    """What a material's vertices do, one thing added to the other.

    Attributes:
        moves: All of it moves by the sum of these.
        swell: A sine along its normals.
        sprite: How its rectangles turn to the camera.
    """

    moves: tuple[Move, ...] = ()
    swell: Swell | None = None
    sprite: Sprite | None = None

    @classmethod
    def of(cls, deforms: tuple[Deform, ...]) -> "Deforms":
        """Those of a script; of several waves one. Waves other than sines are left out."""
        swells = (d for d in deforms if isinstance(d, Swell) and d.wave.shape is Shape.SIN)
        return cls(
            tuple(each for each in deforms if isinstance(each, Move)),
            next(swells, None),
            next((each for each in deforms if isinstance(each, Sprite)), None),
        )

    def moved(self, seconds: float) -> tuple[float, float, float]:
        """World units by which all of it is moved."""
        x = y = z = 0.0
        for by, wave in self.moves:
            height = value(wave, seconds)
            x, y, z = x + by[0] * height, y + by[1] * height, z + by[2] * height
        return x, y, z

    def swelling(self, seconds: float) -> tuple[float, float, float, float]:
        """Base and amplitude in units, phase in periods, periods a unit."""
        if self.swell is None:
            return 0.0, 0.0, 0.0, 0.0
        spread, wave = self.swell
        return wave.base, wave.amplitude, (wave.phase + seconds * wave.frequency) % 1.0, spread

    @property
    def reach(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(3,) least and (3,) largest units by which a vertex may be moved, but for turning."""
        low, high = np.zeros(3), np.zeros(3)
        for by, wave in self.moves:
            ends = np.multiply.outer(_range(wave), by)
            low, high = low + ends.min(axis=0), high + ends.max(axis=0)
        if self.swell is not None:
            most = max(map(abs, _range(self.swell.wave)))
            low, high = low - most, high + most
        return low, high


RIGID = Deforms()
"""That of most materials."""


def _range(wave: Wave) -> tuple[float, float]:
    """Two values between which all of a wave's are."""
    has_valleys = wave.shape in (Shape.SIN, Shape.TRIANGLE, Shape.SQUARE)
    return wave.base - has_valleys * wave.amplitude, wave.base + wave.amplitude


def deformed(mesh: Mesh, deforms: list[Deforms]) -> Mesh:
    """A mesh with sprites, whose faces' boxes hold whatever they do, at any time.

    Args:
        mesh: As it is at rest; the vertices of a face stand next to each other.
        deforms: By material.
    """
    of = mesh.faces["material"]
    chosen = np.array([each != RIGID for each in deforms], bool)[of]
    if not chosen.any():
        return mesh
    faces, vertices, indices = mesh.faces.copy(), mesh.vertices.copy(), mesh.indices.copy()
    sprites = np.zeros((len(vertices), 8), np.float32)
    for sprite in Sprite:
        is_one = np.array([each.sprite is sprite for each in deforms], bool)[of]
        which, quads = _rectangles(mesh, np.flatnonzero(is_one))
        if not len(which):
            continue
        corners = vertices["position"][quads].astype(np.float64)
        middle = corners.mean(axis=1, keepdims=True)
        radius = np.linalg.norm(corners - middle, axis=2).max(axis=1, keepdims=True)
        if sprite is Sprite.WHOLE:
            sprites[quads, :3] = middle
            sprites[quads, 3] = radius * math.sqrt(0.5)
            vertices["texcoord"][quads] = CORNERS
            turned = quads[:, [0, 1, 3, 3, 1, 2]].ravel()
            first, count = faces["first_index"][which], faces["index_count"][which]
            indices[run_members(first, count)] = turned
        else:
            fronts = vertices["normal"][quads].astype(np.float64).sum(axis=1)
            sprites[quads] = _pivots(corners, fronts)
        # A face's box is that of the balls around its rectangles.
        starts = np.cumsum(faces["index_count"][which] // 6) - faces["index_count"][which] // 6
        faces["mins"][which] = np.minimum.reduceat(middle[:, 0] - radius, starts)
        faces["maxs"][which] = np.maximum.reduceat(middle[:, 0] + radius, starts)
    low, high = (np.stack(ends) for ends in zip(*(each.reach for each in deforms), strict=True))
    faces["mins"] += low[of].astype(np.float32)
    faces["maxs"] += high[of].astype(np.float32)
    faces["normal"][chosen], faces["distance"][chosen] = 0, 0  # in no plane for good
    return replace(
        mesh,
        vertices=vertices,
        indices=indices,
        faces=faces,
        sprites=sprites if any(each.sprite is not None for each in deforms) else None,
    )


def at_time(mesh: Mesh, deforms: list[Deforms], seconds: float) -> Mesh:
    """A mesh with its vertices where they are drawn at a time, but sprites as they rest.

    Args:
        mesh: As `deformed` made it.
        deforms: By material.
        seconds: The time.
    """
    moving = [k for k, each in enumerate(deforms) if each.moves or each.swell is not None]
    if not moving:
        return mesh
    vertices = mesh.vertices.copy()
    for number in moving:
        faces = mesh.faces[mesh.faces["material"] == number]
        which = np.unique(mesh.indices[run_members(faces["first_index"], faces["index_count"])])
        base, amplitude, phase, spread = deforms[number].swelling(seconds)
        rest = vertices["position"][which].astype(np.float64)
        height = base + amplitude * np.sin(math.tau * (phase + spread * rest.sum(axis=1)))
        away = vertices["normal"][which] * height[:, np.newaxis]
        vertices["position"][which] = rest + away + deforms[number].moved(seconds)
    return replace(mesh, vertices=vertices)


def _rectangles(mesh: Mesh, faces: Ints) -> tuple[Ints, Ints]:
    """Those of some faces that are made of rectangles, and (q, 4) their vertices in file order."""
    if not len(faces):
        return faces, np.empty((0, 4), np.int64)
    count = mesh.faces["index_count"][faces].astype(np.int64)
    indices = mesh.indices[run_members(mesh.faces["first_index"][faces], count)].astype(np.int64)
    starts = np.cumsum(count) - count
    first = np.minimum.reduceat(indices, starts)
    vertices = np.maximum.reduceat(indices, starts) - first + 1
    fit = (vertices % 4 == 0) & (vertices * 6 == count * 4)
    return faces[fit], run_members(first[fit], vertices[fit]).reshape(-1, 4)


def _pivots(corners: NDArray[np.float64], fronts: NDArray[np.float64]) -> NDArray[np.float64]:
    """(q, 4, 8) what turns rectangles about their long axis: `Mesh.sprites`.

    Args:
        corners: (q, 4, 3) in units.
        fronts: (q, 3) directions that their front sides face.
    """
    ends = corners[:, _EDGES]  # (q, 6, 2, 3)
    length = np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2)
    short = np.argsort(length, axis=1, kind="stable")[:, :2]
    rows = np.arange(len(corners))[:, np.newaxis]
    middles = ends[rows, short].mean(axis=2)  # (q, 2, 3) of the two short edges
    axis = middles[:, 1] - middles[:, 0]
    axis /= np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), 1e-12)
    across = np.cross(axis, fronts)  # which way a corner lies from its edge's middle
    made = np.zeros((len(corners), 4, 8))
    made[..., 4:7] = axis[:, np.newaxis]
    for edge in range(2):
        numbers = _EDGES[short[:, edge]]  # (q, 2) of corners
        for end in range(2):
            corner = numbers[:, end]
            away = corners[rows[:, 0], corner] - middles[:, edge]
            side = np.sign(np.einsum("qk,qk->q", away, across))
            made[rows[:, 0], corner, :3] = middles[:, edge]
            made[rows[:, 0], corner, 3] = side * length[rows[:, 0], short[:, edge]] / 2
    return made
