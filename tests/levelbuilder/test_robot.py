"""The character that the program brings along: whole, reproducible, and its feet do not slide."""

import io
import zipfile
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from vgio.quake2.md2 import Md2

import followspot.builtin
from followspot.assets.md2 import FRAMES_PER_SECOND, Md2Model, read_md2
from followspot.builtin import build_robot
from followspot.builtin.robot_animation import (
    ANIMATIONS,
    FPS,
    RUN_SPEED,
    WALK_SPEED,
)
from followspot.builtin.robot_atlas import HEIGHT, WIDTH, bake, pack
from followspot.builtin.robot_model import robot_parts
from followspot.builtin.robot_skeleton import ANKLE, SIDES, place_bones
from followspot.game import FLOOR_BELOW_PLAYER, GRAVITY
from model_fixtures import facing

PK3 = Path(followspot.builtin.__file__).with_name("robot.pk3")
FLOOR = -FLOOR_BELOW_PLAYER


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    with zipfile.ZipFile(PK3) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


@pytest.fixture(scope="module")
def robot(files: dict[str, bytes]) -> Md2Model:
    return read_md2(files["models/robot/robot.md2"], "robot.md2")


def frames(robot: Md2Model, name: str) -> NDArray[np.float32]:
    """(frames, vertices, 3) of an animation."""
    animation = robot.animations[name]
    return robot.positions[animation.first : animation.first + animation.count]


def picture(data: bytes) -> NDArray[np.uint8]:
    return np.asarray(Image.open(io.BytesIO(data)))


def test_the_pk3_is_what_the_scripts_make(files: dict[str, bytes]) -> None:
    made = build_robot.robot_files()
    assert made.keys() == files.keys() == {"models/robot/robot.md2", "models/robot/skin.jpg"}
    assert made["models/robot/robot.md2"] == files["models/robot/robot.md2"]
    ours, theirs = (picture(f["models/robot/skin.jpg"]).astype(int) for f in (made, files))
    assert np.abs(ours - theirs).max() <= 8  # encoders differ from machine to machine


def test_it_is_small_and_wears_its_skin(files: dict[str, bytes], robot: Md2Model) -> None:
    assert PK3.stat().st_size < 400_000
    assert robot.skins == ("models/robot/skin.jpg",)
    assert picture(files[robot.skins[0]]).shape == (HEIGHT, WIDTH, 3)
    assert robot.texcoords.min() > 0 and robot.texcoords.max() < 1
    assert 600 <= len(robot.indices) // 3 <= 1400


def test_vgio_finds_the_same_corners_in_every_frame(robot: Md2Model, tmp_path: Path) -> None:
    with zipfile.ZipFile(PK3) as archive:
        path = archive.extract("models/robot/robot.md2", tmp_path)
    with closing(Md2.open(path)) as theirs:
        assert robot.frame_names == tuple(frame.name for frame in theirs.frames)
        corners = np.array([triangle.vertexes for triangle in theirs.triangles]).ravel()
        for positions, frame in zip(robot.positions, theirs.frames, strict=True):
            raw = np.array([v[:3] for v in frame.vertexes])
            expected = (raw * frame.scale + frame.translate)[corners]
            np.testing.assert_allclose(positions[robot.indices], expected, atol=1e-4)
        fans = [[v.vertex for v in command.vertexes] for command in theirs.gl_commands]
        drawn = [t for f in fans for t in zip(f[:1] * len(f), f[1:], f[2:], strict=False)]
        assert drawn == [tuple(corner) for corner in corners.reshape(-1, 3).tolist()]


def test_its_animations_are_those_promised(robot: Md2Model) -> None:
    assert FPS == FRAMES_PER_SECOND
    counts = {name: animation.count for name, animation in robot.animations.items()}
    assert counts == {"stand": 20, "run": 8, "walk": 12, "wave": 20, "jump": 16}
    assert list(counts) == list(ANIMATIONS)


@pytest.mark.parametrize(("name", "speed"), [("run", RUN_SPEED), ("walk", WALK_SPEED)])
def test_a_foot_on_the_ground_goes_straight_back(robot: Md2Model, name: str, speed: float) -> None:
    """Every vertex that is down in two frames running has moved back by what the body goes on."""
    now = frames(robot, name)
    then = np.roll(now, -1, axis=0)
    down = (now[..., 2] < FLOOR + 0.5) & (then[..., 2] < FLOOR + 0.5)
    moved = (then - now)[down] * FPS
    assert down.any(axis=1).sum() >= 0.75 * len(now)
    tolerance = 1.5 * np.ptp(now[..., 0]) / 255  # the grid's step, and the sole's roll
    assert np.abs(moved[:, 0] + speed).max() < tolerance * FPS
    assert np.abs(moved[:, 1]).max() < 0.02 * FPS
    assert moved[:, 0].mean() == pytest.approx(-speed, rel=0.005)


