"""Shaders compiled anew while pictures are drawn: what is good stays, what is wrong is told."""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pytest
from gl_calls import live_objects
from numpy.typing import NDArray

from figures import at, figure, with_characters
from followspot.assets.shader_values import AlphaTest
from followspot.gpu import program
from followspot.gpu.program import SHADERS, ShaderError
from followspot.passes.frame import FrameInput, FramePipeline
from followspot.passes.overlay import Overlay
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.material import Material
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
    quad,
    spot,
)

pytestmark = pytest.mark.gl

VIEW = camera((-150, 40, 120), -10, 30)
Edit = Callable[[str, str, str], None]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of the package's shaders."""
    return Path(shutil.copytree(SHADERS, tmp_path / "shaders"))


@pytest.fixture
def edit(folder: Path) -> Edit:
    """Replace a text that is in a file once; the file's time moves on, however fast one types."""

    def replace_text(name: str, before: str, after: str) -> None:
        file = folder / name
        text = file.read_text()
        assert text.count(before) == 1, before
        file.write_text(text.replace(before, after))
        later = file.stat().st_mtime_ns + 1_000_000
        os.utime(file, ns=(later, later))

    return replace_text


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    """A floor with a box, a cut-out sheet and a character under a lamp."""
    leaf = np.zeros((8, 8, 4), np.uint8)
    leaf[:, ::2] = 255
    archive = image_archive(tmp_path / "images", {"leaf.png": leaf})
    sheet = Material("leaf", "leaf.png", alpha_test=AlphaTest.GE128)
    pieces = [floor(300), *box((40, -30, 0), (90, 30, 50))]
    pieces += of(sheet, quad((20, 0, 40), (0, -50, 0), (0, 0, 30)))
    lamp = spot((0, 0, 200), (60, 0, 0), 40, 5e4)
    made = make_scene(pieces, lamp, sky=WHITE_SKY, archive=archive, environment_constant=0.3)
    return with_characters(made, at(figure([box((-5, -5, -5), (5, 5, 5))]), (0, 60, 9)))


@pytest.fixture
def pipeline(renderer: Renderer, scene: Scene, folder: Path) -> Iterator[FramePipeline]:
    """Of the scene, with the folder's shaders."""
    gpu_scene = renderer.open(scene)
    made = FramePipeline(gpu_scene.context, gpu_scene, folder)
    yield made
    made.release()


@pytest.fixture
def picture(
    renderer: Renderer, scene: Scene, pipeline: FramePipeline
) -> Callable[..., NDArray[np.uint8]]:
    """Prepare and draw a view of the scene."""

    def draw(view: View = View.FINAL, **fields: Any) -> NDArray[np.uint8]:
        settings = Settings(exposure=1.0)
        frame = FrameInput(scene, VIEW, settings, 1.0, view, **fields)
        pipeline.prepare(frame, renderer.target())
        pipeline.draw(frame, renderer.target())
        return renderer.target().read()

    return draw


Picture = Callable[..., NDArray[np.uint8]]


def test_a_change_shows_in_views_old_and_new(
    pipeline: FramePipeline, picture: Picture, edit: Edit
) -> None:
    before = picture()
    assert not pipeline.shaders_changed()
    edit("surface.frag", "    value.a = 1.0;", "    value = vec4(0.0, 0.0, 1.0, 1.0);")
    assert pipeline.shaders_changed()
    np.testing.assert_array_equal(picture(), before)
    assert pipeline.reload() is None
    assert not pipeline.shaders_changed()
    for view in (View.FINAL, View.NORMALS):
        after = picture(view)
        is_blue = (after == (0, 0, 255)).all(axis=2)
        assert 0.3 < is_blue.mean() < 1


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("surface.frag", "vec3 n = normalize(world_normal);"),
        ("common/light.glsl", "vec3 l = light_position[i].xyz - p;"),
        ("surface.vert", "texcoord = base_texcoord();"),
        ("sky.frag", "void main() {"),
        ("shadow.vert", "gl_Position = clip_from_world * vertex_in_world();"),
        ("common/object.glsl", "return in_normal;"),
        ("overlay.frag", "in vec4 colour;"),
    ],
)
def test_a_mistake_is_told_by_file_and_line_and_changes_nothing(
    pipeline: FramePipeline,
    picture: Picture,
    edit: Edit,
    folder: Path,
    file: str,
    text: str,
) -> None:
    overlays = frozenset({Overlay.SCENE})
    before = picture(overlays=overlays)
    lines = [line.strip() for line in (folder / file).read_text().splitlines()]
    line = lines.index(text) + 1
    edit(file, text, f"{text} nonsense nonsense2;")
    objects = live_objects()
    error = pipeline.reload()
    assert error is not None
    assert (error.file, error.line) == (file, line)
    assert "error" in error.message
    assert str(error).startswith(f"{file}:{line}: ")
    # moderngl leaves a program behind that does not compile; one in use goes when another is.
    assert all(
        count - objects[kind] <= 2 * (kind == "Program") for kind, count in live_objects().items()
    )
    assert not pipeline.shaders_changed(), "the same mistake is not told again"
    np.testing.assert_array_equal(picture(overlays=overlays), before)
    picture(View.SHADING)  # compiled only now, from what was good
    edit(file, f"{text} nonsense nonsense2;", text)
    assert pipeline.shaders_changed()
    assert pipeline.reload() is None

    np.testing.assert_array_equal(picture(overlays=overlays), before)


