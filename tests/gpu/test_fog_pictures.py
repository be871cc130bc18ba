"""What is seen through fog; how much of it is on the way is told here by where rays cross."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from conftest import Draw
from figures import at, figure, with_characters
from followspot.arrays import Floats, Mask
from followspot.assets.shader_values import BlendFactor
from followspot.gpu import blocks
from followspot.passes.fog import FogInView, LitFog
from followspot.passes.view import SURFACE_VIEWS, View
from followspot.scene.camera import Camera
from followspot.scene.fog import Fog, optical_depths
from followspot.scene.material import Material, Shade
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.spaces import Vec3, vec3
from synthetic import (
    SIZE,
    WHITE_SKY,
    Piece,
    box,
    camera,
    cube_map,
    floor,
    image_archive,
    looking,
    make_scene,
    of,
    quad,
    rays,
    spot,
    srgb_decoded,
    srgb_encoded,
)

pytestmark = pytest.mark.gl

GREY, RUST = np.full(3, 0.5), np.array([0.6, 0.2, 0.05])
COLOURED_SKY = cube_map((124, 170, 231))
AROUND = srgb_decoded(np.array([124, 170, 231]) / 255)
"""Radiance of the sky, in all directions."""


def fog(
    mins: ArrayLike, maxs: ArrayLike, albedo: ArrayLike = GREY, extinction: float = 0.01
) -> Fog:
    return Fog(vec3(mins), vec3(maxs), vec3(albedo), extinction)


def foggy(scene: Scene, *fogs: Fog) -> Scene:
    return replace(scene, level=replace(scene.level, fogs=fogs))


def units_inside(volume: Fog, eye: Floats, ways: Floats) -> Floats:
    """(h, w) of ways from an eye, bit by bit between crossings with the planes of the box."""
    with np.errstate(divide="ignore", invalid="ignore"):
        at = np.concatenate([(c - eye) / ways for c in (volume.mins, volume.maxs)], axis=-1)
    at = np.sort(np.nan_to_num(np.clip(at, 0, 1)), axis=-1)
    at = np.concatenate([np.zeros((*at.shape[:2], 1)), at, np.ones((*at.shape[:2], 1))], axis=-1)
    middle = eye + ways[:, :, np.newaxis] * ((at[..., 1:] + at[..., :-1]) / 2)[..., np.newaxis]
    inside = ((middle > volume.mins) & (middle < volume.maxs)).all(axis=-1)
    shares = (np.diff(at, axis=-1) * inside).sum(axis=-1)
    return np.asarray(shares * np.linalg.norm(ways, axis=-1))


def expected(clear: Floats, fogs: Sequence[Fog], view: Camera, depth: Floats) -> Floats:
    """A picture without fog as it is seen through fog; where nothing is, depth is far."""
    ways = rays(view)
    ways = ways / (ways @ view.forward)[..., np.newaxis] * depth[..., np.newaxis]
    each = [f.extinction * units_inside(f, view.position, ways) for f in fogs]
    total = np.sum(each, axis=0)[..., np.newaxis]
    glow = sum(e[..., np.newaxis] * f.albedo * AROUND for e, f in zip(each, fogs, strict=True))
    through = np.exp(-total)
    return np.asarray(clear * through + glow / np.maximum(total, 1e-9) * (1 - through))


def room() -> list[Piece]:
    """A floor, a wall with a way past it into the sky, and blocks."""
    wall = quad((300, 60, 0), (0, -120, 0), (0, 0, 90))
    return [floor(250), wall, *box((120, -60, 0), (160, -20, 50)), *box((60, 20, 0), (80, 40, 20))]


@pytest.mark.parametrize(
    ("volumes", "eye"),
    [
        ([fog((-900, -900, -5), (900, 900, 30))], (-60, -10, 60)),  # seen from above
        ([fog((-900, -900, -5), (900, 900, 90))], (-60, -10, 60)),  # from within
        ([fog((100, -50, -5), (200, 50, 60), RUST, 0.03)], (-60, -10, 25)),  # through and past it
        ([fog((-200, 5, -5), (40, 90, 90), RUST, 0.03)], (-60, -10, 60)),  # beside, behind the eye
        (
            [fog((0, -90, -5), (90, 90, 40)), fog((150, -90, -5), (250, 90, 60), RUST, 0.02)],
            (-60, -10, 60),
        ),
    ],
)
def test_fog_takes_the_place_of_light_from_behind(
    draw: Draw, volumes: list[Fog], eye: tuple[float, float, float]
) -> None:
    scene = make_scene(room(), spot((0, 100, 250), (150, 0, 0), 40, 3e4), sky=COLOURED_SKY)
    view = looking(eye, (150, 10, 10))
    clear = draw(scene, view, View.FINAL)
    depth = draw(scene, view, View.DEPTH)
    assert 0.02 < np.isinf(depth).mean() < 0.6
    seen = draw(foggy(scene, *volumes), view, View.FINAL)
    wanted = expected(clear, volumes, view, np.where(np.isinf(depth), 1e7, depth))
    np.testing.assert_allclose(seen, wanted, rtol=0.01, atol=2e-4)
    assert np.abs(seen - clear).max() > 0.05
    np.testing.assert_array_equal(draw(foggy(scene, *volumes), view, "final", fog=False), clear)


def test_stages_before_the_final_picture_are_without_fog(draw: Draw) -> None:
    scene = make_scene(room(), spot((0, 100, 250), (150, 0, 0), 40, 3e4), sky=WHITE_SKY)
    hidden = foggy(scene, fog((-900, -900, -5), (900, 900, 90)))
    view = looking((-60, -10, 60), (150, 10, 10))
    for stage in SURFACE_VIEWS:
        if stage is not View.FINAL:
            np.testing.assert_array_equal(draw(hidden, view, stage), draw(scene, view, stage))


def test_fog_is_dark_without_light_around_and_as_bright_as_what_was_baked(draw: Draw) -> None:
    """Nothing but fog is seen: a wall behind a hundred optical depths of it."""
    wall, view = quad((300, 0, 0), (0, -900, 0), (0, 0, 900)), camera((0, 0, 0))
    thick = fog((50, -900, -900), (250, 900, 900), RUST, 0.5)
    scene = foggy(make_scene([wall], sky=WHITE_SKY, ambient=0.5), thick)
    for settings, around in ((Settings(), 1.5), (Settings(sky_light=False), 0.0)):
        shown = draw(scene, view, View.FINAL, settings)
        np.testing.assert_allclose(
            shown, np.tile(np.multiply(RUST, around), (*SIZE[::-1], 1)), rtol=1e-6
        )
    mesh = replace(scene.mesh, baked=np.ones((len(scene.mesh.vertices), 5), np.float32))
    baked = replace(scene, level=replace(scene.level, mesh=mesh))
    np.testing.assert_allclose(
        LitFog(baked, Settings(baked_light=0.7))._glow[0, :3], np.multiply(RUST, 0.7 * 0.5)
    )


ONE, ZERO = BlendFactor.ONE, BlendFactor.ZERO
SRC_A, LESS_A = BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA
SRC_C, LESS_C = BlendFactor.SRC_COLOR, BlendFactor.ONE_MINUS_SRC_COLOR
DST_C, LESS_D = BlendFactor.DST_COLOR, BlendFactor.ONE_MINUS_DST_COLOR
RGB, ALPHA = np.array([200, 120, 40]), 90
PANE_AT, WALL_AT = 150.0, 400.0


@pytest.mark.parametrize(
    ("blend", "shade"),
    [
        ((SRC_A, LESS_A), Shade.LIT),
        ((SRC_A, LESS_A), Shade.EMISSIVE),
        ((ONE, LESS_A), Shade.EMISSIVE),
        ((ONE, LESS_C), Shade.EMISSIVE),
        ((LESS_D, ONE), Shade.EMISSIVE),
        ((ONE, SRC_C), Shade.LIT),
        ((ONE, SRC_A), Shade.LIT),
        ((ONE, ZERO), Shade.LIT),
        ((ONE, ONE), Shade.EMISSIVE),
        ((SRC_A, ONE), Shade.EMISSIVE),
    ],
)
def test_blended_surfaces_stand_in_fog(
    draw: Draw, tmp_path: Path, blend: tuple[BlendFactor, BlendFactor], shade: Shade
) -> None:
    """A pane half-way into fog before a wall: light is followed from the wall, through the pane."""
    image = {"pane.png": np.full((4, 4, 4), (*RGB, ALPHA), np.uint8)}
    pane = of(
        Material("pane", "pane.png", blend=blend, shade=shade),
        quad((PANE_AT, 0, 0), (0, -900, 0), (0, 0, 900)),
    )
    pieces = [quad((WALL_AT, 0, 0), (0, -900, 0), (0, 0, 900)), *pane]
    scene = make_scene(pieces, sky=COLOURED_SKY, archive=image_archive(tmp_path, image))
    volume, view = fog((50, -2e3, -2e3), (350, 2e3, 2e3), RUST, 0.006), camera((0, 0, 0))

    along = rays(view)
    along = along / along[..., :1]  # per unit of x
    length = np.linalg.norm(along, axis=-1, keepdims=True)
    glow = RUST * AROUND

    def through(light: Floats, units: float) -> Floats:
        share = np.exp(-0.006 * units * length)
        return np.asarray(light * share + glow * (1 - share))

    reflectance, alpha = srgb_decoded(RGB / 255), ALPHA / 255
    source = {ONE: 1.0, SRC_A: alpha, LESS_D: 1.0}[blend[0]]
    kept = {
        ZERO: 0.0,
        ONE: 1 - reflectance if blend[0] is LESS_D else 1.0,
        SRC_A: alpha,
        LESS_A: 1 - alpha,
        SRC_C: reflectance,
        LESS_C: 1 - reflectance,
    }[blend[1]]
    sent = reflectance * (AROUND if shade is Shade.LIT else 1.0) * source
    at_pane = through(AROUND * np.ones((*SIZE[::-1], 3)), 350 - PANE_AT)
    wanted = through(sent + kept * at_pane, PANE_AT - 50)
    np.testing.assert_allclose(
        draw(foggy(scene, volume), view, View.FINAL), wanted, rtol=2e-3, atol=2e-4
    )


@pytest.mark.parametrize(
    ("blend", "factor"),
    [
        ((DST_C, ZERO), lambda rho: rho),
        ((ZERO, SRC_C), lambda rho: rho),
        ((DST_C, SRC_C), lambda rho: 2 * rho),
        ((DST_C, ONE), lambda rho: np.minimum((1 + srgb_encoded(rho)) ** 2.2, 2)),
        ((ZERO, LESS_C), lambda rho: 1 - rho),
    ],
)
def test_what_multiplies_fades_to_leaving_all_as_it_is(
    draw: Draw,
    tmp_path: Path,
    blend: tuple[BlendFactor, BlendFactor],
    factor: Callable[[Floats], Floats],
) -> None:
    image = {"pane.png": np.full((4, 4, 4), (*RGB, 255), np.uint8)}
    pane = of(
        Material("pane", "pane.png", blend=blend, shade=Shade.FILTER),
        quad((PANE_AT, 0, 0), (0, -900, 0), (0, 0, 900)),
    )
    wall = quad((WALL_AT, 0, 0), (0, -900, 0), (0, 0, 900))
    scene = make_scene([wall, *pane], sky=WHITE_SKY, archive=image_archive(tmp_path, image))
    view = camera((0, 0, 0))
    along = rays(view)
    through = np.exp(-0.006 * 100 * np.linalg.norm(along / along[..., :1], axis=-1))[..., None]
    # Fog as bright as the wall hides nothing of it, and so only the pane.
    white = fog((50, -2e3, -2e3), (350, 2e3, 2e3), (1, 1, 1), 0.006)
    plain = factor(srgb_decoded(RGB / 255))
    np.testing.assert_allclose(
        draw(foggy(scene, white), view, View.FINAL), 1 + (plain - 1) * through, rtol=2e-3
    )


def test_characters_stand_in_fog_as_the_level_does(draw: Draw) -> None:
    cube = box((-20, -20, -20), (20, 20, 20))
    view, volume = looking((-60, -10, 60), (150, 10, 10)), fog((50, -90, -5), (900, 900, 30))
    scene = make_scene([floor(250)], sky=WHITE_SKY)
    level = foggy(
        make_scene([floor(250), *box((80, -20, 0), (120, 20, 40))], sky=WHITE_SKY), volume
    )
    cast = with_characters(foggy(scene, volume), at(figure([cube], name="cube"), (100, 0, 20)))
    shown, wanted = (draw(each, view, View.FINAL) for each in (cast, level))
    np.testing.assert_allclose(shown, wanted, rtol=1e-4, atol=1e-5)
    assert np.abs(shown - draw(replace(cast, level=scene.level), view, "final")).max() > 0.05


def test_volumes_behind_the_camera_are_left_out() -> None:
    scene = make_scene([floor(250)], sky=WHITE_SKY)
    ahead, behind = (fog((x, -30, 0), (x + 50, 30, 50)) for x in (100, -150))
    lit = LitFog(foggy(scene, ahead, behind), Settings())
    for yaw, there in ((0, ahead), (180, behind)):
        view = camera((0, 0, 20), yaw=yaw)
        matrix = view.clip_from_view(SIZE[0] / SIZE[1], 1e3) @ view.view_from_world
        assert lit.in_view(view.position, matrix).mins.tolist() == [there.mins.tolist()]


def test_what_no_fog_can_cover_is_drawn_without(
    draw: Draw, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The picture is the same as if everything were drawn through it, whoever looks."""
    drawn, asked = FogInView.may_cover, []

    def remembered(*args: Any) -> Mask:
        asked.append(drawn(*args))
        return asked[-1]

    def everything(_: FogInView, eye: Vec3, mins: Floats, maxs: Floats) -> Mask:
        return np.ones(len(mins), bool)

    pieces = [floor(250)]
    for x in (40, 200, 110):
        material = Material(f"box at {x}")
        sides = box((x, -20, 0), (x + 20, 20, 40))
        pieces += [replace(side, material=material) for side in sides]
    scene = foggy(make_scene(pieces, sky=WHITE_SKY), fog((90, -60, 0), (150, 60, 60), RUST))
    for eye, yaw in (((0, 50, 30), -20), ((0, -50, 30), 20), ((120, 40, 20), 0), ((0, 0, 20), 180)):
        view = camera(eye, yaw=yaw)
        monkeypatch.setattr(FogInView, "may_cover", remembered)
        shown = draw(scene, view, View.FINAL)
        monkeypatch.setattr(FogInView, "may_cover", everything)
        assert np.array_equal(shown, draw(scene, view, View.FINAL))
    assert asked[0].any() and not asked[0].all()


