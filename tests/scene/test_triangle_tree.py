"""Lines against triangles, held against every triangle tried by signed volumes."""

import numpy as np
import pytest
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.scene.mesh import FACE, VERTEX, Mesh
from followspot.scene.triangle_tree import Hits, TriangleTree
from synthetic import box, make_mesh, quad


def mesh_of(corners: NDArray[np.float32]) -> Mesh:
    """Triangles (n, 3, 3) that share no vertex, without a table of faces."""
    vertices = np.zeros(corners.size // 3, VERTEX)
    vertices["position"] = corners.reshape(-1, 3)
    return Mesh(vertices, np.arange(len(vertices), dtype=np.uint32), np.zeros(0, FACE))


def all_hits(tree: TriangleTree, start: Floats, end: Floats) -> Hits:
    parts = list(tree.crossings(start, end))
    return Hits(
        *(np.concatenate(each) for each in zip(*(vars(p).values() for p in parts), strict=True))
    )


def volume(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    return np.asarray(np.einsum("...i,...i->...", np.cross(b - a, c - a), d - a))


def crossed(corners: Floats, start: Floats, end: Floats) -> NDArray[np.bool_]:
    """(lines, triangles): the ends on both sides, the line on one side of all three edges."""
    a, b, c = corners.transpose(1, 0, 2)
    s, e = start[:, np.newaxis], end[:, np.newaxis]
    apart = volume(a, b, c, s) * volume(a, b, c, e) < 0
    sides = np.stack(
        [volume(s, e, *np.broadcast_arrays(p, q)) for p, q in ((a, b), (b, c), (c, a))]
    )
    return np.asarray(apart & ((sides > 0).all(axis=0) | (sides < 0).all(axis=0)))


@pytest.mark.parametrize("count", [1, 7, 8, 9, 1000])
def test_crossings_are_those_of_every_triangle_tried(count: int) -> None:
    rng = np.random.default_rng(count)
    size = 10 ** rng.uniform(-1, 2, (count, 1, 1))
    corners = (
        rng.uniform(-100, 100, (count, 1, 3)) + rng.normal(size=(count, 3, 3)) * size
    ).astype(np.float32)
    start, end = rng.uniform(-150, 150, (2, 300, 3))
    end[:50, 0] = start[:50, 0]  # some lie across an axis
    end[:20, 1] = start[:20, 1]
    hits = all_hits(TriangleTree(mesh_of(corners), np.ones(count, bool)), start, end)
    exact = corners.astype(np.float64)
    found = np.zeros((300, count), bool)
    found[hits.line, hits.triangle] = True
    np.testing.assert_array_equal(found, crossed(exact, start, end))
    places = start[hits.line] + (end - start)[hits.line] * hits.fraction[:, np.newaxis]
    mixed = (exact[hits.triangle] * hits.weights[..., np.newaxis]).sum(axis=1)
    np.testing.assert_allclose(places, mixed, atol=1e-6)
    a, b, c = exact[hits.triangle].transpose(1, 0, 2)
    fronts = np.cross(c - a, b - a)  # clockwise
    np.testing.assert_array_equal(
        hits.from_front, np.einsum("ij,ij->i", fronts, (end - start)[hits.line]) < 0
    )


def test_only_chosen_triangles_are_met_and_keep_their_numbers() -> None:
    mesh, _ = make_mesh([quad((0, 0, z), (10, 0, 0), (0, 10, 0)) for z in range(5)])
    chosen = np.arange(10) // 2 % 2 == 1
    hits = all_hits(TriangleTree(mesh, chosen), np.array([[3.0, 1, -9]]), np.array([[3.0, 1, 9]]))
    height = mesh.vertices["position"][mesh.indices.reshape(-1, 3)[hits.triangle], 2]
    assert sorted(height[:, 0]) == [1, 3]
    assert not hits.from_front.any()  # from below


def test_no_line_slips_between_the_triangles_of_a_closed_box() -> None:
    """Straight through edges, corners and the diagonals of the quads, from inside."""
    mesh, _ = make_mesh(box((-8, -8, -8), (8, 8, 8)))
    grid = np.linspace(-16, 16, 9)
    ends = np.stack(np.meshgrid(grid, grid, grid), axis=-1).reshape(-1, 3)
    ends = ends[np.abs(ends).max(axis=1) == 16]
    tree = TriangleTree(mesh, np.ones(12, bool))
    hits = all_hits(tree, np.zeros_like(ends), ends)
    assert set(hits.line) == set(range(len(ends)))
    assert not hits.from_front.any()


def test_lines_along_an_axis_meet_triangles_at_all_their_edges() -> None:
    """There they lie in a side of the boxes round the triangles."""
    mesh, _ = make_mesh([quad((0, 0, 0), (8, 0, 0), (0, 8, 0))])
    start = np.array([(x, y, 5.0) for x in (-8, 0, 8) for y in (-8, 0, 8)])
    hits = all_hits(TriangleTree(mesh, np.ones(2, bool)), start, start - (0, 0, 10))
    assert set(hits.line) == set(range(9))


def test_nothing_is_met_in_an_empty_tree() -> None:
    mesh, _ = make_mesh([quad((0, 0, 0), (1, 0, 0), (0, 1, 0))])
    tree = TriangleTree(mesh, np.zeros(2, bool))
    assert not len(all_hits(tree, np.array([[0.1, 0, -1]]), np.array([[0.1, 0, 1]])).line)


def test_many_lines_come_in_parts_with_their_own_numbers() -> None:
    mesh, _ = make_mesh([quad((0, 0, 0), (1, 0, 0), (0, 1, 0))])
    start = np.zeros((10_000, 3))
    start[:, 2], start[:, 0] = -1, 0.3
    start[::2, 0] = 5  # beside it
    hits = all_hits(TriangleTree(mesh, np.ones(2, bool)), start, start + np.array([0, 0.1, 2]))
    np.testing.assert_array_equal(np.unique(hits.line), np.arange(1, 10_000, 2))
