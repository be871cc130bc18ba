"""The BSP tree: cutting space along the walls, and finding out which part of it is inside.

The tree is built from the visible pieces of structural brushes. Every boundary between solid and
air then lies on a splitting plane, so each leaf is wholly one or the other. Leafs that can't be
reached from the level's entities are outside: they become solid, and faces there are dropped.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from followspot.arrays import Floats, Mask
from followspot.errors import UsageError
from followspot.levelbuilder.brush import Brush
from followspot.levelbuilder.csg import Fragment
from followspot.levelbuilder.winding import (
    EPSILON,
    MIN_AREA,
    area,
    area_vector,
    base_winding,
    split,
)

MARGIN = 64.0
"""Space round the level that the root cell takes in, in units."""

MAX_CANDIDATES = 48
"""At most so many planes are weighed at a node."""


@dataclass(eq=False)
class Leaf:
    """A convex cell of the tree with its box, its neighbours and what lies in it."""

    mins: Floats
    maxs: Floats
    centre: Floats
    solid: bool = False
    inside: bool = False
    neighbours: list["Leaf"] = field(default_factory=list)
    faces: list[int] = field(default_factory=list)
    brushes: list[int] = field(default_factory=list)


@dataclass(eq=False)
class Node:
    """A splitting plane with what lies in front of it and behind it."""

    normal: Floats
    dist: float
    mins: Floats
    maxs: Floats
    portal: Floats
    front: "Node | Leaf"
    back: "Node | Leaf"


@dataclass(frozen=True)
class _Polygons:
    """Fragments as arrays: corners padded to one length, and each one's plane."""

    corners: Floats  # (n, k, 3)
    planes: Floats  # (n, 4)

    def take(self, keep: Mask) -> "_Polygons":
        return _Polygons(self.corners[keep], self.planes[keep])


def build_tree(fragments: Sequence[Fragment], brushes: Sequence[Brush]) -> Node:
    """Split space along the fragments' planes and mark the leafs that lie in solid brushes.

    Args:
        fragments: Visible pieces of the structural brushes.
        brushes: The structural brushes.
    """
    if not fragments:
        raise UsageError("a level needs at least one structural brush")
    longest = max(len(fragment.winding) for fragment in fragments)
    corners = np.stack(
        [np.pad(f.winding, ((0, longest - len(f.winding)), (0, 0)), "edge") for f in fragments]
    )
    planes = np.array([[*f.side.normal, f.side.dist] for f in fragments])
    mins = corners.min(axis=(0, 1)) - MARGIN
    maxs = corners.max(axis=(0, 1)) + MARGIN
    tree = _split_cell(_Polygons(corners, planes), _box_cell(mins, maxs))
    if isinstance(tree, Leaf):
        raise UsageError("the level's structural brushes are too small to split space")
    all_leafs = leafs(tree)
    centres = np.array([leaf.centre for leaf in all_leafs])
    for brush in brushes:
        sides = np.array([[*side.normal, side.dist] for side in brush.sides])
        within = (centres @ sides[:, :3].T < sides[:, 3]).all(axis=1)
        for i in np.flatnonzero(within):
            all_leafs[i].solid = True
    _connect(tree)
    return tree


def _box_cell(mins: Floats, maxs: Floats) -> list[Floats]:
    normals = np.concatenate([-np.eye(3), np.eye(3)])
    dists = np.concatenate([-mins, maxs])
    cell = []
    for i in range(6):
        winding: Floats | None = base_winding(normals[i], dists[i], 1e5)
        for j in range(6):
            if i != j and winding is not None:
                winding = split(winding, normals[j], dists[j])[1]
        if winding is not None:
            cell.append(winding)
    return cell


def _split_cell(polygons: _Polygons, cell: list[Floats]) -> Node | Leaf:
    """Build the subtree of a convex cell (its walls as windings) and the polygons in it."""
    points = np.concatenate(cell)
    mins, maxs = points.min(axis=0), points.max(axis=0)
    if not len(polygons.planes):
        return Leaf(mins, maxs, points.mean(axis=0))
    plane = _choose_plane(polygons)
    normal, dist = plane[:3], float(plane[3])
    portal: Floats | None = base_winding(normal, dist, 1e5)
    halves: tuple[list[Floats], list[Floats]] = ([], [])
    for wall in cell:
        for half, part in zip(halves, split(wall, normal, dist), strict=True):
            if part is not None:
                half.append(part)
        outward = _outward(wall, points)
        if portal is not None:
            portal = split(portal, outward[:3], outward[3])[1]
    side = polygons.corners @ normal - dist
    on_plane = np.abs(side).max(axis=1) <= EPSILON
    in_front = polygons.take((side.max(axis=1) > EPSILON) & ~on_plane)
    behind = polygons.take((side.min(axis=1) < -EPSILON) & ~on_plane)
    if portal is None or not halves[0] or not halves[1]:  # a sliver: the plane grazes the cell
        rest = polygons.take(~on_plane)
        return _split_cell(rest, cell)
    front = _split_cell(in_front, [*halves[0], portal])
    back = _split_cell(behind, [*halves[1], portal])
    return Node(normal, dist, mins, maxs, portal, front, back)


