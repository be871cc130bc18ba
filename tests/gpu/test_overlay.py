"""What is drawn over pictures, pictures in parts, and culling from another camera."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gl_calls import DebugLog
from numpy.typing import NDArray
from test_frame import no_new_gl_objects

import synthetic
from conftest import Draw
from figures import figure
from followspot.errors import UsageError
from followspot.gpu.targets import Part
from followspot.passes.frame import FrameInput
from followspot.passes.overlay import Overlay
from followspot.passes.view import View
from followspot.present import still
from followspot.present.renderer import Renderer
from followspot.scene.camera import Camera
from followspot.scene.character import Character, Crowd
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.scene.walk import standing
from synthetic import WHITE_SKY, box, camera, floor, looking, make_scene, point, quad, spot

pytestmark = pytest.mark.gl

ALL = frozenset(Overlay)
STAGES = [view for view in View if view is not View.SHADOW_MAP]


@pytest.fixture
def yard() -> Scene:
    """A floor with a box on it, a wall before a second box, under a lamp."""
    pieces = [floor(300), *box((40, -30, 0), (90, 30, 50)), *box((200, -100, 0), (240, -50, 40))]
    pieces.append(quad((150, -80, 30), (0, -60, 0), (0, 0, 60)))
    lamp = spot((0, 0, 200), (60, 0, 0), 40, 5e4)
    return make_scene(pieces, lamp, point((0, 100, 90)), sky=WHITE_SKY, environment_constant=0.3)


def one_that_bobs() -> Crowd:
    """One character that moves up and down above a place."""
    body = figure([box((-5, -5, -5), (5, 5, 5))])
    return Crowd([Character(body, standing((40, 10, 12), 0), bob=4, bob_rate=3)])


def frame_of(scene: Scene, view: Camera, stage: View = View.FINAL, **fields: Any) -> FrameInput:
    return FrameInput(scene, view, Settings(exposure=1.0), 1.0, stage, **fields)


def shown(renderer: Renderer, frame: FrameInput, part: Part | None = None) -> NDArray[np.uint8]:
    renderer.open(frame.scene)
    renderer.draw(frame, part=part)
    return renderer.target().read()


def distance_to_lines(
    view: Camera, ends: NDArray[np.float64], size: tuple[int, int] = synthetic.SIZE
) -> NDArray[np.float64]:
    """(h, w) pixels from each pixel to the nearest of lines (n, 2, 3) before the camera."""
    ends = ends[(ends[:, 0] != ends[:, 1]).any(axis=1)]
    towards = synthetic.rays(view, size)
    right = towards[0, 1] - towards[0, 0]
    down = towards[1, 0] - towards[0, 0]
    ahead = np.cross(right, down) / np.linalg.norm(np.cross(right, down))
    to_corner = towards[0, 0]
    matrix = np.linalg.inv(np.stack([right, down, to_corner], axis=1))
    place = (ends - view.position) @ matrix.T
    assert (((ends - view.position) @ ahead) > 0).all()
    xy = place[..., :2] / place[..., 2:]
    rows, columns = np.indices(size[::-1])
    pixels = np.stack([columns, rows], axis=-1)[:, :, np.newaxis]
    way = xy[:, 1] - xy[:, 0]
    share = np.einsum("hwnk,nk->hwn", pixels - xy[:, 0], way) / (way**2).sum(axis=1)
    nearest = xy[:, 0] + np.clip(share, 0, 1)[..., np.newaxis] * way
    return np.asarray(np.linalg.norm(pixels - nearest, axis=-1).min(axis=-1))


def edges(mins: Any, maxs: Any) -> NDArray[np.float64]:
    """(12, 2, 3) of a box."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
    pairs = [(a, b) for a in corners for b in corners if (b - a).sum() == 1 and (b >= a).all()]
    low, high = np.asarray(mins), np.asarray(maxs)
    return np.array([[low + (high - low) * end for end in pair] for pair in pairs], np.float64)


