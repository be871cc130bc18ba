"""Boxes of objects, and the lines and triangles of debugging pictures."""

import math
from dataclasses import replace

import numpy as np
import pytest

from followspot import spaces
from followspot.assets.bsp import LUMPS
from followspot.scene import outlines
from followspot.scene.load import load
from followspot.scene.material import Material
from followspot.scene.props import Prop, PropSurface
from synthetic import Piece, box, floor, make_scene, of, quad, spot, turned


def boxes_of(pieces: list[Piece], first_faces: tuple[int, ...] = ()) -> set[tuple[float, ...]]:
    """Boxes of objects, where brush models have these first faces."""
    scene = make_scene(pieces)
    models = np.zeros(len(first_faces), LUMPS["models"])
    models["first_face"] = first_faces
    level = replace(scene.level, bsp=replace(scene.level.bsp, models=models))
    mins, maxs = outlines.objects(replace(scene, level=level))
    return {tuple(row) for row in np.concatenate([mins, maxs], axis=1).tolist()}


def test_what_stands_on_a_floor_is_an_object_of_its_own() -> None:
    red = of(Material("red"), *box((40, 0, 0), (60, 20, 30))[:3])
    blue = of(Material("blue"), *box((40, 0, 0), (60, 20, 30))[3:])
    other = box((61, 0, 0), (80, 20, 30))
    found = boxes_of([floor(100), *red, *blue, *other])
    assert found == {
        (-100, -100, 0, 100, 100, 0),
        (40, 0, 0, 60, 20, 30),
        (61, 0, 0, 80, 20, 30),
    }


def test_long_chains_of_faces_are_one_object_whatever_their_order() -> None:
    tiles = [quad((20 * k, 0, 0), (10, 0, 0), (0, 10, 0)) for k in range(200)]
    order = np.random.default_rng(5).permutation(200)
    assert boxes_of([tiles[k] for k in order]) == {(-10, -10, 0, 3990, 10, 0)}
    apart = turned(tiles[150:], np.eye(3), (0, 0, 2 * outlines.SAME_CORNER))
    assert len(boxes_of([*tiles[:150], *apart])) == 2


def test_brush_models_are_objects_of_their_own() -> None:
    """A door that closes its frame shares corners with it."""
    pieces = [quad((20 * k, 0, 0), (10, 0, 0), (0, 10, 0)) for k in range(4)]
    assert len(boxes_of(pieces, (0,))) == 1
    assert boxes_of(pieces, (0, 3)) == {(-10, -10, 0, 50, 10, 0), (50, -10, 0, 70, 10, 0)}


def test_every_face_is_in_an_objects_box() -> None:
    scene = load("courtyard")
    with scene.archive:
        mins, maxs = outlines.objects(scene)
    faces = scene.mesh.faces
    low = (mins[:, np.newaxis] <= faces["mins"]).all(axis=2)
    high = (maxs[:, np.newaxis] >= faces["maxs"]).all(axis=2)
    assert (low & high).any(axis=0).all()
    assert 50 < len(mins) < 500
    assert boxes_of([]) == set()


def test_lines_and_triangles_of_boxes_and_frusta() -> None:
    low, high = np.array([[-3.0, 1, 2]]), np.array([[5.0, 4, 8]])
    ends = outlines.box_lines(low, high).reshape(-1, 2, 3)
    assert len(ends) == 12 and len({frozenset(map(tuple, e)) for e in ends.tolist()}) == 12
    assert sorted(np.ptp(ends, axis=1).sum(axis=1)) == [3] * 4 + [6] * 4 + [8] * 4
    matrix = spaces.clip_from_view(90, 60, 4, 100) @ spaces.view_from_world(
        spaces.vec3((5, 6, 7)), 30, 20
    )
    corners = np.c_[outlines.frustum_corners(matrix), np.ones(8)] @ matrix.T
    np.testing.assert_allclose(np.abs(corners[:, :3] / corners[:, 3:]), 1, atol=1e-6)
    lines = np.c_[outlines.frustum_lines(matrix), np.ones(outlines.EDGE_POINTS)] @ matrix.T
    steps = np.abs(np.diff((lines / lines[:, 3:]).reshape(-1, 2, 4), axis=1)[:, 0, :3])
    np.testing.assert_allclose(np.sort(steps, axis=1), [[0, 0, 2]] * 12, atol=1e-3)
    triangles = np.c_[outlines.frustum_triangles(matrix), np.ones(outlines.SIDE_POINTS)] @ matrix.T
    triangles = (triangles / triangles[:, 3:]).reshape(12, 3, 4)[..., :3]
    area = np.linalg.norm(
        np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1
    )
    np.testing.assert_allclose(area, 4, rtol=1e-3)  # halves of sides 2 x 2
    centres = np.round(triangles.reshape(6, 6, 3).mean(axis=1))
    assert len({tuple(centre) for centre in centres.tolist()}) == 6


@pytest.mark.parametrize("degrees", [10, 45, 80])
def test_cones_and_marks(degrees: float) -> None:
    light = spot((10, 20, 30), (40, -10, 0), degrees)
    points = outlines.cone_lines(light, 50.0)
    assert len(points) == outlines.CONE_POINTS
    away = points.astype(np.float64) - light.position
    along = away @ light.direction
    at_rim = along > 1
    np.testing.assert_allclose(along[at_rim], 50, rtol=1e-4)
    across = np.linalg.norm(away[at_rim] - along[at_rim, np.newaxis] * light.direction, axis=1)
    np.testing.assert_allclose(across, 50 * math.tan(math.radians(degrees)), rtol=1e-4)
    assert (~at_rim).sum() == 4 and not away[~at_rim].any()
    cross = outlines.mark_lines(light.position, 16).reshape(-1, 2, 3)
    np.testing.assert_allclose(cross.mean(axis=1), np.tile(light.position, (3, 1)))
    assert (np.linalg.norm(np.diff(cross, axis=1), axis=2) == 32).all()
    assert len(cross) * 2 == outlines.MARK_POINTS


def test_a_prop_is_one_object_however_many_pieces_it_has() -> None:
    pieces = [quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), *box((20, 0, 0), (30, 10, 10))]
    pieces += box((40, 0, 0), (50, 10, 10))
    scene = make_scene(pieces)
    surfaces = tuple(
        PropSurface(piece.vertices, None, piece.indices, piece.material) for piece in pieces[1:]
    )
    level_face = np.where(scene.mesh.faces["mins"][:, 0] >= 20, -1, 0)
    visibility = replace(scene.visibility, level_face=level_face)
    level = replace(scene.level, visibility=visibility)
    mins, maxs = outlines.objects(replace(scene, level=level, props=(Prop("pair", surfaces),)))
    assert sorted(map(tuple, mins.tolist())) == [(-9, -9, 0), (20, 0, 0)]
    assert sorted(map(tuple, maxs.tolist())) == [(9, 9, 0), (50, 10, 10)]
