"""Models that move: their key poses, what they wear, and what they can do.

A figure is an MD2 model, a single MD3 model, or a whole MD3 player, whose three parts hang on one
another by tags. What is the same for all of them is here: surfaces that wear one material are
joined, and animations are found by name.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from followspot.assets.animation import Animation
from followspot.assets.md2 import Md2Model
from followspot.assets.md3 import Md3Model
from followspot.assets.player import PARTS, Player
from followspot.errors import AssetError
from followspot.game import FLOOR_BELOW_PLAYER
from followspot.scene.material import Material
from followspot.spaces import Mat4

STILL = Animation(first=0, count=1, looping=0, fps=1.0)
"""What a figure without animations does."""

FindMaterial = Callable[[str], Material]
"""A shader's or image's name, as models write it, to the material that it makes."""

WHITE = Material("white")
"""Stands in for what is missing."""

_STANDING = {"legs": "legs_idle", "torso": "torso_stand"}


class Tracks(NamedTuple):
    """What the lower and the upper part of a figure play; the same where it is one model."""

    legs: Animation
    torso: Animation


@dataclass(frozen=True)
class Run:
    """Indices of a part, or of all together, that wear one material: `count` from `first` on."""

    material: Material
    first: int
    count: int


@dataclass(frozen=True, eq=False)
class FigurePart:
    """Triangles that move together; Quake units, clockwise front faces.

    Attributes:
        slot: Which part of a player it is: 0 lower, or the whole figure, 1 upper, 2 head.
        positions: (frames, vertices, 3) float32.
        normals: (frames, vertices, 3) float32, unit length.
        texcoords: (vertices, 2) float32.
        indices: (i,) uint32, three a triangle, in the order of `runs`.
        runs: One for each material, without gaps.
    """

    slot: int
    positions: NDArray[np.float32]
    normals: NDArray[np.float32]
    texcoords: NDArray[np.float32]
    indices: NDArray[np.uint32]
    runs: tuple[Run, ...]

    @property
    def vertex_count(self) -> int:
        """Number of vertices of one frame."""
        return len(self.texcoords)

    @property
    def radius(self) -> float:
        """Units from the part's origin to its farthest vertex in any frame."""
        if not self.positions.size:
            return 0.0
        return float(np.sqrt((self.positions.astype(np.float64) ** 2).sum(axis=2).max()))


@dataclass(frozen=True, eq=False)
class Figure:
    """A model ready to be placed, as often as wanted.

    Attributes:
        name: What it was opened as.
        parts: In the order of their slots; at most one a slot.
        animations: By name.
        torso_keys: (frames, 4, 4) ``lower_from_upper`` by frame of the legs, of a player.
        head_keys: (frames, 4, 4) ``upper_from_head`` by frame of the torso, of a player.
        radius: Units from the origin that no pose exceeds.
    """

    name: str
    parts: tuple[FigurePart, ...]
    animations: Mapping[str, Animation] = field(default_factory=dict)
    torso_keys: Mat4 | None = None
    head_keys: Mat4 | None = None
    radius: float = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", self._reach())

    def _reach(self) -> float:
        """Parts hang on one another like the links of a chain, each at most so far out."""
        links = [0.0, _farthest(self.torso_keys), _farthest(self.head_keys)]
        chain = np.cumsum(links)
        return max((float(chain[p.slot]) + p.radius for p in self.parts), default=0.0)

    @property
    def is_player(self) -> bool:
        """Whether legs and torso have animations of their own."""
        return self.torso_keys is not None

    @property
    def triangle_count(self) -> int:
        """Triangles of all parts."""
        return sum(len(part.indices) for part in self.parts) // 3

    def tracks(self, name: str | None = None) -> Tracks:
        """What is played under a name; none is how the figure stands.

        A player's names may leave out what they begin with: ``run`` is ``legs_run`` while the
        torso stands, ``gesture`` is ``torso_gesture`` while the legs do. ``run+attack`` moves
        both, and so does ``death1``, which is ``both_death1``.

        Raises:
            AssetError: the figure has no animation of that name; lists those that it has.
        """
        if name is None:
            name = "stand" if self.is_player or "stand" in self.animations else ""
            if not name or not self.animations:
                first = next(iter(self.animations.values()), STILL)
                return Tracks(first, first)
        if not self.is_player:
            found = self.animations.get(name.lower())
            if found is None:
                raise self._unknown(name)
            return Tracks(found, found)
        legs_name, plus, torso_name = name.lower().partition("+")
        legs, torso = self._track("legs", legs_name), self._track("torso", torso_name or legs_name)
        if (plus and None in (legs, torso)) or (legs is None and torso is None):
            raise self._unknown(name)
        return Tracks(legs or self._standing("legs"), torso or self._standing("torso"))

    def _track(self, part: str, name: str) -> Animation | None:
        if name == "stand":
            return self._standing(part)
        names = (name, f"both_{name}", f"{part}_{name}")
        of_part = (n for n in names if n.startswith(("both_", f"{part}_")))
        return next((self.animations[n] for n in of_part if n in self.animations), None)

    def _standing(self, part: str) -> Animation:
        return self.animations.get(_STANDING[part], STILL)

    def _unknown(self, name: str) -> AssetError:
        there_are = f"one of {', '.join(self.animations)}" if self.animations else "none"
        return AssetError(self.name, place="animation", expected=there_are, found=name)

    def floor_below(self, animation: Animation) -> float:
        """Units from the origin down to the floor that the figure stands on.

        A player's is where the game has it; any other figure's is under its lowest vertex while
        it plays an animation.
        """
        if self.is_player:
            return FLOOR_BELOW_PLAYER
        frames = slice(animation.first, animation.first + animation.count)
        lowest = [p.positions[frames, :, 2].min() for p in self.parts if p.positions.size]
        return -float(min(lowest, default=0.0))