def test_it_stands_on_the_floor_but_for_its_leap(robot: Md2Model) -> None:
    for name in ANIMATIONS:
        lowest = frames(robot, name)[..., 2].min(axis=1) - FLOOR
        if name == "jump":
            airborne = lowest > 0.5
            start, flight = int(np.argmax(airborne)) - 1, int(airborne.sum()) + 1
            assert airborne[start + 1 : start + flight].all()
            apex = GRAVITY / 8 * (flight / FPS) ** 2
            assert apex <= lowest.max() < apex + 6
        else:
            assert np.abs(lowest).max() < 0.5, name


def test_it_has_a_players_size(robot: Md2Model) -> None:
    stand = frames(robot, "stand")
    height = np.ptp(stand[..., 2], axis=1)
    assert height.min() > 55 and height.max() < 57.5
    assert np.abs(stand[..., :2]).max() < 18


def test_a_loop_has_no_seam(robot: Md2Model) -> None:
    for name in ANIMATIONS:
        steps = np.diff(frames(robot, name), axis=0, append=frames(robot, name)[:1])
        longest = np.linalg.norm(steps, axis=2).max(axis=1)
        assert longest[-1] <= longest[:-1].max() + 0.5, name


def test_animations_start_as_it_stands() -> None:
    """So that one can follow the other without a jerk; a gait is begun from anywhere."""
    poses = {name: make() for name, make in ANIMATIONS.items()}
    for name in ("wave", "jump"):
        for part in ("hips", "feet", "shoulders", "elbows"):
            ours, theirs = getattr(poses[name], part)[0], getattr(poses["stand"], part)[0]
            assert np.abs(ours - theirs).max() < 4, (name, part)


@pytest.mark.parametrize("name", list(ANIMATIONS))
def test_bones_are_rigid_and_legs_reach_the_ground(name: str) -> None:
    bones = place_bones(ANIMATIONS[name]())
    for side, sign in SIDES.items():
        end = bones[f"shin.{side}"].points(ANKLE[np.newaxis] * [1, sign, 1])[:, 0]
        np.testing.assert_allclose(end, bones[f"foot.{side}"].at, atol=1e-6)
    for bone, placed in bones.items():
        if bone != "eyes":
            turned = placed.linear @ placed.linear.transpose(0, 2, 1)
            np.testing.assert_allclose(turned, np.broadcast_to(np.eye(3), turned.shape), atol=1e-9)
            assert (np.linalg.det(placed.linear) > 0).all()


def test_triangles_face_the_way_of_their_normals(robot: Md2Model) -> None:
    for positions, normals in zip(robot.positions, robot.normals, strict=True):
        assert (facing(positions, normals, robot.indices) > 0).mean() > 0.985
    for part in robot_parts():
        for shape in (part.shape, part.shape.mirrored()):
            assert (facing(shape.points, shape.normals, shape.triangles) > 0).all(), part.name


def test_islands_of_the_skin_do_not_touch() -> None:
    parts = robot_parts()
    texels = pack(parts)
    owner = np.full((HEIGHT, WIDTH), -1)
    start = count = 0
    for part in parts:
        own = texels[start : start + len(part.shape.st)]
        for island in np.unique(part.shape.islands):
            low, high = (f(own[part.shape.islands == island], axis=0) for f in (np.min, np.max))
            box = owner[low[1] - 1 : high[1] + 2, low[0] - 1 : high[0] + 2]
            assert (box == -1).all() and low.min() > 0
            owner[low[1] : high[1] + 1, low[0] : high[0] + 1] = count
            count += 1
        start += len(part.shape.st)
    surface = bake(parts, texels)
    start = 0
    for number, part in enumerate(parts):
        corners = texels[start + part.shape.st_triangles.ravel()]
        assert (surface.part[corners[:, 1], corners[:, 0]] == number).all(), part.name
        places = surface.place[corners[:, 1], corners[:, 0]]
        off = np.abs(places - part.shape.points[part.shape.triangles.ravel()]).max(axis=1)
        assert np.median(off) < 1e-6, part.name  # at a pole many places share a texel's row
        start += len(part.shape.st)
    assert np.isfinite(surface.place).all() and np.isfinite(surface.edge).all()
