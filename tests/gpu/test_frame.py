"""What a frame does beside its picture: culling, GL objects, GL messages, reports."""

import subprocess
import sys
import textwrap
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pytest
from gl_calls import DebugLog, live_objects

import synthetic
from conftest import Draw
from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.errors import UsageError
from followspot.passes import lighting, shadow_fit, visible
from followspot.passes.frame import FrameInput
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.camera import Camera
from followspot.scene.load import load
from followspot.scene.material import Material, Shade
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from synthetic import (
    WHITE_SKY,
    box,
    camera,
    floor,
    image_archive,
    make_scene,
    of,
    point,
    sphere,
    spot,
)

pytestmark = pytest.mark.gl

BLEND = (BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA)
ADD = (BlendFactor.ONE, BlendFactor.ONE)
CREATORS = [
    name
    for name in dir(moderngl.Context)
    if name
    in {
        "buffer",
        "compute_shader",
        "cubemap_framebuffer",
        "depth_renderbuffer",
        "depth_texture",
        "depth_texture_cube",
        "external_buffer",
        "external_texture",
        "framebuffer",
        "program",
        "query",
        "renderbuffer",
        "sampler",
        "scope",
        "simple_framebuffer",
        "simple_vertex_array",
        "texture",
        "texture3d",
        "texture_array",
        "texture_cube",
        "vertex_array",
    }
]


@pytest.fixture
def village(tmp_path: Path) -> Scene:
    """Many small bodies of every kind of material, spread out so that most are out of sight."""
    leaf = np.random.default_rng(1).integers(0, 256, (16, 16, 4), np.uint8)
    archive = image_archive(tmp_path, {"leaf.png": leaf, "wall.png": leaf[..., :3]})
    kinds = [
        Material("white"),
        Material("wall", "wall.png"),
        Material("leaf", "leaf.png", sides=Sides.BOTH, alpha_test=AlphaTest.GE128),
        Material("glass", "leaf.png", blend=BLEND),
        Material("flame", "leaf.png", blend=ADD, shade=Shade.EMISSIVE, sides=Sides.BOTH),
    ]
    random = np.random.default_rng(2)
    pieces = [floor(3000, -60)]
    for place in random.uniform((-900, -900, -40), (900, 900, 200), (120, 3)):
        body = box(place - 20, place + random.uniform(5, 60, 3))
        pieces += of(kinds[random.integers(len(kinds))], *body)
    pieces += of(kinds[1], sphere((100, 100, 50), 40))
    return make_scene(
        pieces,
        spot((0, 0, 900), (200, 100, 0), 50, 9e4, 0.2),
        point((50, -60, 90), 2000),
        sky=WHITE_SKY,
        archive=archive,
        environment_constant=0.4,
    )


VIEWS_OF_A_STAGE = [stage for stage in View if stage is not View.SHADOW_MAP]
VIEWS = [
    camera(position, yaw, pitch, fov)
    for position, yaw, pitch, fov in [
        ((0, 0, 0), 0, 0, 90),
        ((300, -200, 80), 135, 20, 60),
        ((-800, 700, 300), -40, 35, 110),
        ((0, 0, 10), 200, -60, 30),
        ((1500, 0, 40), 180, 5, 20),
        ((120, 60, 400), 77, 90, 100),
    ]
]


@pytest.mark.parametrize("stage", [View.FINAL, View.DEPTH])
def test_culling_changes_no_bit_of_the_picture(
    renderer: Renderer, draw: Draw, village: Scene, stage: View
) -> None:
    left_out = 0
    for view in VIEWS:
        every = draw(village, view, stage, culling=False)
        np.testing.assert_array_equal(draw(village, view, stage, culling=True), every)
        report = frame_report(renderer, village, view)
        assert 0 < report.triangles <= report.triangles_in_scene
        left_out += report.triangles_in_scene - report.triangles
    assert left_out > village.mesh.triangle_count  # of six pictures' worth


def frame_input(scene: Scene, view: Camera, stage: View = View.FINAL, **changes: Any) -> FrameInput:
    settings = Settings(exposure=1.0, **changes)
    return FrameInput(scene, view, settings, 1.0, stage)


def frame_report(renderer: Renderer, scene: Scene, view: Camera) -> Any:
    renderer.open(scene)
    return renderer.draw(frame_input(scene, view))