def transformed(figure: Figure, figure_from_model: Mat4) -> Figure:
    """A figure of one part, turned, moved and evenly scaled once and for all.

    Args:
        figure: No player.
        figure_from_model: (4, 4).
    """
    assert not figure.is_player, figure.name
    matrix = figure_from_model[:3, :3]
    rotation = matrix / np.cbrt(np.linalg.det(matrix))
    parts = (
        replace(
            part,
            positions=(part.positions @ matrix.T + figure_from_model[:3, 3]).astype(np.float32),
            normals=(part.normals @ rotation.T).astype(np.float32),
        )
        for part in figure.parts
    )
    return Figure(figure.name, tuple(parts), figure.animations)


def from_md2(name: str, model: Md2Model, material: Material) -> Figure:
    """A figure of an MD2 model in one skin."""
    surface = Piece(model.positions, model.normals, model.texcoords, model.indices, material)
    return Figure(name, _parts([(0, [surface])]), model.animations)


def from_md3(
    name: str, model: Md3Model, textures: Sequence[str | None], find: FindMaterial
) -> Figure:
    """A figure of a single MD3 model, which has one animation: ``frames``, all of them in a row.

    Args:
        name: What to call it.
        model: Its surfaces.
        textures: What each surface wears; None is white.
        find: Makes materials of those names.
    """
    count = len(model.frames)
    animations = {"frames": Animation(0, count, count, 10.0)} if count > 1 else {}
    return Figure(name, _parts([(0, _dressed(model, textures, find))]), animations)


def from_player(player: Player, find: FindMaterial) -> Figure:
    """A figure of a whole player; surfaces that its skin says nothing of are white."""
    parts = [
        (slot, _dressed(player.parts[part].model, player.parts[part].textures, find))
        for slot, part in enumerate(PARTS)
        if part in player.parts
    ]
    return Figure(
        f"player:{player.name}",
        _parts(parts),
        player.config.animations,
        _keys(player, "lower", "tag_torso"),
        _keys(player, "upper", "tag_head"),
    )


class Piece(NamedTuple):
    """Triangles in one material; arrays as in `FigurePart`."""

    positions: NDArray[np.float32]
    normals: NDArray[np.float32]
    texcoords: NDArray[np.float32]
    indices: NDArray[np.uint32]
    material: Material


def _dressed(model: Md3Model, textures: Sequence[str | None], find: FindMaterial) -> list[Piece]:
    return [
        Piece(s.positions, s.normals, s.texcoords, s.indices, find(name) if name else WHITE)
        for s, name in zip(model.surfaces, textures, strict=True)
        if len(s.indices)
    ]


def _parts(dressed: Sequence[tuple[int, list[Piece]]]) -> tuple[FigurePart, ...]:
    return tuple(joined(slot, surfaces) for slot, surfaces in dressed if surfaces)


def joined(slot: int, surfaces: Sequence[Piece]) -> FigurePart:
    """Surfaces as one part, those of one material behind one another."""
    surfaces = sorted(surfaces, key=lambda surface: surface.material.order)
    starts = np.cumsum([0, *(len(s.texcoords) for s in surfaces)])
    runs: list[Run] = []
    end = 0
    for surface in surfaces:
        count = len(surface.indices)
        if runs and runs[-1].material == surface.material:
            runs[-1] = Run(surface.material, runs[-1].first, runs[-1].count + count)
        else:
            runs.append(Run(surface.material, end, count))
        end += count
    return FigurePart(
        slot,
        np.concatenate([s.positions for s in surfaces], axis=1),
        np.concatenate([s.normals for s in surfaces], axis=1),
        np.concatenate([s.texcoords for s in surfaces]),
        np.concatenate(
            [s.indices + np.uint32(start) for s, start in zip(surfaces, starts, strict=False)]
        ),
        tuple(runs),
    )


def _keys(player: Player, part: str, tag: str) -> Mat4:
    """The tag's keys; where there is no such part or tag, what hangs on it stands in its place."""
    frames = max((a.first + a.count for a in player.config.animations.values()), default=1)
    nowhere = np.broadcast_to(np.eye(4), (frames, 4, 4))
    if part not in player.parts:
        return nowhere
    return player.parts[part].model.tags.get(tag, nowhere)


def _farthest(keys: Mat4 | None) -> float:
    if keys is None:
        return 0.0
    return float(np.sqrt((keys[:, :3, 3] ** 2).sum(axis=1).max()))
