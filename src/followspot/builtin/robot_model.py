"""The robot's parts at rest: its feet on z = 0, looking along +X, its left at +Y.

Each part hangs on one bone of `robot_skeleton` and wears one paint of `robot_skin`. Limbs are made
for the left; the right ones are their mirror images and share their places in the skin.
"""

from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats
from followspot.builtin.robot_shapes import Shape, lathe, rounded_box


@dataclass(frozen=True, eq=False)
class Part:
    """A rigid piece.

    Attributes:
        name: What it is.
        bone: What it hangs on; of a pair, the left one.
        shape: Its surface, at rest.
        paint: What it wears.
        is_pair: Whether its mirror image hangs on the right bone.
        detail: Factor on its share of the skin.
    """

    name: str
    bone: str
    shape: Shape
    paint: str
    is_pair: bool = False
    detail: float = 1.0


def _tapered(points: Floats) -> Floats:
    """The trunk: full at the shoulders, slim at the waist."""
    factor = 0.82 + 0.18 * np.clip((points[:, 2] - 27) / 10, 0, 1.4)
    return points * np.stack([factor**0.6, factor, np.ones_like(factor)], axis=1)


def _shod(points: Floats) -> Floats:
    """The foot: toes low and wide, heel narrow."""
    x, y, z = points.T
    low = 1 - 0.4 * np.clip(x / 7.4, 0, 1.2)
    wide = 1 + 0.022 * x
    return np.stack([x, 4.4 + (y - 4.4) * wide, z * low], axis=1)


def _flared(points: Floats) -> Floats:
    """The shin: wide above the ankle."""
    x, y, z = points.T
    wide = 1.22 - 0.04 * (z - 4.6)
    return np.stack([x * wide, 4.4 + (y - 4.4) * wide, z], axis=1)


def _bellows(low: float, high: float, thin: float, thick: float, folds: int) -> list[Floats]:
    """The outline of a folded tube, for `lathe`."""
    height = np.linspace(low, high, 2 * folds + 1)
    radius = np.where(np.arange(2 * folds + 1) % 2, thick, thin)
    return [np.stack([radius, height], axis=1)]


def _finger(x: float, y: float) -> Shape:
    """A finger whose root is so far from the palm's middle, hooked outwards."""
    finger = lathe([[(0, 15.3), (0.85, 17), (0.7, 19.8)]], (0, 0, 0), 4)

    def hooked(points: Floats) -> Floats:
        out = 1 + 0.12 * (points[:, 2:] - 15.3) * (19.8 - points[:, 2:])
        return np.concatenate([points[:, :2] + [0, 11.2] + out * [x, y], points[:, 2:]], axis=1)

    return finger.warped(hooked)


