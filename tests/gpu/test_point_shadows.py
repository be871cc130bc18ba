"""Shadow maps around point lights against geometry: edges all around, seams, what is drawn."""

from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest

from conftest import Draw
from figures import figure, with_characters
from followspot.arrays import Floats, Mask
from followspot.passes.frame import FrameInput, FrameReport
from followspot.passes.view import View
from followspot.present.renderer import Renderer
from followspot.scene.camera import Camera
from followspot.scene.character import Character
from followspot.scene.light import Light
from followspot.scene.scene import Scene
from followspot.scene.settings import CullFace, Settings
from followspot.scene.walk import along
from synthetic import Piece, box, camera, floor, looking, make_scene, on_plane, point, rays, spot

pytestmark = pytest.mark.gl

ROOM = 200.0
LAMP = point((5, -10, 15), 900)
DIRECTIONS = [
    (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1),
    (1, 1, 0), (-1, 1, 0), (0, 1, 1), (0, -1, -1), (1, 0, -1), (-1, 0, 1), (1, 1, 1), (-1, -1, -1),
]  # fmt: skip
"""Towards sides of the cube, its edges, and corners."""


def room() -> list[Piece]:
    return box((-ROOM, -ROOM, -ROOM), (ROOM, ROOM, ROOM), inward=True)


def obstacles(size: float = 12) -> tuple[Floats, Floats]:
    """Mins and maxs of boxes all around the lamp, 80 to 110 units from it."""
    middle = LAMP.position + 80 * np.array(DIRECTIONS, float) / np.sqrt([[1]] * 6 + [[1.5]] * 8)
    half = np.array([size, 0.8 * size, 1.3 * size])
    return middle - half, middle + half


def meets(start: Floats, way: Floats, mins: Floats, maxs: Floats, most: float) -> Mask:
    """(...,) whether rays (..., 3) meet any of the boxes before `most` of their length."""
    with np.errstate(divide="ignore"):
        near, far = ((end - start) / way[..., np.newaxis, :] for end in (mins, maxs))
    enter = np.minimum(near, far).max(axis=-1)
    leave = np.maximum(near, far).min(axis=-1)
    found: Mask = ((enter < leave) & (leave > 0) & (enter < most)).any(axis=-1)
    return found


def walls(view: Camera) -> Floats:
    """(h, w, 3) where each pixel's ray meets the room's walls."""
    way = rays(view)
    ends = np.where(way > 0, ROOM, -ROOM) - view.position
    reach = np.where(way == 0, np.inf, ends / np.where(way == 0, 1, way)).min(axis=-1)
    return np.asarray(view.position + way * reach[..., np.newaxis])


@pytest.mark.parametrize(
    "settings",
    [
        Settings(),
        Settings(shadow_fit=False),
        Settings(shadow_cull=CullFace.NONE, shadow_slope_bias=2.0),
        Settings(shadow_taps=3),
    ],
    ids=["default", "whole", "all faces", "wide filter"],
)
def test_edges_all_around_the_light(draw: Draw, settings: Settings) -> None:
    """Walls are dark where the ray to the lamp meets a box, up to a few texels from the edges."""
    mins, maxs = obstacles()
    pieces = [piece for low, high in zip(mins, maxs, strict=True) for piece in box(low, high)]
    scene = make_scene([*room(), *pieces], LAMP)
    # At the boxes, a texel is 2 / 724 of the distance, at most 110 units; filters reach over some.
    blur = (1.5 + settings.shadow_taps) * 2 * 110 / 724
    mixed = 0.0
    for towards in DIRECTIONS:
        eye = LAMP.position - 45 * np.array(towards) / np.linalg.norm(towards) + (9, 5, -7)
        view = looking(eye, LAMP.position, 100)
        visibility = draw(scene, view, View.SHADOW, settings)
        place = walls(view)
        seen = ~meets(view.position, place - view.position, mins - 0.5, maxs + 0.5, 1.0)
        way = place - LAMP.position
        dark = meets(LAMP.position, way, mins + blur, maxs - blur, 1.0)
        lit = ~meets(LAMP.position, way, mins - blur, maxs + blur, 1.0)
        assert (seen & dark).sum() > 50 and (seen & lit).sum() > 1000
        assert (visibility[seen & dark] == 0).all()
        assert (visibility[seen & lit] == 1).all()
        mixed += (seen & ~dark & ~lit).mean() / len(DIRECTIONS)
    assert mixed < 0.12


@pytest.mark.parametrize("cull", list(CullFace))
@pytest.mark.parametrize("fit", [False, True])
def test_an_empty_room_is_lit_without_seams_or_acne(draw: Draw, fit: bool, cull: CullFace) -> None:
    scene = make_scene(room(), LAMP)
    for towards in DIRECTIONS:
        view = looking((-60, 70, -40), np.array([-60, 70, -40]) + towards, 100)
        settings = Settings(shadow_fit=fit, shadow_cull=cull)
        slope = 0.0 if cull is CullFace.FRONT else 2.0  # as spot lights need it
        settings = msgspec.structs.replace(settings, shadow_slope_bias=slope)
        assert (draw(scene, view, View.SHADOW, settings) == 1).all(), towards


