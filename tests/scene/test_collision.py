"""How far boxes get: against brushes and patches, exactly."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from walk_levels import CLIP, HEIGHT, MIST, SIZE, STONE, block, compiled, hall, ramp

from followspot.arrays import Floats
from followspot.assets.surface_flags import Contents, Surface
from followspot.levelbuilder.material import Material
from followspot.levelbuilder.patches import lathe
from followspot.scene import solids
from followspot.scene.collision import (
    GAP,
    PATCH_TOLERANCE,
    STANDING,
    Box,
    CollisionWorld,
    Probe,
)
from followspot.spaces import Vec3, vec3
from synthetic import open_bsp

AIR = vec3((0, 0, 500))
POINT = Box(vec3((0, 0, 0)), vec3((0, 0, 0)))


@pytest.fixture(scope="module")
def empty_hall() -> CollisionWorld:
    return CollisionWorld(compiled(hall()))


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [-1, 1])
def test_walls_stop_a_box_a_gap_before_it_touches(
    empty_hall: CollisionWorld, axis: int, sign: int
) -> None:
    way = np.zeros(3)
    way[axis] = sign * 2000.0
    found = empty_hall.trace(AIR, AIR + way)
    wall = np.array([[-SIZE, -SIZE, 0], [SIZE, SIZE, HEIGHT]])[(sign + 1) // 2, axis]
    expected = AIR.copy()
    expected[axis] = wall - (STANDING.maxs if sign > 0 else STANDING.mins)[axis] - sign * GAP
    np.testing.assert_allclose(found.end, expected, atol=1e-9)
    assert found.fraction == pytest.approx(abs(expected[axis] - AIR[axis]) / 2000)
    assert found.normal is not None
    np.testing.assert_array_equal(found.normal, -np.sign(way))
    assert not found.starts_solid


def test_the_way_is_free_where_nothing_is(empty_hall: CollisionWorld) -> None:
    found = empty_hall.trace(AIR, AIR + np.array((100, 50, -20)))
    assert found.fraction == 1
    assert found.normal is None
    np.testing.assert_array_equal(found.end, AIR + np.array((100, 50, -20)))


def test_a_slope_stops_the_corner_that_leads() -> None:
    world = CollisionWorld(compiled(hall(ramp(0.8))))
    found = world.trace(vec3((120, 0, 300)), vec3((120, 0, -300)))
    assert found.normal is not None
    np.testing.assert_allclose(found.normal, (-0.6, 0, 0.8), atol=1e-6)
    corner = found.end + np.array((15, 0, -24))  # the slope is z = (x - 64) 0.6 / 0.8
    height = (corner - (64, 0, 0)) @ (-0.6, 0, 0.8)
    assert height == pytest.approx(GAP, abs=1e-4)


@pytest.mark.parametrize(
    ("place", "end", "all_solid", "fraction"),
    [
        ((-56, 0, 300), (-60, 0, 300), True, 0.0),  # from a block further into it
        ((-56, 0, 300), (-200, 0, 300), False, 1.0),  # and out of it
        ((-56, 0, 300), (-56, 0, 300), True, 0.0),
        ((-200, 0, 300), (-200, 0, 300), False, 1.0),
    ],
)
def test_starting_inside(
    place: tuple[float, ...], end: tuple[float, ...], all_solid: bool, fraction: float
) -> None:
    world = CollisionWorld(compiled(hall(block((-64, -64, 200), (64, 64, 400)))))
    found = world.trace(vec3(place), vec3(end))
    assert found.starts_solid == (place[0] == -56)
    assert (found.all_solid, found.fraction) == (all_solid, fraction)
    assert world.is_free(vec3(place)) == (not found.starts_solid)


def test_out_of_one_solid_into_the_next() -> None:
    blocks = block((-64, -64, 200), (0, 64, 400)), block((200, -64, 200), (300, 64, 400))
    world = CollisionWorld(compiled(hall(*blocks)))
    found = world.trace(vec3((-5, 0, 300)), vec3((250, 0, 300)))
    assert found.starts_solid
    assert not found.all_solid
    assert found.end[0] == pytest.approx(200 - 15 - GAP)


def test_what_stops_players() -> None:
    """Clip brushes and doors where they stand do; mist, triggers and the like do not."""
    level = hall(
        block((100, 0, 0), (110, 100, 200), CLIP),
        block((100, 100, 0), (110, 200, 200), MIST),
    )
    level.entity("func_door", block((100, -300, -50), (110, -200, 150)), origin=(0, 100, 50))
    level.entity("trigger_multiple", block((100, -300, 0), (110, -200, 200)))
    level.entity("func_illusionary", block((100, -400, 0), (110, -310, 200)))
    world = CollisionWorld(compiled(level))

    def stop(y: float) -> float:
        return float(world.trace(vec3((0, y, 60)), vec3((300, y, 60))).end[0])

    before = pytest.approx(100 - 15 - GAP)
    assert stop(50) == before
    assert stop(-150) == before  # the door, moved by its origin
    assert [stop(150), stop(-250), stop(-355)] == [300, 300, 300]


HIDDEN = Material("hidden", surface=Surface.NODRAW, contents=Contents.PLAYERCLIP, opacity=0.0)


@pytest.mark.parametrize("material", [STONE, HIDDEN])
@pytest.mark.parametrize("box", [STANDING, POINT])
def test_a_round_column_is_not_entered(material: Material, box: Box) -> None:
    """From all around, and no farther off than the curve's triangles make it."""
    radius = 64.0
    profile = np.array([(radius, 0.0), (radius, 100.0), (radius, 200.0)])
    world = CollisionWorld(compiled(hall(lathe(material, (0, 0, 0), profile))))
    for angle in np.radians(np.arange(0, 360, 7.3)):
        away = np.array([np.cos(angle), np.sin(angle), 0.0])
        end = world.trace(vec3(300 * away + (0, 0, 100)), vec3((0, 0, 100)), box).end
        gap = np.maximum(np.abs(end[:2]) - box.maxs[:2], 0)  # from the axis to the box
        assert radius - PATCH_TOLERANCE <= np.hypot(*gap) <= radius * 1.003 + 2 * GAP


