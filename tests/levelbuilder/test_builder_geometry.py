"""Windings, hidden faces, T-junctions and patches, against closed forms and brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot.errors import UsageError
from followspot.levelbuilder import (
    Material,
    arc,
    arch,
    box,
    brush_from_planes,
    groin_vault,
    hull,
    lathe,
    polyline,
)
from followspot.levelbuilder.csg import merge_all, visible_fragments
from followspot.levelbuilder.faces import patch_face
from followspot.levelbuilder.mesh import triangulate, weld_t_junctions
from followspot.levelbuilder.patches import evaluate
from followspot.levelbuilder.winding import area, area_vector, base_winding, plane_axes, split

STONE = Material("textures/test/stone", (64, 64), 1.0)
WATER = Material("textures/test/water", opacity=0.5)

directions = (
    st.tuples(*[st.floats(-1, 1)] * 3)
    .filter(lambda v: float(np.linalg.norm(v)) > 0.1)
    .map(lambda v: np.array(v) / np.linalg.norm(v))
)
corners = st.tuples(*[st.integers(0, 6)] * 3)
boxes = st.lists(
    st.tuples(corners, corners).filter(lambda b: all(p != q for p, q in zip(*b, strict=True))),
    min_size=1,
    max_size=5,
)


def sorted_box(ends: tuple[tuple[int, ...], tuple[int, ...]]) -> tuple[np.ndarray, np.ndarray]:
    return np.min(ends, axis=0), np.max(ends, axis=0)


@given(directions)
def test_windings_run_clockwise_as_seen_from_their_front(normal: np.ndarray) -> None:
    winding = base_winding(normal, 3.0, 10.0)
    np.testing.assert_allclose(area_vector(winding), 400 * normal, atol=1e-9)
    right, down = plane_axes(normal)
    np.testing.assert_allclose(np.cross(right, down), -normal, atol=1e-12)


@given(directions, directions, st.floats(-8, 8))
def test_a_cut_loses_no_area_and_leaves_each_part_on_its_side(
    normal: np.ndarray, cutter: np.ndarray, dist: float
) -> None:
    winding = base_winding(normal, 0.0, 10.0)
    front, back = split(winding, cutter, dist)
    parts = [part for part in (front, back) if part is not None]
    assert sum(area(part) for part in parts) == pytest.approx(400, abs=0.3)
    assert front is None or (front @ cutter - dist).min() > -0.011
    assert back is None or (back @ cutter - dist).max() < 0.011


@settings(deadline=None, max_examples=60)
@given(boxes)
def test_what_is_left_is_the_surface_of_the_union_each_point_once(
    ends: list[tuple[tuple[int, ...], tuple[int, ...]]],
) -> None:
    voxels = np.zeros((8, 8, 8), bool)
    brushes = []
    for pair in ends:
        low, high = sorted_box(pair)
        voxels[tuple(slice(a + 1, b + 1) for a, b in zip(low, high, strict=True))] = True
        brushes.append(box(low * 16, high * 16, STONE))
    surface = sum(np.abs(np.diff(voxels.astype(int), axis=axis)).sum() for axis in range(3))
    fragments = visible_fragments(brushes)
    assert sum(area(f.winding) for f in fragments) == pytest.approx(surface * 256)
    for fragment in fragments:  # and air lies in front of every piece
        probe = fragment.winding.mean(axis=0) / 16 + fragment.side.normal * 0.01
        assert not voxels[tuple(np.floor(probe).astype(int) + 1)]


def test_water_is_cut_by_stone_and_hides_nothing() -> None:
    stone, water = box((0, 0, 0), (64, 64, 64), STONE), box((32, 0, 0), (96, 64, 32), WATER)
    areas = {0: 0.0, 1: 0.0}
    for fragment in visible_fragments([stone, water]):
        areas[fragment.brush] += area(fragment.winding)
    assert areas[0] == pytest.approx(6 * 64 * 64)
    assert areas[1] == pytest.approx(2 * 32 * 64 + 2 * 32 * 32 + 32 * 64)


def test_pieces_of_a_cut_square_grow_together_again() -> None:
    normal = np.array([0.0, 0.0, 1.0])
    pieces = [base_winding(normal, 0.0, 64.0)]
    for cutter, dist in (([1.0, 0, 0], 10.0), ([0, 1.0, 0], -20.0), ([1.0, 0, 0], -30.0)):
        cut = [split(piece, np.array(cutter), dist) for piece in pieces]
        pieces = [part for pair in cut for part in pair if part is not None]
    assert len(pieces) == 6
    (whole,) = merge_all(pieces)
    assert area(whole) == pytest.approx(128 * 128)
    assert len(whole) == 4


@settings(deadline=None, max_examples=40)
@given(boxes)
def test_no_corner_lies_within_another_polygons_edge_after_welding(
    ends: list[tuple[tuple[int, ...], tuple[int, ...]]],
) -> None:
    brushes = [box(low * 16, high * 16, STONE) for low, high in map(sorted_box, ends)]
    fragments = visible_fragments(brushes)
    windings = weld_t_junctions([fragment.winding for fragment in fragments])
    points = np.concatenate(windings)
    a = points
    b = np.concatenate([np.roll(winding, -1, axis=0) for winding in windings])
    share = np.einsum("enk,ek->en", points[None] - a[:, None], b - a)
    share /= np.maximum(((b - a) ** 2).sum(axis=1), 1e-9)[:, None]
    foot = a[:, None] + share[..., None] * (b - a)[:, None]
    apart = np.linalg.norm(points[None] - foot, axis=2)
    assert not ((apart < 0.05) & (share > 0.01) & (share < 0.99)).any()
    for winding, fragment in zip(windings, fragments, strict=True):
        triangles = winding[triangulate(winding)]
        doubled = np.cross(triangles[:, 2] - triangles[:, 0], triangles[:, 1] - triangles[:, 0])
        assert (doubled @ fragment.side.normal > 1e-3).all()
        total = doubled @ fragment.side.normal / 2
        assert total.sum() == pytest.approx(area(fragment.winding))


def test_a_hull_finds_the_sides_of_a_wedge() -> None:
    wedge = hull([(0, 0, 0), (64, 0, 0), (0, 64, 0), (64, 64, 0), (0, 0, 32), (0, 64, 32)], STONE)
    assert len(wedge.sides) == 5
    assert sum(area(s.winding) for s in wedge.sides) == pytest.approx(
        64 * 64 + 64 * 32 + 2 * 64 * 32 / 2 + 64 * np.hypot(64, 32)
    )


def test_planes_that_enclose_nothing_are_refused() -> None:
    planes = np.array([[1.0, 0, 0, -5], [-1, 0, 0, -5], [0, 1, 0, 5], [0, -1, 0, 5]])
    with pytest.raises(UsageError, match="encloses nothing"):
        brush_from_planes(planes, STONE)


def test_an_arc_stays_within_three_thousandths_of_its_circle() -> None:
    controls = arc(0, 360)
    curve = evaluate(controls[None].repeat(3, axis=0), np.zeros(1), np.linspace(0, 8, 400))[0]
    np.testing.assert_allclose(np.hypot(*curve.T), 1.0, atol=0.0032)


def test_a_lathe_faces_outwards() -> None:
    face = patch_face(lathe(STONE, (10, 20, 0), polyline([(8, 0), (12, 30), (8, 60)])))
    outward = (face.points - [10, 20, 0])[:, :2]
    assert ((face.normals[:, :2] * outward).sum(axis=1) > 0).all()


@pytest.mark.parametrize("turns", range(4))
def test_an_arch_is_seen_from_below_and_its_fronts_from_outside(turns: int) -> None:
    cos, sin = round(np.cos(turns * np.pi / 2)), round(np.sin(turns * np.pi / 2))

    def turned(x: float, y: float) -> tuple[float, float, float]:
        return (cos * x - sin * y, sin * x + cos * y, 0.0)

    for handed in (1, -1):  # looked at along its depth, and against it
        across, through = np.array(turned(96, 0)), handed * np.array(turned(0, 32))
        soffit, front, back = arch((0, 0, 64), tuple(across), tuple(through), 48, STONE, top=160)
        assert patch_face(soffit).normals[4, 2] < -0.99  # at the crown
        for patch, facing in ((front, -through), (back, through)):
            normals = patch_face(patch).normals
            np.testing.assert_allclose(normals, np.tile(facing / 32, (len(normals), 1)), atol=1e-6)


def test_the_webs_of_a_vault_share_their_groins_to_the_bit() -> None:
    webs = groin_vault((0, 0, 100), (128, 128), 64, STONE)
    groins = [np.concatenate([web.points[0, :5], web.points[0, 4:]]) for web in webs]
    for web in webs:
        assert patch_face(web).normals[:, 2].max() < 0.05
    ends = np.concatenate(groins)
    _, counts = np.unique(np.round(ends, 9), axis=0, return_counts=True)
    assert (counts >= 2).all()