def _outward(wall: Floats, points: Floats) -> Floats:
    """Return the plane (4,) of a cell's wall, facing away from the cell's corners."""
    normal = area_vector(wall)
    normal /= np.linalg.norm(normal)
    dist = float(normal @ wall.mean(axis=0))
    if (points @ normal).mean() > dist:
        normal, dist = -normal, -dist
    return np.array([*normal, dist])


def _choose_plane(polygons: _Polygons) -> Floats:
    """Pick the plane that splits few polygons, takes many, is upright and balances the halves."""
    _, first = np.unique(np.round(polygons.planes, 3), axis=0, return_index=True)
    if len(first) > MAX_CANDIDATES:
        first = first[np.linspace(0, len(first) - 1, MAX_CANDIDATES).astype(int)]
    planes = polygons.planes[first]
    side = np.einsum("nkx,px->pnk", polygons.corners, planes[:, :3]) - planes[:, None, 3:]
    front = side.max(axis=2) > EPSILON
    back = side.min(axis=2) < -EPSILON
    splits = (front & back).sum(axis=1)
    taken = (~front & ~back).sum(axis=1)
    balance = np.abs(front.sum(axis=1) - back.sum(axis=1))
    upright = (np.abs(planes[:, :3]).max(axis=1) > 1 - 1e-6) * 5
    best: Floats = planes[np.argmax(5 * taken - 5 * splits - balance + upright)]
    return best


def nodes(tree: Node) -> list[Node]:
    """Return all nodes, parents before children, the root first."""
    found = [tree]
    for node in found:
        found += [child for child in (node.front, node.back) if isinstance(child, Node)]
    return found


def leafs(tree: Node | Leaf) -> list[Leaf]:
    """Return all leafs, from front to back at every node."""
    if isinstance(tree, Leaf):
        return [tree]
    return leafs(tree.front) + leafs(tree.back)


def leaf_at(tree: Node, point: Floats) -> Leaf:
    """Return the leaf that a point, (3,), lies in."""
    at: Node | Leaf = tree
    while isinstance(at, Node):
        at = at.front if at.normal @ point > at.dist else at.back
    return at


def pieces_in_leafs(
    tree: Node | Leaf, winding: Floats, normal: Floats | None = None
) -> list[tuple[Leaf, Floats]]:
    """Cut a winding along the tree and return each piece with its leaf.

    Args:
        tree: Where to begin.
        winding: (n, 3) float64.
        normal: The way the polygon faces; one that lies on a node's plane goes to that side.
            Without it such a polygon goes to the back.
    """
    if isinstance(tree, Leaf):
        return [(tree, winding)]
    side = winding @ tree.normal - tree.dist
    if normal is not None and np.abs(side).max() <= EPSILON:
        child = tree.front if normal @ tree.normal > 0 else tree.back
        return pieces_in_leafs(child, winding, normal)
    front, back = split(winding, tree.normal, tree.dist)
    found = []
    if front is not None and area(front) > MIN_AREA:
        found += pieces_in_leafs(tree.front, front, normal)
    if back is not None and area(back) > MIN_AREA:
        found += pieces_in_leafs(tree.back, back, normal)
    return found


def leafs_of_points(tree: Node | Leaf, points: Floats) -> list[Leaf]:
    """Return every leaf that the hull of some points, (n, 3), may touch."""
    if isinstance(tree, Leaf):
        return [tree]
    side = points @ tree.normal - tree.dist
    found = leafs_of_points(tree.front, points) if side.max() > -EPSILON else []
    return found + (leafs_of_points(tree.back, points) if side.min() < EPSILON else [])


def _connect(tree: Node) -> None:
    """Make leafs that share a piece of a splitting plane each other's neighbours."""
    for node in nodes(tree):
        for front_leaf, piece in pieces_in_leafs(node.front, node.portal):
            if not front_leaf.solid:
                for back_leaf, _ in pieces_in_leafs(node.back, piece):
                    if not back_leaf.solid:
                        front_leaf.neighbours.append(back_leaf)
                        back_leaf.neighbours.append(front_leaf)


def flood(tree: Node, origins: Floats) -> None:
    """Mark as inside what can be reached from the entities' origins, (n, 3); the rest is solid.

    Raises:
        UsageError: The level leaks: the void round it can be reached.
    """
    frontier = [leaf for leaf in (leaf_at(tree, point) for point in origins) if not leaf.solid]
    while frontier:
        leaf = frontier.pop()
        if not leaf.inside:
            leaf.inside = True
            frontier += leaf.neighbours
    for leaf in leafs(tree):
        if leaf.inside and ((leaf.mins <= tree.mins) | (leaf.maxs >= tree.maxs)).any():
            place = " ".join(f"{value:.0f}" for value in leaf.centre)
            raise UsageError(f"the level leaks into the void near {place}")
        leaf.solid |= not leaf.inside
