"""Characters against the same triangles in the level: every stage, shadows, instances."""

import itertools
from dataclasses import replace
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pytest
from gl_calls import DebugLog, live_objects
from test_frame import no_new_gl_objects

from conftest import Draw
from figures import at, figure, key, mixed, part, placed, puppet, with_characters
from followspot.assets.animation import Pose
from followspot.assets.md3 import between
from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.passes.characters import CharacterPass
from followspot.passes.frame import FrameInput, FrameReport
from followspot.passes.shadow import ShadowPass
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.camera import Camera
from followspot.scene.character import Character
from followspot.scene.figure import Figure, FigurePart
from followspot.scene.material import Material
from followspot.scene.scene import Scene
from followspot.scene.settings import CullFace, Settings
from followspot.scene.walk import along, standing
from synthetic import (
    DIM,
    WHITE_SKY,
    Piece,
    box,
    camera,
    floor,
    image_archive,
    looking,
    make_scene,
    of,
    point,
    rotation,
    sphere,
    spot,
    turned,
)

pytestmark = pytest.mark.gl

VIEW = looking((-150, 20, 90), (0, 0, 30), 60)
LIGHT = spot((-60, 120, 260), (0, 0, 0), 35, 4e3)
STAGES = [stage for stage in View if stage is not View.SHADOW_MAP]
PLACE = (16.0, -8.0, 32.0)


def body(
    size: float = 24.0, shift: tuple[float, float, float] = (0, 0, 0), material: str = "white"
) -> list[Piece]:
    """A ball with a nose, on whole units, so that placing it rounds nothing."""
    nose = box((size - 4, -4, -4), (size + 16, 4, 4))
    return turned(of(Material(material), sphere((0, 0, 0), size), *nose), np.eye(3), shift)


FRAMES = [body(), body(32, (0, 8, 16)), body(16, (8, -16, 0))]


def room(*pieces: Piece, **fields: Any) -> Scene:
    return make_scene([floor(400), *pieces], LIGHT, point((0, -90, 60)), sky=WHITE_SKY, **fields)


def frame_input(
    scene: Scene, view: Camera, time: float, stage: View = View.FINAL, **changes: Any
) -> FrameInput:
    settings = Settings(exposure=1.0, **changes)
    return FrameInput(scene, view, settings, 1.0, stage, time)


def report(renderer: Renderer, scene: Scene, view: Camera, time: float) -> FrameReport:
    renderer.open(scene)
    return renderer.draw(frame_input(scene, view, time))


def unshadowed(draw: Draw, scene: Scene, stage: View, time: float) -> Any:
    return draw(scene, VIEW, stage, time=time, shadows=False)


@pytest.mark.parametrize("stage", STAGES)
@pytest.mark.parametrize("frame", range(3))
def test_a_key_pose_is_drawn_as_the_level_would_be(draw: Draw, stage: View, frame: int) -> None:
    """Bit for bit in place and texture; light, but for the rounding of a unit normal's length."""
    scene = with_characters(room(), at(figure(FRAMES), PLACE))
    level = room(*placed(FRAMES[frame], PLACE))
    shown = unshadowed(draw, scene, stage, float(frame))
    expected = unshadowed(draw, level, stage, 0.0)
    if stage in (View.DEPTH, View.LAMBERTIAN, View.SHADOW):
        np.testing.assert_array_equal(shown, expected)
    np.testing.assert_allclose(shown, expected, rtol=2e-4, atol=2e-5)
    again = unshadowed(draw, scene, stage, frame + 3.0)  # the animation repeats
    np.testing.assert_array_equal(again, shown)


