"""Shadow maps against geometry: edges, distances, what casts, and when they are drawn."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from numpy.typing import NDArray

from conftest import Draw
from followspot.arrays import Floats
from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.errors import UsageError
from followspot.passes.frame import FrameInput, FrameReport
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.camera import Camera
from followspot.scene.light import SpotLight
from followspot.scene.material import Material
from followspot.scene.scene import Scene
from followspot.scene.settings import CullFace, Settings
from synthetic import (
    DIM,
    Piece,
    box,
    camera,
    floor,
    image_archive,
    looking,
    make_scene,
    of,
    on_plane,
    point,
    quad,
    rays,
    rotation,
    spot,
    turned,
)

pytestmark = pytest.mark.gl

UP = (0, 0, 1)
UNBIASED = Settings(shadow_fit=False, shadow_bias=0.0, shadow_normal_offset=0.0)
SLOPE = 2.0
"""Slope bias that a map of faces turned to the light needs against acne."""


def texel_on(
    light: SpotLight, points: Floats, normal: tuple[float, float, float], size: int
) -> Floats:
    """World units that a texel of the light's map covers at most, at points of a plane.

    Across the axis a texel is 2 tan(half-angle) z / size wide; on a plane that a ray meets under
    the angle theta it is longer by 1 / cos(theta), and by no more than 1 / cos of the ray's angle
    with the axis again. The pyramid is wider than the cone by a margin of 6 texels.
    """
    away = points - light.position
    r = np.linalg.norm(away, axis=-1)
    z = away @ light.direction
    across = 2 * math.tan(light.half_angle) * (1 + 6 / size) * z / size
    return np.asarray(across / np.abs(away @ np.asarray(normal) / r) * r / z)


def texel_at_one(renderer: Renderer) -> float:
    """Size of a texel of the wide tile drawn last, in the plane at distance 1."""
    return renderer.pipeline.shadow.tiles[0].frustum.texel


def half_plane(turn: Floats) -> list[Piece]:
    """A thick slab over x < 0 whose rim runs along the turned y axis."""
    return turned(box((-300, -400, 60), (0, 400, 70)), turn)


@pytest.mark.parametrize("cull", list(CullFace))
@pytest.mark.parametrize("fit", [False, True])
@pytest.mark.parametrize("size", [256, 1024])
@pytest.mark.parametrize(("yaw", "over"), [(0, 50), (17, 50), (45, -30), (100, -30)])
def test_edge_of_a_half_planes_shadow(
    renderer: Renderer,
    draw: Draw,
    yaw: float,
    over: float,
    size: int,
    fit: bool,
    cull: CullFace,
) -> None:
    """The light's line through the slab's rim meets the floor where visibility passes 1/2.

    The linear filter reaches over two texels: a diagonal edge is all lit or dark 1.5 from it.
    """
    turn = rotation(UP, yaw)
    position = turn @ (over, 10, 300)
    light = spot(position, turn @ (over / 2, 0, 0), 30)
    scene = make_scene([floor(600), *half_plane(turn)], light)
    # Projecting the rim's lower and upper edge from the light; the shadow ends at the farther one.
    edge = max(over - over * 300 / (300 - z) for z in (60, 70))
    view = looking(turn @ (edge, 0, 50), turn @ (edge + 0.1, 0, 0), 15)
    settings = Settings(shadow_map_size=size, shadow_cull=cull, shadow_fit=fit)
    visibility = draw(scene, view, View.SHADOW, settings)
    p, _ = on_plane(view, UP)
    x = p @ (turn @ (1, 0, 0)) - edge
    texel = texel_on(light, p, UP, size)
    whole = 2 * math.tan(light.half_angle) * (1 + 6 / size) / size
    if fit:  # the map is spent on what the camera sees, so that its texels are smaller
        texel *= texel_at_one(renderer) / whole
        assert texel_at_one(renderer) <= whole
    else:
        assert texel_at_one(renderer) == pytest.approx(whole)
    assert (np.abs(x) > 2 * texel).any() and (visibility == 1).any() and (visibility == 0).any()
    assert (visibility[x > texel] > 0.5).all() and (visibility[x < -texel] < 0.5).all()
    assert (visibility[x > 1.5 * texel] == 1).all()
    assert (visibility[x < -1.5 * texel] == 0).all()


def edge_crossings(visibility: Floats, x: Floats) -> Floats:
    """x at which visibility passes 1/2 in each column, where x grows upwards; (columns,)."""
    x, visibility = x[::-1], visibility[::-1]
    first = np.argmax(visibility >= 0.5, axis=0)
    column = np.arange(x.shape[1])
    low, high = visibility[first - 1, column], visibility[first, column]
    share = (0.5 - low) / (high - low)
    return np.asarray(x[first - 1, column] * (1 - share) + x[first, column] * share)


def test_shadow_edge_is_unbiased(draw: Draw) -> None:
    """Over the length of an edge that is askew to the map, errors of a texel average out."""
    turn = rotation(UP, 17)
    light = spot(turn @ (50, 10, 300), turn @ (25, 0, 0), 30)
    scene = make_scene([floor(600), *half_plane(turn)], light)
    edge = 50 - 50 * 300 / (300 - 60)
    view = looking(turn @ (edge, 0, 50), turn @ (edge + 0.1, 0, 0), 30)
    visibility = draw(scene, view, View.SHADOW, UNBIASED)
    p, _ = on_plane(view, UP)
    x = edge_crossings(visibility, p @ (turn @ (1, 0, 0)) - edge)
    texel = texel_on(light, p, UP, 1024).max()
    assert np.abs(x).max() < texel
    assert abs(x.mean()) < 0.1 * texel


def test_shadow_of_a_box_on_the_floor(draw: Draw) -> None:
    """Every pixel of the floor: is the segment to the light inside the box? (slab method)"""
    light = spot((120, -80, 400), (0, 0, 20), 30)
    low, high = np.array([-40, -30, 15]), np.array([50, 20, 80])
    scene = make_scene([floor(600), *box(low, high)], light)
    view = camera((0, 0, 14), pitch=90, fov=172)
    p, _ = on_plane(view, UP)
    light_to_p = p - light.position
    texel = texel_on(light, p, UP, 1024)[..., np.newaxis]

    def blocked(grown: Floats) -> NDArray[np.bool_]:
        t = np.stack([(low - grown - light.position) / light_to_p,
                      (high + grown - light.position) / light_to_p])  # fmt: skip
        return np.asarray(t.min(axis=0).max(axis=-1) < t.max(axis=0).min(axis=-1))

    cosine = light_to_p @ light.direction / np.linalg.norm(light_to_p, axis=-1)
    near = cosine > math.cos(math.radians(29.5))
    visibility = draw(scene, view, View.SHADOW, UNBIASED)
    assert not visibility[near & blocked(-texel)].any()
    assert (visibility[near & ~blocked(texel)] == 1).all()
    assert (near & blocked(-texel)).sum() > 300


@pytest.mark.parametrize("tilt", [0, 20, 45, 60, 75, 85])
@pytest.mark.parametrize("turn", [0, 37])
def test_no_acne_on_a_tilted_slab_at_default_settings(draw: Draw, tilt: float, turn: float) -> None:
    matrix = rotation(UP, turn) @ rotation((0, 1, 0), tilt)
    slab = turned(box((-150, -150, -16), (150, 150, 0)), matrix)
    light = spot((0, 0, 400), (0, 0, 0), 30)
    normal = matrix @ np.array([0.0, 0.0, 1.0])
    view = looking(normal * 120 + matrix @ np.array([1.0, 0, 0]), (0, 0, 0), 60)
    scene = make_scene(slab, light)
    np.testing.assert_array_equal(draw(scene, view, View.SHADOW), 1.0)


@pytest.mark.parametrize(("tilt", "least"), [(0, 1), (45, 1), (60, 0.9), (75, 0.8), (85, 0.7)])
def test_no_acne_on_a_two_sided_sheet_at_default_settings(
    draw: Draw, tilt: float, least: float
) -> None:
    """Its lit side is in the map whichever faces are left out: it has no other.

    Towards grazing light the filter mixes in what lies under the offset, a little.
    """
    matrix = rotation(UP, 37) @ rotation((0, 1, 0), tilt)
    sheet = turned([quad((0, 0, 0), (150, 0, 0), (0, 150, 0))], matrix)
    normal = matrix @ np.array([0.0, 0.0, 1.0])
    view = looking(normal * 120 + matrix @ np.array([1.0, 0, 0]), (0, 0, 0), 60)
    both = of(Material("sheet", sides=Sides.BOTH), *sheet)
    scene = make_scene(both, spot((0, 0, 400), (0, 0, 0), 30))
    assert draw(scene, view, View.SHADOW).min() >= least


@pytest.mark.parametrize("cull", [CullFace.BACK, CullFace.NONE])
@pytest.mark.parametrize("tilt", [0, 45, 75])
def test_slope_bias_cures_acne_where_lit_faces_are_in_the_map(
    draw: Draw, tilt: float, cull: CullFace
) -> None:
    matrix = rotation(UP, 37) @ rotation((0, 1, 0), tilt)
    slab = turned(box((-150, -150, -16), (150, 150, 0)), matrix)
    normal = matrix @ np.array([0.0, 0.0, 1.0])
    view = looking(normal * 120 + matrix @ np.array([1.0, 0, 0]), (0, 0, 0), 60)
    scene = make_scene(slab, spot((0, 0, 400), (0, 0, 0), 30))
    biased = Settings(shadow_cull=cull, shadow_slope_bias=SLOPE)
    np.testing.assert_array_equal(draw(scene, view, View.SHADOW, biased), 1.0)
    bare = Settings(shadow_cull=cull, shadow_bias=0.0, shadow_normal_offset=0.0)
    assert draw(scene, view, View.SHADOW, bare).min() < 1


def test_bias_moves_receivers_towards_the_light_by_its_length(draw: Draw) -> None:
    """A caster that hangs lower than the bias over the floor casts nothing, a higher one does."""
    sheet = of(Material("sheet", sides=Sides.BOTH), quad((0, 0, 4), (50, 0, 0), (0, 50, 0)))
    scene = make_scene([floor(), *sheet], spot((0, 0, 200), (0, 0, 0), 30))
    view = camera((60, 0, 2), pitch=0, yaw=180, fov=20)
    under = draw(scene, view, View.SHADOW, Settings(shadow_bias=3.9, shadow_normal_offset=0.0))
    over = draw(scene, view, View.SHADOW, Settings(shadow_bias=4.1, shadow_normal_offset=0.0))
    p, depth = on_plane(view, UP)
    inside = (np.abs(p[..., :2]) < 45).all(axis=-1) & np.isfinite(depth)
    assert inside.sum() > 1000
    assert not under[inside].any()
    assert (over[inside] == 1).all()


def test_cut_out_casters_cast_what_is_left_of_them(draw: Draw, tmp_path: Path) -> None:
    pixels = np.full((4, 4, 4), 255, np.uint8)
    pixels[1:3, 2, 3] = 0  # a slit: s in [1/2, 3/4], t in [1/4, 3/4]
    pixels = pixels.repeat(16, axis=0).repeat(16, axis=1)
    grate = Material("grate", "grate.png", sides=Sides.BOTH, alpha_test=AlphaTest.GE128)
    sheet = of(grate, quad((0, 0, 100), (80, 0, 0), (0, 80, 0)))
    light = spot((0, 0, 300), (0, 0, 0), 40)
    archive = image_archive(tmp_path, {"grate.png": pixels})
    scene = make_scene([floor(), *sheet], light, archive=archive)
    view = camera((0, 0, 90), yaw=90, pitch=90, fov=120)
    visibility = draw(scene, view, View.SHADOW)
    p, _ = on_plane(view, UP)
    on_sheet = p[..., :2] * (300 - 100) / 300  # from the light through the sheet to the floor
    s, t = (on_sheet[..., 0] / 80 + 1) / 2, (1 - on_sheet[..., 1] / 80) / 2
    margin = 0.02

    def inside(low_s: float, high_s: float, low_t: float, high_t: float) -> NDArray[np.bool_]:
        return (s > low_s) & (s < high_s) & (t > low_t) & (t < high_t)

    hole = inside(0.5 + margin, 0.75 - margin, 0.25 + margin, 0.75 - margin)
    round_it = inside(0.5 - margin, 0.75 + margin, 0.25 - margin, 0.75 + margin)
    sheet_shadow = inside(margin, 1 - margin, margin, 1 - margin) & ~round_it
    assert hole.sum() > 100 and sheet_shadow.sum() > 1000
    assert (visibility[hole] == 1).all()
    assert not visibility[sheet_shadow].any()


def test_blended_surfaces_cast_no_shadow(draw: Draw) -> None:
    glass = Material(
        "glass", sides=Sides.BOTH, blend=(BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA)
    )
    light, view = spot((0, 0, 300), (0, 0, 0), 30), camera((0, 0, 40), pitch=90)
    pane = quad((0, 0, 100), (50, 0, 0), (0, 50, 0))
    assert (draw(make_scene([floor(), *of(glass, pane)], light), view, View.SHADOW) == 1).all()
    solid = of(Material("solid", sides=Sides.BOTH), pane)
    assert (draw(make_scene([floor(), *solid], light), view, View.SHADOW) < 1).any()


def test_faces_drawn_from_behind_cast_as_their_mirror_images_do(draw: Draw) -> None:
    """A body made of inward faces whose *back* is drawn looks and shadows like an outward one."""
    light, view = spot((100, 0, 300), (0, 0, 0), 30), camera((-200, 10, 120), pitch=30)
    outward = make_scene([floor(), *box((-30, -30, 0), (30, 30, 60))], light)
    inside_out = of(
        Material("inside out", sides=Sides.BACK), *box((-30, -30, 0), (30, 30, 60), inward=True)
    )
    flipped = make_scene([floor(), *inside_out], light)
    for stage in (View.DEPTH, View.SHADOW, View.DIRECT):
        expected = draw(outward, view, stage)
        np.testing.assert_allclose(draw(flipped, view, stage), expected, rtol=1e-5, atol=1e-3)


def test_outside_of_the_cone_nothing_is_reached_by_the_key_light(draw: Draw) -> None:
    """As the view's description promises; also behind the light."""
    light = spot((0, 0, 100), (0, 0, 0), 20)
    above = quad((0, 0, 150), (0, 200, 0), (200, 0, 0))
    scene = make_scene([floor(), above], light)
    for view, z in (camera((0, 0, 50), pitch=90, fov=150), 0), (camera((0, 0, 50), pitch=-90), 150):
        p, _ = on_plane(view, UP, z)
        away = p - light.position
        cosine = away @ light.direction / np.linalg.norm(away, axis=-1)
        outside = cosine < math.cos(math.radians(21))
        assert outside.any()
        assert not draw(scene, view, View.SHADOW)[outside].any()


