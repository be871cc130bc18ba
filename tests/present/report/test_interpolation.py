"""Interpolation: triangles whose answer is known, formulae of the proof, the renderer's depth."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import cast

import html5lib
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot import spaces
from followspot.arrays import Floats
from followspot.errors import UsageError
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.present.report import interpolation_answer
from followspot.present.report.interpolation_study import (
    Map,
    Ways,
    compare,
    edge_error,
    lit,
    rasterise,
)
from followspot.present.report.material import Material
from followspot.scene.camera import Camera
from followspot.scene.scene import Scene
from synthetic import SIZE, box, camera, floor, make_scene, on_plane, quad, spot

Draw = Callable[..., Floats]

VIEW = camera((0, 0, 60), yaw=20, pitch=25)
NEAR, FAR = 10.0, 500.0
LIGHT = spot((0, 0, 300), (40, 20, 0), 50)
"""Looks down at the floor from above."""


def corners_of(scene: Scene) -> Floats:
    position = scene.mesh.vertices["position"].astype(np.float64)
    return np.asarray(position[scene.mesh.indices.reshape(-1, 3)])


def clip_from_world(view: Camera, size: tuple[int, int] = SIZE, far: float = 5000.0) -> Floats:
    return np.asarray(view.clip_from_view(size[0] / size[1], far) @ view.view_from_world)


def shadow_map(light_at: Floats, size: int = 1024, offset: float = 0.0) -> Map:
    """A light that looks straight down from a place, with a right-angled pyramid."""
    view = spaces.view_from_world(light_at, 0.0, 90.0)
    matrix = spaces.SHADOW_FROM_CLIP @ spaces.clip_from_view(90, 90, NEAR, FAR) @ view
    return Map(matrix, view, size, NEAR, FAR, offset)


DOWN = shadow_map(np.array([0.0, 0.0, 300.0]))


def ways(corners: Floats, weights: Floats, map_: Map = DOWN, normals: Floats | None = None) -> Ways:
    n = len(weights)
    corners = np.broadcast_to(corners, (n, 3, 3))
    up = np.broadcast_to([0.0, 0.0, 1.0], (n, 3, 3)) if normals is None else normals
    return compare(corners, up, weights, np.ones((n, 3)), map_)


def test_every_pixel_of_a_floor_is_where_the_plane_is() -> None:
    """The floor goes on behind the camera, so its triangles cross the near plane and beyond."""
    corners = corners_of(make_scene([floor(2000)]))
    seen = rasterise(corners, clip_from_world(VIEW), SIZE)
    points, depth = on_plane(VIEW, (0, 0, 1))
    truth, hit = points.reshape(-1, 3), seen.triangle >= 0
    within = (np.abs(truth) < 2000).all(axis=1) & np.isfinite(depth).ravel()
    np.testing.assert_array_equal(hit, within)
    found = np.einsum("nk,nkc->nc", seen.weights[hit], corners[seen.triangle[hit]])
    np.testing.assert_allclose(found, truth[hit], atol=1e-6)
    distance = np.einsum("nk,nk->n", seen.weights[hit], seen.w[hit])
    np.testing.assert_allclose(distance, depth.ravel()[hit], rtol=1e-9)


def test_the_nearest_triangle_is_seen() -> None:
    wall = quad((100, 0, 60), (0, 30, 0), (0, 0, 30))
    far_wall = quad((200, 0, 60), (0, 300, 0), (0, 0, 300))
    for pieces in ([wall, far_wall], [far_wall, wall]):
        scene = make_scene(pieces)
        straight = camera((0, 0, 60))
        seen = rasterise(corners_of(scene), clip_from_world(straight), SIZE)
        x = np.einsum("nk,nkc->nc", seen.weights, corners_of(scene)[seen.triangle])[:, 0]
        _, depth = on_plane(straight, (1, 0, 0), 100)
        near = x.reshape(SIZE[::-1]) < 150
        assert near.sum() == pytest.approx((30 / 100) ** 2 * SIZE[0] ** 2, rel=0.05)
        np.testing.assert_allclose(x.reshape(SIZE[::-1])[near], 100)
        assert depth.min() == 100


def test_what_is_behind_or_before_the_near_plane_is_not_seen() -> None:
    behind = quad((-100, 0, 0), (0, 50, 0), (0, 0, 50))
    too_near = quad((3, 0, 0), (0, 50, 0), (0, 0, 50))
    seen = rasterise(
        corners_of(make_scene([behind, too_near])), clip_from_world(camera((0, 0, 0))), SIZE
    )
    assert (seen.triangle == -1).all()


@pytest.mark.gl
def test_the_triangles_seen_are_the_renderers(draw: Draw) -> None:
    scene = make_scene(
        [*box((-400, -400, 0), (400, 400, 300), inward=True), *box((60, -30, 0), (120, 50, 90))]
    )
    view = camera((-100, -150, 130), yaw=40, pitch=15)
    seen = rasterise(
        corners_of(scene), clip_from_world(view, far=view.far_for(*scene.bounds)), SIZE
    )
    found = np.einsum("nk,nk->n", seen.weights, seen.w).reshape(SIZE[::-1])
    drawn = draw(scene, view, View.DEPTH)
    same = np.isclose(found, drawn, rtol=1e-4)
    assert same.mean() > 0.995  # but for edges, whose pixels' middles lie on both sides
    assert (seen.triangle >= 0).all()


@given(st.integers(0, 2**32 - 1))
def test_perspective_correct_weights_are_those_in_space(seed: int) -> None:
    """Formula (3) of the proof, from the weights on the screen."""
    rng = np.random.default_rng(seed)
    clip = np.column_stack([rng.normal(size=(3, 2)), rng.uniform(0.5, 4, 3)])  # x, y, w
    b = rng.dirichlet([1, 1, 1])
    point = b @ clip
    screen = np.column_stack([clip[:, :2] / clip[:, 2:], np.ones(3)])
    if abs(np.linalg.det(screen)) < 1e-3:
        return
    on_screen = np.linalg.solve(screen.T, [*(point[:2] / point[2]), 1])
    np.testing.assert_allclose(
        (on_screen / clip[:, 2]) / (on_screen / clip[:, 2]).sum(), b, rtol=1e-6, atol=1e-9
    )


def test_texels_and_distances_of_a_point_that_is_known() -> None:
    """100 below the light and 50 aside: half-way from the middle to the edge of the map."""
    homogeneous = np.array([[0.0, 50, 200, 1], [0, 0, 290, 1], [0, 0, -200, 1]])
    found = DOWN.measured(homogeneous @ DOWN.shadow_from_world.T)
    np.testing.assert_allclose(np.abs(found[0, :2] - 512).max(), 256, atol=1e-9)
    np.testing.assert_allclose(found[1:, :2], 512, atol=1e-9)
    np.testing.assert_allclose(found[:, 2], [100, NEAR, FAR], rtol=1e-9)


def test_before_and_after_interpolation_differ_by_rounding_only() -> None:
    rng = np.random.default_rng(5)
    corners = rng.uniform(-150, 150, (5000, 3, 3))
    found = compare(corners, corners * 0, rng.dirichlet([1, 1, 1], 5000), np.ones((5000, 3)), DOWN)
    for a, b in ((found.by_vertex, found.by_pixel), (found.by_vertex, found.exact)):
        apart = np.abs(a - b)
        assert 0 < apart[:, :2].max() < 1024 * 64 * 2.0**-24
        assert apart[:, 2].max() < 1e-2


def test_dividing_at_the_corners_errs_as_the_proof_says() -> None:
    """Formulae (7) and (8), along an edge whose ends are 40 and 250 units below the light."""
    ends = np.array([[-30.0, 10, 260], [100, -90, 50]])
    corners = np.array([*ends, [0.0, 0, 100]])
    w0, w1 = 40.0, 250.0
    t = np.append(np.linspace(0, 1, 101), math.sqrt(w0) / (math.sqrt(w0) + math.sqrt(w1)))
    found = ways(corners, np.column_stack([1 - t, t, 0 * t]))
    error = (found.divided_early - found.exact)[:, :2]
    edge = (found.exact[0] - found.exact[100])[:2]
    share = t * (1 - t) * (w1 - w0) / ((1 - t) * w0 + t * w1)
    np.testing.assert_allclose(error, share[:, np.newaxis] * edge, atol=1e-6)
    largest = np.linalg.norm(error, axis=1)
    assert largest[-1] >= largest.max() - 1e-9
    assert largest[-1] == pytest.approx(edge_error(w0, w1) * np.linalg.norm(edge))


def test_four_times_as_far_displaces_an_edge_by_a_third() -> None:
    assert edge_error(1, 4) == pytest.approx(1 / 3) == edge_error(8, 2)
    assert edge_error(5, 5) == 0


def test_dividing_early_is_right_where_corners_are_equally_far() -> None:
    rng = np.random.default_rng(6)
    corners = rng.uniform(-200, 200, (500, 3, 3))
    corners[..., 2] = 30.0
    found = compare(corners, corners * 0, rng.dirichlet([1, 1, 1], 500), np.ones((500, 3)), DOWN)
    np.testing.assert_allclose(found.divided_early, found.exact, atol=1e-8)


def test_dividing_early_is_right_for_a_directional_light() -> None:
    parallel = np.eye(4)
    parallel[:3, :3] *= 1e-3
    rng = np.random.default_rng(8)
    corners = rng.uniform(-200, 200, (500, 3, 3))
    map_ = Map(parallel, np.eye(4), 1024, NEAR, FAR, 2 / 1024)
    found = compare(corners, corners * 0, rng.dirichlet([1, 1, 1], 500), np.ones((500, 3)), map_)
    np.testing.assert_allclose(found.divided_early[:, :2], found.exact[:, :2], atol=1e-9)


def test_linear_on_the_screen_is_right_where_the_camera_is_equally_far() -> None:
    rng = np.random.default_rng(9)
    corners, weights = rng.uniform(-150, 150, (500, 3, 3)), rng.dirichlet([1, 1, 1], 500)
    level = compare(corners, corners * 0, weights, np.full((500, 3), 7.0), DOWN)
    np.testing.assert_allclose(level.screen_linear, level.exact, atol=1e-8)
    leaning = compare(corners, corners * 0, weights, rng.uniform(1, 9, (500, 3)), DOWN)
    assert np.abs(leaning.screen_linear - leaning.exact)[:, :2].max() > 10


def test_offsets_across_the_map_are_exact_on_flat_faces() -> None:
    rng = np.random.default_rng(10)
    corners = rng.uniform(-150, 150, (500, 3, 3))
    flat = np.repeat(rng.normal(size=(500, 1, 3)), 3, axis=1)
    flat /= np.linalg.norm(flat, axis=2, keepdims=True)
    weights, map_ = rng.dirichlet([1, 1, 1], 500), shadow_map(np.array([0, 0, 300.0]), offset=5.0)
    found = compare(corners, flat, weights, np.ones((500, 3)), map_)
    apart = np.abs(found.offset_by_vertex - found.offset_by_pixel)
    np.testing.assert_allclose(apart[:, :2], 0, atol=1e-7)
    np.testing.assert_allclose(found.offset_by_vertex[:, 2], found.exact[:, 2], rtol=1e-9)
    moved = (found.offset_by_pixel - found.exact)[:, :2]
    sideways = flat[:, 0, :2] * map_.offset
    np.testing.assert_allclose(
        np.linalg.norm(moved, axis=1), np.linalg.norm(sideways, axis=1), atol=1e-7
    )


@pytest.mark.parametrize("sign", [1, -1])
def test_what_looks_straight_at_the_light_or_away_is_not_moved(sign: int) -> None:
    """Not towards it either: the foot of a shaded wall would come to lie in the wall."""
    corners = np.array([[0.0, 0, 100], [200, 0, 100], [0, 200, 100]])
    light, n = np.array([0, 0, 300.0]), np.broadcast_to([0.0, 0.0, 1.0], (3, 3, 3))
    found = ways(corners, np.eye(3), shadow_map(light, offset=5.0), n * sign)
    np.testing.assert_allclose(found.offset_by_vertex, found.exact, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.offset_by_pixel, found.exact, rtol=1e-9, atol=1e-9)


def test_points_in_the_map_are_before_the_light_and_inside_its_pyramid() -> None:
    middles = np.array([[0, 0, 0], [290, 0, 0], [310, 0, 0], [0, 0, 295], [0, 0, 400]], float)
    corners = np.repeat(middles[:, np.newaxis], 3, axis=1)
    weights = np.full((5, 3), 1 / 3)
    assert lit(corners, weights, DOWN).tolist() == [True, True, False, False, False]


def material(scene: Scene, view: Camera, folder: Path) -> Material:
    nothing_drawn = cast(Renderer, None)
    return Material("room", scene, view, SIZE, (), nothing_drawn, folder, lambda share, what: None)


ROOM = [*box((-400, -400, 0), (400, 400, 350), inward=True)]


def test_the_section_is_html_with_formulae_and_true_to_the_proof(tmp_path: Path) -> None:
    section = interpolation_answer.section(material(make_scene(ROOM, LIGHT), VIEW, tmp_path))
    html5lib.HTMLParser(strict=True).parseFragment(section.html)
    assert section.html.count("<math") > 40 and section.html.count("<svg") >= 2
    assert "$" not in section.html and "stand-in" not in section.html
    figures = section.figures
    assert 0 < figures["interpolation_float32_largest"] < 1e-2
    assert figures["interpolation_offset_largest"] < 1e-6  # all faces are flat
    assert figures["interpolation_early_largest"] > 1 < figures["interpolation_screen_largest"]


def test_without_a_light_one_beside_the_camera_stands_in(tmp_path: Path) -> None:
    section = interpolation_answer.section(material(make_scene(ROOM), VIEW, tmp_path))
    assert "stand-in" in section.html
    assert 0 < section.figures["interpolation_float32_largest"] < 1e-2


def test_a_camera_that_sees_nothing_is_told_so(tmp_path: Path) -> None:
    up = camera((0, 0, 60), pitch=-80)
    with pytest.raises(UsageError, match="sees no surface"):
        interpolation_answer.section(material(make_scene([floor()], LIGHT), up, tmp_path))