@pytest.mark.parametrize("stage", [View.DEPTH, View.NORMALS, View.FINAL])
@pytest.mark.parametrize(("time", "a", "b", "share"), [(0.5, 0, 1, 0.5), (2.25, 2, 0, 0.25)])
def test_positions_and_normals_are_interpolated(
    draw: Draw, stage: View, time: float, a: int, b: int, share: float
) -> None:
    scene = with_characters(room(), at(figure(FRAMES), PLACE))
    level = room(*placed(mixed(FRAMES[a], FRAMES[b], share), PLACE))
    shown = unshadowed(draw, scene, stage, time)
    expected = unshadowed(draw, level, stage, 0.0)
    close = np.isclose(shown, expected, rtol=1e-4, atol=1e-4)
    assert close.mean() > 0.999  # rounding moves a rim by a pixel here and there
    key_pose = unshadowed(draw, scene, stage, float(a))
    assert (~np.isclose(shown, key_pose, rtol=1e-3)).mean() > 0.01


@pytest.mark.parametrize("fit", [False, True])
@pytest.mark.parametrize("cull", list(CullFace))
def test_a_character_casts_and_receives_shadows_as_the_level_does(
    draw: Draw, fit: bool, cull: CullFace
) -> None:
    """A ball over another: its shadow falls on the one below, on the floor and on itself."""
    high = (-10.0, 24.0, 96.0)
    ball = figure([body()])
    scene = with_characters(room(), at(ball, PLACE), at(ball, high))
    level = room(*placed(body(), PLACE), *placed(body(), high))
    slope = 0.0 if cull is CullFace.FRONT else 2.0  # lit faces are in the map
    settings = Settings(
        shadow_fit=fit, shadow_cull=cull, shadow_map_size=2048, shadow_slope_bias=slope
    )
    shown, expected = (draw(s, VIEW, View.SHADOW, settings) for s in (scene, level))
    alone = draw(room(), VIEW, View.SHADOW, settings)
    assert (expected != alone).mean() > 0.02
    # Other boxes make other near planes and windows: texels lie elsewhere at the edges.
    assert (np.abs(shown - expected) > 0.5).mean() < 0.002


def test_level_casts_on_characters(draw: Draw) -> None:
    roof = box((-80, -80, 130), (80, 80, 140))
    below = with_characters(room(*roof), at(figure([body()]), PLACE))
    visible = draw(below, VIEW, View.SHADOW)
    depth = draw(below, VIEW, View.DEPTH)
    on_ball = depth < draw(room(*roof), VIEW, View.DEPTH) - 1
    assert on_ball.sum() > 200 and (visible[on_ball] == 0).all()


def test_many_characters_of_one_figure(renderer: Renderer, draw: Draw) -> None:
    """Each has its own place, heading and clock, in as many draws as one needs."""
    moving = figure(FRAMES)
    places = [(x, y, 24.0) for x in (-80.0, 0.0, 80.0) for y in (-90.0, 0.0, 90.0)]
    yaws = [90.0 * k for k in range(len(places))]
    crowd = [
        at(moving, place, yaw, clock=float(k % 3))
        for k, (place, yaw) in enumerate(zip(places, yaws, strict=True))
    ]
    view = looking((-260, 20, 190), (0, 0, 20), 70)
    scene = with_characters(room(), *crowd)
    pieces = [
        piece
        for k, (place, yaw) in enumerate(zip(places, yaws, strict=True))
        for piece in placed(FRAMES[k % 3], place, yaw)
    ]
    for stage in (View.DEPTH, View.NORMALS):
        shown = draw(scene, view, stage)
        np.testing.assert_allclose(shown, draw(room(*pieces), view, stage), rtol=1e-4, atol=1e-4)
    one = with_characters(room(), crowd[0])
    many, single = (report(renderer, s, view, 0.0) for s in (scene, one))
    assert many.draws == single.draws and many.characters == 9
    added = single.triangles - report(renderer, room(), view, 0.0).triangles
    assert many.triangles - single.triangles == 8 * added


