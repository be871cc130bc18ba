"""Light from lightmaps, vertices' colours and the light grid."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from followspot.assets.bsp import LUMPS, BspFile
from followspot.assets.image import srgb_to_linear
from followspot.scene import baked
from followspot.scene.baked import PAGE, BakedLight
from followspot.scene.load import load
from synthetic import open_bsp

RNG = np.random.default_rng(5)


def records(name: str, count: int, **fields: Any) -> NDArray[np.void]:
    made = np.zeros(count, LUMPS[name])
    for field, values in fields.items():
        made[field] = values
    return made


def lit_bsp(**arrays: Any) -> BspFile:
    """Three lightmaps of noise, and what else a test wants."""
    pages = RNG.integers(0, 256, (3, PAGE, PAGE, 3), dtype=np.uint8)
    return replace(open_bsp(), **({"lightmaps": pages} | arrays))


def test_bytes_are_four_times_as_bright_on_display() -> None:
    bright = baked.decoded(np.array([[10, 20, 63]], np.uint8))
    assert_allclose(bright, srgb_to_linear(np.array([[40, 80, 252]]) / 255), rtol=1e-6)
    assert baked.decoded(np.zeros((1, 3), np.uint8)).tolist() == [[0, 0, 0]]


def test_what_is_too_bright_keeps_its_hue() -> None:
    """As the game does it: beyond twice full brightness, all channels shrink alike."""
    found = baked.decoded(np.array([[255, 128, 0], [127, 127, 127]], np.uint8))
    assert_allclose(found[0], srgb_to_linear(np.array([2, 2 * 128 / 255, 0])), rtol=1e-6)
    assert_allclose(found[1], srgb_to_linear(np.full(3, 127 * 4 / 255)), rtol=1e-6)


def luxels(light: BakedLight, places: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n, 3) of the image at (n, 2) places that are the middles of luxels, as GL finds them."""
    image = light.image()
    height, width = image.shape[:2]
    x, y = (places.astype(np.float64) * (width, height) - 0.5).T
    assert_allclose(x, x.round(), atol=1e-3)
    assert_allclose(y, y.round(), atol=1e-3)
    found: NDArray[np.float32] = image[y.round().astype(int), x.round().astype(int)]
    return found


def test_lightmapped_vertices_find_their_luxels() -> None:
    """Middles of luxels of all pages, at all places of a page."""
    count = 500
    page = RNG.integers(0, 3, count)
    column, row = RNG.integers(0, PAGE, (2, count))
    place = (np.stack([column, row], axis=1) + 0.5) / PAGE
    bsp = lit_bsp(
        faces=records("faces", count, lightmap=page),
        vertices=records("vertices", count, lightmap_texcoord=place, color=77),
    )
    light = BakedLight(bsp)
    found = light.at_vertices(np.arange(count), np.arange(count))
    expected = baked.decoded(bsp.lightmaps[page, row, column])
    assert_allclose(luxels(light, found[:, :2]), expected, rtol=1e-6)
    assert (found[:, 2:] == 1).all()


@pytest.mark.parametrize("lightmap", [-1, -3, 3])
def test_faces_without_a_lightmap_have_the_colours_of_their_vertices(lightmap: int) -> None:
    """None, by vertex, one in a file of its own; their coordinates may be anything."""
    colors = RNG.integers(0, 64, (4, 4), dtype=np.uint8)
    bsp = lit_bsp(
        faces=records("faces", 1, lightmap=lightmap),
        vertices=records("vertices", 4, color=colors, lightmap_texcoord=np.nan),
    )
    light = BakedLight(bsp)
    found = light.at_vertices(np.arange(4), np.zeros(4, np.int64))
    assert_allclose(found[:, 2:], baked.decoded(colors[:, :3]))
    image = light.image()
    x, y = (found[:, :2] * image.shape[1::-1]).astype(int).T
    for dx, dy in ((0, 0), (-1, 0), (0, -1), (-1, -1)):  # all that GL mixes there
        assert (image[y + dy, x + dx] == 1).all()


def test_places_beside_a_page_are_pulled_onto_its_luxels() -> None:
    """Where coordinates are a page's very edge, GL would mix in what is next to it."""
    edges = np.array([(0, 0), (1, 1), (128.07 / 128, 0.5 / 128), (-3, 0.5 / 128)])
    bsp = lit_bsp(
        faces=records("faces", 1, lightmap=1),
        vertices=records("vertices", 4, lightmap_texcoord=edges),
    )
    light = BakedLight(bsp)
    found = light.at_vertices(np.arange(4), np.zeros(4, np.int64))
    page = baked.decoded(bsp.lightmaps[1])
    assert_allclose(luxels(light, found[:, :2]), page[[0, 127, 0, 0], [0, 127, 127, 0]])