def test_one_draw_for_each_opaque_material(renderer: Renderer, village: Scene) -> None:
    report = frame_report(renderer, village, camera((-2500, 0, 900), pitch=20, fov=100))
    opaque = {m for m in village.materials if m.blend is None}
    blended = {m for m in village.materials if m.blend is not None}
    faces = village.mesh.faces["material"]
    blended_faces = sum(village.materials[n] in blended for n in faces.tolist())
    assert report.triangles == report.triangles_in_scene
    assert len(opaque) < report.draws <= len(opaque) + blended_faces + 2
    depth = renderer.draw(frame_input(village, camera((-2500, 0, 900), pitch=20), View.DEPTH))
    assert len(opaque) <= depth.draws <= len(opaque) + 1


def test_still_frames_work_nothing_out_anew(
    renderer: Renderer, village: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor do stages shown in turn, nor scenes that are described anew in every frame."""
    renderer.open(village)
    view = camera((-300, 0, 200), pitch=20)
    worked: list[str] = []

    def counted(owner: object, name: str) -> None:
        function = getattr(owner, name)

        def call(*args: Any, **named: Any) -> Any:
            worked.append(name)
            return function(*args, **named)

        monkeypatch.setattr(owner, name, call)

    counted(visible.VisibleFaces, "_seen_from")
    counted(shadow_fit, "fit")
    counted(lighting, "constants")
    counted(lighting, "write_lights")
    for number in range(6):
        stage = (View.FINAL, View.NORMALS)[number % 2]
        renderer.draw(frame_input(replace(village), view, stage))
        renderer.draw(frame_input(replace(village), view, stage))
        if number == 1:
            assert {"_seen_from", "fit", "constants", "write_lights"} == set(worked)
            worked.clear()
    assert not worked


@contextmanager
def no_new_gl_objects() -> Iterator[None]:
    """Every method of moderngl's context that makes an object raises meanwhile."""

    def refuse(*_: Any, **__: Any) -> None:
        raise AssertionError("a GL object is created inside a frame")

    with pytest.MonkeyPatch.context() as patch:
        for name in CREATORS:
            patch.setattr(moderngl.Context, name, refuse)
        yield


def test_no_gl_object_is_created_inside_a_frame(renderer: Renderer, village: Scene) -> None:
    """All views, with and without shadows, from several places, also where maps are redrawn."""
    assert len(CREATORS) > 12
    renderer.open(village)
    pipeline = renderer.pipeline
    for stage in VIEWS_OF_A_STAGE:
        for shadows in (True, False):
            first = frame_input(village, VIEWS[0], stage, shadows=shadows)
            renderer.draw(first, linear=True)
            renderer.draw(first)
            with no_new_gl_objects():
                for view in VIEWS:
                    frame = frame_input(village, view, stage, shadows=shadows, redraw_shadows=True)
                    for target in renderer._targets.values():
                        pipeline.prepare(frame, target)
                        pipeline.draw(frame, target)
                moved = replace(frame.lights[0], position=frame.lights[0].position + 1)
                elsewhere = replace(frame.scene, lights=(moved, *frame.lights[1:]))
                pipeline.draw(replace(frame, scene=elsewhere), target)


def test_the_guard_against_new_objects_works(renderer: Renderer, village: Scene) -> None:
    gpu_scene = renderer.open(village)
    with no_new_gl_objects(), pytest.raises(AssertionError, match="inside a frame"):
        gpu_scene.context.buffer(reserve=4)


def test_a_frame_raises_no_gl_message(renderer: Renderer, village: Scene) -> None:
    """Neither errors nor warnings, of synthetic scene and courtyard, loading included."""
    courtyard = load("courtyard")
    with courtyard.archive, DebugLog() as log:
        log.say("is anybody there?")
        assert log.messages() == ["is anybody there?"]
        for scene in (village, courtyard):
            view = scene.camera() if scene.cameras else VIEWS[0]
            gpu_scene = renderer.open(scene)
            for stage in VIEWS_OF_A_STAGE:
                for shadows in (True, False):
                    frame = frame_input(scene, view, stage, shadows=shadows)
                    renderer.draw(frame)
                    renderer.draw(frame, linear=True)
                    assert gpu_scene.context.error == "GL_NO_ERROR"
            renderer.render(scene, view, ["shadow-map", "final"])
            assert gpu_scene.context.error == "GL_NO_ERROR"
            assert log.messages() == []


def test_a_closed_scene_leaves_no_gl_object_behind(renderer: Renderer, village: Scene) -> None:
    """Names that the GL knows, counted before and after; also for programs of many views."""
    renderer.render(make_scene([floor()]), camera((0, 0, 20)))
    renderer.render(make_scene([floor()]), camera((0, 0, 20)), linear=True)
    renderer._drop_scene()
    before = live_objects()
    for lights in ((), village.lights):
        for linear in (False, True):
            renderer.render(village.with_lights(*lights), VIEWS[0], VIEWS_OF_A_STAGE, linear=linear)
    assert sum(live_objects().values()) > sum(before.values()) + 20
    renderer._drop_scene()
    after = live_objects()
    # A program that is still current goes only when another one is.
    assert all(after[kind] <= before[kind] for kind in before)


def test_resizing_raises_no_gl_message(village: Scene) -> None:
    """The framebuffer that is given back was the one drawn into last."""
    with Renderer((64, 48)) as renderer, DebugLog() as log:
        for size in ((64, 48), (48, 64), (64, 48)):
            renderer.resize(size)
            for linear in (False, True):
                (picture,) = renderer.render(village, VIEWS[0], linear=linear).values()
                assert picture.shape == (*size[::-1], 3)
        assert log.messages() == []
        assert renderer.open(village).context.error == "GL_NO_ERROR"


def test_too_many_lights_are_refused(renderer: Renderer) -> None:
    lights = [point((0, 0, 50 + k)) for k in range(9)]
    with pytest.raises(UsageError, match="at most 8 lights"):
        renderer.render(make_scene([floor()], *lights), camera((0, 0, 20)))
    spots = [spot((0, 0, 50 + k), (0, 0, 0), 30) for k in range(5)]
    with pytest.raises(UsageError, match="4 of them spot lights with shadows"):
        renderer.render(make_scene([floor()], *spots), camera((0, 0, 20)))


def test_eight_lights_four_of_them_spots(draw: Draw) -> None:
    lights = [spot((30 * k, 0, 100), (30 * k, 0, 0), 40) for k in range(4)]
    others = [point((30 * k, 50, 100)) for k in range(4)]
    scene = make_scene([floor(), *box((-10, -10, 0), (10, 10, 40))])
    view, settings = camera((0, 0, 150), pitch=90), Settings(sky_light=False)
    together = draw(scene.with_lights(*others, *lights), view, View.DIRECT, settings)
    apart = sum(
        draw(scene.with_lights(light), view, View.DIRECT, settings) for light in lights + others
    )
    np.testing.assert_allclose(together, apart, rtol=1e-4, atol=1e-3 * together.max())


def test_largest_shadow_maps_that_do_not_fit_are_a_users_error(renderer: Renderer) -> None:
    lights = [spot((0, 0, 50 + k), (0, 0, 0), 30) for k in range(4)]
    settings = Settings(shadow_map_size=8192)
    limit = renderer.open(make_scene([floor()])).context.info["GL_MAX_TEXTURE_SIZE"]
    assert limit < 4 * 8192, "this GL holds four of the largest maps: make the test's larger"
    with pytest.raises(UsageError, match="shadow_map_size"):
        renderer.render(make_scene([floor()], *lights), camera((0, 0, 20)), settings=settings)


def test_scene_without_a_single_face(draw: Draw) -> None:
    scene = make_scene([], spot((0, 0, 50), (0, 0, 0), 30), sky=WHITE_SKY)
    for stage in View:
        if stage is not View.SHADOW_MAP:
            draw(scene, camera((0, 0, 0)), stage)
    np.testing.assert_array_equal(draw(scene, camera((0, 0, 0)), View.FINAL), 1)


def test_frames_of_two_scenes_in_turn(draw: Draw) -> None:
    """Nothing of one scene is left in the other's pictures."""
    one = make_scene([floor(), sphere((50, 0, 20), 20)], spot((0, 0, 200), (0, 0, 0), 40))
    two = make_scene([floor(), *box((30, -9, 0), (50, 9, 30))], point((0, 0, 100)))
    view = camera((-40, 0, 60), pitch=20)
    first = [draw(scene, view, View.FINAL) for scene in (one, two)]
    again = [draw(scene, view, View.FINAL) for scene in (one, two)]
    np.testing.assert_array_equal(again, first)


def test_same_level_under_another_description(draw: Draw) -> None:
    """`replace` on a scene counts: lights, sky's strength, unit and settings are the new one's."""
    scene = make_scene([floor()], point((0, 0, 100)), sky=WHITE_SKY)
    view = camera((0, 0, 60), pitch=60)
    direct, sky = draw(scene, view, View.DIRECT), draw(scene, view, View.ENVIRONMENT)
    other = replace(scene, metres_per_unit=scene.metres_per_unit / 2, environment_constant=3.0)
    np.testing.assert_allclose(draw(other, view, View.DIRECT), 4 * direct, rtol=1e-5)
    np.testing.assert_allclose(draw(other, view, View.ENVIRONMENT), 3 * sky, rtol=1e-5)


def run_alone(script: str) -> None:
    """Run a script in a process of its own: what it tests could take the others down."""
    head = f"import sys; sys.path.insert(0, {str(Path(synthetic.__file__).parent)!r})\n"
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", head + textwrap.dedent(script)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_two_renderers_at_once() -> None:
    """Each keeps to its own context, in whatever order they are used and closed."""
    run_alone(
        """
        import numpy as np
        from followspot import Renderer, Settings, View
        from synthetic import WHITE_SKY, box, camera, floor, make_scene, point

        body = box((50, 0, 0), (90, 30, 30))
        scene = make_scene([floor(), *body], point((0, 0, 99)), sky=WHITE_SKY)
        other = make_scene(box((40, -20, 0), (90, 60, 80)), point((0, 0, 200)), sky=WHITE_SKY)
        view = camera((0, 0, 60), 0, 30)

        def picture(renderer, scene, size):
            shown = renderer.render(scene, view, settings=Settings(exposure=1.0))[View.FINAL]
            assert shown.shape == (*size[::-1], 3)
            return shown

        large = Renderer((160, 120))
        before = picture(large, scene, (160, 120))
        with Renderer((40, 30)) as small:
            first = picture(small, other, (40, 30))
            np.testing.assert_array_equal(picture(large, scene, (160, 120)), before)
            np.testing.assert_array_equal(picture(small, other, (40, 30)), first)
        np.testing.assert_array_equal(picture(large, scene, (160, 120)), before)
        large.close()
        """
    )


def test_impossible_sizes_are_refused_and_hurt_no_other_renderer() -> None:
    run_alone(
        """
        from followspot import Renderer, UsageError, View
        from synthetic import camera, floor, make_scene, point

        scene, view = make_scene([floor()], point((0, 0, 90))), camera((0, 0, 20))
        with Renderer((16, 16)) as renderer:
            before = renderer.render(scene, view)[View.FINAL].tolist()
            for size in ((0, 5), (5, -1), (10**6, 5)):
                try:
                    Renderer(size)
                except UsageError as error:
                    assert "cannot be drawn" in str(error)
                else:
                    raise AssertionError(f"{size} is not refused")
            assert renderer.render(scene, view)[View.FINAL].tolist() == before
        """
    )


def test_unknown_views_and_cameras(renderer: Renderer) -> None:
    scene = replace(make_scene([floor()]), cameras={"door": camera((0, 0, 20))})
    with pytest.raises(UsageError, match="no view is named 'colour'; there are final, normals"):
        renderer.render(scene, "door", ["colour"])
    with pytest.raises(UsageError, match="no camera is named 'roof'; there are door"):
        renderer.render(scene, "roof")
    assert set(renderer.render(scene, "door", ["final", View.DEPTH])) == {View.FINAL, View.DEPTH}


def test_shading_is_metered_by_itself_and_the_other_stages_as_parts_of_the_picture(
    renderer: Renderer,
) -> None:
    """Of a scene whose surfaces have all one albedo, the picture and its shading look the same."""
    scene, down = make_scene([floor()], point((30, 20, 80), 200)), camera((0, 0, 200), pitch=90)
    dark = Settings(albedo=0.05)
    stages = [View.FINAL, View.SHADING, View.DIRECT]
    shown = renderer.render(scene, down, stages, settings=dark)
    assert abs(shown[View.SHADING].astype(int) - shown[View.FINAL]).max() <= 1
    np.testing.assert_array_equal(shown[View.DIRECT], shown[View.FINAL])  # there is no sky light
    given = renderer.render(scene, down, stages, settings=Settings(albedo=0.05, exposure=0.5))
    assert (given[View.SHADING].astype(int) - given[View.FINAL]).max() > 20
