"""The mesh's table of faces."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.scene.material import Material
from followspot.scene.mesh import FACE, VERTEX, Mesh, face_boxes
from synthetic import box, floor, make_mesh, of, quad


@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_face_boxes_are_the_extremes_of_each_run(seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    positions = random.normal(size=(30, 3)).astype(np.float32)
    lengths = random.integers(1, 5, count) * 3
    indices = random.integers(0, 30, lengths.sum()).astype(np.uint32)
    first = np.cumsum(lengths) - lengths
    mins, maxs = face_boxes(positions, indices, first.astype(np.int32))
    for k, (start, length) in enumerate(zip(first, lengths, strict=True)):
        corners = positions[indices[start : start + length]]
        assert (mins[k] == corners.min(axis=0)).all() and (maxs[k] == corners.max(axis=0)).all()


def test_bounds_and_count() -> None:
    mesh, _ = make_mesh([*box((-1, -2, -3), (4, 5, 6)), floor(10)])
    low, high = mesh.bounds
    assert low.tolist() == [-10, -10, -3] and high.tolist() == [10, 10, 6]
    assert mesh.triangle_count == 14


def test_no_faces_have_a_box_all_the_same() -> None:
    mesh = Mesh(np.empty(0, VERTEX), np.empty(0, np.uint32), np.empty(0, FACE))
    low, high = mesh.bounds
    assert (low < high).all() and mesh.triangle_count == 0


@pytest.mark.parametrize(("degrees", "bent"), [(0, False), (14, False), (16, True), (80, True)])
def test_smoothed_materials_have_normals_far_from_their_triangles(
    degrees: float, bent: bool
) -> None:
    wall, slope = Material("a wall"), Material("slope")
    leaning = quad((0, 0, 0), (5, 0, 0), (0, 5, 0))
    angle = np.radians(degrees)
    leaning.vertices["normal"][0] = np.sin(angle), 0, np.cos(angle)  # of both triangles
    mesh, materials = make_mesh([*of(wall, floor(20)), *of(slope, leaning)])
    assert mesh.is_smoothed(2).tolist() == [m is slope and bent for m in materials]


def test_few_bent_triangles_make_no_material_smoothed() -> None:
    small = quad((0, 0, 0), (1, 0, 0), (0, 1, 0))
    small.vertices["normal"] = 1, 0, 0
    mesh, _ = make_mesh([floor(20), small])
    assert mesh.is_smoothed(1).tolist() == [False]
    assert make_mesh([])[0].is_smoothed(0).tolist() == []
