"""Where a point of the level lies, what it may see, and how far a straight line gets.

All of it goes down the level's binary tree of planes, for many points or lines at once: one pass
of the loop takes every one of them a node further.

The tree knows *structural* walls only. What the level's author marked as detail, curved patches
and doors don't split it: lines pass through them here, as they do for the tool that computes
visibility.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints, Mask
from followspot.assets.bsp import BspFile


def leaf_is_solid(bsp: BspFile) -> Mask:
    """Tell which leafs are solid or outside of the level: those in no cluster.

    Returns:
        (leafs,) bool.
    """
    return np.asarray(bsp.leafs["cluster"] < 0)


def point_leafs(bsp: BspFile, points: NDArray[np.floating[Any]]) -> Ints:
    """Find the leaf that each point lies in; a point on a plane counts as in front of it.

    Args:
        bsp: The level.
        points: (n, 3) world space, Quake units.

    Returns:
        (n,) int64 leaf numbers.
    """
    node = np.zeros(len(points), dtype=np.int64)
    walking = np.arange(len(points))
    while walking.size:
        at = bsp.nodes[node[walking]]
        plane = bsp.planes[at["plane"]]
        behind = _dot(plane["normal"], points[walking]) < plane["distance"]
        node[walking] = _child(at, behind)
        walking = walking[node[walking] >= 0]
    return ~node


def box_leafs(
    bsp: BspFile, mins: NDArray[np.floating[Any]], maxs: NDArray[np.floating[Any]]
) -> tuple[Ints, Ints]:
    """Find the leafs that boxes reach into; a box that touches a plane is on both sides of it.

    Args:
        bsp: The level.
        mins: (n, 3) world space, Quake units.
        maxs: (n, 3) likewise.

    Returns:
        Numbers of boxes and of leafs, pair by pair, in no order.
    """
    middle, half = (maxs + mins) / 2, (maxs - mins) / 2
    box, node = np.arange(len(mins)), np.zeros(len(mins), dtype=np.int64)
    boxes, leafs = [box[:0]], [node[:0]]
    while box.size:
        at = bsp.nodes[node]
        plane = bsp.planes[at["plane"]]
        height = _dot(plane["normal"], middle[box]) - plane["distance"]
        reach = _dot(np.abs(plane["normal"]), half[box])
        front, back = np.flatnonzero(height >= -reach), np.flatnonzero(height <= reach)
        box = np.concatenate([box[front], box[back]])
        node = np.concatenate([at["children"][front, 0], at["children"][back, 1]]).astype(np.int64)
        in_leaf = node < 0
        boxes.append(box[in_leaf])
        leafs.append(~node[in_leaf])
        box, node = box[~in_leaf], node[~in_leaf]
    return np.concatenate(boxes), np.concatenate(leafs)


def box_leafs_to_see(
    bsp: BspFile, mins: NDArray[np.floating[Any]], maxs: NDArray[np.floating[Any]]
) -> tuple[Ints, Ints]:
    """Find the leafs of which one has to be visible for something in a box to be seen.

    Args:
        bsp: The level.
        mins: (n, 3) world space, Quake units.
        maxs: (n, 3) likewise.

    Returns:
        Numbers of boxes and of leafs as from `box_leafs`. A box that reaches into no open leaf has
        the number behind the last leaf's besides, which stands for everywhere.
    """
    box, leaf = box_leafs(bsp, mins, maxs)
    lost = np.setdiff1d(np.arange(len(mins)), box[~leaf_is_solid(bsp)[leaf]])
    everywhere = np.full(len(lost), len(bsp.leafs))
    return np.concatenate([box, lost]), np.concatenate([leaf, everywhere])


def visible_leafs(bsp: BspFile, position: NDArray[np.floating[Any]]) -> Mask:
    """Tell which leafs may be seen from a position, by the level's precomputed visibility.

    It never hides what a straight line reaches, unless the level's author cut it off at a
    distance (worldspawn's ``_farplanedist``). Leafs that hang on no node hold the faces of brush
    models, which can be anywhere; their cluster, and so the answer for them, means nothing.

    Args:
        bsp: The level.
        position: (3,) world space, Quake units.

    Returns:
        (leafs,) bool; all True for a position in a solid leaf, whence the level is looked at
        from outside.
    """
    clusters = bsp.leafs["cluster"]
    own = int(clusters[point_leafs(bsp, position[np.newaxis])[0]])
    if own < 0:
        return np.ones(len(clusters), dtype=np.bool_)
    return np.asarray((clusters >= 0) & bsp.visible_clusters(own)[clusters])


def trace(bsp: BspFile, start: NDArray[np.floating[Any]], end: NDArray[np.floating[Any]]) -> Floats:
    """Find where straight lines first enter a solid leaf.

    Each line is an interval of fractions, [0, 1], at the root. A node hands an interval to the
    child it lies in, or cuts it in two at the plane; in a solid leaf an interval's near end is a
    candidate for the answer. A line has at most one interval for each leaf, since leafs are
    convex.

    Args:
        bsp: The level.
        start: (n, 3) world space, Quake units.
        end: (n, 3) world space, Quake units.

    Returns:
        (n,) float64: the line is free up to ``start + fraction * (end - start)``. 0 where it
        starts in a solid leaf, 1 where it meets none.
    """
    start, way = np.asarray(start, dtype=np.float64), np.subtract(end, start, dtype=np.float64)
    solid = leaf_is_solid(bsp)
    fraction = np.ones(len(start))

    line = np.arange(len(start))
    node = np.zeros(len(start), dtype=np.int64)
    near, far = np.zeros(len(start)), np.ones(len(start))
    while line.size:
        at = bsp.nodes[node]
        plane = bsp.planes[at["plane"]]
        height = _dot(plane["normal"], start[line]) - plane["distance"]
        slope = _dot(plane["normal"], way[line])
        near_behind, far_behind = height + near * slope < 0, height + far * slope < 0

        cut = np.flatnonzero(near_behind != far_behind)
        middle = far.copy()
        middle[cut] = np.clip(-height[cut] / slope[cut], near[cut], far[cut])
        line = np.concatenate([line, line[cut]])
        node = np.concatenate([_child(at, near_behind), _child(at, far_behind)[cut]])
        near, far = np.concatenate([near, middle[cut]]), np.concatenate([middle, far[cut]])

        in_leaf = node < 0
        hit = np.flatnonzero(in_leaf)
        hit = hit[solid[~node[hit]]]
        np.minimum.at(fraction, line[hit], near[hit])
        # What begins behind a line's nearest hit cannot matter any more.
        keep = ~in_leaf & (near < fraction[line])
        line, node, near, far = line[keep], node[keep], near[keep], far[keep]
    return fraction


def _child(nodes: NDArray[np.void], behind: Mask) -> Ints:
    """Pick each node's child in front of its plane or behind; (n,) each."""
    children: Ints = nodes["children"].astype(np.int64)
    return np.where(behind, children[:, 1], children[:, 0])


def _dot(a: NDArray[np.floating[Any]], b: NDArray[np.floating[Any]]) -> Floats:
    """(n, 3), (n, 3) -> (n,) in double precision."""
    products: Floats = np.einsum("ij,ij->i", a, b, dtype=np.float64)
    return products
