"""Walking by the game's rules: falls, jumps, steps, slopes, pads, teleporters; and real levels."""

import math
from collections.abc import Iterator

import numpy as np
import pytest
from walk_levels import SIZE, Obstacles, block, compiled, hall, ramp

from followspot.assets.bsp_reader import read_bsp
from followspot.assets.locate import locate_level, search_path
from followspot.game import EYE_HEIGHT, GRAVITY, RUN_SPEED, STEP_HEIGHT
from followspot.levelbuilder.level import Level
from followspot.scene.collision import GAP, PATCH_TOLERANCE, STANDING, CollisionWorld
from followspot.scene.scene import spawn_cameras
from followspot.scene.search import BUILTIN
from followspot.scene.slide import Motion, step_slide
from followspot.scene.walker import (
    CROUCHED_EYE_HEIGHT,
    JUMP_SPEED,
    TELEPORT_SPEED,
    TICK,
    Walker,
    Wish,
)
from followspot.spaces import Vec3, vec3

FLOOR = 24 + GAP
"""Height of the origin of one who stands on a floor at 0."""
AHEAD = Wish(forward=1.0)


def standing(level: Level, x: float = 0.0, y: float = 0.0, z: float = 60.0) -> Walker:
    walker = Walker(CollisionWorld(compiled(level)))
    assert walker.place(vec3((x, y, z)), drop=True)
    assert walker.on_ground
    return walker


def ticks(walker: Walker, count: int, wish: Wish, yaw: float = 0.0) -> Iterator[Vec3]:
    """The positions after ticks one by one."""
    for _ in range(count):
        yaw = walker.step(TICK, wish, yaw)
        yield walker.position


def last(walker: Walker, count: int, wish: Wish, yaw: float = 0.0) -> Vec3:
    return list(ticks(walker, count, wish, yaw))[-1]


@pytest.fixture(scope="module")
def empty() -> CollisionWorld:
    return CollisionWorld(compiled(hall()))


def test_a_fall_is_a_parabola(empty: CollisionWorld) -> None:
    walker = Walker(empty)
    assert walker.place(vec3((0, 0, 900)))
    height = walker.position[2]
    for n in range(1, 125):
        walker.step(TICK, Wish(), 0)
        assert walker._now[2] == pytest.approx(height - GRAVITY * (n * TICK) ** 2 / 2)
        assert walker.velocity[2] == pytest.approx(-GRAVITY * n * TICK)
    last(walker, 125, Wish())
    assert walker.position[2] == pytest.approx(FLOOR, abs=GAP)
    assert walker.on_ground


def test_a_jump_is_as_high_as_its_energy(empty: CollisionWorld) -> None:
    walker = Walker(empty)
    assert walker.place(vec3((0, 0, 60)), drop=True)
    np.testing.assert_allclose(walker.position, (0, 0, FLOOR), atol=1e-9)
    start = walker.position[2]
    path = [p[2] - start for p in ticks(walker, 200, Wish(jump=True))]
    apex = JUMP_SPEED**2 / (2 * GRAVITY)
    assert apex - GRAVITY * TICK**2 / 8 <= max(path) <= apex + 1e-9
    assert path[-1] == pytest.approx(0, abs=GAP)  # held down, the key does nothing more
    walker.step(TICK, Wish(), 0)
    assert max(p[2] - start for p in ticks(walker, 50, Wish(jump=True))) > apex - 0.1


def test_running_keeps_to_the_full_speed(empty: CollisionWorld) -> None:
    """In all directions; and friction stops it again."""
    for wish in (AHEAD, Wish(side=-1), Wish(forward=1, side=1), Wish(forward=-1, side=0.5)):
        walker = Walker(empty)
        assert walker.place(vec3((0, 0, 60)), drop=True)
        last(walker, 100, wish, yaw=30)
        x, y, _ = walker.velocity
        way = math.radians(30) - math.atan2(wish.side, wish.forward)
        assert math.hypot(x, y) == pytest.approx(RUN_SPEED, rel=1e-6)
        assert x * math.cos(way) + y * math.sin(way) == pytest.approx(RUN_SPEED, rel=1e-6)
        last(walker, 100, Wish())
        assert not walker.velocity.any()
        assert walker.position[2] == pytest.approx(FLOOR, abs=GAP)


