import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import ArrayLike, NDArray
from patch_geometry import all_triangles, distance, point_set, samples, surface

from followspot.assets.bsp import FaceType, read_bsp
from followspot.errors import UsageError
from followspot.scene.mesh import VERTEX
from followspot.scene.patch import Tessellation, tessellate

Array = NDArray[Any]

OPENARENA = Path("/usr/share/games/openarena/baseoa")


def control_grid(positions: ArrayLike, normal: ArrayLike = (0, 0, 1)) -> Array:
    """(h, w) of VERTEX from (h, w, 3) positions; texture coordinates are some other function."""
    points = np.asarray(positions, np.float32)
    grid = np.zeros(points.shape[:2], VERTEX)
    grid["position"] = points
    grid["normal"] = normal
    grid["texcoord"] = points[..., :2] * 0.25 + points[..., 2:] * 0.5
    return grid


def cut(*grids: Array, tolerance: float = 1.0, max_segments: int = 64) -> Tessellation:
    """Tessellate grids (h, w) of VERTEX as the patches of one level."""
    control = np.concatenate([np.empty(0, VERTEX), *(grid.ravel() for grid in grids)])
    counts = np.array([grid.size for grid in grids], np.int64)
    size = np.array([grid.shape[::-1] for grid in grids], np.int32).reshape(-1, 2)
    return tessellate(control, np.cumsum(counts) - counts, size, tolerance, max_segments)


def vertex_grid(made: Tessellation, patch: int) -> Array:
    """(height, width) of VERTEX of one patch."""
    width, height = made.grid_size[patch]
    first = made.first_vertex[patch]
    return made.vertices[first : first + width * height].reshape(height, width)


def patch_triangles(made: Tessellation, patch: int) -> Array:
    """(t, 3, 3) float64 corners of one patch's triangles."""
    first, count = made.first_index[patch], made.index_count[patch]
    indices = made.indices[first : first + count].reshape(-1, 3)
    return made.vertices["position"][indices].astype(np.float64)


def borders(grid: Array) -> list[Array]:
    """The four borders of a grid, in either direction the same places."""
    return [grid[0], grid[-1], grid[:, 0], grid[:, -1]]


def arc(radius: float, pieces: int) -> Array:
    """(2 pieces + 1, 2) control points of about a full circle, exactly closed."""
    angles = np.arange(2 * pieces + 1) % (2 * pieces) * (np.pi / pieces)
    reach = np.where(np.arange(2 * pieces + 1) % 2, 1 / np.cos(np.pi / pieces), 1.0)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.asarray(radius * reach[:, None] * circle)


def cylinder(radius: float, height: float, top_radius: float | None = None) -> Array:
    """A closed tube of 3 rows and 9 columns, seen from outside, or a cone."""
    top = radius if top_radius is None else top_radius
    rows = [
        np.column_stack([arc(size, 4), np.full(9, level)])
        for size, level in zip(
            (radius, (radius + top) / 2, top), (0, height / 2, height), strict=True
        )
    ]
    outward = np.zeros((3, 9, 3))
    outward[..., :2] = arc(1, 4)
    return control_grid(rows, outward)


def plane(width: int, height: int, step: float = 10.0) -> Array:
    """A level grid of evenly spaced control points, seen from above."""
    x, y = np.meshgrid(np.arange(width) * step, np.arange(height) * step)
    return control_grid(np.stack([x, y, np.zeros_like(x)], axis=-1))


def hill(height: float) -> Array:
    """3 by 3 control points from (0, 0) to (20, 20), curved along x only."""
    grid = plane(3, 3)
    grid["position"][:, 1, 2] = height
    return grid


coordinates = st.floats(-100, 100, width=32)
patches = st.sampled_from([(3, 3), (3, 5), (5, 3)]).flatmap(
    lambda shape: arrays(np.float32, (*shape, 3), elements=coordinates)
)
tolerances = st.sampled_from([1.0, 3.0, 10.0, 40.0])


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