def test_a_players_parts_hang_on_its_tags(draw: Draw) -> None:
    """Legs at one second, torso at another; the head goes with both."""
    legs = [body(16), body(16, (4, 0, 0))]
    torso = [body(12), body(12, (0, 4, 0))]
    head = [body(8)]
    torso_keys = np.stack([key((0, 0, 32)), key((8, 0, 32), rotation((0, 0, 1), 90))])
    head_keys = np.stack([key((0, 0, 24)), key((0, 4, 24), rotation((1, 0, 0), 90))])
    doll = puppet([legs, torso, head], torso_keys, head_keys)
    plays = ((doll.tracks("run+attack"), 0.0),)
    for time in (0.0, 1.0, 0.25):
        scene = with_characters(room(), Character(doll, standing(PLACE, 90.0), plays))
        pose = Pose(*(np.array(v) for v in (int(time), 1 - int(time), time % 1)))
        upper = between(torso_keys, pose)
        over = upper @ between(head_keys, pose)
        pieces = mixed(legs[int(time)], legs[1 - int(time)], time % 1)
        for matrix, frames in ((upper, torso), (over, [head[0], head[0]])):
            there = mixed(frames[int(time)], frames[1 - int(time)], time % 1)
            pieces += turned(there, matrix[:3, :3], matrix[:3, 3])
        level = room(*placed(pieces, PLACE, 90.0))
        for stage in (View.DEPTH, View.NORMALS):
            shown = unshadowed(draw, scene, stage, time)
            expected = unshadowed(draw, level, stage, 0.0)
            close = np.isclose(shown, expected, rtol=1e-4, atol=1e-4)
            assert close.mean() > 0.9985, (time, stage)


@pytest.mark.parametrize(
    "material",
    [
        Material("solid", "leaf.png"),
        Material("cut", "leaf.png", alpha_test=AlphaTest.GE128, sides=Sides.BOTH),
        Material("glass", "leaf.png", blend=(BlendFactor.ONE, BlendFactor.ONE)),
        Material("inside", "leaf.png", sides=Sides.BACK, clamps=True),
    ],
    ids=lambda m: m.name,
)
@pytest.mark.parametrize("stage", [View.FINAL, View.LAMBERTIAN, View.NORMALS, View.SHADOW])
def test_materials_of_characters(
    draw: Draw, tmp_path: Path, material: Material, stage: View
) -> None:
    leaf = np.random.default_rng(1).integers(0, 256, (16, 16, 4), np.uint8)
    archive = image_archive(tmp_path, {"leaf.png": leaf})
    ball = of(material, *box((-24, -20, -16), (16, 24, 32)))
    scene = with_characters(room(archive=archive), at(figure([ball]), PLACE))
    level = room(*placed(ball, PLACE), archive=archive)
    shown, expected = (draw(s, VIEW, stage, shadow_map_size=2896) for s in (scene, level))
    nothing = draw(room(archive=archive), VIEW, stage, shadow_map_size=2896)
    if not (stage in (View.NORMALS, View.SHADOW) and material.blend):
        assert (np.abs(nothing - expected) > 0.01).mean() > 0.005
    off = 0.5 if stage is View.SHADOW else 0.02 * np.abs(expected).max()
    assert (np.abs(shown - expected) > off).mean() < 0.004


def test_a_moving_character_leaves_no_shadow_behind(renderer: Renderer, draw: Draw) -> None:
    """The level's depth is kept and copied; what was drawn over the copy is gone with it."""
    way = along([(-100, -80, 60), (60, 80, 60)], 40.0)
    scene = with_characters(room(), Character(figure([body()]), way))
    first = draw(scene, VIEW, View.SHADOW, DIM, time=0.5)
    then = draw(scene, VIEW, View.SHADOW, DIM, time=3.0)
    assert (first != then).mean() > 0.01
    np.testing.assert_array_equal(draw(scene, VIEW, View.SHADOW, DIM, time=0.5), first)
    renderer._drop_scene()
    np.testing.assert_array_equal(draw(scene, VIEW, View.SHADOW, DIM, time=3.0), then)


