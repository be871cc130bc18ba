"""What the panels find out: their pictures, and the window."""

import gc
import weakref
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import moderngl
import numpy as np
import pytest
from driver import display, play
from numpy.typing import NDArray

import synthetic
from followspot.assets.shader_values import AlphaTest
from followspot.passes import sky_preview, thumbnails
from followspot.passes.sky_preview import FACES, SkyPreview
from followspot.passes.thumbnails import ACROSS, EDGE, Thumbnail, Thumbnails
from followspot.present.renderer import Renderer
from followspot.present.viewer import copying, saving
from followspot.present.viewer.asking import Asked
from followspot.present.viewer.inspection import Inspector
from followspot.present.viewer.state import State
from followspot.scene import scene_file
from followspot.scene.load import load
from followspot.scene.material import Material
from followspot.scene.search import BUILTIN
from followspot.scene.sky import CubeMap

pytestmark = pytest.mark.gl


@pytest.fixture(scope="module")
def screen() -> Iterator[str]:
    with display() as name:
        yield name


@pytest.mark.parametrize("scenario", ["mapping", "asking"])
def test_what_panels_read(scenario: str, screen: str, tmp_path: Path) -> None:
    play(scenario, screen, tmp_path)


@pytest.mark.parametrize("scenario", ["colouring", "leaving"])
def test_what_panels_show(scenario: str, screen: str, tmp_path: Path) -> None:
    play(scenario, screen, tmp_path, GALLIUM_NOOP="1", GALLIUM_THREAD="0")


def test_the_sky_unfolded_is_the_sky_all_around(renderer: Renderer) -> None:
    """Each pixel against the direction that it stands for, looked up as GL does."""
    random = np.random.default_rng(2)
    texels = random.integers(0, 256, (6, 8, 8, 4), np.uint8)
    scene = synthetic.make_scene([synthetic.floor()], sky=CubeMap("noise", texels))
    gpu_scene = renderer.open(scene)
    preview = SkyPreview(gpu_scene.context)
    light = synthetic.srgb_decoded(texels[..., :3] / 255)
    edge = sky_preview.EDGE
    place = (np.arange(edge) + 0.5) / edge * 2 - 1
    right, down = np.meshgrid(place, place)
    for level in (0, 1, 3):
        size = 8 >> level
        means = light.reshape(6, size, 1 << level, size, 1 << level, 3).mean(axis=(2, 4))
        cross = pixels(preview.draw(gpu_scene.sky, level))
        for face, (column, row) in FACES.items():
            ahead, rightwards, upwards = SEEN[face]
            directions = ahead + right[..., np.newaxis] * rightwards - down[..., None] * upwards
            expected = looked_up(means, directions)
            part = cross[row * edge : (row + 1) * edge, column * edge : (column + 1) * edge]
            # Texels have nine bits below the exponent of their brightest channel, so steps of up
            # to 1/256; each level is rounded anew.
            for sign in (-1, 1):
                bound = np.clip(expected + sign * 5 / 1024, 0, 1)
                beyond = sign * (part[..., :3] - synthetic.srgb_encoded(bound) * 255)
                assert beyond.max() <= 0.6, face
            assert (part[..., 3] == 255).all()
        assert not cross[:edge, 2 * edge :].any()
    preview.release()


def axes(*rows: str) -> tuple[NDArray[np.float64], ...]:
    unit = dict(zip("XYZ", np.eye(3), strict=True))
    return tuple((-1 if row[0] == "-" else 1) * unit[row[1]] for row in rows)


SEEN = {
    "+X": axes("+X", "-Y", "+Z"),
    "-X": axes("-X", "+Y", "+Z"),
    "+Y": axes("+Y", "+X", "+Z"),
    "-Y": axes("-Y", "-X", "+Z"),
    "+Z": axes("+Z", "-Y", "-X"),
    "-Z": axes("-Z", "-Y", "+X"),
}
"""Ahead, right and up of somebody who turns from +X, or looks up or down from there."""


