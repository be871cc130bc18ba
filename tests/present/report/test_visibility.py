"""The report's own rays against closed forms and against Mitsuba's."""

import math
from pathlib import Path

import numpy as np
import pytest

from figures import at, figure, with_characters
from followspot.assets.shader_deform import Sprite
from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.passes.shadow_fit import MARGIN, view_from_world
from followspot.passes.shadow_tiles import tile_size
from followspot.passes.view import View
from followspot.present.raytracer import RayTracer
from followspot.present.renderer import Renderer
from followspot.present.report.visibility import Rays, fitted
from followspot.scene.camera import Camera
from followspot.scene.deform import Deforms
from followspot.scene.light import SpotLight
from followspot.scene.load import load
from followspot.scene.material import Material
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from synthetic import (
    SIZE,
    box,
    floor,
    image_archive,
    looking,
    make_scene,
    of,
    on_plane,
    quad,
    sphere,
    spot,
)

VIEW = looking((-180, -120, 110), (30, 20, 30))
LIGHT = spot((-60, 130, 190), (30, 10, 20), 35)
SUN = spot((0, 3000, 4000), (0, 0, 0), 35)
PLAIN = Material("plain")
SPRITE = Material("sprite", deforms=Deforms(sprite=Sprite.WHOLE))
GLASS = Material("glass", blend=(BlendFactor.ONE, BlendFactor.ONE))
UNFITTED = Settings(shadow_fit=False)


def test_a_floor_is_seen_where_the_closed_form_says() -> None:
    places = Rays(make_scene([floor()])).seen_by(VIEW, SIZE, 5000)
    expected, depth = on_plane(VIEW, (0, 0, 1))
    hit = np.flatnonzero((depth < 5000) & (np.abs(expected[..., :2]).max(axis=2) < 1000))
    np.testing.assert_array_equal(places.pixel, hit)
    np.testing.assert_allclose(places.depth, depth.ravel()[hit], rtol=1e-9)
    np.testing.assert_allclose(places.position, expected.reshape(-1, 3)[hit], atol=1e-6)
    assert (places.normal == (0, 0, 1)).all()
    assert (places.face_normal == (0, 0, 1)).all()


def test_backs_are_invisible_to_the_camera_and_stop_light() -> None:
    roof = quad((0, 0, 100), (0, 40, 0), (40, 0, 0))  # looks down
    view = looking((0, -200, 250), (0, 0, 0), 60)
    rays = Rays(make_scene([floor(), roof]))
    places = rays.seen_by(view, SIZE, 5000)
    np.testing.assert_allclose(places.position[:, 2], 0, atol=1e-9)
    lit = rays.reach(places.position, places.face_normal, np.array([0.0, 0, 300]))
    outside = np.abs(places.position[:, :2]).max(axis=1) - 60  # the roof's half of 40, from 300
    np.testing.assert_array_equal(lit[np.abs(outside) > 0.1], (outside > 0)[np.abs(outside) > 0.1])