TURNS: list[Callable[[Array], Array]] = [
    turn
    for down in (1, -1)
    for right in (1, -1)
    for turn in (
        lambda grid, d=down, r=right: grid[::d, ::r],
        lambda grid, d=down, r=right: grid[::d, ::r].T,
    )
]


def along(curve: Array, control: Array, vertices: Array) -> Array:
    """The vertices of the border of a patch that has the control points of `curve`, in order."""
    for points, cuts in zip(borders(control), borders(vertices), strict=True):
        if np.array_equal(points["position"], curve["position"]):
            return cuts
        if np.array_equal(points["position"], curve["position"][::-1]):
            return cuts[::-1]
    raise AssertionError("no such border")


@settings(max_examples=60, deadline=None)
@given(
    arrays(np.float32, (5, 5, 3), elements=coordinates),
    st.sampled_from(TURNS),
    st.sampled_from(TURNS),
    tolerances,
)
def test_neighbours_share_their_border_bit_by_bit(
    points: Array, turn: Callable[[Array], Array], other: Callable[[Array], Array], tolerance: float
) -> None:
    """A grid parted down the middle, both halves turned every way: nothing gapes between them."""
    grid = control_grid(points)
    grid["normal"] = points * 0.01 + [0, 0, 2]
    halves = turn(grid[:, :3]), other(grid[:, 2:])
    made = cut(*halves, tolerance=tolerance)
    ours, theirs = (along(grid[:, 2], halves[k], vertex_grid(made, k)) for k in (0, 1))
    assert len(ours) >= 3
    assert ours["position"].tobytes() == theirs["position"].tobytes()
    assert ours["texcoord"].tobytes() == theirs["texcoord"].tobytes()
    np.testing.assert_array_equal(ours["normal"], theirs["normal"])


def test_rounding_does_not_see_which_way_a_border_runs() -> None:
    """This one's thirds lie so near to halfway between two floats that the order of sums shows."""
    border = np.array([15.480579376220703, 1.5497207641601562e-06, 12.776068687438965])
    grid = plane(5, 3)
    grid["position"][..., 1] = border[:, None]
    halves = grid[:, :3], grid[::-1, 2:]
    made = cut(*halves)
    ours, theirs = (along(grid[:, 2], halves[k], vertex_grid(made, k)) for k in (0, 1))
    assert len(ours) == 4
    assert ours["position"].tobytes() == theirs["position"].tobytes()


@pytest.mark.parametrize("turn", TURNS)
def test_a_neighbour_that_needs_fewer_cuts_gets_as_many(turn: Callable[[Array], Array]) -> None:
    steep, low = hill(64), plane(3, 3)
    steep["position"][0, 1, 2] = 10
    low["position"][2] = steep["position"][0]
    low["position"][:2, :, 1] -= 20
    low = turn(low)
    alone = along(steep[0], low, vertex_grid(cut(low), 0))
    made = cut(low, steep)
    ours = along(steep[0], low, vertex_grid(made, 0))
    theirs = along(steep[0], steep, vertex_grid(made, 1))
    assert len(alone) < len(ours) == cut(steep).grid_size[0, 0]
    assert ours["position"].tobytes() == theirs["position"].tobytes()


def test_the_greatest_number_travels_along_a_chain_of_patches() -> None:
    """Twelve squares in a row, shuffled and turned every way; only the last needs to be cut."""
    count = 12
    strip = plane(2 * count + 1, 3)
    strip["position"][1, :, 2] = 0.5
    strip["position"][1, -2, 2] = 300
    squares = [TURNS[k % 8](strip[:, 2 * k : 2 * k + 3]) for k in range(count)]
    assert cut(squares[0]).grid_size.tolist() == [[2, 2]]
    order = np.random.default_rng(3).permutation(count)
    made = cut(*(squares[k] for k in order))
    grids = [vertex_grid(made, patch) for patch in np.argsort(order)]
    lefts = [along(strip[:, 2 * k], squares[k], grids[k])["position"] for k in range(count)]
    rights = [along(strip[:, 2 * k + 2], squares[k], grids[k])["position"] for k in range(count)]
    assert len(rights[-1]) > 10
    for left, right in zip(lefts[1:], rights[:-1], strict=True):
        assert left.tobytes() == right.tobytes()
    assert len(lefts[0]) == len(rights[-1])


