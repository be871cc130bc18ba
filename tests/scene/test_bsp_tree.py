import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from followspot.assets.binary import run_members
from followspot.assets.bsp import LUMPS, BspFile
from followspot.assets.bsp_reader import read_bsp
from followspot.scene.bsp_tree import (
    box_leafs,
    leaf_is_solid,
    point_leafs,
    trace,
    visible_leafs,
)
from followspot.scene.load import load

OPENARENA = Path("/usr/share/games/openarena/baseoa")
LEVELS = [
    ("pak1-maps.pk3", "dm4ish"),
    ("pak1-maps.pk3", "oa_koth1"),
    ("pak6-patch088.pk3", "aggressor"),
    ("pak6-patch085.pk3", "ctf_compromise"),
    ("z_oacmp-volume1-v3.pk3", "oacmpdm9"),
]

Points = NDArray[np.float64]
Node = tuple[tuple[float, float, float], float, int, int]


def tree(
    nodes: list[Node], clusters: list[int], visible: list[list[bool]] | None = None
) -> BspFile:
    """A level of nothing but a tree; nodes are (normal, distance, front, back)."""
    lumps: dict[str, Any] = {
        name: np.zeros(0, dtype)
        for name, dtype in LUMPS.items()
        if name not in ("entities", "visibility")
    }
    lumps["planes"] = np.array([node[:2] for node in nodes], LUMPS["planes"])
    lumps["nodes"] = np.zeros(len(nodes), LUMPS["nodes"])
    lumps["nodes"]["plane"] = np.arange(len(nodes))
    lumps["nodes"]["children"] = [node[2:] for node in nodes]
    lumps["leafs"] = np.zeros(len(clusters), LUMPS["leafs"])
    lumps["leafs"]["cluster"] = clusters
    count = max(clusters) + 1
    seen = np.ones((count, count), bool) if visible is None else np.array(visible)
    return BspFile(
        source="tree",
        entities=(),
        shader_names=(),
        cluster_count=count,
        cluster_visible=np.packbits(seen, axis=1, bitorder="little"),
        **lumps,
    )


# The room -64 < x, y, z < 64 with solid all round it, divided at x = 16 by a solid slab up to 24
# that leaves a passage above z = 0. Leafs: 0 unused, 1 solid, 2 low x, 3 high x, 4 passage.
ROOM = tree(
    [
        ((1, 0, 0), 64, ~1, 1),
        ((-1, 0, 0), 64, ~1, 2),
        ((0, 1, 0), 64, ~1, 3),
        ((0, -1, 0), 64, ~1, 4),
        ((0, 0, 1), 64, ~1, 5),
        ((0, 0, -1), 64, ~1, 6),
        ((1, 0, 0), 16, 7, ~2),
        ((1, 0, 0), 24, ~3, 8),
        ((0, 0, 1), 0, ~4, ~1),
    ],
    [0, -1, 0, 1, 2],
    [[True, False, True], [False, True, True], [True, True, True]],
)


def test_points_of_a_room() -> None:
    points = [(0, 0, 0), (40, 0, 0), (20, 0, 5), (20, 0, -5), (65, 0, 0), (0, -99, 0), (0, 0, 1e9)]
    leafs = point_leafs(ROOM, np.array(points))
    assert leafs.tolist() == [2, 3, 4, 1, 1, 1, 1]
    assert leafs.dtype == np.int64
    assert point_leafs(ROOM, np.zeros((0, 3))).shape == (0,)


def test_point_on_a_plane_is_in_front() -> None:
    assert point_leafs(ROOM, np.array([(64.0, 0, 0), (24, 0, -5), (20, 0, 0)])).tolist() == [
        1,
        3,
        4,
    ]


def test_solid_leafs() -> None:
    assert leaf_is_solid(ROOM).tolist() == [False, True, False, False, False]


def test_visible_leafs_of_a_room() -> None:
    def visible(*position: float) -> list[bool]:
        return list(visible_leafs(ROOM, np.array(position)))

    assert visible(0, 0, 0) == [True, False, True, False, True]
    assert visible(40, 0, 0) == [False, False, False, True, True]
    assert visible(20, 0, 5) == [True, False, True, True, True]
    assert visible(20, 0, -5) == [True] * 5  # in the slab


def test_all_is_visible_where_there_are_no_clusters() -> None:
    bsp = tree([((0, 0, 1), 0, ~0, ~1)], [-1, -1])
    assert visible_leafs(bsp, np.zeros(3)).all()