def test_a_mistake_in_a_view_that_is_not_in_use_yet(
    pipeline: FramePipeline, picture: Picture, edit: Edit
) -> None:
    """It is told when the view is wanted; the views before can still be drawn."""
    before = picture(), picture(View.NORMALS)
    edit("surface.frag", "value.rgb = vec3(scale / gl_FragCoord.w);", "value.rgb = nonsense;")
    assert pipeline.reload() is None
    for _ in range(2):
        with pytest.raises(ShaderError, match=r"surface.frag:\d+: .*nonsense") as caught:
            picture(View.DEPTH)
        assert caught.value.file == "surface.frag"
    np.testing.assert_array_equal(picture(), before[0])
    np.testing.assert_array_equal(picture(View.NORMALS), before[1])


def test_a_view_compiled_before_is_kept_though_it_is_not_shown(
    pipeline: FramePipeline, picture: Picture, edit: Edit
) -> None:
    before = picture(View.DEPTH)
    picture(View.FINAL)
    edit("surface.frag", "value.rgb = vec3(scale / gl_FragCoord.w);", "value.rgb = nonsense;")
    error = pipeline.reload()
    assert error is not None and error.file == "surface.frag"
    np.testing.assert_array_equal(picture(View.DEPTH), before)


def test_mistakes_that_are_in_no_line(
    pipeline: FramePipeline, picture: Picture, edit: Edit, folder: Path
) -> None:
    before = picture()
    edit("sky.vert", "out vec3 direction;", "out vec2 direction;")
    edit("sky.vert", ".xyz;", ".xy;")
    error = pipeline.reload()
    assert error is not None
    assert (error.file, error.line) == ("sky", None)
    assert "direction" in error.message
    edit("sky.vert", "out vec2 direction;", "out vec3 direction;")
    edit("sky.vert", ".xy;", ".xyz;")
    edit("surface.vert", 'include "common/object.glsl"', 'include "common/objects.glsl"')
    error = pipeline.reload()
    assert error is not None
    assert (error.file, error.line) == ("surface.vert", 6)
    assert error.message == "there is no common/objects.glsl to include"
    edit("surface.vert", 'include "common/objects.glsl"', 'include "common/object.glsl"')
    (folder / "sky.frag").rename(folder / "sky.away")
    assert pipeline.shaders_changed()
    error = pipeline.reload()
    assert error is not None
    assert (error.file, error.message) == ("sky.frag", "there is no such file")
    np.testing.assert_array_equal(picture(), before)
    (folder / "sky.away").rename(folder / "sky.frag")
    assert pipeline.reload() is None
    np.testing.assert_array_equal(picture(), before)


def test_a_shader_may_leave_uniforms_and_vertices_unused(
    pipeline: FramePipeline, picture: Picture, edit: Edit
) -> None:
    """As when somebody comments the cutting out, or the light, out to see what it does."""
    before = picture()
    edit("surface.frag", "a * alpha_test.x + alpha_test.y <= 0.0) discard;", "a < -1.0) discard;")
    edit("shadow.frag", ".a * alpha_test.x + alpha_test.y <= 0.0) discard;", ".a < -1.0) discard;")
    edit("surface.vert", "world_normal = normal_in_world();", "world_normal = vec3(0.0, 0.0, 1.0);")
    assert pipeline.reload() is None
    after = picture()
    assert (after != before).any()
    edit("shadow.vert", "clip_from_world * vertex_in_world();", "vec4(0.0);")
    edit("surface.vert", "clip_from_world * vec4(drawn_at(world.xyz), 1.0);", "vec4(0.0);")
    assert pipeline.reload() is None
    assert len(np.unique(picture().reshape(-1, 3), axis=0)) == 1  # only the sky


def test_a_change_of_the_shadow_pass_alone_shows_at_once(
    pipeline: FramePipeline, picture: Picture, edit: Edit
) -> None:
    before = picture(View.SHADOW)
    edit("shadow.frag", "void main() {", "void main() { discard;")
    assert pipeline.reload() is None
    assert picture(View.SHADOW).sum() > before.sum()


def test_reloading_leaves_no_gl_object_behind(pipeline: FramePipeline, picture: Picture) -> None:
    picture()
    picture(View.NORMALS, overlays=frozenset(Overlay))
    objects = live_objects()
    for _ in range(3):
        assert pipeline.reload() is None
        picture()
        assert live_objects() == objects


def test_drivers_messages_are_understood(
    monkeypatch: pytest.MonkeyPatch, renderer: Renderer
) -> None:
    """Forms of Mesa, NVIDIA and others; the number in front is the file's."""
    context = renderer.open(make_scene([floor()])).context
    for said, line in (
        ("1:12(3): error: no", 12),
        ("1(34) : error C1008: no", 34),
        ("ERROR: 1:56: no", 56),
        ("something is wrong", None),
        ("9:12(3): error: no such file", None),
    ):

        def fail(*_: Any, said: str = said, **__: Any) -> None:
            raise moderngl.Error(
                f"GLSL Compiler failed\n\nfragment_shader\n===============\n{said}\n"
            )

        with monkeypatch.context() as patch:
            patch.setattr(moderngl.Context, "program", fail)
            with pytest.raises(ShaderError) as caught:
                program.build(context, "surface", {"LIGHTS": 0, "SHADOWS": 0})
        assert caught.value.line == line
        assert caught.value.file == ("surface" if line is None else "common/frame.glsl")
        assert said in caught.value.message