def test_a_box_is_covered_where_any_ray_into_it_meets_fog() -> None:
    random = np.random.default_rng(4)
    places = np.sort(random.uniform(-100, 100, (300, 3, 2, 3)), axis=2)
    found = []
    for (volume_mins, volume_maxs), (mins, maxs), (eye, _) in places:
        volume = fog(volume_mins, (volume_mins + volume_maxs) / 2)
        corners = np.array([[volume.mins], [volume.maxs]], np.float32)
        view = FogInView(corners[0], corners[1], np.ones((1, 4)))
        told = view.may_cover(eye, mins[np.newaxis], maxs[np.newaxis])[0]
        inside = random.uniform(mins, maxs, (500, 3))
        meets = (optical_depths([volume], eye, inside) > 0).any()
        assert told or not meets
        found.append((told, meets))
    told, meets = np.mean(found, axis=0)
    assert meets > 0.2 and told < 0.8  # of what is told, most is so


def test_of_too_many_volumes_the_nearest_are_drawn(draw: Draw) -> None:
    """Twelve sheets one behind the other: light from the wall comes through the first eight."""
    wall, view = quad((300, 0, 0), (0, -300, 0), (0, 0, 300)), camera((0, 0, 0), fov=2)
    sheets = [
        fog((10 * n, -99, -99), (10 * n + 1, 99, 99), (0, 0, 0), 0.1) for n in range(12, 0, -1)
    ]
    shown = draw(foggy(make_scene([wall], sky=WHITE_SKY), *sheets), view, View.FINAL)
    assert blocks.MAX_FOGS == 8
    np.testing.assert_allclose(shown, np.exp(-0.8) * np.ones_like(shown), rtol=1e-3)