@pytest.mark.parametrize(
    ("start", "end", "fraction"),
    [
        ((0, 0, 0), (-128, 0, 0), 0.5),  # a wall
        ((0, 0, 0), (0, 0, 256), 0.25),
        ((0, 0, -5), (40, 0, -5), 16 / 40),  # the slab, from either side
        ((40, 0, -5), (0, 0, -5), 16 / 40),
        ((0, 0, 5), (40, 0, 5), 1),  # the passage
        ((0, 0, 8), (32, 0, -8), 0.5),  # down onto the edge where the passage begins
        ((0, 0, 9), (32, 0, -7), 18 / 32),  # down into the slab from the passage
        ((0, 0, 0), (10, 10, 10), 1),  # inside of one leaf
        ((0, 0, 0), (0, 0, 0), 1),  # no length
        ((20, 0, -5), (0, 0, -5), 0),  # begins in the slab
        ((100, 0, 0), (0, 0, 0), 0),  # begins outside
    ],
)
def test_lines_in_a_room(start: Any, end: Any, fraction: float) -> None:
    result = trace(ROOM, np.array([start]), np.array([end]))
    assert result.shape == (1,)
    assert result.dtype == np.float64
    assert result[0] == pytest.approx(fraction, abs=1e-12)


def test_no_lines() -> None:
    assert trace(ROOM, np.zeros((0, 3)), np.zeros((0, 3))).shape == (0,)


def random_tree(rng: np.random.Generator) -> tuple[BspFile, list[Points]]:
    """A tree, and each leaf's walls: rows (normal, distance) with the leaf behind them."""
    nodes: list[Node] = []
    walls: list[list[Points]] = []

    def grow(above: list[Points], levels: int) -> int:
        if levels == 0 or rng.random() < 0.15:
            walls.append(above)
            return ~(len(walls) - 1)
        normal = rng.normal(size=3)
        plane = np.append(normal / np.linalg.norm(normal), rng.uniform(-50, 50))
        plane = plane.astype(np.float32).astype(np.float64)
        number = len(nodes)
        nodes.append(((0, 0, 0), 0, 0, 0))
        front, back = grow([*above, -plane], levels - 1), grow([*above, plane], levels - 1)
        nodes[number] = ((plane[0], plane[1], plane[2]), plane[3], front, back)
        return number

    while len(walls) < 2:
        walls.clear()
        grow([], 6)
    solid = rng.random(len(walls)) < 0.4
    solid[0] = False
    return tree(nodes, np.where(solid, -1, 0).tolist()), [np.array(rows) for rows in walls]


@pytest.mark.parametrize("seed", range(10))
def test_random_tree_agrees_with_its_leafs_walls(seed: int) -> None:
    """Each leaf clips each line by its own walls, without any tree."""
    rng = np.random.default_rng(seed)
    bsp, walls = random_tree(rng)
    start, end = rng.uniform(-100, 100, (2, 300, 3))

    inside = np.array([(start @ w[:, :3].T <= w[:, 3]).all(axis=1) for w in walls])
    assert (inside.sum(axis=0) == 1).all()
    assert (point_leafs(bsp, start) == inside.argmax(axis=0)).all()

    expected = np.ones(300)
    for leaf in np.flatnonzero(leaf_is_solid(bsp)):
        normal, distance = walls[leaf][:, :3], walls[leaf][:, 3]
        height, slope = start @ normal.T - distance, (end - start) @ normal.T
        at = -height / slope
        enter = np.where(slope < 0, at, 0).max(axis=1, initial=0)
        leave = np.where(slope > 0, at, 1).min(axis=1, initial=1)
        expected = np.where(enter <= leave, np.minimum(expected, enter), expected)
    assert (expected < 1).any()
    np.testing.assert_allclose(trace(bsp, start, end), expected, rtol=0, atol=1e-9)


def read_level(pak: str, name: str) -> BspFile:
    with zipfile.ZipFile(OPENARENA / pak) as file:
        return read_bsp(file.read(f"maps/{name}.bsp"), name)


def random_points(bsp: BspFile, count: int) -> Points:
    world = bsp.models[0]
    return np.random.default_rng(7).uniform(world["mins"], world["maxs"], (count, 3))