def test_shadow_map_view_shows_distances_along_the_axis(renderer: Renderer) -> None:
    light = spot((30, -20, 200), (50, 10, 0), 35)
    scene = make_scene([floor(1000)], light)
    settings = Settings(
        shadow_map_size=64, shadow_cull=CullFace.NONE, shadow_fit=False, exposure=1.0
    )
    shown = renderer.render(
        scene, camera((0, 0, 50)), [View.SHADOW_MAP], settings=settings, linear=True
    )[View.SHADOW_MAP]
    assert shown.shape == (64, 64) and shown.dtype == np.float32
    # The map is the picture of a camera at the light that looks along its axis.
    angle = 2 * math.degrees(math.atan(math.tan(light.half_angle) * (1 + 6 / 64)))
    eye = looking(light.position, light.position + light.direction, angle)
    towards = rays(eye, (64, 64))
    expected = -light.position[2] / towards[..., 2]
    np.testing.assert_allclose(shown, expected, rtol=5e-4)


def test_shadow_map_view_as_displayed(renderer: Renderer) -> None:
    scene = make_scene(box((-20, -20, 0), (20, 20, 40)), spot((0, 0, 200), (0, 0, 0), 35))
    view = camera((-90, 0, 20))
    shown = renderer.render(scene, view, ["shadow-map"], settings=UNBIASED)[View.SHADOW_MAP]
    assert shown.shape == (1024, 1024, 3) and shown.dtype == np.uint8
    assert (shown[0, 0] == 255).all() and (shown[512, 512] < 255).all()