def test_lines_lie_where_the_boxes_edges_are_seen(renderer: Renderer) -> None:
    """Every visible edge is red all along, and nothing else changes."""
    low, high = (60, -20, 10), (100, 30, 40)
    scene = make_scene(box(low, high), sky=WHITE_SKY, environment_constant=0.5)
    view = looking((0, 60, 80), (80, 0, 20))
    before = shown(renderer, frame_of(scene, view)).astype(int)
    after = shown(renderer, frame_of(scene, view, overlays=frozenset({Overlay.BOXES}))).astype(int)
    distance = distance_to_lines(view, edges(low, high))
    changed = (before != after).any(axis=2)
    assert not changed[distance > 1.5].any()
    from_here = np.asarray(edges(low, high))
    hidden_corner = np.array([high[0], low[1], low[2]])  # farthest from the eye
    in_sight = from_here[~(from_here == hidden_corner).all(axis=2).any(axis=1)]
    assert len(in_sight) == 9
    near = distance_to_lines(view, in_sight) < 0.4
    redder = (after - before)[..., 1:].sum(axis=2) < -60
    assert redder[near].mean() > 0.97


def test_what_is_behind_something_is_fainter(renderer: Renderer, yard: Scene) -> None:
    view = looking((60, -80, 30), (220, -75, 20))
    behind = edges((200, -100, 0), (240, -50, 40))
    without_wall = [floor(300), *box((200, -100, 0), (240, -50, 40))]
    seen = make_scene(without_wall, *yard.lights, sky=WHITE_SKY, environment_constant=0.3)
    strength = []
    for scene in (yard, seen):
        before = shown(renderer, frame_of(scene, view)).astype(int)
        after = shown(renderer, frame_of(scene, view, overlays=ALL)).astype(int)
        on_line = distance_to_lines(view, behind[behind[:, :, 0].max(axis=1) == 200]) < 0.4
        strength.append(np.abs(after - before)[on_line].max(axis=1).mean())
    assert 0 < strength[0] < strength[1] / 2.5


def test_boxes_of_characters_go_with_them(renderer: Renderer) -> None:
    crowd = one_that_bobs()
    scene = make_scene([floor(300)], crowd=crowd, sky=WHITE_SKY, environment_constant=0.3)
    view = looking((-100, 0, 120), (30, 0, 0))
    for time in (0.0, 0.5):
        before = shown(renderer, frame_of(scene, view, time=time))
        frame = frame_of(scene, view, time=time, overlays=frozenset({Overlay.BOXES}))
        changed = (shown(renderer, frame) != before).any(axis=2)
        x, y, z, _ = crowd.places(time)[0]
        radius = crowd.radius[0]
        place = np.array([x, y, z])
        body = edges(place - radius, place + radius)
        visible = distance_to_lines(view, body[body[..., 2].min(axis=1) > 0])
        assert changed[visible < 0.4].mean() > 0.97
        below_the_floors_own = np.s_[32:]
        elsewhere = distance_to_lines(view, body)[below_the_floors_own] > 1.5
        assert not changed[below_the_floors_own][elsewhere].any()


@pytest.mark.parametrize("stage", [View.FINAL, View.NORMALS])
def test_overlays_are_in_no_linear_picture_and_leave_no_trace(
    renderer: Renderer, draw: Draw, yard: Scene, stage: View
) -> None:
    view = camera((-150, 40, 120), -10, 30)
    frame = frame_of(yard, view, stage)
    plain = shown(renderer, frame)
    values = draw(yard, view, stage)
    assert (shown(renderer, replace(frame, overlays=ALL)) != plain).any()
    renderer.draw(replace(frame, overlays=ALL), linear=True)
    np.testing.assert_array_equal(renderer.target(linear=True).read(), values)
    np.testing.assert_array_equal(shown(renderer, frame), plain)


def test_overlays_create_nothing_in_a_frame_and_raise_no_message(
    renderer: Renderer, yard: Scene
) -> None:
    view, other = camera((-150, 40, 120), -10, 30), camera((-100, 0, 60))
    frame = frame_of(yard, view, overlays=ALL, culled_from=other)
    renderer.open(yard)
    pipeline = renderer.pipeline
    with DebugLog() as log:
        renderer.draw(frame)
        with no_new_gl_objects():
            pipeline.draw(replace(frame, overlays=frozenset({Overlay.SCENE})), renderer.target())
            pipeline.draw(frame, renderer.target(), part=(10, 10, 50, 30))
        assert log.messages() == []