def test_a_ring_of_patches_and_a_closed_tube_are_tight() -> None:
    tube = cylinder(50, 80)
    assert np.array_equal(tube[:, 0], tube[:, -1])
    closed = vertex_grid(cut(tube), 0)
    assert closed["position"][:, 0].tobytes() == closed["position"][:, -1].tobytes()
    quarters = [TURNS[2 * k + 1](tube[:, 2 * k : 2 * k + 3]) for k in range(4)]
    quarters[2]["position"][1, 1] *= 1.5  # in the ring, only one quarter bulges
    made = cut(*quarters)
    for k in range(4):
        seam, after = tube[:, 2 * k + 2], (k + 1) % 4
        ours = along(seam, quarters[k], vertex_grid(made, k))
        theirs = along(seam, quarters[after], vertex_grid(made, after))
        assert len(ours) > 2
        assert ours["position"].tobytes() == theirs["position"].tobytes()


def test_pieces_of_one_patch_and_the_same_pieces_as_patches_have_the_same_vertices() -> None:
    rng = np.random.default_rng(5)
    grid = control_grid(rng.uniform(-50, 50, (5, 7, 3)))
    parts = [grid[r : r + 3, c : c + 3] for r in (0, 2) for c in (0, 2, 4)]
    whole, apart = cut(grid), cut(*parts)
    assert point_set(whole.vertices["position"]) == point_set(apart.vertices["position"])
    assert len(point_set(whole.vertices["position"])) == len(whole.vertices)
    assert whole.index_count.sum() == apart.index_count.sum()


def test_borders_that_differ_by_a_compilers_rounding_are_cut_alike() -> None:
    steep, low = hill(64), plane(3, 3)
    steep["position"][0, 1, 2] = 10
    low["position"][2] = steep["position"][0] + np.float32(0.0005)
    low["position"][:2, :, 1] -= 20
    made = cut(low, steep)
    ours, theirs = vertex_grid(made, 0)["position"][-1], vertex_grid(made, 1)["position"][0]
    assert ours.shape == theirs.shape
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=0.001)

    low["position"][2] += np.float32(0.2)  # a gap that somebody built
    assert cut(low, steep).grid_size[0, 0] < made.grid_size[0, 0]


def test_zero_and_minus_zero_are_one_place() -> None:
    steep, low = hill(64), plane(3, 3)
    low["position"][0] = steep["position"][0] * np.float32(-1) * np.float32(-1)
    low["position"][0, :, 1] = -0.0
    low["position"][1:, :, 1] *= -1
    made = cut(low, steep)
    ours, theirs = (vertex_grid(made, patch)["position"][0] for patch in (0, 1))
    assert ours.tobytes() == theirs.tobytes()


def test_vertices_lie_on_the_surface_with_its_texture_and_normal() -> None:
    rng = np.random.default_rng(11)
    grid = control_grid(rng.uniform(-50, 50, (3, 3, 3)), rng.uniform(0.1, 1, (3, 3, 3)))
    grid["texcoord"] = rng.uniform(-4, 4, (3, 3, 2))
    made = cut(grid)
    width, height = made.grid_size[0]
    assert width != height
    u, v = np.arange(width) / (width - 1), np.arange(height) / (height - 1)
    vertices = vertex_grid(made, 0)
    for name in ("position", "texcoord"):
        np.testing.assert_allclose(vertices[name], surface(grid[name], u, v), rtol=0, atol=1e-5)
    normals = surface(grid["normal"], u, v)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    np.testing.assert_allclose(vertices["normal"], normals, rtol=0, atol=1e-6)
    assert vertices[0, 0]["position"].tobytes() == grid[0, 0]["position"].tobytes()
    assert vertices[-1, -1]["position"].tobytes() == grid[-1, -1]["position"].tobytes()


