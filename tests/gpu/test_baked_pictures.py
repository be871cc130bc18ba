"""Baked light on pictures: what lightmaps, colours and the grid say is what is seen."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from test_frame import no_new_gl_objects

from conftest import Draw
from figures import at, figure, key, puppet, with_characters
from followspot.arrays import Floats
from followspot.assets.bsp import LUMPS
from followspot.passes.frame import FrameInput
from followspot.passes.view import View
from followspot.present.pixel import inspect_pixel
from followspot.present.renderer import Renderer
from followspot.scene import baked
from followspot.scene.baked import PAGE, BakedLight
from followspot.scene.mesh import Mesh
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from synthetic import WHITE_SKY, Piece, box, floor, looking, make_scene, on_plane, point, sphere

pytestmark = pytest.mark.gl

RNG = np.random.default_rng(8)
HALF = 100.0
"""Units from the floor's middle to its edges."""

ABOVE = looking((1, 0, 90), (0, 0, 0), 60)
TEXEL = 2e-3
"""Relative error of a channel in RGB9E5, half a step of nine bits, and of the filter's weights."""


def grid(level: int, count: int) -> NDArray[np.void]:
    cells = np.zeros(count, LUMPS["light_grid"])
    cells["ambient"] = (level, level // 2, level // 4)
    return cells


def lit(scene: Scene, luxel: NDArray[np.float32], color: Any = (1, 1, 1)) -> Scene:
    """The scene as if its compiler had lit it: vertices' (v, 2) luxels on page 1 of three."""
    world = np.zeros(1, LUMPS["models"])
    world["mins"], world["maxs"] = (-128, -128, 0), (128, 128, 128)
    pages = RNG.integers(20, 60, (3, PAGE, PAGE, 3), dtype=np.uint8)
    bsp = replace(
        scene.level.bsp, lightmaps=pages, models=world, light_grid=grid(40, 50), entities=({},)
    )
    light = BakedLight(bsp)
    place = (luxel / PAGE + (1, 0)) / (light.columns, light.rows)
    colors = np.broadcast_to(np.asarray(color, np.float32), (len(luxel), 3))
    made: Mesh = replace(scene.mesh, baked=np.hstack([place, colors]).astype(np.float32))
    return replace(scene, level=replace(scene.level, bsp=bsp, mesh=made, baked=light))


@pytest.fixture
def lightmapped() -> Scene:
    """A floor whose edges lie on the middles of luxels 4 and 20 of a page."""
    scene = make_scene([floor(HALF)], point((0, 0, 50)), sky=WHITE_SKY)
    corner = scene.mesh.vertices["texcoord"] * (1, 1)
    return lit(scene, (4.5 + 16 * corner).astype(np.float32))


def between_luxels(scene: Scene) -> Floats:
    """(h, w, 3) of the picture from above, by this test's own bilinear mean; NaN beside it."""
    assert scene.level.baked is not None
    page = baked.decoded(scene.level.baked.bsp.lightmaps[1]).astype(np.float64)
    p, _ = on_plane(ABOVE, (0, 0, 1))
    s, t = (p[..., 0] + HALF) / (2 * HALF), (HALF - p[..., 1]) / (2 * HALF)
    x, y = 4 + 16 * s, 4 + 16 * t
    beside = (s < 0.01) | (s > 0.99) | (t < 0.01) | (t > 0.99)
    x, y = np.where(beside, 4, x), np.where(beside, 4, y)
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = (x - left)[..., np.newaxis], (y - top)[..., np.newaxis]
    low = page[top, left] * (1 - a) + page[top, left + 1] * a
    high = page[top + 1, left] * (1 - a) + page[top + 1, left + 1] * a
    return np.where(beside[..., np.newaxis], np.nan, low * (1 - b) + high * b)


def test_a_lightmap_is_on_its_surface(draw: Draw, lightmapped: Scene) -> None:
    """Mixed between its luxels, times albedo and strength, in place of the sky's light."""
    found = draw(lightmapped, ABOVE, View.ENVIRONMENT, albedo=0.5, baked_light=3.0)
    expected = 0.5 * 3.0 * between_luxels(lightmapped)
    seen = ~np.isnan(expected)
    assert seen.mean() > 0.5
    # GL mixes texels by weights of 8 bits.
    step = 1.5 * np.nanmax(expected) / 256
    assert_allclose(found[seen], expected[seen], rtol=TEXEL, atol=step)


def test_it_is_added_to_the_lights(draw: Draw, lightmapped: Scene) -> None:
    changes = {"albedo": 0.5, "baked_light": 1.0}
    final = draw(lightmapped, ABOVE, View.FINAL, **changes)
    direct = draw(lightmapped, ABOVE, View.DIRECT, **changes)
    around = draw(lightmapped, ABOVE, View.ENVIRONMENT, **changes)
    seen = ~np.isnan(between_luxels(lightmapped))
    assert (direct[seen] > 0).any()
    assert_allclose(final[seen], (direct + around)[seen], rtol=1e-6)


def test_without_it_the_sky_lights_as_before(draw: Draw, lightmapped: Scene) -> None:
    plain = make_scene([floor(HALF)], point((0, 0, 50)), sky=WHITE_SKY)
    expected = draw(plain, ABOVE, View.FINAL)
    assert (draw(lightmapped, ABOVE, View.FINAL) == expected).all()
    assert (draw(plain, ABOVE, View.FINAL, baked_light=1.0) == expected).all(), "nobody baked it"
    dark = draw(lightmapped, ABOVE, View.ENVIRONMENT, baked_light=1.0, sky_light=False)
    assert (dark == 0).all()


def test_colours_of_vertices_are_mixed_between_them(draw: Draw) -> None:
    """Where there is no lightmap, the place on its image is white."""
    scene = make_scene([floor(HALF)], sky=WHITE_SKY)
    across = scene.mesh.vertices["position"][:, :1] / (2 * HALF) + 0.5
    scene = lit(scene, np.zeros((4, 2), np.float32), across * (0.2, 0.4, 0.8))
    assert scene.level.baked is not None
    white = scene.level.baked.at_points(np.zeros((4, 3)))[:, :2]
    assert scene.mesh.baked is not None
    rows = np.hstack([white, scene.mesh.baked[:, 2:]])
    scene = replace(scene, level=replace(scene.level, mesh=replace(scene.mesh, baked=rows)))
    found = draw(scene, ABOVE, View.ENVIRONMENT, albedo=1.0, baked_light=1.0)
    p, _ = on_plane(ABOVE, (0, 0, 1))
    inside = (np.abs(p[..., :2]) < HALF - 2).all(axis=2)
    share = p[..., :1] / (2 * HALF) + 0.5
    expected = (share * (0.2, 0.4, 0.8))[inside]
    assert_allclose(found[inside], expected, rtol=1e-4, atol=1e-5)


def body() -> list[Piece]:
    return [sphere((0, 0, 0), 20), *box((16, -4, -4), (30, 4, 4))]


@pytest.mark.parametrize("is_player", [False, True])
def test_characters_have_the_light_of_their_place(draw: Draw, *, is_player: bool) -> None:
    """The same from all around, whichever of its parts is seen."""
    far_below = make_scene([floor(HALF, -2000)], sky=WHITE_SKY)
    scene = lit(far_below, np.zeros((4, 2), np.float32))
    assert scene.level.baked is not None
    scene.level.baked.bsp.light_grid["ambient"][:25] = 10  # below, and four times darker
    keys = np.stack([key((0, 0, 24))])
    model = puppet([[body()]] * 3, keys, keys) if is_player else figure([body()])
    scene = with_characters(scene, at(model, (0, 0, 64)))
    view = looking((-150, 20, 90), (0, 0, 80), 60)
    found = draw(scene, view, View.ENVIRONMENT, albedo=0.5, baked_light=2.0)
    seen = draw(scene, view, View.DEPTH) < 400
    assert seen.mean() > 0.03
    low, high = (baked.decoded(np.array(c, np.uint8)) for c in ((10, 10, 10), (40, 20, 10)))
    expected = 0.5 * 2.0 * (low + high) / 2  # half-way up between two points of the grid
    assert_allclose(found[seen], np.broadcast_to(expected, found[seen].shape), rtol=1e-5)


def test_switching_it_on_makes_gl_objects_outside_of_frames_alone(
    renderer: Renderer, lightmapped: Scene
) -> None:
    renderer.open(lightmapped)
    on = FrameInput(lightmapped, ABOVE, Settings(exposure=1.0, baked_light=1.0), 1.0)
    off = replace(on, settings=Settings(exposure=1.0))
    for frame in (off, on):
        renderer.draw(frame)
    pipeline = renderer.pipeline
    with no_new_gl_objects():
        for frame in (off, on, off):
            pipeline.prepare(frame, renderer.target())
            pipeline.draw(frame, renderer.target())


def test_a_pixel_tells_of_it(renderer: Renderer, lightmapped: Scene) -> None:
    renderer.open(lightmapped)
    frame = FrameInput(lightmapped, ABOVE, Settings(baked_light=2.0), 1.0)
    told = inspect_pixel(renderer, frame, 70, 50)
    expected = 2.0 * np.pi * between_luxels(lightmapped)[50, 70]
    assert_allclose(told.environment, expected, rtol=0.01)
    assert_allclose(told.radiance, (told.direct + told.environment) * told.rho / np.pi, rtol=1e-4)