def test_refused_overlays(renderer: Renderer, yard: Scene) -> None:
    view = camera((0, 0, 50))
    with pytest.raises(UsageError, match="no overlay is named 'cone'; there are boxes, scene, "):
        renderer.render(yard, view, overlays=["cone"])
    with pytest.raises(UsageError, match="displayed colours"):
        renderer.render(yard, view, overlays=["boxes"], linear=True)
    with pytest.raises(UsageError, match="camera-frustum needs"):
        renderer.render(yard, view, overlays=["camera-frustum"])


def test_another_camera_decides_what_is_drawn(renderer: Renderer, yard: Scene) -> None:
    """What it does not see is absent; the shadow map is the one that it gets."""
    inside = camera((60, 0, 100), yaw=180, pitch=30)  # the boxes are behind it
    outside = camera((-250, 0, 250), pitch=30)
    renderer.open(yard)
    renderer.draw(frame_of(yard, inside))
    pipeline = renderer.pipeline
    tiles = pipeline.shadow.tiles
    of_inside = renderer.draw(frame_of(yard, inside)).triangles
    detached = frame_of(yard, outside, View.NORMALS, culled_from=inside)
    assert renderer.draw(detached).triangles == of_inside == 2
    for kept, tile in zip(pipeline.shadow.tiles, tiles, strict=True):
        np.testing.assert_array_equal(kept.frustum.clip_from_world, tile.frustum.clip_from_world)
    only_floor = make_scene([floor(300)], *yard.lights, sky=WHITE_SKY)
    picture = shown(renderer, detached)
    np.testing.assert_array_equal(
        picture, shown(renderer, frame_of(only_floor, outside, View.NORMALS))
    )
    same = shown(renderer, frame_of(yard, outside, culled_from=outside))
    np.testing.assert_array_equal(same, shown(renderer, frame_of(yard, outside)))


@pytest.mark.parametrize("stage", STAGES)
def test_a_part_is_exactly_that_part_of_the_whole(
    renderer: Renderer, yard: Scene, stage: View
) -> None:
    view = camera((-150, 40, 120), -10, 30)
    width, height = renderer.size
    frames = frame_of(yard, view), frame_of(yard, view, stage, overlays=ALL)
    whole = [shown(renderer, frame) for frame in frames]
    cut = 57
    shown(renderer, frames[0], part=(0, 0, cut, height))
    split = shown(renderer, frames[1], part=(cut, 0, width - cut, height))
    np.testing.assert_array_equal(split[:, :cut], whole[0][:, :cut])
    np.testing.assert_array_equal(split[:, cut:], whole[1][:, cut:])
    renderer.draw(frames[0])
    part = (20, 30, 7, 5)
    mixed = shown(renderer, frames[1], part=part)
    expected = whole[0].copy()
    expected[30:35, 20:27] = whole[1][30:35, 20:27]
    np.testing.assert_array_equal(mixed, expected)
    np.testing.assert_array_equal(renderer.target().read(part=part), expected[30:35, 20:27])


def test_parts_do_not_cut_shadow_maps(renderer: Renderer) -> None:
    """With characters a map is copied, which GL's scissor box would cut."""
    crowd = one_that_bobs()
    scene = make_scene([floor(300)], spot((0, 0, 200), (40, 0, 0), 40, 5e4), crowd=crowd)
    view = looking((-100, 0, 120), (30, 0, 0))
    frames = [frame_of(scene, view, View.SHADOW, time=time) for time in (0.0, 0.5)]
    whole = shown(renderer, frames[1])
    shown(renderer, frames[0], part=(0, 0, 5, 5))
    shown(renderer, frames[0], part=(0, 0, 5, 5))
    np.testing.assert_array_equal(shown(renderer, frames[1]), whole)


def test_files_of_a_debugging_picture(tmp_path: Path) -> None:
    names = "boxes, scene,light-frustum,camera-frustum"
    wish = still.Wish(size="64x48", overlays=names, culled_from="title")
    still.render("courtyard", tmp_path / "over.png", wish)
    still.render("courtyard", tmp_path / "plain.png", still.Wish(size="64x48"))
    assert (tmp_path / "over.png").read_bytes() != (tmp_path / "plain.png").read_bytes()
    with pytest.raises(UsageError, match="--culled-from: expected x,y,z,yaw,pitch, found '1,2'"):
        still.render("courtyard", tmp_path / "x.png", replace(wish, culled_from="1,2"))
