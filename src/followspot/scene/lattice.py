"""Open space as a lattice of points with room around them, and ways from point to point."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints, Mask
from followspot.scene import bsp_tree
from followspot.scene.level import Level
from followspot.scene.open_space import OpenSpace
from followspot.scene.scene import spawn_cameras

Cells = Ints

ROOM = 21.0
"""Units that are free around every open point."""

_SPACING = 22.0  # units between lattice points, or more where there would be too many; a gateway of
# 64 units, the usual width, leaves 64 - 2 * 21 for them, so that one always fits
_MAX_POINTS = 600_000


@dataclass(frozen=True, eq=False)
class Lattice:
    """Points in the level's box, a fixed distance apart, and which of them are in open space.

    Points are known by one number each; a step along an axis adds or subtracts a fixed one.

    Attributes:
        origin: (3,) world place of point 0.
        spacing: Units between neighbours.
        shape: Points along each axis; the outermost are never open.
        open: (points,) bool, those in the largest connected part.
        steps: (6,) what leads to a neighbour: +x, -x, +y, -y, +z, -z.
    """

    origin: Floats
    spacing: float
    shape: tuple[int, ...]
    open: Mask
    steps: Cells

    @classmethod
    def of(cls, level: Level, space: OpenSpace) -> "Lattice":
        """The lattice of a level, whose open space is known for boxes of some size."""
        mins, maxs = (level.bsp.models[name][0].astype(np.float64) for name in ("mins", "maxs"))
        extent = np.maximum(maxs - mins, 1.0)
        spacing = _SPACING
        while np.prod(np.ceil(extent / spacing) + 1) > _MAX_POINTS:
            spacing *= 1.05
        inner = np.ceil(extent / spacing).astype(np.int64)
        shape = tuple((inner + 2).tolist())
        origin = mins - spacing / 2
        index = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
        points = origin + index.reshape(-1, 3) * spacing
        inside = ((index > 0) & (index <= inner)).all(axis=-1).ravel()
        is_open = (
            inside & ~bsp_tree.leaf_is_solid(level.bsp)[bsp_tree.point_leafs(level.bsp, points)]
        )
        # Boxes that touch: what is free around two neighbours is free all the way between them.
        room = space.sized(max(spacing / 2, ROOM))
        is_open[is_open] = room.is_free(points[is_open])
        strides = (shape[1] * shape[2], shape[2], 1)
        steps = np.array([sign * stride for stride in strides for sign in (1, -1)])
        eyes = np.array([camera.position for camera in spawn_cameras(level.bsp).values()])
        lattice = cls(origin, spacing, shape, is_open, steps)
        return cls(origin, spacing, shape, lattice._main_part(eyes), steps)

    def points(self, cells: Cells) -> Floats:
        """(n, 3) world places of lattice points."""
        index = np.stack(np.unravel_index(cells, self.shape), axis=-1)
        return np.asarray(self.origin + index * self.spacing)

    def nearest(self, place: Floats, within: float) -> int | None:
        """The open lattice point nearest to a world place, if one is near enough."""
        low = np.floor((place - within - self.origin) / self.spacing)
        high = np.ceil((place + within - self.origin) / self.spacing) + 1
        ends = np.clip([low, high], 0, self.shape).astype(np.int64)
        window = np.meshgrid(*map(np.arange, *ends), indexing="ij")
        cells = np.asarray(np.ravel_multi_index([axis.ravel() for axis in window], self.shape))
        cells = cells[self.open[cells]]
        distance = np.linalg.norm(self.points(cells) - place, axis=1)
        if not len(cells) or distance.min() > within:
            return None
        return int(cells[distance.argmin()])

    def _main_part(self, eyes: Floats) -> Mask:
        """The largest connected part, of those that hold spawn points if any do."""
        reach = 3 * self.spacing
        starts = [cell for eye in eyes if (cell := self.nearest(eye, reach)) is not None]
        left, best = self.open.copy(), np.zeros_like(self.open)
        for start in starts:
            if left[start]:
                best = max(best, self.flood(start, left), key=np.count_nonzero)
        while not starts and np.count_nonzero(left) > np.count_nonzero(best):
            best = max(best, self.flood(int(left.argmax()), left), key=np.count_nonzero)
        return best

    def flood(self, start: int, left: Mask) -> Mask:
        """(points,) all of some points that are connected to one; they are taken out of `left`."""
        part = np.zeros_like(left)
        front = np.array([start])
        while front.size:
            part[front], left[front] = True, False
            around = (front[:, np.newaxis] + self.steps).ravel()
            front = np.unique(around[left[around]])
        return part

    def grown(self, mask: Mask, times: int) -> Mask:
        """A mask of points with their neighbours, again and again; only open points."""
        for _ in range(times):
            spread = mask.copy()
            for step in self.steps.tolist():
                spread |= np.roll(mask, step)  # the rim is never open: nothing comes round
            mask = spread & self.open
        return mask

    def clearance(self, most: int) -> Ints:
        """(points,) how many steps away what is not open is, from 1 to `most`; 0 there itself."""
        count = self.open.astype(np.int64)
        inner = self.open
        for _ in range(most - 1):
            eroded = inner.copy()
            for step in self.steps.tolist():
                eroded &= np.roll(inner, step)
            inner = eroded
            count += inner
        return count

    def way(self, cost: Ints, start: int, goals: Cells) -> list[int]:
        """The cheapest way to one of the goals: Dijkstra, all points of one distance at a time.

        Args:
            cost: (points,) small whole numbers, what entering a point costs; 0 where none may.
            start: Where from.
            goals: Where to, whichever is nearest.

        Returns:
            Lattice points from start to goal, both included.
        """
        far = np.iinfo(np.int32).max
        distance = np.full(len(cost), far, np.int32)
        distance[start] = 0
        waiting = {0: [np.array([start])]}
        now = 0
        while waiting and not (distance[goals] <= now).any():
            front = np.unique(np.concatenate(waiting.pop(now, [goals[:0]])))
            front = front[distance[front] == now]
            around = (front[:, np.newaxis] + self.steps).ravel()
            around = around[cost[around] > 0]
            reached = now + cost[around]
            better = reached < distance[around]
            around, reached = around[better], reached[better]
            distance[around] = reached
            for value in np.unique(reached).tolist():
                waiting.setdefault(value, []).append(around[reached == value])
            now += 1
        goal = int(goals[distance[goals].argmin()])
        if distance[goal] == far:
            return [start]
        return self._back(cost, distance, goal)

    def _back(self, cost: Ints, distance: NDArray[np.int32], goal: int) -> list[int]:
        """From a goal back to where its distance is 0, turning at every chance: diagonals."""
        way, last = [goal], -1
        while distance[way[-1]]:
            around = way[-1] + self.steps
            fits = np.flatnonzero(distance[around] == distance[way[-1]] - cost[way[-1]])
            turns = [k for k in fits.tolist() if k // 2 != last // 2]
            last = turns[0] if turns else int(fits[0])
            way.append(int(around[last]))
        return way[::-1]