def test_half_a_wish_is_half_the_speed(empty: CollisionWorld) -> None:
    walker = Walker(empty)
    assert walker.place(vec3((0, 0, 60)), drop=True)
    last(walker, 100, Wish(forward=0.5))
    assert walker.velocity[0] == pytest.approx(RUN_SPEED / 2)


@pytest.mark.parametrize("angle", [5.0, 30.0, 60.0, 85.0])
def test_sliding_along_a_wall_keeps_the_speed_along_it(empty: CollisionWorld, angle: float) -> None:
    across, along = 400 * math.sin(math.radians(angle)), 400 * math.cos(math.radians(angle))
    start = Motion(vec3((SIZE - 20, 0, 300)), vec3((across, along, 0)))
    after = step_slide(empty, start, STANDING, 0.5, None, falls=False)
    assert after.velocity[1] == pytest.approx(along, rel=1e-12)
    assert after.velocity[0] == pytest.approx(0, abs=0.0011 * across)
    assert after.position[1] == pytest.approx(along * 0.5, rel=1e-9)
    assert after.position[0] == pytest.approx(SIZE - 15 - GAP, abs=0.3)


def test_a_corner_stops(empty: CollisionWorld) -> None:
    """Two walls leave the way along their crease, which is upright: no level one."""
    start = Motion(vec3((SIZE - 30, SIZE - 30, 300)), vec3((300, 300, 0)))
    after = step_slide(empty, start, STANDING, 0.5, None, falls=False)
    np.testing.assert_allclose(after.position[:2], SIZE - 15 - GAP, atol=0.3)
    assert np.linalg.norm(after.velocity) < 1


@pytest.mark.parametrize(("height", "climbs"), [(8, True), (18, True), (19, False), (40, False)])
def test_steps(height: float, climbs: bool) -> None:
    walker = standing(hall(block((100, -200, 0), (400, 200, height))))
    end = last(walker, 110, AHEAD)
    if climbs:
        assert end[0] > 150
        assert end[2] == pytest.approx(FLOOR + height, abs=GAP)
    else:
        assert end[0] == pytest.approx(100 - 15 - GAP, abs=GAP)
        assert end[2] == pytest.approx(FLOOR, abs=GAP)


def test_stairs_take_the_eye_along_smoothly() -> None:
    stairs = [block((100 + 24 * n, -200, 0), (400, 200, 16 * (n + 1))) for n in range(6)]
    walker = standing(hall(*stairs))
    eyes, feet = [walker.eye[2]], [walker.position[2]]
    for place in ticks(walker, 125, AHEAD):
        eyes.append(walker.eye[2])
        feet.append(place[2])
    assert feet[-1] == pytest.approx(FLOOR + 96, abs=GAP)
    assert max(np.diff(feet)) > 15
    assert max(np.diff(eyes)) < 5
    assert eyes[-1] - feet[-1] == pytest.approx(EYE_HEIGHT, abs=0.5)


@pytest.mark.parametrize(("normal_z", "climbs"), [(0.9, True), (0.71, True), (0.69, False)])
def test_slopes(normal_z: float, climbs: bool) -> None:
    """Flat enough, a slope is walked up at full speed; on a steeper one a run ends when its energy
    is spent, and leads back to the floor.
    """
    walker = standing(hall(ramp(normal_z)))
    path = np.array(list(ticks(walker, 500, AHEAD)))
    if climbs:
        speeds = np.linalg.norm(np.diff(path[70:75], axis=0), axis=1) / TICK
        np.testing.assert_allclose(speeds, RUN_SPEED, rtol=0.01)
        assert path[:, 0].max() > 264  # over the ramp's end
    else:
        assert path[:, 2].max() < FLOOR + STEP_HEIGHT + RUN_SPEED**2 / (2 * GRAVITY)
        assert last(walker, 100, Wish())[2] == pytest.approx(FLOOR, abs=GAP)


def test_standing_on_a_slope_is_standing_still() -> None:
    walker = standing(hall(ramp(0.75)), x=160, z=300)
    start = walker.position
    np.testing.assert_array_equal(last(walker, 200, Wish()), start)


