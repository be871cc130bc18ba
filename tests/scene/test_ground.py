"""Where the floor is: of triangles, of the level's walls, and of both."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.assets.shader_values import BlendFactor
from followspot.scene.ground import Ground
from followspot.scene.load import load
from followspot.scene.material import Material
from synthetic import box, floor, make_scene, of, quad

GLASS = Material("glass", blend=(BlendFactor.ONE, BlendFactor.ONE))


def test_the_highest_floor_below_counts() -> None:
    pieces = [floor(100, z=-8), *box((-10, -10, 0), (10, 10, 20)), *of(GLASS, floor(90, z=4))]
    ground = Ground(make_scene(pieces).level)
    points = np.array([(0, 0, 50), (0, 0, 10), (50, 3, 5), (500, 0, 7), (0, 0, -9), (0, 0, 20)])
    found = ground.below(points.astype(np.float64))
    np.testing.assert_allclose(found, [20, 0, -8, 7, -9, 20])


def test_a_floor_reaches_to_its_very_edge() -> None:
    ground = Ground(make_scene([*box((-8, -8, 0), (8, 8, 16))]).level)
    points = np.array([(x, y, z) for x in (-8, 0, 8) for y in (-8, 0, 8) for z in (16.0, 40)])
    np.testing.assert_allclose(ground.below(points), 16)


@given(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9), st.floats(-2, 2), st.floats(-2, 2))
def test_height_on_a_slope(u: float, v: float, a: float, b: float) -> None:
    """On the plane z = a x + b y."""
    slope = quad((0, 0, 0), (100, 0, 100 * a), (0, 100, 100 * b))
    ground = Ground(make_scene([slope]).level)
    point = np.array([[100 * u, 100 * v, 500.0]])
    np.testing.assert_allclose(ground.below(point), [100 * (a * u + b * v)], atol=1e-4)


def test_a_wall_is_no_floor_and_nothing_is_found_in_the_void() -> None:
    wall = quad((0, 0, 0), (0, 50, 0), (1, 0, 50))
    ground = Ground(make_scene([wall]).level)
    np.testing.assert_array_equal(ground.below(np.array([[0.0, 0.0, 40.0]])), [40.0])
    empty = Ground(make_scene([]).level)
    np.testing.assert_array_equal(empty.below(np.array([[1.0, 2.0, 3.0]])), [3.0])


def test_floors_of_the_courtyard() -> None:
    """Its cameras stand at eye height or so."""
    scene = load("courtyard")
    with scene.archive:
        ground = Ground(scene.level)
        eyes = np.stack([scene.cameras[n].position for n in ("arcade", "cloister", "gate")])
        height = eyes[:, 2] - ground.below(eyes)
    assert ((height > 30) & (height < 110)).all(), height


@pytest.mark.parametrize("count", [0, 1, 600])
def test_any_number_of_points(count: int) -> None:
    ground = Ground(make_scene([floor(100)]).level)
    points = np.tile([[1.0, 2.0, 9.0]], (count, 1))
    np.testing.assert_array_equal(ground.below(points), np.zeros(count))