def looked_up(faces: NDArray[np.float64], directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """The texels in directions (OpenGL 3.3 core specification, table 3.10)."""
    x, y, z = np.moveaxis(directions, -1, 0)
    major = np.abs(directions).argmax(axis=-1)
    length = np.abs(directions).max(axis=-1)
    positive = np.take_along_axis(directions, major[..., np.newaxis], -1)[..., 0] > 0
    face = major * 2 + ~positive
    s = np.choose(face, [-z, z, x, x, x, -x]) / length
    t = np.choose(face, [-y, -y, z, -z, -y, -y]) / length
    size = faces.shape[1]
    column, row = (((at + 1) / 2 * size).astype(int).clip(0, size - 1) for at in (s, t))
    return np.asarray(faces[face, row, column])


def pixels(texture: moderngl.Texture) -> NDArray[np.uint8]:
    width, height = texture.size
    return np.frombuffer(texture.read(), np.uint8).reshape(height, width, 4)


def cut(sheet: NDArray[np.uint8], thumbnail: Thumbnail) -> NDArray[np.uint8]:
    """A thumbnail out of the whole sheet."""
    (left, top), (right, bottom) = np.array(thumbnail[1:]) * ACROSS * EDGE
    return sheet[int(top) : int(bottom), int(left) : int(right)]


def test_thumbnails_show_images_as_they_are(renderer: Renderer, tmp_path: Path) -> None:
    """Of a picture of four fields: the right way up, in its colours, with holes if it has some."""
    fields = np.array([[(200, 30, 30, 255), (40, 180, 40, 0)], [(20, 20, 90, 255), (9, 9, 9, 0)]])
    image = np.kron(fields, np.ones((32, 64, 1))).astype(np.uint8)
    archive = synthetic.image_archive(tmp_path, {"fields.png": image})
    whole = Material("whole", "fields.png")
    holed = Material("holed", "fields.png", alpha_test=AlphaTest.GE128)
    bare = Material("bare")
    pieces = [synthetic.floor(z=z) for z in (0, 1, 2)]
    made = [
        piece
        for material, piece in zip((whole, holed, bare), pieces, strict=True)
        for piece in synthetic.of(material, piece)
    ]
    gpu_scene = renderer.open(synthetic.make_scene(made, archive=archive))
    small = Thumbnails(gpu_scene.context)
    shown = {m: small.of(m, gpu_scene) for m in (whole, holed, bare)}
    sheet = pixels(small.texture)
    for material in (whole, holed):
        assert shown[material].size == (128, 64)
        picture = cut(sheet, shown[material])
        assert picture.shape == (EDGE, EDGE, 4)
        for (row, column), field in (((r, c), fields[r, c]) for r in (0, 1) for c in (0, 1)):
            middle = picture[EDGE // 4 + row * EDGE // 2, EDGE // 4 + column * EDGE // 2]
            np.testing.assert_allclose(middle[:3], field[:3], atol=1.6)
            assert middle[3] == (field[3] if material is holed else 255)
    assert (cut(sheet, shown[bare]) == 255).all()
    small.release()


def test_thumbnails_make_room_for_new_ones(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(thumbnails, "ACROSS", 2)
    gpu_scene = renderer.open(synthetic.make_scene([synthetic.floor()]))
    small = Thumbnails(gpu_scene.context)
    materials = [Material(f"m{number}") for number in range(6)]
    places = [small.of(material, gpu_scene) for material in materials[:4]]
    assert len(set(places)) == 4
    assert small.of(materials[0], gpu_scene) == places[0]
    assert small.of(materials[4], gpu_scene) == places[1], "the one that was longest not asked for"
    assert small.of(materials[5], gpu_scene) == places[2]
    assert [material in small for material in materials] == [True, False, False, True, True, True]
    small.forget()
    assert materials[0] not in small
    assert small.of(materials[5], gpu_scene) == places[0]
    small.release()


def asking(pixel: tuple[int, int], **more: object) -> State:
    """Somebody who asks for a pixel of a floor under a lamp."""
    scene = synthetic.make_scene([synthetic.floor()], synthetic.point((0, 0, 90)))
    state = State.of(scene, synthetic.camera((0, 0, 60), pitch=40))
    return replace(state, asked=Asked(pixel=pixel, **more))  # type: ignore[arg-type]


def test_a_pixel_is_another_one_in_a_picture_of_another_size() -> None:
    state = asking((20, 30), follows=True)
    with Renderer((64, 48)) as renderer:
        inspector = Inspector(renderer.open(state.scene).context)

        def look() -> tuple[object, bool]:
            inspector.before(renderer, state)
            renderer.draw(state.frame(state.look))
            found = inspector.after(renderer, state)
            return found.pixel, found.pixel_is_old

        before, is_old = look()
        assert before is not None and not is_old
        renderer.resize((96, 72))
        assert look() == (before, True)
        seen = [look() for _ in range(30)]
        assert seen[-1][0] != before and not seen[-1][1]
        inspector.release()


def test_a_level_that_was_closed_is_let_go() -> None:
    state = asking((20, 30), sky_level=0)
    with Renderer((64, 48)) as renderer:
        inspector = Inspector(renderer.open(state.scene).context)
        level = weakref.ref(state.scene.level)
        inspector.before(renderer, state)
        renderer.draw(state.frame(state.look))
        assert inspector.after(renderer, state).pixel is not None
        other = replace(asking((0, 0)), asked=Asked())
        inspector.before(renderer, other)
        renderer.draw(other.frame(other.look))
        inspector.after(renderer, other)
        del state
        gc.collect()
        assert level() is None
        inspector.release()


def test_the_environment_constant_is_saved_and_told(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    text = (BUILTIN / "courtyard.toml").read_text(encoding="utf-8")
    path.write_text(text.replace("_constant = 1.0", "_constant = 0.5 # weak"), encoding="utf-8")
    scene = load(str(path))
    state = State.of(scene, scene.camera())
    assert copying.untold(state) == []
    brighter = replace(state, environment_constant=1.25)
    assert brighter.lit.environment_constant == 1.25
    assert copying.untold(brighter) == ["the environment constant"]
    after = saving.saved(brighter)
    assert "environment_constant = 1.25 # weak" in path.read_text()
    assert scene_file.read(path).environment_constant == 1.25
    assert after.environment_constant == after.scene.environment_constant == 1.25
    assert copying.untold(after) == []
