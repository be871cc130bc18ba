import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from patch_geometry import point_set, surface
from patch_grids import (
    borders,
    control_grid,
    coordinates,
    cut,
    cylinder,
    hill,
    patch_triangles,
    plane,
    tolerances,
    vertex_grid,
)

from followspot.assets.bsp import FaceType
from followspot.assets.bsp_reader import read_bsp
from followspot.errors import UsageError
from followspot.scene.mesh import VERTEX
from followspot.scene.patch import tessellate

Array = NDArray[Any]

OPENARENA = Path("/usr/share/games/openarena/baseoa")


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
