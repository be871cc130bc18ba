"""How far the triangles of patches are from the curves: at most the tolerance, with few cuts."""

from typing import Any

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from patch_geometry import all_triangles, distance, samples, surface
from patch_grids import (
    control_grid,
    cut,
    hill,
    patch_triangles,
    patches,
    plane,
    tolerances,
    vertex_grid,
)

Array = NDArray[Any]


@settings(max_examples=40, deadline=None)
@given(patches, tolerances)
@example(np.pad(np.full((1, 1, 1), 40, np.float32), ((1, 1), (1, 1), (0, 2))), 1.0)  # a needle
def test_no_point_of_a_patch_is_farther_from_its_triangles_than_the_tolerance(
    points: Array, tolerance: float
) -> None:
    grid = control_grid(points)
    made = cut(grid, tolerance=tolerance)
    assert made.grid_size.max() < 2 * 64  # not held back by max_segments
    far = distance(samples(grid, 8), all_triangles(vertex_grid(made, 0)))
    assert far.max() <= tolerance + 1e-4


@st.composite
def flat_patches(draw: st.DrawFn) -> Array:
    """Uneven, sheared, bulging, collapsed, sometimes folded, in a tilted plane and almost in it."""
    steps = st.lists(st.integers(0, 40), min_size=2, max_size=2)
    x, y = np.meshgrid(*([0, *np.cumsum(draw(steps))] for _ in range(2)))
    bulge = draw(arrays(np.int64, (2, 3, 3), elements=st.sampled_from([0, 0, 0, 0, -9, 15, 30])))
    x, y = x + bulge[0], y + bulge[1]
    if draw(st.booleans()):  # a cap: a corner, and the arc opposite
        x[:, 1:], y[:, 1:] = x[0, 2], y[0, 2]
    lift = draw(arrays(np.float64, (3, 3), elements=st.sampled_from([0.0, 0.1, 1.0])))
    axes = np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    return np.asarray(np.stack([x, y, lift], axis=-1) @ axes)


@settings(max_examples=100, deadline=None)
@given(flat_patches(), tolerances)
def test_flat_patches_keep_to_the_tolerance_too(points: Array, tolerance: float) -> None:
    grid = control_grid(points)
    made = cut(grid, tolerance=tolerance)
    far = distance(samples(grid, 9), all_triangles(vertex_grid(made, 0)))
    assert far.max() <= tolerance + 1e-4


def test_the_bound_is_reached_by_a_parabola_and_by_a_saddle() -> None:
    """The error is A / (4 n^2) for the one and T / (n m) for the other, no less."""
    grid = hill(64.0)  # A = 128
    for tolerance, segments in ((32.0, 1), (31.9, 2), (8.0, 2), (2.0, 4), (1.99, 5)):
        assert cut(grid, tolerance=tolerance).grid_size.tolist() == [[segments + 1, 2]]
    one_cell = cut(grid, tolerance=32.0)
    assert distance(samples(grid, 3), patch_triangles(one_cell, 0)).max() == 32.0
    saddle = plane(3, 3)
    saddle["position"][..., 2] = np.outer([-1, 0, 1], [-4, 0, 4])  # T = 4
    assert cut(saddle, tolerance=1.0).grid_size.tolist() == [[3, 3]]
    assert cut(saddle, tolerance=0.99).grid_size.tolist() == [[3, 4]]  # T / 6 is enough
    one_cell = cut(saddle, tolerance=4.0)
    assert one_cell.grid_size.tolist() == [[2, 2]]
    t = np.array([0.5])
    centre = surface(saddle["position"], t, t)[0, 0]
    diagonal = vertex_grid(one_cell, 0)["position"][[0, 1], [1, 0]].mean(axis=0)
    assert np.linalg.norm(centre - diagonal) == 4.0


def test_bends_that_point_different_ways_do_not_add_up() -> None:
    """Both are 128 long: where they meet, points miss by 32 sqrt(2) = 45.3 and not by 64."""
    grid = plane(3, 3)
    grid["position"][:, 1, 2] = 64
    grid["position"][1, :, 1] += 64
    assert cut(grid, tolerance=49.0).grid_size.tolist() == [[2, 2]]
    assert cut(grid, tolerance=45.0).grid_size.tolist() != [[2, 2]]


def test_flat_pieces_get_two_triangles_each_however_unevenly_they_are_spaced() -> None:
    assert cut(plane(7, 5)).index_count.tolist() == [3 * 2 * 3 * 2]
    uneven = plane(7, 5)
    uneven["position"][:, [1, 3], 0] += 9
    uneven["position"][1, :, 1] -= 9
    made = cut(uneven, tolerance=0.01)
    assert made.index_count.tolist() == [3 * 2 * 3 * 2]
    assert made.grid_size.tolist() == [[4, 3]]


def test_a_bevel_cap_becomes_a_fan() -> None:
    """The caps that editors make: an arc in one column, its corner point in all others."""
    corner = np.array([64.0, 0, 0])
    points = np.broadcast_to(corner, (3, 3, 3)).copy()
    points[:, 0] = [[0, 0, 0], corner, [64, 64, 0]]
    made = cut(control_grid(points))
    # |p0 - 2 p1 + p2| = 64 sqrt(2) takes ceil(sqrt(22.6)) cuts; half of every cell collapses.
    assert made.grid_size.tolist() == [[2, 6]]
    assert made.index_count.tolist() == [3 * 5]


def test_a_flat_piece_is_cut_for_its_bent_borders_and_its_thickness() -> None:
    def bulging(by: float, lift: float = 0.0) -> list[int]:
        grid = plane(3, 3)
        grid["position"][0, 1, 1] = -by
        grid["position"][1, 1, 2] = lift
        sizes: list[int] = cut(grid, tolerance=1.0).grid_size[0].tolist()
        return sizes

    assert bulging(2.0) == [2, 2]  # the border leaves its chord by half of that
    assert bulging(2.1) == [3, 2]
    assert bulging(8.0) == [3, 2]  # n^2 = 16 / 4
    assert bulging(8.1) == [4, 2]
    assert bulging(8.0, lift=0.1) == [4, 2]  # n^2 = 16 / (4 - 0.4)


def test_max_segments_limits_every_piece() -> None:
    made = cut(hill(5000), tolerance=0.01, max_segments=7)
    assert made.grid_size.tolist() == [[8, 2]]