def test_missing_normals_come_from_the_triangles() -> None:
    tube = cylinder(50, 80)[:, :3]
    tube["normal"] = 0
    vertices = vertex_grid(cut(tube, tolerance=0.05), 0)
    segments = vertices.shape[1] - 1
    steps = np.diff(tube["position"][0].astype(np.float64), axis=0)
    t = np.arange(segments + 1)[:, None] / segments
    tangent = steps[0] + t * (steps[1] - steps[0])
    outward = np.cross(tangent, [0, 0, 1])
    outward /= np.linalg.norm(outward, axis=-1, keepdims=True)
    cosine = np.sum(outward * vertices["normal"], axis=-1)
    # At the patch's ends there is one triangle's normal: that half a segment farther in.
    assert cosine[:, 1:-1].min() > np.cos(np.radians(0.25 * 90 / segments))
    assert cosine.min() > np.cos(np.radians(0.6 * 90 / segments))


def test_normals_that_cancel_out_come_from_the_triangles() -> None:
    bent = hill(64)
    bent["normal"] = [[(1, 0, 0), (0, 0, 0), (-1, 0, 0)]] * 3
    crest = vertex_grid(cut(bent, tolerance=8.0), 0)["normal"][:, 1]
    # Of the two triangles on either side that meet there, some count once and some twice.
    np.testing.assert_allclose(crest[:, 1], 0, atol=1e-6)
    assert (crest[:, 2] > 0.1).all()


@pytest.mark.parametrize("with_normals", [True, False])
def test_a_cone_has_no_triangle_without_area(with_normals: bool) -> None:
    cone = cylinder(40, 60, top_radius=0)
    if not with_normals:
        cone["normal"] = 0
    made = cut(cone)
    width, height = made.grid_size[0]
    around, up = width - 1, height - 1
    assert len(np.unique(vertex_grid(made, 0)["position"][-1], axis=0)) == 1
    assert made.index_count.tolist() == [3 * around * (2 * up - 1)]
    corners = patch_triangles(made, 0)
    areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert areas.any(axis=1).all()
    used = made.vertices["normal"][np.unique(made.indices)]
    np.testing.assert_allclose(np.linalg.norm(used, axis=1), 1, atol=1e-6)
    assert (used[:, 2] >= 0).all()


def test_a_patch_collapsed_to_a_point_or_a_line_has_no_triangles() -> None:
    point, line = plane(3, 3), plane(3, 3)
    point["position"] = 7
    line["position"][..., 1] = 0
    for grid in (point, line):
        grid["normal"] = 0
    made = cut(point, plane(3, 3), line)
    assert made.index_count.tolist() == [0, 6, 0]
    assert made.first_index.tolist() == [0, 0, 6]
    np.testing.assert_array_equal(vertex_grid(made, 0)["normal"], np.full((2, 2, 3), (0, 0, 1.0)))


def test_each_patch_is_one_run_of_indices_into_its_own_vertices() -> None:
    rng = np.random.default_rng(2)
    shapes = [(3, 3), (5, 3), (3, 9), (7, 5), (3, 3)]
    grids = [control_grid(rng.uniform(-30, 30, (*shape, 3))) for shape in shapes]
    grids[3]["position"] = 1
    made = cut(*grids)
    assert made.vertices.dtype == VERTEX
    assert made.indices.dtype == np.uint32
    assert made.index_count.sum() == len(made.indices)
    assert made.first_index.tolist() == [0, *np.cumsum(made.index_count)[:-1].tolist()]
    ends = np.cumsum(made.grid_size.prod(axis=1))
    assert made.first_vertex.tolist() == [0, *ends[:-1].tolist()]
    assert ends[-1] == len(made.vertices)
    for patch, grid in enumerate(grids):
        first, count = made.first_index[patch], made.index_count[patch]
        run = made.indices[first : first + count]
        assert ((run >= made.first_vertex[patch]) & (run < ends[patch])).all()
        alone = cut(grid)  # strangers do not touch each other
        np.testing.assert_array_equal(run - made.first_vertex[patch], alone.indices)
        assert vertex_grid(made, patch).tobytes() == vertex_grid(alone, 0).tobytes()