@pytest.mark.parametrize("fit", [False, True])
def test_only_characters_are_redrawn_into_the_shadow_map(renderer: Renderer, fit: bool) -> None:
    way = along([(-100, -80, 60), (60, 80, 60)], 40.0)
    scene = with_characters(room(*box((50, 50, 0), (60, 60, 90))), Character(figure(FRAMES), way))
    renderer.open(scene)
    frames = [frame_input(scene, VIEW, t, shadow_fit=fit) for t in (0.0, 0.1, 1.7, 5.0)]
    done = [renderer.draw(frame) for frame in frames]
    assert [each.shadow_redrawn for each in done] == [True, False, False, False]
    assert [each.characters for each in done] == [1, 1, 1, 1]


def test_a_moving_camera_does_not_redraw_characters_that_stand_still(renderer: Renderer) -> None:
    scene = with_characters(room(), at(figure([body()]), PLACE))
    renderer.open(scene)
    shadow = renderer.pipeline.shadow
    versions = []
    for step in range(8):
        eye = (-150 + 0.01 * step, 20, 90)
        renderer.draw(frame_input(scene, looking(eye, (0, 0, 30), 60), 0.0))
        versions.append(shadow.version)
    assert len(set(versions)) == 1
    renderer.draw(frame_input(scene, VIEW, 1.0))
    assert shadow.version == versions[-1] + 1


def test_frames_without_shadows_between_leave_characters_in_the_map(renderer: Renderer) -> None:
    """As where one half of a split picture shows no shadows."""
    scene = with_characters(room(), at(figure([body()]), PLACE))
    renderer.open(scene)
    shadow = renderer.pipeline.shadow
    versions = []
    for _ in range(4):
        renderer.draw(frame_input(scene, VIEW, 0.0))
        renderer.draw(frame_input(scene, VIEW, 0.0, shadows=False))
        versions.append(shadow.version)
    assert len(set(versions)) == 1
    renderer.draw(frame_input(scene, VIEW, 1.0, shadows=False))
    renderer.draw(frame_input(scene, VIEW, 1.0))
    assert shadow.version == versions[-1] + 1


def test_another_light_at_the_same_time(renderer: Renderer, draw: Draw) -> None:
    """One that reached nobody makes place for one that shines on the character."""
    scene = with_characters(make_scene([floor(400)]), at(figure([body()]), PLACE))
    far_off = spot((3000, 0, 250), (3000, 0, 0), 10)
    draw(scene.with_lights(far_off), VIEW, View.SHADOW)
    found = draw(scene.with_lights(LIGHT), VIEW, View.SHADOW)
    renderer._drop_scene()
    np.testing.assert_array_equal(found, draw(scene.with_lights(LIGHT), VIEW, View.SHADOW))


def test_whoever_the_camera_stands_in_is_not_in_the_picture_but_casts_a_shadow(
    renderer: Renderer, draw: Draw
) -> None:
    inside = camera((*PLACE[:2], 40.0), pitch=60, fov=100)
    empty = room()
    scene = with_characters(empty, at(figure([body()]), PLACE))
    np.testing.assert_array_equal(draw(scene, inside, View.DEPTH), draw(empty, inside, View.DEPTH))
    assert report(renderer, scene, inside, 0.0).characters == 0
    shadows = draw(scene, inside, View.SHADOW, DIM), draw(empty, inside, View.SHADOW, DIM)
    assert shadows[0].mean() < shadows[1].mean() - 0.05


def test_two_lights_see_the_same_characters(draw: Draw) -> None:
    red = spot((150, 0, 150), (0, 0, 0), 40, (200, 0, 0))
    blue = spot((0, -150, 150), (0, 0, 0), 40, (0, 0, 200))
    scene = with_characters(make_scene([floor()]), at(figure([body()]), (0, 0, 30)))
    view, settings = camera((0, 0, 250), pitch=90, fov=50), Settings(sky_light=False)
    both, only_red, only_blue = (
        draw(scene.with_lights(*lights), view, View.DIRECT, settings)
        for lights in ((red, blue), (red,), (blue,))
    )
    assert (only_red[..., 0] == 0).any() and (only_blue[..., 2] == 0).any()
    off = np.abs(both - only_red - only_blue) > 0.01 * both.max()
    assert off.mean() < 0.002