def test_white_lightmaps_are_full_light() -> None:
    bsp = lit_bsp(faces=records("faces", 1, lightmap=-2), vertices=records("vertices", 1))
    found = BakedLight(bsp).at_vertices(np.zeros(1, np.int64), np.zeros(1, np.int64))
    assert found[0, 2:].tolist() == [1, 1, 1]


def gridded(light: NDArray[np.uint8], **entity: str) -> BakedLight:
    """A level from -128 to 128 across, 0 to 256 high, whose grid has 5 by 5 by 3 points."""
    world = records("models", 1, mins=(-130, -128, -5), maxs=(130, 140, 260))
    grid = records("light_grid", light.size // 3, ambient=light.reshape(-1, 3))
    return BakedLight(replace(open_bsp(), models=world, light_grid=grid, entities=(entity,)))


def test_light_between_the_points_of_the_grid() -> None:
    """Exactly theirs at them, and the mean of two in the middle between them."""
    values = RNG.integers(1, 256, (3, 5, 5, 3), dtype=np.uint8)
    light, linear = gridded(values), baked.decoded(values)
    x, y, z = np.meshgrid(np.arange(5), np.arange(5), np.arange(3), indexing="ij")
    points = np.stack([64.0 * x - 128, 64.0 * y - 128, 128.0 * z], axis=-1).reshape(-1, 3)
    at = linear[z, y, x].reshape(-1, 3)
    assert_allclose(light.around(points), at, rtol=1e-6)
    between = light.around(np.array([[-128.0, -96, 128]]))
    assert_allclose(between[0], (linear[1, 0, 0] + linear[1, 1, 0]) / 2, rtol=1e-6)
    outside = light.around(np.array([[-900.0, -128, -70]]))
    assert_allclose(outside[0], linear[0, 0, 0], rtol=1e-6)


def test_points_in_walls_do_not_darken_the_grid() -> None:
    values = np.full((3, 5, 5, 3), 60, np.uint8)
    values[:, :, ::2] = 0
    places = RNG.uniform((-120, -120, 0), (120, 120, 256), (200, 3))
    assert_allclose(gridded(values).around(places), baked.decoded(values[:1, 0, 1]).repeat(200, 0))
    nowhere = gridded(np.zeros((3, 5, 5, 3), np.uint8))
    assert (nowhere.around(places) == 0).all()


def test_directed_light_counts_a_quarter() -> None:
    """The mean of the cosine's positive part over the sphere."""
    level = gridded(np.full((3, 5, 5, 3), 10, np.uint8))
    level.bsp.light_grid["directed"] = 50
    expected = baked.decoded(np.full(3, 10, np.uint8)) + baked.decoded(np.full(3, 50, np.uint8)) / 4
    assert_allclose(level.around(np.array([[3.0, 4, 5]]))[0], expected, rtol=1e-6)


def test_the_level_says_how_fine_its_grid_is() -> None:
    values = RNG.integers(1, 256, (3, 3, 3, 3), dtype=np.uint8)
    level = gridded(values, gridsize="128 128 128")
    found = level.around(np.array([[0.0, 128, 256]]))
    assert_allclose(found[0], baked.decoded(values[2, 2, 1]), rtol=1e-6)


def test_a_grid_of_another_size_lights_nothing() -> None:
    level = gridded(np.full((3, 5, 4, 3), 99, np.uint8))
    assert level.around(np.zeros((2, 3))).tolist() == [[0, 0, 0], [0, 0, 0]]


def test_what_stands_in_a_level_is_lit_by_its_place() -> None:
    values = RNG.integers(1, 256, (3, 5, 5, 3), dtype=np.uint8)
    light = gridded(values)
    points = RNG.uniform((-128, -128, 0), (128, 128, 256), (20, 3))
    found = light.at_points(points)
    assert_allclose(found[:, 2:], light.around(points), rtol=1e-6)
    middle = (light.image().shape[1] / 2 / light.image().shape[1], 0.5)
    assert_allclose(found[:, :2], np.tile(middle, (20, 1)))  # of the one white page


def test_every_triangle_of_the_courtyard_stays_on_its_page() -> None:
    """Polygons' and patches' alike, after their cutting into triangles."""
    mesh = load("courtyard").mesh
    assert mesh.baked is not None
    assert len(mesh.baked) == len(mesh.vertices)
    light = BakedLight(load("courtyard").level.bsp)
    corners = mesh.baked[mesh.indices.reshape(-1, 3), :2] * (light.columns, light.rows)
    middle = corners.mean(axis=1, keepdims=True)
    assert (np.abs(corners - np.floor(middle) - 0.5) <= 0.5 + 1e-4).all()