coordinates = st.floats(-50, 50)
points = st.tuples(coordinates, coordinates, coordinates).map(vec3)


def _part_inside(corners: Floats, mins: Vec3, maxs: Vec3) -> bool:
    """Whether a triangle has points in a box: it is cut off at the six sides one by one."""
    polygon = list(corners)
    for axis in range(3):
        for sign, limit in ((1, maxs[axis]), (-1, -mins[axis])):
            heights = [sign * p[axis] - limit for p in polygon]
            kept = []
            for i, (p, h) in enumerate(zip(polygon, heights, strict=True)):
                before, other = polygon[i - 1], heights[i - 1]
                if (h <= 0) != (other <= 0):
                    kept.append(before + (p - before) * (other / (other - h)))
                if h <= 0:
                    kept.append(p)
            polygon = kept
    return bool(polygon)


def _grown(box: Box, by: float) -> Box:
    return Box(vec3(box.mins - by), vec3(box.maxs + by))


@given(points, points, points, points, points)
def test_boxes_against_triangles(a: Vec3, b: Vec3, c: Vec3, start: Vec3, end: Vec3) -> None:
    """Compared with cutting the triangle: overlap, no entry on the way, and no stop too early."""
    corners = np.stack([a, b, c])
    longest = max(np.linalg.norm(edge) for edge in (b - a, c - b, a - c))
    if np.linalg.norm(np.cross(b - a, c - a)) < 1e-2 * longest + 1e-2:
        return
    probe = Probe(solids.of_triangles(corners[np.newaxis]))
    box = Box(vec3((-7, -9, -11)), vec3((7, 5, 20)))

    def overlaps(at: Vec3, grown: float) -> bool:
        larger = _grown(box, grown)
        return _part_inside(corners, at + larger.mins, at + larger.maxs)

    found = probe.trace(start, end, box)
    if overlaps(start, -1e-3):
        assert found.starts_solid
    if not overlaps(start, 1e-3):
        assert not found.starts_solid
        for fraction in np.linspace(0, found.fraction, 9):
            assert not overlaps(start + fraction * (end - start), -1e-3)
        if found.fraction < 1:
            assert overlaps(found.end, GAP + 1e-3)


def test_answers_do_not_depend_on_earlier_questions() -> None:
    bsp = compiled(hall(ramp(0.8), block((-200, -100, 0), (-100, 100, 80))))
    one = CollisionWorld(bsp)
    rng = np.random.default_rng(3)
    for _ in range(200):
        start, end = rng.uniform((-400, -400, 30), (400, 400, 300), (2, 3))
        mine, fresh = one.trace(start, end), CollisionWorld(bsp).trace(start, end)
        assert (mine.fraction, mine.starts_solid) == (fresh.fraction, fresh.starts_solid)
        np.testing.assert_array_equal(mine.end, fresh.end)


def test_the_nearest_free_place() -> None:
    world = CollisionWorld(compiled(hall()))
    np.testing.assert_array_equal(world.nearest_free(AIR), AIR)
    low = world.nearest_free(vec3((0, 0, 10)))
    assert low is not None
    np.testing.assert_allclose(low, (0, 0, 26))  # 14 too low: the next distance of the star
    assert world.nearest_free(vec3((0, 0, -300))) is None
    assert world.nearest_free(vec3((9000, 0, 0))) is None  # free of walls, but outside


def test_a_level_without_walls() -> None:
    assert CollisionWorld(open_bsp()).trace(AIR, -AIR).fraction == 1