def village() -> Scene:
    """Characters all over the place, also behind the camera and far off."""
    random = np.random.default_rng(5)
    kinds = [figure(FRAMES), figure([body(12)]), figure([body(20), body(28)])]
    crowd = [
        at(kinds[k % 3], (*place, 30.0), yaw, clock=k * 0.3)
        for k, (place, yaw) in enumerate(
            zip(random.uniform(-700, 700, (60, 2)), random.uniform(0, 360, 60), strict=True)
        )
    ]
    scene = make_scene([floor(900)], spot((0, 0, 900), (200, 100, 0), 50, 9e4), sky=WHITE_SKY)
    return with_characters(scene, *crowd)


@pytest.mark.parametrize("stage", [View.FINAL, View.SHADOW])
def test_culling_characters_changes_no_bit_of_the_picture(
    renderer: Renderer, draw: Draw, stage: View
) -> None:
    scene, seen = village(), []
    for view in (camera((0, 0, 60)), camera((300, -200, 80), 135, 20, 60)):
        every = draw(scene, view, stage, culling=False, time=0.7)
        np.testing.assert_array_equal(draw(scene, view, stage, culling=True, time=0.7), every)
        seen.append(report(renderer, scene, view, 0.7).characters)
    assert min(seen) > 0 and max(seen) < 40


def test_a_frame_of_characters_raises_no_gl_message(renderer: Renderer) -> None:
    scene, view = village(), camera((0, 0, 60))
    renderer._drop_scene()
    with DebugLog() as log:
        renderer.render(scene, view, STAGES)
        renderer.render(scene, view, STAGES, settings=Settings(albedo=0.5))
        assert log.messages() == []