def test_there_is_no_shadow_map_without_a_light_that_casts(renderer: Renderer) -> None:
    scene = make_scene([floor()], replace(point((0, 0, 100)), casts_shadow=False))
    with pytest.raises(UsageError, match="no shadow map"):
        renderer.render(scene, camera((0, 0, 50)), ["shadow-map"])


def test_two_shadowed_lights_have_a_map_each(draw: Draw) -> None:
    """A red and a blue light on two sides of a post: each colour misses in its own shadow."""
    red = spot((150, 0, 100), (0, 0, 0), 40, (200, 0, 0))
    blue = spot((0, -150, 100), (0, 0, 0), 40, (0, 0, 200))
    scene = make_scene([floor(), *box((-10, -10, 0), (10, 10, 50))])
    view = camera((0, 0, 200), pitch=90, fov=40)
    settings = Settings(sky_light=False)
    both = draw(scene.with_lights(red, blue), view, View.DIRECT, settings)
    only_red = draw(scene.with_lights(red), view, View.DIRECT, settings)
    only_blue = draw(scene.with_lights(blue), view, View.DIRECT, settings)
    assert (only_red[..., 0] == 0).any() and (only_blue[..., 2] == 0).any()
    # Places in a wider atlas round differently, which shows where the filter mixes.
    np.testing.assert_allclose(both, only_red + only_blue, rtol=1e-5, atol=1e-3 * both.max())
    swapped = draw(scene.with_lights(blue, red), view, View.DIRECT, settings)
    np.testing.assert_allclose(swapped, both, rtol=1e-5, atol=1e-3 * both.max())