def test_crouching() -> None:
    """Under a ceiling of 50 units one gets through and cannot stand up before the other side."""
    walker = standing(hall(block((100, -SIZE, 50), (200, SIZE, 300))))
    assert last(walker, 100, AHEAD)[0] == pytest.approx(100 - 15 - GAP, abs=GAP)
    low = Wish(forward=1, crouch=True)
    assert 100 < last(walker, 125, low)[0] < 200
    assert walker.velocity[0] == pytest.approx(RUN_SPEED / 4)
    assert walker.eye[2] - walker.position[2] == pytest.approx(CROUCHED_EYE_HEIGHT, abs=0.1)
    last(walker, 60, Wish())
    assert walker.eye[2] - walker.position[2] == pytest.approx(CROUCHED_EYE_HEIGHT, abs=0.1)
    last(walker, 160, AHEAD)
    last(walker, 60, Wish())
    assert walker.position[0] > 215
    assert walker.eye[2] - walker.position[2] == pytest.approx(EYE_HEIGHT, abs=0.1)


def test_a_jump_pad_throws_to_its_target() -> None:
    """From where the pad lets go it is as far to the highest point, in height, in time and to the
    side, as from the pad's middle to its target.
    """
    level = hall()
    pad, target = np.array((100.0, 0.0, 4.0)), np.array((300.0, 120.0, 404.0))
    level.entity("trigger_push", block((84, -16, 0), (116, 16, 8)), target="up")
    level.entity("target_position", origin=target.tolist(), targetname="up")
    walker = standing(level)
    flight = np.array([(*walker._now, *walker.velocity) for _ in ticks(walker, 190, AHEAD)])
    height, rising = flight[:, 2], flight[:, 5]
    time = math.sqrt(2 * (target - pad)[2] / GRAVITY)
    assert rising.max() == pytest.approx(GRAVITY * time)
    let_go, apex = int(np.flatnonzero(rising == rising.max())[-1]), int(height.argmax())
    assert (apex - let_go) * TICK == pytest.approx(time, abs=TICK)
    assert height[apex] - height[let_go] == pytest.approx((target - pad)[2], abs=0.01)
    assert flight[apex, 1] - flight[let_go, 1] == pytest.approx((target - pad)[1], rel=1e-3)
    # It touches the pad for a few ticks, and its feet must come off: so much higher it gets.
    assert 0 < height[apex] - target[2] < FLOOR + 8 + GRAVITY * time * TICK


def test_a_pad_without_anything_to_throw_at_does_nothing() -> None:
    level = hall()
    level.entity("trigger_push", block((50, -50, 0), (90, 50, 8)), target="nowhere")
    level.entity("trigger_push", block((90, -50, 0), (150, 50, 80)), target="low")
    level.entity("target_position", origin=(300, 0, 20), targetname="low")
    walker = standing(level)
    assert max(p[2] for p in ticks(walker, 100, AHEAD)) == pytest.approx(FLOOR, abs=GAP)
    assert walker.position[0] > 200


def test_a_teleporter() -> None:
    level = hall()
    level.entity("trigger_teleport", block((100, -50, 0), (120, 50, 80)), target="There")
    level.entity("misc_teleporter_dest", origin=(-300, 200, 24), targetname="there", angle=90)
    level.entity(
        "trigger_teleport", block((60, -50, 0), (70, 50, 80)), target="there", spawnflags=1
    )
    walker = standing(level)
    yaw = 0.0
    for _ in range(100):
        before = walker.position
        yaw = walker.step(TICK, Wish(forward=1), yaw)
        if yaw != 0:
            break
    assert before[0] + 15 == pytest.approx(100, abs=2 * RUN_SPEED * TICK)  # and not at 60
    assert yaw == 90
    np.testing.assert_allclose(walker.position, (-300, 200, 25))
    np.testing.assert_allclose(walker.velocity, (0, TELEPORT_SPEED, 0), atol=1e-9)
    walker.step(TICK / 2, Wish(), yaw)
    np.testing.assert_allclose(walker.eye, (-300, 200, 25 + EYE_HEIGHT))  # no flight between