def test_it_lights_what_a_spot_light_in_its_place_does(draw: Draw) -> None:
    """Inside of the cone, of one intensity, where the two maps say the same."""
    mins, maxs = (-20, -20, 0), (20, 20, 30)
    scene = make_scene([floor(300), *box(mins, maxs)])
    cone = spot((30, 40, 150), (0, 0, 0), 60)
    lamp = point(cone.position, cone.intensity * 4 * np.pi)
    view = looking((-90, -80, 120), (0, 0, 0), 60)
    settings = Settings(sky_light=False)
    by_lamp, by_cone = (
        draw(scene.with_lights(light), view, View.DIRECT, settings) for light in (lamp, cone)
    )
    p, _ = on_plane(view, (0, 0, 1))
    away = p - cone.position
    inside = away @ cone.direction > cone.cos_rim * np.linalg.norm(away, axis=-1)
    same = np.asarray(np.isclose(by_lamp, by_cone, rtol=1e-4).all(axis=-1))
    assert same[inside].mean() > 0.985
    assert (by_cone[inside] > 0).mean() > 0.5 and (by_cone[inside] == 0).mean() > 0.02
    assert (by_lamp[~inside] > 0).any() and (by_cone[~inside] == 0).all()


def frame_of(scene: Scene, view: Camera, time: float = 0.0, **changes: Any) -> FrameInput:
    settings = msgspec.structs.replace(Settings(exposure=1.0), **changes)
    return FrameInput(scene, view, settings, 1.0, time=time)