def test_key_light_is_the_first_that_casts(draw: Draw) -> None:
    first, second = spot((150, 0, 100), (0, 0, 0), 40), spot((0, -150, 100), (0, 0, 0), 40)
    scene = make_scene([floor(), *box((-10, -10, 0), (10, 10, 50))])
    view = camera((0, 0, 200), pitch=90, fov=40)
    alone = draw(scene.with_lights(second), view, View.SHADOW)
    bare = replace(first, casts_shadow=False)
    lights = (replace(point((0, 0, 90)), casts_shadow=False), bare, second, first)
    np.testing.assert_array_equal(draw(scene.with_lights(*lights), view, View.SHADOW), alone)


def report(
    renderer: Renderer,
    scene: Scene,
    view: Camera,
    settings: Settings = DIM,
    stage: View = View.FINAL,
) -> FrameReport:
    renderer.open(scene)
    return renderer.draw(FrameInput(scene, view, settings, 1.0, stage))


def test_shadow_map_of_the_whole_cone_is_redrawn_only_for_a_reason(renderer: Renderer) -> None:
    """The light or a setting of the map has changed; the camera and all else do not count."""
    light = spot((0, 0, 300), (0, 0, 0), 30)
    scene = make_scene([floor(), *box((-10, -10, 0), (10, 10, 50))], light)
    view, other = camera((-100, 0, 80), pitch=20), camera((0, 90, 30), yaw=45)
    whole = Settings(shadow_fit=False)

    def redrawn(scene: Scene, view: Camera, stage: View = View.FINAL, **changes: Any) -> bool:
        settings = msgspec.structs.replace(whole, **changes)
        done = report(renderer, scene, view, settings, stage)
        assert (done.shadow_draws > 0) == (done.shadow_triangles > 0) == done.shadow_redrawn
        return done.shadow_redrawn

    first = report(renderer, scene, view, whole)
    assert first.shadow_redrawn and first.shadow_draws == 1
    assert first.shadow_triangles <= scene.mesh.triangle_count
    for stage in (View.FINAL, View.SHADOW, View.NORMALS):
        assert not redrawn(scene, other, stage)
    for change in (
        {"sky_light": False},
        {"shadow_bias": 1.0},
        {"shadow_normal_offset": 0.0},
        {"albedo": 0.5},
        {"culling": False},
        {"shadows": False},
    ):
        assert not redrawn(scene, view, **change), change
        assert not redrawn(scene, view), change

    moved = scene.with_lights(spot((0, 0, 299), (0, 0, 0), 30))
    assert redrawn(moved, view)
    for matters in (
        {"shadow_map_size": 512},
        {"shadow_cull": CullFace.NONE},
        {"shadow_slope_bias": 1.0},
    ):
        assert redrawn(moved, view, **matters), matters
        assert not redrawn(moved, other, **matters), matters
    assert redrawn(moved, view, redraw_shadows=True)
    assert redrawn(moved, view, redraw_shadows=True)


