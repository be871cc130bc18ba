"""Six Quake images as one cube map, and its low MIP levels; see also the GPU's own look-ups."""

import numpy as np
import pytest

from followspot.assets.image import Image
from followspot.scene import sky
from synthetic import cube_map, srgb_decoded

FACES = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))


def gl_face(direction: tuple[float, float, float]) -> tuple[int, float, float]:
    """Face, s and t in [0, 1] of a look-up: table 3.10 of the OpenGL 3.3 core specification."""
    rx, ry, rz = direction
    major = int(np.argmax(np.abs(direction)))
    sc, tc = {
        (0, True): (-rz, -ry),
        (0, False): (rz, -ry),
        (1, True): (rx, rz),
        (1, False): (rx, -rz),
        (2, True): (rx, -ry),
        (2, False): (-rx, -ry),
    }[major, direction[major] > 0]
    ma = abs(direction[major])
    return 2 * major + (direction[major] < 0), (sc / ma + 1) / 2, (tc / ma + 1) / 2


def images(size: int = 4) -> list[Image]:
    """Six images whose texels are told apart: red is the image, green the row, blue the column."""
    made = []
    for number in range(6):
        pixels = np.full((size, size, 4), 255, np.uint8)
        pixels[..., 0] = number * 40
        pixels[..., 1] = np.arange(size)[:, np.newaxis] * 10
        pixels[..., 2] = np.arange(size) * 10
        made.append(Image(pixels, False, str(number)))
    return made


@pytest.mark.parametrize(
    ("direction", "image", "row", "column"),
    [
        # Looking along +X with +Z up, the picture's right is -Y.
        ((1, -0.8, 0.8), 0, 0, 3),
        ((1, 0.8, -0.8), 0, 3, 0),
        # Looking along -X, right is +Y; along +Y it is +X; along -Y it is -X.
        ((-1, 0.8, 0.8), 1, 0, 3),
        ((0.8, 1, 0.8), 2, 0, 3),
        ((-0.8, -1, 0.8), 3, 0, 3),
        # Straight up: the image's bottom goes on in that of +X, its right is -Y.
        ((0.8, -0.3, 1), 4, 3, 2),
        # Straight down: the image's top goes on in that of +X, its right is -Y.
        ((0.8, -0.3, -1), 5, 0, 2),
    ],
)
def test_texels_are_found_where_the_game_shows_them(
    direction: tuple[float, float, float], image: int, row: int, column: int
) -> None:
    cube = sky.from_quake_images("coded", images())
    face, s, t = gl_face(direction)
    texel = cube.faces[face, int(t * 4), int(s * 4)]
    assert texel.tolist() == [image * 40, row * 10, column * 10, 255]


@pytest.mark.parametrize(("sizes", "expected"), [((4, 4), 4), ((3, 5), 8), ((4000, 16), 2048)])
def test_images_of_any_size_become_square_powers_of_two(
    sizes: tuple[int, int], expected: int
) -> None:
    width, height = sizes
    pixels = np.full((height, width, 4), 200, np.uint8)
    cube = sky.from_quake_images("odd", [Image(pixels, False, "")] * 6)
    assert cube.faces.shape == (6, expected, expected, 4) and cube.faces.flags.c_contiguous
    assert (cube.faces == 200).all()


def test_top_level_is_the_mean_in_linear_light() -> None:
    random = np.random.default_rng(0)
    cube = cube_map(random.integers(0, 256, (6, 16, 16, 3), np.uint8))
    expected = srgb_decoded(cube.faces[..., :3] / 255).mean(axis=(1, 2))
    np.testing.assert_allclose(cube.towards_axes(), expected, rtol=1e-6)
    np.testing.assert_allclose(cube.towards_axes(4), expected, rtol=1e-6)
    np.testing.assert_allclose(cube.towards_axes(99), expected, rtol=1e-6)


@pytest.mark.parametrize("level", range(6))
def test_levels_are_box_filtered_and_looked_up_in_the_middle(level: int) -> None:
    random = np.random.default_rng(level)
    cube = cube_map(random.integers(0, 256, (6, 32, 32, 3), np.uint8))
    mip = srgb_decoded(cube.faces[..., :3] / 255)
    for _ in range(level):
        mip = (mip[:, ::2, ::2] + mip[:, 1::2, ::2] + mip[:, ::2, 1::2] + mip[:, 1::2, 1::2]) / 4
    half = mip.shape[1] // 2
    middle = mip[:, half - 1 : half + 1, half - 1 : half + 1] if half else mip
    np.testing.assert_allclose(cube.towards_axes(level), middle.mean(axis=(1, 2)), rtol=1e-6)


def test_between_two_levels_values_are_mixed() -> None:
    random = np.random.default_rng(9)
    cube = cube_map(random.integers(0, 256, (6, 32, 32, 3), np.uint8))
    low, high = cube.towards_axes(2), cube.towards_axes(3)
    np.testing.assert_allclose(cube.towards_axes(2.25), 0.75 * low + 0.25 * high)