def test_a_frame_of_characters_creates_nothing_and_sends_no_vertices(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, view = village(), camera((0, 0, 60))
    renderer.open(scene)
    renderer.draw(frame_input(scene, view, 0.0))
    sent: list[int] = []
    write = moderngl.Buffer.write

    def counted(self: moderngl.Buffer, data: Any, offset: int = 0) -> None:
        sent.append(memoryview(data).nbytes)
        write(self, data, offset)

    monkeypatch.setattr(moderngl.Buffer, "write", counted)
    with no_new_gl_objects():
        for time in (0.25, 0.5, 0.75):
            sent.clear()
            renderer.draw(frame_input(scene, view, time))
            pipeline = renderer.pipeline
            casting = sum(
                len(pipeline._characters.covering(k)) for k in range(len(pipeline.shadow.tiles))
            )
            assert 0 < sum(sent) <= (192 + 16) * casting + 192 * len(scene.crowd) + 2048
    monkeypatch.undo()
    renderer._drop_scene()
    renderer.render(make_scene([floor()]), view)
    renderer._drop_scene()
    before = live_objects()
    renderer.render(scene, view, STAGES)
    renderer._drop_scene()
    after = live_objects()
    assert all(after[kind] <= before[kind] for kind in before)


def test_pictures_of_a_time_do_not_depend_on_what_was_drawn_before(draw: Draw) -> None:
    scene = village()
    views = [camera((0, 0, 60)), camera((300, -200, 80), 135, 20, 60)]
    first = [draw(scene, view, View.FINAL, time=1.5) for view in views]
    draw(scene, views[0], View.DEPTH, time=9.0)
    draw(scene, views[1], View.FINAL, time=2.0, shadows=False)
    again = [draw(scene, view, View.FINAL, time=1.5) for view in views]
    np.testing.assert_array_equal(again, first)


def test_a_character_outside_of_the_level_is_seen_and_shaded(draw: Draw) -> None:
    """Before the sky, beyond the level's box: the far plane and the light's window reach it."""
    away = (1500.0, 0.0, 400.0)
    scene = make_scene([floor(100)], spot((1400, 0, 900), away, 30, 1e5), sky=WHITE_SKY)
    scene = with_characters(scene, at(figure([body()]), away))
    view = looking((1400, 0, 380), away, 40)
    assert np.isfinite(draw(scene, view, View.DEPTH)).mean() > 0.03
    assert 0.01 < (draw(scene, view, View.SHADOW) == 1).mean() < 0.25


def test_a_figure_with_more_poses_than_the_gl_holds(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    from followspot.errors import AssetError
    from followspot.gpu import characters

    scene = with_characters(room(), at(figure(FRAMES), PLACE))
    limits = {**renderer._context.info, "GL_MAX_TEXTURE_SIZE": 1024}
    monkeypatch.setattr(moderngl.Context, "info", limits)
    with pytest.raises(AssetError, match="test: expected at most"):
        characters.GpuCrowd(renderer._context, scene.crowd)


def test_the_kept_depth_comes_back_where_characters_were() -> None:
    """A map that characters have walked through is the one that is drawn from nothing."""
    ways = [
        along([(-120.0, y, 40.0), (120.0, -y, 40.0)], 60.0, is_closed=False)
        for y in (-90.0, 0.0, 90.0)
    ]
    lights = (LIGHT, spot((140, -100, 220), (0, 0, 0), 30, 4e3))
    walkers = [Character(figure(FRAMES), way) for way in ways]
    scene = with_characters(room(*box((-20, -60, 0), (10, -40, 50))), *walkers).with_lights(*lights)
    times = (0.0, 0.7, 1.9, 1.2, 3.6)

    def atlas(renderer: Renderer, time: float) -> Any:
        report(renderer, scene, VIEW, time)
        renderer.finish()  # Mesa's llvmpipe may not wait for what is still being drawn
        pipeline = renderer.pipeline
        return np.frombuffer(pipeline.shadow.atlas.read(alignment=1), "<f4")

    with Renderer((96, 72)) as renderer:
        kept = [atlas(renderer, time) for time in times]
    for time, found in zip(times, kept, strict=True):
        with Renderer((96, 72)) as renderer:
            np.testing.assert_array_equal(found, atlas(renderer, time))
    assert all((a != b).any() for a, b in itertools.pairwise(kept))


@pytest.mark.parametrize("call", ["_put_back", "draw_casters"])
@pytest.mark.parametrize("nth", [1, 2])
def test_a_frame_that_was_interrupted_is_drawn_anew(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch, call: str, nth: int
) -> None:
    """At the same time, too, when nothing has moved since."""
    scene, view, views = village(), camera((0, 0, 60)), [View.FINAL, View.SHADOW_MAP]
    renderer._drop_scene()
    expected = renderer.render(scene, view, views, time=5.0)
    renderer.render(scene, view, time=0.0)
    owner = ShadowPass if call == "_put_back" else CharacterPass
    original, calls = getattr(owner, call), itertools.count(1)

    def interrupted(*arguments: Any) -> None:
        if next(calls) == nth:
            raise KeyboardInterrupt
        original(*arguments)

    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(owner, call, interrupted)
        renderer.render(scene, view, views, time=5.0)
    found = renderer.render(scene, view, views, time=5.0)
    for each in views:
        np.testing.assert_array_equal(found[each], expected[each])


NO_TRIANGLES = replace(part(FRAMES), indices=np.empty(0, np.uint32), runs=())


@pytest.mark.parametrize("parts", [(), (NO_TRIANGLES,)])
def test_a_figure_without_triangles_is_not_seen(draw: Draw, parts: tuple[FigurePart, ...]) -> None:
    """As the game's models of hands, which have tags alone."""
    scene = make_scene([floor()], LIGHT, sky=WHITE_SKY)
    empty = with_characters(scene, at(Figure("hand", parts), PLACE))
    np.testing.assert_array_equal(draw(empty, VIEW, View.FINAL), draw(scene, VIEW, View.FINAL))