def test_what_is_in_no_shadow_map_stops_no_light_and_is_not_seen() -> None:
    """A sprite has no place of its own: it is wherever it turns to."""
    above, light = quad((0, 0, 50), (20, 0, 0), (0, 20, 0)), np.array([0.0, 0, 200])
    here = np.array([[0.0, 0, 0], [50, 0, 0]])
    up = np.array([[0.0, 0, 1]] * 2)
    for board, seen in ((PLAIN, 50), (SPRITE, 0), (GLASS, 0)):
        rays = Rays(make_scene([floor(), *of(board, above)]))
        assert rays.reach(here, up, light).tolist() == [board is not PLAIN, True]
        places = rays.seen_by(looking((0, 0, 150), (0, 0, 0)), SIZE, 5000)
        middle = places.pixel == SIZE[0] * (SIZE[1] // 2) + SIZE[0] // 2
        np.testing.assert_allclose(places.position[middle][:, 2], [seen], atol=1e-9)


def test_what_is_two_sided_turns_its_normals_to_the_camera() -> None:
    sheet = of(Material("sheet", sides=Sides.BOTH), quad((0, 0, 100), (0, 40, 0), (40, 0, 0)))
    places = Rays(make_scene(sheet)).seen_by(looking((0, -200, 250), (0, 0, 100)), SIZE, 5000)
    assert len(places) > 100
    assert places.two_sided.all()
    assert (places.normal == (0, 0, 1)).all()


def test_nothing_nearer_than_the_near_plane_is_seen() -> None:
    view = looking((0, 0, 3.9), (0, 0, 0))
    assert not len(Rays(make_scene([floor(2)])).seen_by(view, SIZE, 100))


def compare(scene: Scene, view: Camera, light: SpotLight, unlike: float) -> None:
    """Depth, face normals and visibility, at all but a share of the pixels of grazed edges."""
    truth = RayTracer(scene, 0.5).render(view, SIZE, light)
    rays = Rays(scene)
    places = rays.seen_by(view, SIZE, view.far_for(*scene.bounds))
    depth, normal = np.full(SIZE[0] * SIZE[1], np.inf), np.zeros((SIZE[0] * SIZE[1], 3))
    depth[places.pixel], normal[places.pixel] = places.depth, places.face_normal
    lit = np.zeros(len(depth), bool)
    lit[places.pixel] = rays.reach(places.position, places.face_normal, light.position)
    same = np.isclose(depth, truth.depth.ravel(), rtol=1e-4)
    assert (~same).mean() <= unlike
    same &= np.isfinite(depth)
    away = np.abs(normal - truth.face_normal.reshape(-1, 3)).max(axis=1)
    assert (away[same] > 1e-3).mean() <= unlike
    assert (lit != truth.lit.ravel())[same].mean() <= unlike
    assert 0.05 < lit[same].mean() < 0.95


def test_rays_agree_with_mitsubas_in_a_room() -> None:
    pieces = [
        *box((-200, -200, 0), (200, 200, 200), inward=True),
        *box((20, 0, 0), (50, 30, 120)),
        *box((140, -60, 60), (199, 60, 70)),
        sphere((-20, -50, 30), 25),
    ]
    compare(make_scene(pieces, LIGHT), VIEW, LIGHT, unlike=1e-3)


def test_cut_outs_agree_with_mitsubas(tmp_path: Path) -> None:
    pixels = np.full((64, 64, 4), 255, np.uint8)
    pixels[:32, :32, 3] = pixels[32:, 32:, 3] = 0
    grate = Material("grate", "grate.png", Sides.BOTH, AlphaTest.GE128, clamps=True)
    board = quad((0, 0, 100), (50, 0, 0), (0, 50, 0))
    light = spot((0, 0, 300), (0, 0, 0), 40)
    with image_archive(tmp_path, {"grate.png": pixels}) as archive:
        scene = make_scene([floor(), *of(grate, board)], light, archive=archive)
        compare(scene, looking((0, -200, 250), (0, 0, 0), 40), light, unlike=1e-3)


@pytest.mark.openarena
def test_rays_agree_with_mitsubas_in_a_level() -> None:
    scene = load("oa_dm5")
    light = scene.lights[0]
    assert isinstance(light, SpotLight)
    with scene.archive:
        compare(scene, scene.camera(), light, unlike=1e-3)


def test_without_fitting_the_map_covers_the_cone_and_its_margin() -> None:
    scene = make_scene([floor(), *box((-5, -5, 0), (5, 5, 20))], LIGHT)
    found = fitted(scene, VIEW, SIZE, LIGHT, UNFITTED)
    assert found.near is None
    assert found.wide.covers_the_same(found.cone)
    rim = math.tan(LIGHT.half_angle) * (1 + 2 * MARGIN / UNFITTED.shadow_map_size)
    np.testing.assert_allclose(found.wide.window, (-rim, rim, -rim, rim))
    np.testing.assert_allclose(found.wide.texels, 2 * rim / UNFITTED.shadow_map_size)


@pytest.mark.gl
def test_the_fitted_tiles_are_the_frames_and_within_the_cone(renderer: Renderer) -> None:
    small = looking((0, -100, 60), (0, 0, 0), 30)
    far = looking((0, -100, 60), (0, 200, 50), 90)  # the floor from here to far away
    bare = make_scene([floor(), *box((-5, -5, 0), (5, 5, 20))], SUN)
    board = figure([[quad((0, 0, 0), (50, 0, 0), (0, 50, 0))]])
    crowded = with_characters(bare, at(board, (0, 1500, 2000)))  # half-way to the sun
    for scene, view, settings in (
        (bare, small, Settings()),
        (bare, far, Settings()),
        (bare, far, UNFITTED),
        (crowded, far, Settings()),
        (crowded, far, UNFITTED),
    ):
        found = fitted(scene, view, SIZE, SUN, settings)
        renderer.render(scene, view, [View.SHADOW], settings=settings)
        own = [tile for tile in (found.wide, found.near) if tile is not None]
        drawn = [tile.frustum for tile in renderer.pipeline.shadow.tiles_of(0)]
        assert len(drawn) == len(own) == (2 if settings.shadow_fit else 1)
        for ours, theirs in zip(own, drawn, strict=True):
            assert ours.covers_the_same(theirs)
            np.testing.assert_array_equal(ours.texels, theirs.texels)
        sides = [np.ptp(np.reshape(tile.window, (2, 2)), axis=1) for tile in (found.cone, *own)]
        if view is small:
            assert (sides[1] < sides[0] / 2).all()
        if settings.shadow_fit:
            assert (sides[2] < sides[1] / 2).any()
            assert (sides[2] <= sides[1]).all()


def test_texels_are_the_near_tiles_where_it_is_looked_at() -> None:
    view = looking((0, -100, 60), (0, 200, 50), 90)
    scene = make_scene([floor()], SUN)
    found = fitted(scene, view, SIZE, SUN, Settings())
    assert found.near is not None
    left, right, bottom, top = found.near.window
    middle, half = np.array([left + right, bottom + top]) / 2, (right - left) / 2
    edge = MARGIN / tile_size(Settings()) * 2
    shares = np.array([0, 1 - edge - 1e-3, 1 - edge + 1e-3, 1.1, -1.1])
    tangents = np.column_stack([middle[0] + half * shares, np.full(5, middle[1])])
    inverse = np.linalg.inv(view_from_world(SUN))
    for distance in (50.0, 3000.0):
        in_view = np.column_stack([tangents * distance, np.full(5, -distance), np.ones(5)])
        texels = found.texels((in_view @ inverse.T)[:, :3])
        near, wide = found.near.texel, found.wide.texel
        np.testing.assert_array_equal(texels, [near, near, wide, wide, wide])
