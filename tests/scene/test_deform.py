"""Deformations: numbers of a time, and boxes that hold all that they do."""

import numpy as np
import pytest

from followspot.arrays import Floats
from followspot.assets.shader_deform import Move, Sprite, Swell
from followspot.assets.shader_motion import Shape, Wave
from followspot.scene.deform import CORNERS, RIGID, Deforms, deformed
from followspot.scene.load import load
from followspot.scene.material import Material
from followspot.scene.mesh import Mesh
from synthetic import floor, make_mesh, of, quad

SMOKE = Material("smoke", deforms=Deforms((Move((1, 2, 30), Wave(Shape.SAWTOOTH, 0, 1, 0, 0.5)),)))
WATER = Material("water", deforms=Deforms(swell=Swell(0.25, Wave(Shape.SIN, 1, -3, 0.5, 2))))
FLARE = Material("flare", deforms=Deforms(sprite=Sprite.WHOLE))
BEAM = Material("beam", deforms=Deforms(sprite=Sprite.PIVOT))


def test_moves_add_up_by_the_time() -> None:
    twice = Deforms((*SMOKE.deforms.moves, Move((4, 0, 0), Wave(Shape.SIN, 1, 0, 0, 0))))
    np.testing.assert_allclose(twice.moved(0.5), (4 + 0.25, 0.5, 7.5))
    np.testing.assert_allclose(twice.moved(2.5), twice.moved(0.5))
    assert RIGID.moved(3) == (0, 0, 0)


def test_a_swell_by_the_time() -> None:
    assert WATER.deforms.swelling(0.3) == pytest.approx((1, -3, 0.1, 0.25))
    assert Deforms.of((Swell(1, Wave(Shape.SQUARE, 0, 1, 0, 1)),)) == RIGID


def test_what_is_rigid_stays_as_it_is() -> None:
    mesh, materials = make_mesh([floor()])
    assert deformed(mesh, [m.deforms for m in materials]) is mesh


def test_boxes_hold_moves_and_swells() -> None:
    pieces = [floor(100), *of(SMOKE, floor(100)), *of(WATER, floor(100))]
    mesh, materials = make_mesh(pieces)
    made = deformed(mesh, [m.deforms for m in materials])
    boxes = {
        m.name: (made.faces["mins"][k].tolist(), made.faces["maxs"][k].tolist())
        for k, m in enumerate(materials)
    }
    assert boxes["white"] == ([-100, -100, 0], [100, 100, 0])
    assert boxes["smoke"] == ([-100, -100, 0], [101, 102, 30])
    assert boxes["water"] == ([-104, -104, -4], [104, 104, 4])
    assert made.sprites is None


def test_sprites_know_what_they_turn_about() -> None:
    flare, beam = quad((10, 20, 30), (8, 0, 0), (0, 0, 8)), quad((0, 0, 50), (3, 0, 0), (0, 0, 9))
    mesh, materials = make_mesh([floor(), *of(FLARE, flare, flare), *of(BEAM, beam)])
    made = deformed(mesh, [m.deforms for m in materials])
    assert made.sprites is not None
    whole = next(k for k, m in enumerate(materials) if m is FLARE)
    face = made.faces[made.faces["material"] == whole][1]
    corners = made.indices[face["first_index"] :][:6]
    np.testing.assert_array_equal(made.vertices["texcoord"][corners], CORNERS[[0, 1, 3, 3, 1, 2]])
    np.testing.assert_allclose(made.sprites[corners], np.tile((10, 20, 30, 8, 0, 0, 0, 0), (6, 1)))
    reach = np.hypot(8, 8)
    np.testing.assert_allclose(face["mins"], np.array((10, 20, 30)) - reach, rtol=1e-6)
    np.testing.assert_allclose(face["maxs"], np.array((10, 20, 30)) + reach, rtol=1e-6)
    (pivot,) = (k for k, m in enumerate(materials) if m is BEAM)
    face = made.faces[made.faces["material"] == pivot][0]
    corners = np.unique(made.indices[face["first_index"] :][:6])
    turned = made.sprites[corners]
    np.testing.assert_allclose(turned[:, :2], 0)  # on the middles of its short edges
    np.testing.assert_allclose(turned[:, 2], made.vertices["position"][corners, 2])
    np.testing.assert_allclose(np.abs(turned[:, 3]), 3)
    np.testing.assert_allclose(np.abs(turned[:, 4:7]), np.tile((0, 0, 1), (4, 1)), atol=1e-7)
    (rigid,) = (k for k, m in enumerate(materials) if m.name == "white")
    face = made.faces[made.faces["material"] == rigid][0]
    assert not made.sprites[made.indices[face["first_index"] :][:6]].any()


def test_what_is_no_rectangle_does_not_turn() -> None:
    piece = quad((0, 0, 0), (8, 0, 0), (0, 0, 8))
    piece = type(piece)(piece.vertices[:3], piece.indices[:3] % 3, FLARE)
    mesh, materials = make_mesh([piece])
    made = deformed(mesh, [m.deforms for m in materials])
    assert made.sprites is not None and not made.sprites.any()
    np.testing.assert_array_equal(made.vertices, mesh.vertices)


def turned(mesh: Mesh, right: Floats, up: Floats, ahead: Floats) -> Floats:
    """(v, 3) where deform.glsl turns vertices, for camera axes."""
    assert mesh.sprites is not None
    sprites = mesh.sprites.astype(np.float64)
    place, reach, axis = sprites[:, :3], sprites[:, 3:4], sprites[:, 4:7]
    s, t = mesh.vertices["texcoord"].T.astype(np.float64)[:, :, np.newaxis]
    across = np.cross(ahead, axis)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9)
    away = np.where(axis.any(axis=1, keepdims=True), across, right * (2 * s - 1) + up * (1 - 2 * t))
    return np.where(reach != 0, place + reach * away, mesh.vertices["position"])


@pytest.mark.openarena
@pytest.mark.parametrize("name", ["oa_shouse", "oa_spirit3"])
def test_boxes_of_a_levels_sprites_hold_them_from_all_sides(name: str) -> None:
    scene = load(name)
    mesh, faces = scene.mesh, scene.mesh.faces
    is_sprite = np.array([m.deforms.sprite is not None for m in scene.materials])
    chosen = np.flatnonzero(is_sprite[faces["material"]])
    assert len(chosen) > 10
    rng = np.random.default_rng(4)
    for _ in range(20):
        right, up, ahead = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        places = turned(mesh, right, up, ahead)
        seconds = rng.uniform(0, 60)
        for face in faces[chosen]:
            first, count = face["first_index"], face["index_count"]
            moved = scene.materials[face["material"]].deforms.moved(seconds)
            corners = places[mesh.indices[first : first + count]] + moved
            assert (corners >= face["mins"] - 0.01).all() and (corners <= face["maxs"] + 0.01).all()
    scene.archive.close()