@pytest.mark.parametrize("rate", [24, 30, 60, 75, 144, 500, 1000])
def test_the_frame_rate_makes_no_difference(rate: int) -> None:
    """The same wishes for the same times lead to the same place, but for rounding."""
    steps = [block((60 + 40 * n, -200, 0), (400, 200, 12 * (n + 1))) for n in range(4)]

    def walk(frames_a_second: int) -> tuple[Vec3, Vec3, Vec3]:
        walker = standing(hall(*steps, ramp(0.6, start=-300)))
        for wish, yaw in ((AHEAD, 0.0), (Wish(1, 0.3, jump=True), 20.0), (Wish(1, -1), 170.0)):
            for _ in range(frames_a_second):
                walker.step(1 / frames_a_second, wish, yaw)
        return walker.position, walker.velocity, walker.eye

    # A change of wish falls into one tick or the next; here all do on the same one (125 a second).
    for found, expected in zip(walk(rate), walk(125), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-6)


def test_positions_between_ticks_are_between_them(empty: CollisionWorld) -> None:
    walker = Walker(empty)
    assert walker.place(vec3((0, 0, 60)), drop=True)
    last(walker, 100, AHEAD)
    path = []
    for _ in range(40):
        walker.step(TICK / 4, AHEAD, 0)
        path.append(walker.position[0])
    np.testing.assert_allclose(np.diff(path), RUN_SPEED * TICK / 4, rtol=1e-6)


def test_a_long_stop_is_not_made_up_for(empty: CollisionWorld) -> None:
    walker = Walker(empty)
    assert walker.place(vec3((0, 0, 60)), drop=True)
    walker.step(60.0, AHEAD, 0)
    assert walker.position[0] < 0.25 * RUN_SPEED


def test_being_put_into_a_wall() -> None:
    """It is put beside it; where there is no room near, it stays as it was."""
    walker = standing(hall(block((100, -50, 0), (140, 50, 200))))
    assert walker.place(vec3((110, 0, 100)))
    assert not walker._world.trace(walker.position, walker.position).starts_solid
    assert np.linalg.norm(walker.eye - (110, 0, 100)) <= 32
    eye = walker.eye
    assert not walker.place(vec3((0, 0, -400)))
    np.testing.assert_array_equal(walker.eye, eye)


LEVELS = ("aggressor", "ctf_inyard", "suspended", "am_thornish", "oa_thor")
MOVES = 500
"""Random moves in every level."""


@pytest.mark.parametrize(
    "name", ["courtyard", *(pytest.param(n, marks=pytest.mark.openarena) for n in LEVELS)]
)
def test_random_walks_never_end_in_walls(name: str) -> None:
    """From all spawn points by turns: nobody gets into brushes, curves, or out of the level."""
    archive, entry = locate_level(name, [*search_path([]), BUILTIN / "courtyard.pk3"])
    with archive:
        bsp = read_bsp(archive.read(entry), entry)
    walker, obstacles = Walker(CollisionWorld(bsp)), Obstacles(bsp)
    spawns = [c for name, c in spawn_cameras(bsp).items() if name.startswith("spawn")]
    rng = np.random.default_rng(7)
    moves = MOVES // len(spawns) + 1
    travelled = 0.0
    for spawn in spawns:
        assert walker.place(spawn.position, drop=True), spawn
        yaw = spawn.yaw
        for _ in range(moves):
            wish = Wish(*rng.uniform(-1, 1, 2), *(rng.random(2) < (0.4, 0.15)))
            yaw = yaw if rng.random() < 0.3 else rng.uniform(-180, 180)
            for _ in range(int(rng.integers(3, 20))):
                before = walker.position
                yaw = walker.step(1 / 30, wish, yaw)
                travelled += float(np.linalg.norm(walker.position - before))
            place, box = walker._now, walker._box
            assert not obstacles.brush_in(place, box), (spawn, place)
            assert not obstacles.curve_in(place, box, PATCH_TOLERANCE + 0.1), (spawn, place)
            assert not obstacles.is_outside(place), (spawn, place)
    assert travelled > 20 * MOVES