@pytest.mark.openarena
@pytest.mark.parametrize(("pak", "name"), LEVELS)
def test_a_points_leaf_lists_every_brush_around_the_point(pak: str, name: str) -> None:
    bsp = read_level(pak, name)
    points = random_points(bsp, 800)
    world = bsp.models[0]
    brushes = bsp.brushes[world["first_brush"] :][: world["brush_count"]]
    planes = bsp.planes[
        bsp.brush_sides["plane"][run_members(brushes["first_side"], brushes["side_count"])]
    ]
    heights = points @ planes["normal"].T.astype(np.float64) - planes["distance"]
    first = np.cumsum(brushes["side_count"]) - brushes["side_count"]
    around = np.maximum.reduceat(heights, first, axis=1) < -0.1  # clear of rounding

    leafs = bsp.leafs[point_leafs(bsp, points)]
    listed = bsp.leaf_brushes[run_members(leafs["first_leaf_brush"], leafs["leaf_brush_count"])]
    in_leaf = np.zeros((len(points), len(bsp.brushes)), bool)
    in_leaf[np.repeat(np.arange(len(points)), leafs["leaf_brush_count"]), listed] = True
    assert around.any(axis=1).sum() > 50
    assert not (around & ~in_leaf[:, : len(brushes)]).any()


@pytest.mark.openarena
@pytest.mark.parametrize(("pak", "name"), LEVELS)
def test_players_start_in_the_open(pak: str, name: str) -> None:
    bsp = read_level(pak, name)
    places = [
        np.array(entity["origin"].split(), float)
        for entity in bsp.entities
        if entity.get("classname", "").startswith("info_player_")
    ]
    assert places
    assert not leaf_is_solid(bsp)[point_leafs(bsp, np.array(places))].any()


@pytest.mark.openarena
@pytest.mark.parametrize(("pak", "name"), LEVELS)
def test_lines_end_where_walking_along_them_meets_a_solid_leaf(pak: str, name: str) -> None:
    bsp = read_level(pak, name)
    solid = leaf_is_solid(bsp)
    points = random_points(bsp, 800)
    start, end = points[:400], points[400:]
    fraction = trace(bsp, start, end)

    def solid_at(t: NDArray[np.float64]) -> NDArray[np.bool_]:
        return solid[point_leafs(bsp, start + t[:, np.newaxis] * (end - start))]

    step = 1e-3 / np.linalg.norm(end - start, axis=1)
    np.testing.assert_array_equal(fraction == 0, solid_at(np.zeros(400)))
    hit, moved = fraction < 1, fraction > 2 * step
    assert hit.any()
    assert solid_at(fraction + step)[hit].all()
    for share in np.linspace(0, 1, 40):
        assert not solid_at(share * (fraction - step))[moved].any()


@pytest.mark.openarena
@pytest.mark.parametrize(("pak", "name"), LEVELS)
def test_what_a_free_line_reaches_is_visible(pak: str, name: str) -> None:
    bsp = read_level(pak, name)
    assert "_farplanedist" not in bsp.entities[0]
    points = random_points(bsp, 3000)
    points = points[~leaf_is_solid(bsp)[point_leafs(bsp, points)]]
    targets = point_leafs(bsp, points)
    hidden = 0
    for viewer in points[:20]:
        free = trace(bsp, np.broadcast_to(viewer, points.shape), points) == 1
        seen = visible_leafs(bsp, viewer)[targets]
        assert seen[free].all()
        hidden += int((~seen).sum())
    assert hidden > 0  # or the test says nothing


def test_boxes_reach_into_the_leafs_of_their_points() -> None:
    bsp = load("courtyard").level.bsp
    rng = np.random.default_rng(2)
    low = rng.uniform(-600, 600, (40, 3))
    high = low + rng.uniform(0, 200, (40, 3))
    boxes, leafs = box_leafs(bsp, low, high)
    pairs = set(zip(boxes.tolist(), leafs.tolist(), strict=True))
    assert len(pairs) == len(boxes)
    for number in range(40):
        inside = rng.uniform(low[number], high[number], (300, 3))
        for leaf in point_leafs(bsp, inside).tolist():
            assert (number, leaf) in pairs
    # A box so small that it touches no plane is where its middle is.
    tiny = rng.uniform(-600, 600, (200, 3))
    boxes, leafs = box_leafs(bsp, tiny - 1e-9, tiny + 1e-9)
    assert leafs[np.argsort(boxes)].tolist() == point_leafs(bsp, tiny).tolist()
