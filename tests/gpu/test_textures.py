"""What textures hold: linear light, as exactly as their formats can, and averaged as such."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import pytest
from numpy.typing import NDArray

from conftest import Draw
from followspot.assets.shader_values import BlendFactor
from followspot.gpu import mip_levels, textures
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.material import Layer, Material
from synthetic import camera, floor, image_archive, make_scene, of, srgb_decoded

pytestmark = pytest.mark.gl

SIZE = 32


Upload = Callable[..., moderngl.Texture]


@pytest.fixture
def upload(renderer: Renderer) -> Iterator[Upload]:
    """`textures.upload` into the renderer's context, until the test ends."""
    context = renderer.open(make_scene([floor()])).context
    made: list[moderngl.Texture] = []

    def upload_one(*arguments: Any, **options: Any) -> moderngl.Texture:
        made.append(textures.upload(context, *arguments, **options))
        return made[-1]

    yield upload_one
    for texture in made:
        texture.release()


@pytest.fixture
def pixels() -> NDArray[np.uint8]:
    """Noise, darker from column to column, and every grey in the lower half."""
    noise = np.random.default_rng(5).uniform(0, 256, (SIZE, SIZE, 4))
    noise *= np.linspace(1, 0, SIZE)[:, np.newaxis]
    noise[SIZE // 2 :] = np.arange(SIZE * SIZE // 2).reshape(-1, SIZE, 1) % 256
    return noise.astype(np.uint8)


def texels(texture: moderngl.Texture, level: int) -> NDArray[np.float32]:
    """(h, w, 3) of a MIP level."""
    size = SIZE >> level
    raw = texture.read(level=level, alignment=1)
    return np.frombuffer(raw, "<f4").reshape(size, size, 3)


def steps(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """(h, w, 1) distance of neighbouring values in GL_RGB9_E5, told by the largest channel."""
    exponent = np.floor(np.log2(np.maximum(linear.max(axis=-1, keepdims=True), 2.0**-16)))
    return np.asarray(2.0 ** (exponent - 8))


def test_texels_are_linear_light_to_half_a_step(upload: Upload, pixels: NDArray[np.uint8]) -> None:
    linear = srgb_decoded(pixels[..., :3] / 255)
    off = np.abs(texels(upload(pixels), 0) - linear) / steps(linear)
    assert off.max() <= 0.501
    # The brightest channel comes back as the byte that it was.
    brightest = linear.argmax(axis=-1)[..., np.newaxis]
    slope = np.gradient(srgb_decoded(np.arange(256) / 255))  # linear light a byte
    byte = np.take_along_axis(pixels[..., :3], brightest, axis=-1)
    error = np.take_along_axis(off * steps(linear), brightest, axis=-1)
    assert (error < 0.3 * slope[byte]).all()


def test_smaller_levels_are_means_of_linear_light(
    upload: Upload, pixels: NDArray[np.uint8]
) -> None:
    texture = upload(pixels)
    mean = srgb_decoded(pixels[..., :3] / 255)
    for level in range(1, 6):
        mean = mean.reshape(len(mean) // 2, 2, -1, 2, 3).mean(axis=(1, 3))
        # Each level is made of the one before, as that was rounded; some drop the remainder.
        assert (np.abs(texels(texture, level) - mean) <= (level + 1.01) * steps(mean)).all()


def test_alpha_is_kept_where_it_is_wanted(upload: Upload, pixels: NDArray[np.uint8]) -> None:
    assert upload(pixels, with_alpha=True).read(alignment=1) == pixels.tobytes()


_FETCH = """
    #version 330 core
    uniform sampler2D image;
    uniform int level;
    out vec4 texel;
    void main() { texel = texelFetch(image, ivec2(gl_FragCoord.xy), level); }
"""
_WHOLE = """
    #version 330 core
    void main() { gl_Position = vec4(gl_VertexID % 2 * 4 - 1, gl_VertexID / 2 * 4 - 1, 0, 1); }
"""


def fetched(
    context: moderngl.Context, texture: moderngl.Texture, level: int, size: tuple[int, int]
) -> NDArray[np.float32]:
    """(h, w, 4) of a MIP level of w, h texels, as shaders read it: moderngl reads but its own."""
    program = context.program(vertex_shader=_WHOLE, fragment_shader=_FETCH)
    target = context.simple_framebuffer(size, 4, dtype="f4")
    target.use()
    context.enable_only(moderngl.NOTHING)
    texture.use(0)
    program["image"], program["level"] = 0, level
    context.vertex_array(program, []).render(vertices=3)
    return np.frombuffer(target.read(components=4, dtype="f4"), "<f4").reshape(*size[::-1], 4)


@pytest.mark.parametrize("shape", [(SIZE, SIZE), (12, 7), (1, 5)])
def test_levels_with_alpha_are_those_that_were_averaged(
    renderer: Renderer, upload: Upload, pixels: NDArray[np.uint8], shape: tuple[int, int]
) -> None:
    context = renderer.open(make_scene([floor()])).context
    image = np.ascontiguousarray(pixels[: shape[0], : shape[1]])
    texture = upload(image, with_alpha=True)
    shown = textures.upload_shown(context, image)
    for level, srgb in enumerate(mip_levels.of_srgb(image), 1):
        found = fetched(context, texture, level, srgb.shape[1::-1])
        # llvmpipe decodes by a polynomial; neighbouring levels differ by some tenths.
        np.testing.assert_allclose(found[..., :3], srgb_decoded(srgb[..., :3] / 255), atol=2e-3)
        np.testing.assert_allclose(found[..., 3], srgb[..., 3] / 255, atol=1e-6)
    for level, plain in enumerate(mip_levels.of_bytes(image), 1):
        found = fetched(context, shown, level, plain.shape[1::-1])
        np.testing.assert_allclose(found, plain / 255, atol=1e-6)
    shown.release()


def test_pieces_make_the_whole(upload: Upload, pixels: NDArray[np.uint8]) -> None:
    """Images that are decoded in several pieces, the last one smaller, or all alike."""
    for shape in ((33, 3, 1), (9, 128, 1)):
        many = np.tile(pixels, shape)
        assert many.size // 4 > 2 * textures._AT_ONCE
        expected = np.tile(texels(upload(pixels), 0), shape)
        found = np.frombuffer(upload(many).read(alignment=1), "<f4").reshape(expected.shape)
        np.testing.assert_array_equal(found, expected)


def test_only_an_image_with_alpha_is_uploaded_for_it(
    renderer: Renderer, tmp_path: Path, pixels: NDArray[np.uint8]
) -> None:
    opaque = pixels.copy()
    opaque[..., 3] = 255
    archive = image_archive(tmp_path, {"glass.png": pixels, "wall.png": opaque})
    blend = BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA
    pairs = [
        (Material(f"solid {name}", name), Material(f"blended {name}", name, blend=blend))
        for name in ("glass.png", "wall.png")
    ]
    faces = [face for pair in pairs for material in pair for face in of(material, floor())]
    gpu_scene = renderer.open(make_scene(faces, archive=archive))
    (solid, blended), (wall, pane) = (map(gpu_scene.image_of, pair) for pair in pairs)
    assert (solid.components, blended.components) == (3, 4)
    assert wall is pane
    assert wall.components == 3


@pytest.mark.parametrize("cover", [1.0, 0.6])
def test_a_layer_is_mixed_into_linear_light_by_the_vertices_alpha(
    draw: Draw, tmp_path: Path, cover: float
) -> None:
    """By the texels' own alpha, too."""
    grounds = {"sand.png": (200, 180, 90), "rock.png": (40, 60, 90)}
    images = {name: np.full((4, 4, 4), (*c, 255), np.uint8) for name, c in grounds.items()}
    images["rock.png"][..., 3] = round(cover * 255)
    archive = image_archive(tmp_path, images)
    sand, rock = (srgb_decoded(np.array(color) / 255) for color in grounds.values())
    ground = make_scene(
        of(Material("ground", "sand.png", layer=Layer("rock.png", fades=True)), floor()),
        archive=archive,
    )
    tints = np.ones((4, 4), np.float32)
    for alpha in (0.0, 0.25, 1.0):
        tints[:, 3] = alpha
        mesh = replace(ground.mesh, tints=tints.copy())
        scene = replace(ground, level=replace(ground.level, mesh=mesh))
        picture = draw(scene, camera((0, 0, 60), pitch=60), View.LAMBERTIAN)
        expected = np.broadcast_to(sand + (rock - sand) * alpha * cover, picture.shape)
        np.testing.assert_allclose(picture, expected, atol=2e-3)