def test_kept_shadow_map_gives_the_same_picture_as_a_new_one(draw: Draw) -> None:
    light = spot((60, 0, 300), (0, 0, 0), 30)
    scene = make_scene([floor(), *box((-10, -10, 0), (10, 10, 50))], light)
    view, other = camera((-100, 0, 80), pitch=20), camera((0, 90, 30), yaw=45)
    draw(scene, other, View.DIRECT)
    kept = draw(scene, view, View.DIRECT)
    np.testing.assert_array_equal(draw(scene, view, View.DIRECT, redraw_shadows=True), kept)


def test_switching_shadows_off_and_on_again(draw: Draw) -> None:
    light = spot((60, 0, 300), (0, 0, 0), 30)
    scene = make_scene([floor(), *box((-10, -10, 0), (10, 10, 50))], light)
    view = camera((-100, 0, 80), pitch=20)
    before = draw(scene, view, View.DIRECT)
    assert (draw(scene, view, View.DIRECT, shadows=False) > before).any()
    np.testing.assert_array_equal(draw(scene, view, View.DIRECT), before)


def test_changing_one_light_or_the_map_size_and_back(draw: Draw) -> None:
    one, two = spot((60, 0, 300), (0, 0, 0), 30), spot((0, 80, 200), (0, 0, 0), 35)
    scene = make_scene([floor(), *box((-10, -10, 0), (10, 10, 50))], one)
    view = camera((-100, 0, 80), pitch=20)
    before = draw(scene, view, View.DIRECT)
    draw(scene.with_lights(one, two), view, View.DIRECT)
    draw(scene, view, View.DIRECT, shadow_map_size=64)
    np.testing.assert_array_equal(draw(scene, view, View.DIRECT), before)


