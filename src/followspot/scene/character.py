"""Characters: figures at their places with their own clocks; and all of a scene's at a time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.assets import md3
from followspot.assets.animation import Pose
from followspot.scene.figure import Figure, FigurePart, Tracks
from followspot.scene.schedule import Play, Schedules
from followspot.scene.walk import Walk

SLOTS = 3
"""Parts of a player: lower, upper, head; see `FigurePart.slot`."""

_BOUNDS_SEGMENT = 8
"""Places of a way that share one box."""

_FAR = 1e30
"""Units; farther away than anything is."""


@dataclass(frozen=True, eq=False)
class Character:
    """A figure somewhere, doing something.

    Attributes:
        figure: Its model.
        walk: Where its origin is and which way it looks; see `walk.standing`.
        plays: What it plays from which of its own seconds on, one after another; see
            `Figure.tracks`.
        clock: Seconds by which its own time is ahead of the scene's.
        spin: Degrees a second by which it turns about Z, counter-clockwise.
        bob: Units by which it moves up and down about their height above its place.
        bob_rate: Radians a second of that.
    """

    figure: Figure
    walk: Walk
    plays: tuple[tuple[Tracks, float], ...] = ()
    clock: float = 0.0
    spin: float = 0.0
    bob: float = 0.0
    bob_rate: float = 0.0


class Crowd:
    """All characters of a scene, those of one figure next to each other.

    Attributes:
        characters: In the crowd's order.
        figures: Each once, in the same order.
        materials: All that the figures wear, each once.
        figure_of: (n,) number of each character's figure.
        radius: (n,) units from a character's origin that it never exceeds.
        mins: (b, 3) boxes that hold every character wherever it goes.
        maxs: (b, 3) likewise.
        box_of: (b,) number of the character that a box is of.
    """

    def __init__(self, characters: Sequence[Character] = ()) -> None:
        self.figures = tuple(dict.fromkeys(c.figure for c in characters))
        runs = [run for figure in self.figures for part in figure.parts for run in part.runs]
        self.materials = tuple(dict.fromkeys(run.material for run in runs))
        number = {figure: k for k, figure in enumerate(self.figures)}
        self.characters = tuple(sorted(characters, key=lambda c: number[c.figure]))
        self.figure_of = np.array([number[c.figure] for c in self.characters], np.intp)
        self.radius = np.array([c.figure.radius + 2 * c.bob for c in self.characters], np.float64)
        self._clock = np.array([c.clock for c in self.characters], np.float64)
        self._spin = np.array([(c.spin, c.bob, c.bob_rate) for c in self.characters]).reshape(-1, 3)
        self._some_spin = bool(self._spin[:, :2].any())
        self._ways = _Ways([c.walk for c in self.characters])
        # The legs' tracks, then the torsos'.
        plays = [c.plays or ((c.figure.tracks(), 0.0),) for c in self.characters]
        self._schedules = Schedules(
            [[Play(tracks[k], at) for tracks, at in each] for k in (0, 1) for each in plays]
        )
        self._joints = _Joints(self.figures, self.figure_of)
        self._key_boxes = _KeyBoxes(self.figures)
        self._vertex_counts = np.array([_vertex_counts(f.parts) for f in self.figures], np.float64)
        self.mins, self.maxs, self.box_of = self._bounds()

    def __len__(self) -> int:
        return len(self.characters)

    def _bounds(self) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.intp]]:
        mins, maxs, owner = [np.empty((0, 3))], [np.empty((0, 3))], []
        for number, character in enumerate(self.characters):
            radius = self.radius[number]
            places = character.walk.places[:, :3]
            starts = np.arange(0, max(len(places) - 1, 1), _BOUNDS_SEGMENT)
            ends = np.minimum(starts + _BOUNDS_SEGMENT, len(places) - 1) + 1
            for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
                mins.append(places[start:end].min(axis=0, keepdims=True) - radius)
                maxs.append(places[start:end].max(axis=0, keepdims=True) + radius)
                owner.append(number)
        return (
            np.concatenate(mins).astype(np.float32),
            np.concatenate(maxs).astype(np.float32),
            np.array(owner, np.intp),
        )

    def places(self, seconds: float) -> Floats:
        """(n, 4) x, y, z of every character's origin in units, and yaw in degrees, at a time."""
        own = seconds + self._clock
        places = self._ways.at(own)
        if self._some_spin:
            spin, bob, rate = self._spin.T
            places[:, 3] += spin * own
            places[:, 2] += bob * (1 + np.cos(rate * own))
        return places

    def instances(
        self, seconds: float, places: Floats, which: NDArray[np.intp]
    ) -> NDArray[np.float32]:
        """What the GPU is told of some characters.

        Args:
            seconds: The scene's time.
            places: (n, 4) as `places` gives them at that time.
            which: (m,) numbers of characters.

        Returns:
            (m, SLOTS, 4, 4) float32: by slot the three rows of ``world_from_part``, and a row of
            the first vertex of the key pose before, that of the one behind, and their blend from
            0 to 1. Slots that a figure lacks hold anything.
        """
        own = seconds + self._clock[which]
        tracks = np.concatenate([which, which + len(self)])
        poses = self._schedules.poses(np.concatenate([own, own]), tracks)
        lower = _turned(places[which])
        upper_from_next = self._joints.between(which, poses)
        upper = lower @ upper_from_next[: len(which)]
        head = upper @ upper_from_next[len(which) :]

        rows = np.zeros((len(which), SLOTS, 4, 4), np.float32)
        for slot, world_from_part in enumerate((lower, upper, head)):
            rows[:, slot, :3] = world_from_part[:, :3]
        count = self._vertex_counts[self.figure_of[which]]
        for k, frames in enumerate((poses.frame, poses.next_frame)):
            legs_and_torso = frames.reshape(2, -1).T
            rows[:, :2, 3, k] = legs_and_torso * count[:, :2]
        rows[:, :2, 3, 2] = poses.blend.reshape(2, -1).T
        return rows

    def boxes(
        self, rows: NDArray[np.float32], which: NDArray[np.intp]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(m, 3) least and largest corners of boxes around some characters as they stand.

        Args:
            rows: What `instances` gives for them.
            which: (m,) their numbers.
        """
        slots = np.ascontiguousarray(rows.transpose(1, 2, 3, 0))  # NumPy loops over the many
        turn, shift, first_vertices = slots[:, :3, :3], slots[:, :3, 3], slots[:, 3, :2]
        low, high = self._key_boxes.around(self.figure_of[which], first_vertices)
        centre = np.einsum("pijm,jpm->pim", turn, 0.5 * (low + high)) + shift
        reach = np.einsum("pijm,jpm->pim", np.abs(turn), 0.5 * (high - low))
        return (centre - reach).min(axis=0).T, (centre + reach).max(axis=0).T


def _vertex_counts(parts: Sequence[FigurePart]) -> list[int]:
    counts = [0] * SLOTS
    for part in parts:
        counts[part.slot] = part.vertex_count
    return counts


def _turned(places: Floats) -> Floats:
    """(m, 4, 4) ``world_from_character`` of places and yaws."""
    yaw = np.radians(places[:, 3])
    matrices = np.zeros((len(places), 4, 4))
    matrices[:, 0, 0] = matrices[:, 1, 1] = np.cos(yaw)
    matrices[:, 1, 0] = np.sin(yaw)
    matrices[:, 0, 1] = -matrices[:, 1, 0]
    matrices[:, 2, 2] = matrices[:, 3, 3] = 1
    matrices[:, :3, 3] = places[:, :3]
    return matrices


class _Ways:
    """All characters' ways in one table."""

    def __init__(self, walks: Sequence[Walk]) -> None:
        self._places = np.concatenate([np.empty((0, 4)), *(walk.places for walk in walks)])
        count = np.array([len(walk.places) for walk in walks], np.intp)
        self._first = np.cumsum(count) - count
        self._last = self._first + count - 1
        self._speed = np.array([walk.speed / walk.spacing for walk in walks])
        self._closed = np.array([walk.is_closed for walk in walks], bool)
        self._all_stand = len(self._places) == len(walks)

    def at(self, seconds: Floats) -> Floats:
        """(n, 4) places, each at its own (n,) time."""
        if self._all_stand:
            return self._places.copy()
        steps = seconds * self._speed
        length = np.maximum(self._last - self._first, 1)
        steps = np.where(self._closed, steps % length, np.clip(steps, 0, length))
        before = np.minimum(self._first + steps.astype(np.intp), self._last)
        behind = np.minimum(before + 1, self._last)
        share = (steps - (before - self._first))[:, np.newaxis]
        a, b = self._places[before], self._places[behind]
        return np.asarray(a + (b - a) * share)


class _KeyBoxes:
    """Boxes around the key poses of all figures' parts in one table."""

    def __init__(self, figures: Sequence[Figure]) -> None:
        # The first is of parts that there are not: too small to count.
        low, high, ends = [np.full((1, 3), _FAR)], [np.full((1, 3), -_FAR)], 1
        self._first = np.zeros((SLOTS, len(figures)), np.intp)
        self._vertex_counts = np.ones((SLOTS, 1, len(figures)), np.float32)
        for number, figure in enumerate(figures):
            for part in figure.parts:
                if part.positions.size:
                    low.append(part.positions.min(axis=1))
                    high.append(part.positions.max(axis=1))
                    self._first[part.slot, number] = ends
                    self._vertex_counts[part.slot, 0, number] = part.vertex_count
                    ends += len(part.positions)
        reach = np.hstack([-np.concatenate(low), np.concatenate(high)])
        self._reach = np.ascontiguousarray(reach.T, np.float32)

    def around(
        self, figure: NDArray[np.intp], first_vertices: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(3, SLOTS, m) least and largest corners around two key poses of each part.

        Args:
            figure: (m,) numbers of figures.
            first_vertices: (SLOTS, 2, m) of the key poses; anything between them lies in the
                boxes, too.
        """
        frames = (first_vertices / self._vertex_counts[..., figure]).astype(np.intp)
        keys = self._first[:, np.newaxis, figure] + frames
        reach = self._reach.take(keys, axis=1).max(axis=2)
        return -reach[:3], reach[3:]


class _Joints:
    """The tags of all players' key frames in one table: torsos on legs, heads on torsos.

    Figures without tags have one key in it, which changes nothing.
    """

    def __init__(self, figures: Sequence[Figure], figure_of: NDArray[np.intp]) -> None:
        keys, first, ends = [np.eye(4)[np.newaxis]], np.zeros((2, len(figures)), np.intp), 1
        highest = np.zeros_like(first)
        for number, figure in enumerate(figures):
            for track, own in enumerate((figure.torso_keys, figure.head_keys)):
                if own is not None:
                    keys.append(own)
                    first[track, number] = ends
                    highest[track, number] = len(own) - 1
                    ends += len(own)
        self._keys = np.concatenate(keys)
        self._first, self._highest = first[:, figure_of], highest[:, figure_of]

    def between(self, which: NDArray[np.intp], poses: Pose) -> Floats:
        """(2m, 4, 4) of m characters: ``lower_from_upper`` of all, then ``upper_from_head``."""
        first, highest = self._first[:, which].ravel(), self._highest[:, which].ravel()
        frame, next_frame = (first + np.minimum(f, highest) for f in poses[:2])
        return md3.between(self._keys, Pose(frame, next_frame, poses.blend))
