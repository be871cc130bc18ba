"""The mesh's table of faces."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from followspot.scene.mesh import FACE, VERTEX, Mesh, face_boxes
from synthetic import box, floor, make_mesh


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