def robot_parts() -> list[Part]:
    """Make every part, left ones of pairs only."""
    return [
        Part(
            "trunk",
            "chest",
            rounded_box((-6, -8.8, 26.4), (6.2, 8.8, 40), 2).warped(_tapered),
            "teal",
            detail=1.15,
        ),
        Part(
            "panel",
            "chest",
            rounded_box((4.4, -5.4, 29.4), (7, 5.4, 37.8), 0.7).without(0, -1),
            "ivory",
            detail=1.5,
        ),
        Part(
            "pack",
            "chest",
            rounded_box((-9.2, -5.4, 28.6), (-4.4, 5.4, 38.8), 1.2).without(0, 1),
            "steel",
        ),
        Part(
            "pelvis",
            "pelvis",
            rounded_box((-4.2, -6, 20.8), (4.2, 6, 25), 1.4),
            "steel",
            detail=0.8,
        ),
        Part(
            "waist",
            "pelvis",
            lathe(_bellows(24.4, 27.6, 4, 4.7, 2), (0, 0, 0), 9),
            "rubber",
            detail=0.6,
        ),
        Part(
            "neck",
            "chest",
            lathe(_bellows(39.4, 42.2, 2.6, 3.3, 1), (0, 0, 0), 8),
            "rubber",
            detail=0.6,
        ),
        Part(
            "skull", "head", rounded_box((-6.4, -8, 41.4), (6.4, 8, 53), 2.4), "teal", detail=1.15
        ),
        Part(
            "frame",
            "head",
            rounded_box((5, -6.7, 42.8), (7.3, 6.7, 51.6), 0.9).without(0, -1),
            "ivory",
            detail=1.3,
        ),
        Part(
            "visor",
            "head",
            rounded_box((6.6, -5.7, 43.8), (7.7, 5.7, 50.6), 0.4).without(0, -1),
            "glass",
            detail=1.3,
        ),
        Part(
            "eye",
            "eyes",
            lathe([[(1.95, -0.2), (1.8, 0.3), (0, 0.65)]], (7.6, 2.7, 47.3), 12, axis=0),
            "lamp",
            is_pair=True,
            detail=1.6,
        ),
        Part(
            "ear",
            "head",
            lathe([[(3, 0), (2.6, 1.5)], [(2.6, 1.5), (0, 1.8)]], (-0.3, 7.8, 47), 10, axis=1),
            "orange",
            is_pair=True,
        ),
        Part(
            "mast",
            "antenna",
            lathe([[(0.55, 47), (0.35, 55.3)]], (-0.3, 9, 0), 5),
            "steel",
            detail=0.8,
        ),
        Part(
            "tip",
            "antenna",
            lathe([[(0, 54.6), (1, 55.1), (1, 56.2), (0, 56.7)]], (-0.3, 9, 0), 8),
            "lamp",
            detail=0.8,
        ),
        Part(
            "shoulder",
            "upper_arm.l",
            lathe(
                [[(0, -3.3), (2.5, -2.3), (3.4, 0), (2.5, 2.3), (0, 3.3)]],
                (0, 10.9, 36.4),
                9,
                axis=1,
            ),
            "orange",
            is_pair=True,
        ),
        Part(
            "upper arm",
            "upper_arm.l",
            lathe(_bellows(28.6, 35.4, 1.45, 2.05, 2), (0, 11.2, 0), 6),
            "rubber",
            is_pair=True,
            detail=0.6,
        ),
        Part(
            "forearm",
            "forearm.l",
            lathe(
                [
                    [(1, 21), (3, 21)],
                    [(3.05, 21), (3.05, 22.6)],
                    [(2.95, 22.6), (2.35, 27.6), (1.6, 29.2), (0, 29.8)],
                ],
                (0, 11.2, 0),
                8,
            ),
            "teal",
            is_pair=True,
        ),
        Part(
            "palm",
            "hand.l",
            lathe([[(0, 18.8), (1.75, 19.3), (1.6, 21.2)]], (0, 11.2, 0), 7),
            "steel",
            is_pair=True,
            detail=0.7,
        ),
        *(
            Part(f"finger {i}", "hand.l", _finger(x, y), "steel", is_pair=True, detail=0.6)
            for i, (x, y) in enumerate([(1.1, 0.8), (-1.1, 0.8), (0.1, -1.3)])
        ),
        Part(
            "thigh",
            "thigh.l",
            lathe(_bellows(13.4, 23, 2.1, 2.8, 2), (0, 4.4, 0), 7),
            "rubber",
            is_pair=True,
            detail=0.6,
        ),
        Part(
            "knee",
            "shin.l",
            lathe(
                [[(0, -2.8), (2.3, -2.6)], [(2.6, -2.5), (2.6, 2.5)], [(2.3, 2.6), (0, 2.8)]],
                (0.2, 4.4, 13.4),
                8,
                axis=1,
            ),
            "orange",
            is_pair=True,
            detail=0.9,
        ),
        Part(
            "shin",
            "shin.l",
            rounded_box((-2.4, 2, 4.2), (2.5, 6.8, 12), 0.9).warped(_flared),
            "teal",
            is_pair=True,
        ),
        Part(
            "foot",
            "foot.l",
            rounded_box((-4.6, 0.9, 0), (7.6, 7.9, 4.8), 1).warped(_shod),
            "teal",
            is_pair=True,
        ),
    ]