def test_maps_are_redrawn_only_for_a_reason(renderer: Renderer) -> None:
    scene = make_scene([floor(300), *box((30, 30, 0), (60, 60, 50))], point((0, 0, 100), 900))
    renderer.open(scene)

    def draw(view: Camera, **changes: Any) -> FrameReport:
        return renderer.draw(frame_of(scene, view, **changes))

    below = camera((0, 0, 90), pitch=90, fov=60)
    report = draw(below)
    shadow = renderer.pipeline.shadow
    assert report.shadow_redrawn
    places = [(k % 3, k // 3) for k in range(6)]
    assert [tile.place for tile in shadow.tiles] == places
    assert report.shadow_triangles == sum(tile.casters.triangle_count for tile in shadow.tiles)
    assert not draw(below).shadow_redrawn
    assert not draw(looking((-250, -250, 60), (0, 0, 0), 70)).shadow_redrawn, "wherever one looks"
    assert draw(below, redraw_shadows=True).shadow_redrawn
    assert draw(below, shadow_fit=False).shadow_redrawn, "other tiles"
    assert [tile.place for tile in shadow.tiles] == places
    moved = replace(scene, lights=(point((1, 0, 100), 900),))
    assert renderer.draw(frame_of(moved, below)).shadow_redrawn
    assert not frame_of(scene, below, shadows=False).shadowed


def test_spots_and_points_share_the_atlas(draw: Draw, renderer: Renderer) -> None:
    """Lights together give what each gives alone, whatever their order and kind."""
    scene = make_scene([*room(), *box((-30, -30, -60), (30, 30, -40))])
    lights: list[Light] = [
        point((90, 10, 50), (900, 0, 0)),
        spot((-90, -30, 150), (0, 0, -100), 50, (0, 900, 0)),
        replace(point((0, 90, 60), (0, 0, 900)), casts_shadow=False),
        point((-60, 40, -10), (400, 400, 0)),
        spot((0, 0, 190), (0, 0, 0), 40, (0, 300, 300)),
    ]
    settings = Settings(sky_light=False)
    for view in (looking((-150, -150, 100), (0, 0, -80), 90), camera((0, 0, 150), pitch=90)):
        together = draw(scene.with_lights(*lights), view, View.DIRECT, settings)
        apart = [draw(scene.with_lights(each), view, View.DIRECT, settings) for each in lights]
        np.testing.assert_allclose(together, sum(apart), rtol=1e-4, atol=2e-3 * together.max())
        bare = [
            draw(scene.with_lights(replace(each, casts_shadow=False)), view, View.DIRECT, settings)
            for each in lights
        ]
        differ = [np.abs(a - b).max() > 0 for a, b in zip(apart, bare, strict=True)]
        assert differ == [True, True, False, True, True]


def test_eight_point_lights_with_shadows(draw: Draw) -> None:
    lights = [point((60 * np.cos(k), 60 * np.sin(k), 80), 500) for k in range(8)]
    scene = make_scene([floor(), *box((-10, -10, 0), (10, 10, 40))])
    view, settings = camera((0, 0, 190), pitch=90), Settings(sky_light=False)
    together = draw(scene.with_lights(*lights), view, View.DIRECT, settings)
    apart = sum(draw(scene.with_lights(each), view, View.DIRECT, settings) for each in lights)
    np.testing.assert_allclose(together, apart, rtol=1e-4, atol=2e-3 * together.max())


def test_what_was_prepared_and_not_drawn_changes_nothing(renderer: Renderer) -> None:
    """Room is made for more maps, and for fewer again: what casts is there all the same."""
    scene = make_scene([floor(300), *box((-20, -20, 0), (20, 20, 30))], point((30, 40, 150), 900))
    view = looking((-90, -80, 120), (0, 0, 0), 60)
    frame = replace(frame_of(scene, view), view=View.SHADOW)

    def drawn() -> Floats:
        renderer.draw(frame, linear=True)
        return renderer.target(linear=True).read()[..., 0].astype(np.float64)

    renderer.open(scene)
    before = drawn()
    assert 0.01 < (before == 0).mean() < 0.9
    more = frame_of(replace(scene, lights=(*scene.lights, point((0, 0, 90), 9))), view)
    renderer.pipeline.prepare(more, renderer.target())
    np.testing.assert_array_equal(drawn(), before)


def test_what_is_far_away_changes_no_shadow(draw: Draw) -> None:
    """A lamp's planes are its own, whatever stands behind the horizon."""
    lamp, things = point((0, 0, 16), 900), box((4, -3, 4), (7, 3, 9))
    view = looking((-60, -50, 60), (20, 0, 0), 60)
    near, far = (
        draw(make_scene([floor(size), *things], lamp), view, View.SHADOW) for size in (500, 20000)
    )
    p, _ = on_plane(view, (0, 0, 1))
    inside = np.abs(p[..., :2]).max(axis=-1) < 400
    np.testing.assert_allclose(near[inside], far[inside], atol=0.01)
    assert (near[inside] == 0).mean() > 0.004


def test_shadow_map_view_unfolds_the_cube(renderer: Renderer) -> None:
    """Distances along the sides' axes: of a room's walls the same all over a side."""
    mins, maxs = np.array([-90, -100, -110]), np.array([95, 105, 115])
    scene = make_scene(box(mins, maxs, inward=True), point((0, 0, 0), 900))
    settings = Settings(shadow_cull=CullFace.NONE, shadow_fit=False, shadow_map_size=128)
    picture = renderer.render(
        scene, camera((0, 0, 0)), [View.SHADOW_MAP], settings=settings, linear=True
    )[View.SHADOW_MAP]
    assert picture.shape == (3 * 128, 4 * 128)
    middles = picture.reshape(3, 128, 4, 128).swapaxes(1, 2)[:, :, 20:108, 20:108]
    wanted = np.full((3, 4), np.inf)
    wanted[1] = maxs[1], maxs[0], -mins[1], -mins[0]  # +Y +X -Y -X
    wanted[0, 1], wanted[2, 1] = maxs[2], -mins[2]
    np.testing.assert_allclose(middles, np.broadcast_to(wanted.T, (88, 88, 4, 3)).T, rtol=1e-4)


def test_the_cubes_picture_is_seen_from_the_light(renderer: Renderer) -> None:
    """A box ahead (+X), to the right (-Y) and above lies right of the middle and higher."""
    lamp = point((0, 0, 0), 900)
    scene = make_scene([*room(), *box((90, -60, 30), (100, -40, 50))], lamp)
    settings = Settings(shadow_fit=False, shadow_map_size=128, shadow_cull=CullFace.FRONT)
    picture = renderer.render(
        scene, camera((-150, 0, 0)), [View.SHADOW_MAP], settings=settings, linear=True
    )[View.SHADOW_MAP]
    rows, columns = np.nonzero(np.isfinite(picture))
    up, right = 1 - 2 * (rows / 128 - 1), 2 * (columns / 128 - 1) - 1
    assert len(rows) > 30
    texel = 2 / 128
    # What is turned away from the light: the far side at 100, and two that end at 90.
    assert 30 / 100 - texel < up.min() and up.max() < 50 / 90 + texel
    assert 40 / 100 - texel < right.min() and right.max() < 60 / 90 + texel


def test_characters_cast_around_a_light_and_leave_no_shadow_behind(
    renderer: Renderer, draw: Draw
) -> None:
    """Only they are redrawn; a second pass over the same times gives the same pictures."""
    way = along([(-100, -80, -160), (60, 80, -160)], 40.0)
    body = figure([box((-20, -20, -20), (20, 20, 20))])
    scene = with_characters(make_scene(room(), LAMP), Character(body, way))
    view = looking((-150, -150, 120), (0, 0, -180), 90)
    empty = draw(make_scene(room(), LAMP), view, View.SHADOW)
    pictures = [draw(scene, view, View.SHADOW, time=t) for t in (0.5, 3.0)]
    for picture in pictures:
        assert 0.004 < (picture != empty).mean() < 0.2
    assert (pictures[0] != pictures[1]).mean() > 0.004
    np.testing.assert_array_equal(draw(scene, view, View.SHADOW, time=0.5), pictures[0])
    renderer.open(scene)
    done = [renderer.draw(frame_of(scene, view, t)) for t in (0.0, 0.1, 1.7)]
    assert [each.shadow_redrawn for each in done[1:]] == [False, False]