@pytest.mark.parametrize("grid", [plane(5, 3), hill(30), cylinder(50, 80)])
@pytest.mark.parametrize("sign", [1, -1])
def test_front_faces_are_clockwise(grid: Array, sign: int) -> None:
    """Seen from where cross(along a row, from row to row) points, whatever the normals say."""
    turned = grid.copy()
    turned["normal"] *= sign
    made = cut(turned)
    a, b, c = patch_triangles(made, 0).swapaxes(0, 1)
    front = sign * made.vertices["normal"][made.indices.reshape(-1, 3)].mean(axis=1)
    assert (np.sum(np.cross(b - a, c - a) * front, axis=1) < 0).all()


def test_a_level_without_patches() -> None:
    made = cut()
    assert made.vertices.shape == (0,)
    assert made.indices.shape == (0,)
    assert made.grid_size.shape == (0, 2)
    assert made.first_index.shape == made.index_count.shape == made.first_vertex.shape == (0,)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan, np.inf])
def test_senseless_numbers_are_refused(tolerance: float) -> None:
    with pytest.raises(UsageError, match="tolerance"):
        cut(plane(3, 3), tolerance=tolerance)
    with pytest.raises(UsageError, match="at least 1 segment"):
        cut(plane(3, 3), max_segments=0)


@pytest.mark.openarena
@pytest.mark.parametrize(
    ("pak", "name"),
    [
        ("pak6-patch088.pk3", "am_thornish"),
        ("z_oacmp-volume1-v3.pk3", "oacmpctf3"),
        ("pak1-maps.pk3", "oa_spirit3"),  # has normals that vanish
    ],
)
def test_the_patches_of_real_levels(pak: str, name: str) -> None:
    with zipfile.ZipFile(OPENARENA / pak) as archive:
        level = read_bsp(archive.read(f"maps/{name}.bsp"), name)
    faces = level.faces[level.faces["type"] == FaceType.PATCH]
    made = tessellate(level.vertices, faces["first_vertex"], faces["patch_size"], 1.0)

    # The front that the control points' order gives is the one that the file's normals mean.
    assert (made.index_count > 0).all()
    a, b, c = made.vertices["position"][made.indices.reshape(-1, 3).T].astype(np.float64)
    facing = made.vertices["normal"][made.indices.reshape(-1, 3)].sum(axis=1)
    volume = np.sum(np.cross(c - a, b - a) * facing, axis=1)
    assert (np.add.reduceat(volume, made.first_index // 3) > 0).all()
    np.testing.assert_allclose(np.linalg.norm(made.vertices["normal"], axis=1), 1, atol=1e-6)

    # Borders with equal control points have equal vertices.
    cuts: dict[frozenset[bytes], set[bytes]] = {}
    shared = 0
    for patch, face in enumerate(faces):
        width, height = face["patch_size"]
        first = face["first_vertex"]
        grid = level.vertices[first : first + width * height].reshape(height, width)
        sides = zip(borders(grid), borders(vertex_grid(made, patch)), strict=True)
        for control, vertices in sides:
            points = control["position"]
            key = frozenset((points.tobytes(), points[::-1].tobytes()))
            places = point_set(vertices["position"])
            shared += key in cuts
            assert cuts.setdefault(key, places) == places
    assert shared > 100
