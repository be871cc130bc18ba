"""Figures made of the synthetic scenes' pieces, and the same pieces as a level, to compare with."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from followspot.arrays import Floats
from followspot.assets.animation import Animation
from followspot.scene.character import Character, Crowd
from followspot.scene.figure import Figure, FigurePart, Piece, joined
from followspot.scene.scene import Scene
from followspot.scene.walk import standing
from followspot.spaces import Mat4
from synthetic import Piece as StaticPiece
from synthetic import rotation, turned

Frames = Sequence[Sequence[StaticPiece]]
"""The same triangles at each key frame."""


def part(frames: Frames, slot: int = 0) -> FigurePart:
    """A figure's part whose key poses are these pieces."""
    surfaces = []
    for pieces in zip(*frames, strict=True):
        vertices = np.stack([piece.vertices for piece in pieces])
        first = pieces[0]
        surfaces.append(
            Piece(
                vertices["position"],
                vertices["normal"],
                first.vertices["texcoord"],
                first.indices,
                first.material,
            )
        )
    return joined(slot, surfaces)


def figure(
    frames: Frames, animations: Mapping[str, Animation] | None = None, name: str = "test"
) -> Figure:
    """A figure of one part; by itself it goes through all its frames, one a second."""
    every = Animation(0, len(frames), len(frames), 1.0)
    return Figure(name, (part(frames),), animations or {"frames": every})


def puppet(parts: Sequence[Frames], torso: Mat4, head: Mat4) -> Figure:
    """A player of three parts, whose legs and torso go through all their frames, one a second."""
    animations = {
        name: Animation(0, len(frames), len(frames), 1.0)
        for name, frames in (("legs_run", parts[0]), ("torso_attack", parts[1]))
    }
    animations |= {"legs_idle": Animation(0, 1, 0, 1.0), "torso_stand": Animation(0, 1, 0, 1.0)}
    made = tuple(part(frames, slot) for slot, frames in enumerate(parts))
    return Figure("player:test", made, animations, torso, head)


def key(shift: ArrayLike, turn: Floats | None = None) -> Mat4:
    """A (4, 4) matrix that turns, then moves."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.eye(3) if turn is None else turn
    matrix[:3, 3] = shift
    return matrix


def at(of: Figure, position: ArrayLike, yaw: float = 0.0, clock: float = 0.0) -> Character:
    """A character that does what its figure does by itself."""
    return Character(of, standing(position, yaw), clock=clock)


def placed(
    pieces: Sequence[StaticPiece], position: ArrayLike, yaw: float = 0.0
) -> list[StaticPiece]:
    """The pieces where a character would stand, as a level has them."""
    return turned(pieces, rotation((0, 0, 1), yaw), position)


def mixed(a: Sequence[StaticPiece], b: Sequence[StaticPiece], share: float) -> list[StaticPiece]:
    """Pieces between two key frames, with normals of unit length."""
    result = []
    for before, behind in zip(a, b, strict=True):
        vertices = before.vertices.copy()
        for name in ("position", "normal"):
            vertices[name] = (1 - share) * before.vertices[name] + share * behind.vertices[name]
        length = np.linalg.norm(vertices["normal"], axis=1, keepdims=True)
        vertices["normal"] /= length
        result.append(replace(before, vertices=vertices))
    return result


def with_characters(scene: Scene, *characters: Character) -> Scene:
    """The scene with these characters in it."""
    return replace(scene, crowd=Crowd(characters))
