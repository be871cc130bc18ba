"""Shadow maps that are spent on what the camera sees: still the same shadows."""

from dataclasses import replace

import numpy as np
import pytest
from test_shadows import report, texel_at_one

from conftest import Draw
from followspot.passes.shadow_fit import ShadowFrustum
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.light import SpotLight
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from synthetic import box, camera, floor, looking, make_scene, on_plane, point, quad, spot

pytestmark = pytest.mark.gl

GRID = range(-950, 951, 100)


def wide_scene() -> Scene:
    """A yard of boxes under one light, so large that a camera sees a small part of it."""
    random = np.random.default_rng(4)
    pieces = [quad((x, y, 0), (50, 0, 0), (0, 50, 0)) for x in GRID for y in GRID]
    for x, y in random.uniform(-900, 900, (60, 2)):
        pieces += box((x, y, 0), (x + 30, y + 40, random.uniform(20, 120)))
    return make_scene(pieces, spot((300, -200, 1500), (0, 0, 0), 40))


def test_fitted_shadow_map_is_kept_while_the_camera_moves_a_little(renderer: Renderer) -> None:
    scene, settings = wide_scene(), Settings()
    places = [camera((k * 0.5, 0, 60), yaw=k * 0.2, pitch=10) for k in range(100)]
    redrawn = [report(renderer, scene, place, settings).shadow_redrawn for place in places]
    assert redrawn[0] and sum(redrawn) < 30
    assert not any(report(renderer, scene, places[-1], settings).shadow_redrawn for _ in range(3))


def test_fitted_shadow_map_depends_on_no_earlier_frame(draw: Draw) -> None:
    """Frame k drawn alone is frame k of the film."""
    scene = wide_scene()
    places = [camera((k * 7, 0, 60), yaw=k * 3, pitch=10) for k in range(12)]
    film = [draw(scene, place, View.SHADOW) for place in places]
    for place, frame in reversed(list(zip(places, film, strict=True))):
        draw(replace(scene, level=wide_scene().level), places[0], View.SHADOW)
        np.testing.assert_array_equal(draw(scene, place, View.SHADOW), frame)


def test_fitted_shadow_map_is_sharper_where_the_camera_sees_little(
    renderer: Renderer, draw: Draw
) -> None:
    scene, view = wide_scene(), camera((0, 0, 60), pitch=60, fov=40)
    draw(scene, view, View.SHADOW, shadow_fit=False)
    whole = texel_at_one(renderer)
    draw(scene, view, View.SHADOW)
    assert texel_at_one(renderer) < whole / 4


def test_fitted_shadows_are_those_of_the_whole_cone_only_sharper(draw: Draw) -> None:
    """Wherever the camera stands: the fit leaves out no receiver and no caster of what it sees."""
    scene, random = wide_scene(), np.random.default_rng(8)
    for _ in range(12):
        x, y, z = random.uniform((-900, -900, 130), (900, 900, 600))
        view = camera((x, y, z), random.uniform(-180, 180), random.uniform(-20, 80))
        fitted = draw(scene, view, View.SHADOW)
        whole = draw(scene, view, View.SHADOW, shadow_fit=False, shadow_map_size=4096)
        wrong = np.abs(fitted - whole) >= 0.5
        assert wrong.mean() < 0.02, view
        blocks = np.lib.stride_tricks.sliding_window_view(wrong, (3, 3))
        assert not blocks.all(axis=(2, 3)).any(), "more than an edge"