def test_receivers_behind_every_caster_and_beyond_the_map_are_lit(draw: Draw) -> None:
    """A scene that is flat across the light's axis has a depth range of almost nothing."""
    scene = make_scene([floor()], spot((0, 0, 500), (0, 0, 0), 40))
    np.testing.assert_array_equal(draw(scene, camera((0, 0, 50), pitch=90), View.SHADOW), 1.0)


@pytest.mark.parametrize("degrees", [1, 45, 80, 89])
def test_narrow_and_wide_cones_cast_shadows(draw: Draw, degrees: float) -> None:
    """A ceiling low enough over the floor that its middle lies in deep shadow."""
    ceiling = box((-300, -300, 40), (300, 300, 60))
    scene = make_scene([floor(), *ceiling], spot((0, 0, 300), (0, 0, 0), degrees))
    view = camera((0, 0, 39), pitch=90, fov=5)
    np.testing.assert_array_equal(draw(scene, view, View.SHADOW), 0.0)
    above = looking((0, 0, 290), (0, 0, 60), 0.9 if degrees == 1 else 5)
    np.testing.assert_array_equal(draw(scene, above, View.SHADOW), 1.0)


@pytest.mark.parametrize("fit", [True, False])
def test_a_triangle_turned_away_is_in_its_own_shadow_whatever_its_normals_say(
    draw: Draw, fit: bool
) -> None:
    """As of a steep slope in terrain, whose normals are smoothed with those of the lit top."""
    slope = quad((0, 0, 0), (0, 60, 0), (20, 0, 60))  # looks down a little, towards +x
    bent = replace(slope, vertices=slope.vertices.copy())
    bent.vertices["normal"] = np.array([0.6, 0, 0.8])
    light = spot((40, 0, 400), (0, 0, 0), 40, 1e4)
    scene, view = make_scene([bent], light), looking((150, 10, -20), (0, 0, 0), 60)
    there = np.isfinite(draw(scene, view, View.DEPTH))
    assert there.mean() > 0.2
    settings = Settings(shadow_fit=fit)
    assert draw(scene, view, View.DIRECT, settings).max() == 0
    assert draw(scene, view, View.SHADOW, settings).max() == 0
    assert draw(scene, view, View.DIRECT, settings, shadows=False)[there].min() > 0
    below = make_scene([bent], spot((300, 0, 60), (0, 0, 0), 40, 1e4))
    assert draw(below, view, View.DIRECT, settings)[there].min() > 0


@pytest.mark.parametrize("cosine", [0.002, -0.002])
def test_the_side_of_a_triangle_that_a_far_light_grazes_is_told_without_noise(
    draw: Draw, cosine: float
) -> None:
    """Rays to a sun hardly differ from pixel to pixel, by less than float32 keeps of them."""
    across, along = np.array([3, 0, -1]) / np.sqrt(10), np.array([1, 0, 3]) / np.sqrt(10)
    slope = quad((0, 0, 0), (0, 60, 0), (20, 0, 60))
    bent = replace(slope, vertices=slope.vertices.copy())
    bent.vertices["normal"] = np.array([0.6, 0, 0.8])
    light = spot(tuple(50_000 * (along + cosine * across)), (0, 0, 0), 1, 1e9)
    scene, view = make_scene([bent], light), looking((150, 10, -20), (0, 0, 0), 60)
    there = np.isfinite(draw(scene, view, View.DEPTH))
    found = draw(scene, view, View.DIRECT)[there]
    assert (found > 0).all() if cosine > 0 else (found == 0).all()
