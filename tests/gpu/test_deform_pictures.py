"""Vertices that move, in pictures: each against a surface that stands where they are moved to."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conftest import Draw
from followspot.arrays import Floats
from followspot.assets.archive import Archive
from followspot.assets.shader_deform import Move, Sprite, Swell
from followspot.assets.shader_motion import Shape, Wave
from followspot.assets.shader_values import Sides
from followspot.passes.view import View
from followspot.scene.camera import Camera
from followspot.scene.deform import Deforms, deformed
from followspot.scene.material import Material
from followspot.scene.settings import Settings
from synthetic import Piece, camera, floor, image_archive, make_scene, of, point, quad

pytestmark = pytest.mark.gl


@pytest.fixture
def archive(tmp_path: Path) -> Archive:
    noise = np.random.default_rng(3).integers(0, 256, (8, 8, 4), np.uint8)
    return image_archive(tmp_path, {"noise.png": noise})


def axes(view: Camera) -> tuple[Floats, Floats, Floats]:
    """(3,) right, up and ahead of a camera, from its angles."""
    yaw, pitch = math.radians(view.yaw), math.radians(view.pitch)
    ahead = np.array([math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), 0])
    ahead[2] = -math.sin(pitch)
    right = np.array([math.sin(yaw), -math.cos(yaw), 0])
    return right, np.cross(right, ahead), ahead


def shown(draw: Draw, archive: Archive, piece: Piece, view: Camera, stage: View) -> Any:
    """Two pictures: after one second, and one with the piece at rest."""
    still = make_scene([floor(400, -60), replace(piece, material=PICTURE)], archive=archive)
    scene = make_scene([floor(400, -60), piece], archive=archive)
    mesh = deformed(scene.mesh, [each.deforms for each in scene.materials])
    scene = replace(scene, level=replace(scene.level, mesh=mesh))
    return draw(scene, view, stage, time=1.0), draw(still, view, stage)


PICTURE = Material("p", "noise.png", clamps=True)
PLACE = np.array((200.0, 30.0, 20.0))


@pytest.mark.parametrize("stage", [View.LAMBERTIAN, View.DEPTH])
@pytest.mark.parametrize("sides", [Sides.BOTH, Sides.FRONT])
@pytest.mark.parametrize("view", [camera((0, 0, 0), 8, -5), camera((60, -90, 90), 40, 20)])
def test_sprites_turn_to_the_camera(
    draw: Draw, archive: Archive, view: Camera, sides: Sides, stage: View
) -> None:
    """Seen edge-on without turning; against those that stand as they should."""
    right, up, ahead = axes(view)
    across = np.cross(ahead, (0, 0, 1))
    across /= np.linalg.norm(across)
    edge_on = np.array((30, 0, 0)), np.array((0, 0, 60))
    for sprite, u, v in (
        (Sprite.WHOLE, right * 30 * math.sqrt(2.5), up * 30 * math.sqrt(2.5)),
        (Sprite.PIVOT, across * 30, (0, 0, 60)),
    ):
        material = replace(PICTURE, sides=sides, deforms=Deforms(sprite=sprite))
        found, rest = shown(
            draw, archive, replace(quad(PLACE, *edge_on), material=material), view, stage
        )
        expected = make_scene(
            [floor(400, -60), replace(quad(PLACE, u, v), material=PICTURE)], archive=archive
        )
        close = np.isclose(found, draw(expected, view, stage), rtol=1e-3, atol=1e-3)
        assert close.mean() > 0.995
        assert not np.isclose(rest, found, rtol=1e-3, atol=1e-3).mean() > 0.95


def test_surfaces_move_and_swell(draw: Draw, archive: Archive) -> None:
    """Depth is that of the place where they are drawn; light that of where they rest."""
    view = camera((0, 0, 120), 10, 35)
    piece = quad((200, 30, 10), (90, 0, 0), (0, 70, 0))
    move = Move((10, -20, 8), Wave(Shape.SAWTOOTH, 1, 2, 0.25, 1))
    swell = Swell(0.003, Wave(Shape.SIN, 5, 20, 0.1, 0.3))
    x, y, z = piece.vertices["position"].T.astype(np.float64)
    heights = 5 + 20 * np.sin(math.tau * (0.4 + 0.003 * (x + y + z)))
    for deforms, shift in (
        (Deforms((move,)), np.tile((15, -30, 12), (4, 1))),
        (Deforms(swell=swell), heights[:, np.newaxis] * (0, 0, 1)),
        (Deforms((move,), swell), heights[:, np.newaxis] * (0, 0, 1) + (15, -30, 12)),
    ):
        moving = replace(piece, material=replace(PICTURE, deforms=deforms))
        vertices = piece.vertices.copy()
        vertices["position"] += shift
        there = replace(piece, vertices=vertices)
        for stage in (View.DEPTH, View.LAMBERTIAN):
            found, _ = shown(draw, archive, moving, view, stage)
            _, expected = shown(draw, archive, there, view, stage)
            assert np.isclose(found, expected, rtol=1e-3, atol=1e-3).mean() > 0.995


def test_light_is_that_of_where_a_surface_rests(draw: Draw) -> None:
    """Raised straight up towards the camera, it keeps the radiance that each of its points had."""
    raised = Deforms((Move((0, 0, 50), Wave(Shape.SIN, 1, 0, 0, 0)),))
    ground, lamp = quad((0, 0, 0), (60, 0, 0), (0, 60, 0)), point((10, 5, 80), 900)
    low, high = camera((0, 0, 150), 0, 90, 60), camera((0, 0, 200), 0, 90, 60)
    settings = Settings(sky_light=False)
    (moving,) = of(Material("raised", deforms=raised), ground)
    expected = draw(make_scene([ground], lamp), low, View.DIRECT, settings)
    found = draw(make_scene([moving], lamp), high, View.DIRECT, settings)
    assert (expected > 0).mean() > 0.2
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-3 * expected.max())


@pytest.mark.parametrize("is_turned", [False, True])
def test_sprites_are_lit_and_cast_nothing(draw: Draw, is_turned: bool) -> None:
    """Whichever way round their triangles are in the file."""
    piece = quad((200, 0, 0), (0, -30, 0), (0, 0, 30))
    if is_turned:
        piece = replace(piece, indices=piece.indices[::-1].copy())
    (sprite,) = of(Material("sprite", deforms=Deforms(sprite=Sprite.WHOLE)), piece)
    wall = quad((260, 0, 0), (0, -200, 0), (0, 0, 200))
    scene = make_scene([sprite, wall], point((0, 0, 20), 900))
    mesh = deformed(scene.mesh, [each.deforms for each in scene.materials])
    scene = replace(scene, level=replace(scene.level, mesh=mesh))
    visibility = draw(scene, camera((0, 0, 0), fov=60), View.SHADOW)
    assert (visibility == 1).all()


def test_a_sprite_that_is_no_rectangle_is_drawn_as_it_rests(draw: Draw) -> None:
    whole = quad((200, 0, 0), (0, -30, 0), (0, 0, 30))
    piece = replace(whole, vertices=whole.vertices[:3], indices=np.array([0, 2, 1], np.uint32))
    (sprite,) = of(Material("sprite", deforms=Deforms(sprite=Sprite.WHOLE)), piece)
    scene = make_scene([sprite])
    mesh = deformed(scene.mesh, [each.deforms for each in scene.materials])
    turned = replace(scene, level=replace(scene.level, mesh=mesh))
    view = camera((0, 0, 0), fov=60)
    found, expected = (draw(s, view, View.DEPTH) for s in (turned, make_scene([piece])))
    assert np.isfinite(expected).any()
    np.testing.assert_array_equal(found, expected)