def test_tiles_of_another_size_in_an_atlas_as_large(renderer: Renderer, draw: Draw) -> None:
    """Two spots' maps of 1536 texels take as much room as one of 1024 with a point light's."""
    scene, view = wide_scene(), camera((0, 0, 300), pitch=60)
    (light,) = scene.lights
    assert isinstance(light, SpotLight)
    two = scene.with_lights(light, replace(light, position=light.position + 60))
    other = scene.with_lights(light, point((0, 0, 90)))
    expected = draw(other, view, View.SHADOW, shadow_map_size=1024)
    draw(two, view, View.SHADOW, shadow_map_size=1536)
    before = renderer.pipeline.shadow.atlas.size
    found = draw(other, view, View.SHADOW, shadow_map_size=1024)
    assert renderer.pipeline.shadow.atlas.size == before
    np.testing.assert_array_equal(found, expected)


def test_culling_moves_no_shadow(draw: Draw) -> None:
    """The map is fitted alike with culling off."""
    scene = wide_scene()
    for k in range(6):
        view = camera((k * 100 - 300, 50, 60), yaw=k * 60, pitch=20, fov=60)
        every = draw(scene, view, View.DIRECT, culling=False)
        np.testing.assert_array_equal(draw(scene, view, View.DIRECT), every)


def tiles(renderer: Renderer) -> list[ShadowFrustum]:
    """Of the key light: the wide one, then the near one if there is any."""
    return [tile.frustum for tile in renderer.pipeline.shadow.tiles_of(0)]


def test_near_the_camera_edges_are_those_of_a_finer_map(renderer: Renderer, draw: Draw) -> None:
    """A pole's shadow before the camera, on a floor that goes on to the horizon."""
    light = spot((0, 3000, 4000), (0, 0, 0), 35)
    pole = box((-4, 20, 0), (4, 28, 300))
    scene = make_scene([floor(2000), *pole], light)
    view = looking((0, -90, 60), (0, -60, 55), 90)  # the floor from here to far away
    visibility = draw(scene, view, View.SHADOW)
    wide, near = tiles(renderer)
    assert near.texel < wide.texel / 5
    p, depth = on_plane(view, (0, 0, 1))
    p[~np.isfinite(depth)] = 0, 0, 0  # the sky: the foot of the pole, which is neither
    # The shadow of the pole's near corners goes away from the light's place on the floor.
    share = (p[..., 1] - 20) / (p[..., 1] - 3000)
    reaches = (p[..., 1] < -1) & (p[..., 1] > -150) & (share > 0)
    x_at_pole = p[..., 0] * (1 - share)
    texel = near.texel * np.linalg.norm(p - light.position, axis=-1) * 1.5
    inside = reaches & (np.abs(x_at_pole) < 4 - texel)
    outside = reaches & (np.abs(x_at_pole) > 4 + texel)
    assert inside.sum() > 50 and outside.sum() > 500
    assert (visibility[inside] < 0.5).all() and (visibility[outside] > 0.5).all()


def test_no_seam_between_the_tiles(renderer: Renderer, draw: Draw) -> None:
    """Nothing that is lit all over shows where one tile ends, whatever the filter takes."""
    scene = make_scene([floor(2000)], spot((0, 3000, 4000), (0, 0, 0), 35))
    for taps in (1, 4):
        for yaw in range(0, 360, 30):
            view = camera((0, 0, 60), yaw=yaw, pitch=15)
            visibility = draw(scene, view, View.SHADOW, shadow_taps=taps)
            depth = draw(scene, view, View.DEPTH)
            assert len(tiles(renderer)) == 2
            assert (visibility[np.isfinite(depth) & (depth < 1500)] == 1).all()


def test_tiles_agree_about_what_both_hold(renderer: Renderer, draw: Draw) -> None:
    """The near tile's shadows are those of a wide tile as fine, wherever it ends."""
    scene = wide_scene()
    for yaw in (0, 100, 230):
        view = camera((0, 0, 130), yaw=yaw, pitch=20)
        shared = draw(scene, view, View.SHADOW, shadow_map_size=2048)
        assert len(tiles(renderer)) == 2
        alone = draw(scene, view, View.SHADOW, shadow_map_size=8192, shadow_fit=False)
        assert (np.abs(shared - alone) < 0.5).mean() > 0.99
