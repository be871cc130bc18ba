"""Hidden face removal: what of the brushes' sides can be seen at all.

Constructive solid geometry on the sides' polygons: whatever lies inside another solid, or flat
against one, is cut away. What is left is the boundary of the union of all brushes, each point
of it covered once, so that nothing fights for depth and nothing is drawn for nobody.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats
from followspot.levelbuilder.brush import Brush, Side
from followspot.levelbuilder.winding import EPSILON, MIN_AREA, area, merge, split


@dataclass(frozen=True)
class Fragment:
    """A convex piece of a brush's side: its winding, the side and the brush's index."""

    winding: Floats
    side: Side
    brush: int


def visible_fragments(brushes: Sequence[Brush]) -> list[Fragment]:
    """Return the pieces of all brushes' sides that no hiding brush covers.

    Where two brushes share a plane and face the same way, the later brush has the surface.
    Brushes that hide nothing (water, clip) are cut but cut nothing, nor one another.
    """
    mins = np.array([brush.mins for brush in brushes]).reshape(-1, 3) - EPSILON
    maxs = np.array([brush.maxs for brush in brushes]).reshape(-1, 3) + EPSILON
    hides = np.array([brush.hides for brush in brushes])
    fragments = []
    for index, brush in enumerate(brushes):
        for side in brush.sides:
            low, high = side.winding.min(axis=0), side.winding.max(axis=0)
            near = hides & (mins <= high).all(axis=1) & (maxs >= low).all(axis=1)
            near[index] = False
            pieces = [side.winding]
            for other in np.flatnonzero(near).tolist():
                wins = other < index and brush.hides
                pieces = [
                    rest for piece in pieces for rest in _outside(piece, side, brushes[other], wins)
                ]
            fragments += [Fragment(piece, side, index) for piece in merge_all(pieces)]
    return fragments


def _outside(winding: Floats, side: Side, solid: Brush, wins: bool) -> list[Floats]:
    """Return what of a winding lies outside a solid; whole where the two do not overlap."""
    rest = winding
    pieces = []
    for cutter in solid.sides:
        along = float(side.normal @ cutter.normal)
        if along > 1 - 1e-6 and abs(side.dist - cutter.dist) < EPSILON:
            if wins:
                return [winding]
            continue
        if along < -1 + 1e-6 and abs(side.dist + cutter.dist) < EPSILON:
            continue
        front, back = split(rest, cutter.normal, cutter.dist)
        if back is None:
            return [winding]
        if front is not None and area(front) > MIN_AREA:
            pieces.append(front)
        rest = back
    if area(rest) <= MIN_AREA:
        return [winding]
    return pieces


def merge_all(pieces: list[Floats]) -> list[Floats]:
    """Join convex pieces of one plane that share a whole edge, as long as the join is convex."""
    left = dict(enumerate(pieces))
    owners = {edge: i for i, piece in left.items() for edge in _edges(piece)}
    waiting = list(left)
    while waiting:
        i = waiting.pop()
        for start, end in _edges(left[i]) if i in left else ():
            j = owners.get((end, start), i)
            joined = merge(left[i], left[j]) if i != j else None
            if joined is not None:
                for edge in (*_edges(left[i]), *_edges(left[j])):
                    owners.pop(edge, None)
                del left[j]
                left[i] = joined
                owners |= dict.fromkeys(_edges(joined), i)
                waiting.append(i)
                break
    return list(left.values())


def _edges(winding: Floats) -> list[tuple[bytes, bytes]]:
    """Return a winding's directed edges, their ends rounded so that equal corners are equal."""
    keys = [corner.tobytes() for corner in np.round(winding * 64).astype(np.int64)]
    return list(zip(keys, keys[1:] + keys[:1], strict=True))
