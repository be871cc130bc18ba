"""Cubes that surfaces go through: none is missed, and they grow as their numbers do."""

import numpy as np
import pytest

from followspot.scene.voxels import Voxels

EDGE = 8.0


def triangles(count: int, seed: int) -> np.ndarray:
    """Small ones and slivers, some of them far below 0."""
    generator = np.random.default_rng(seed)
    corners = generator.uniform(-900, 600, (count, 1, 3))
    corners = corners + generator.normal(scale=60, size=(count, 3, 3))
    corners[::3, 2] = corners[::3, 0] + generator.normal(scale=2, size=(len(corners[::3]), 3))
    return corners


def inside(corners: np.ndarray, count: int) -> np.ndarray:
    """Points spread over triangles, whichever way their edges run."""
    weights = np.random.default_rng(9).dirichlet((1, 1, 1), (len(corners), count))
    return np.asarray(np.einsum("tnk,tkc->tnc", weights, corners).reshape(-1, 3))


@pytest.mark.parametrize("distance", [0.0, 7.0, 21.0, 48.0, 300.0])
def test_growing_is_being_near_in_every_axis(distance: float) -> None:
    taken = Voxels.of(triangles(40, 1), EDGE)
    generator = np.random.default_rng(2)
    places = generator.uniform(-1400, 1100, (3000, 3))
    reach = int(np.ceil(distance / EDGE))
    cubes = np.argwhere(
        (taken.words[..., np.newaxis] >> np.arange(64, dtype=np.uint64)) & np.uint64(1)
    )
    cubes = np.stack([cubes[:, 0], cubes[:, 1], cubes[:, 2] * 64 + cubes[:, 3]], axis=1)
    own = np.floor(places / EDGE).astype(np.int64)
    apart = np.abs(own[:, np.newaxis] - (cubes + taken.origin)).max(axis=2).min(axis=1)
    assert np.array_equal(taken.grown(distance).hold(places), apart <= reach)


def test_surfaces_are_nowhere_outside_of_cubes() -> None:
    """But for a cube at whose very edge one passes, which its neighbour stands for."""
    corners = triangles(200, 3)
    taken = Voxels.of(corners, EDGE)
    points = inside(corners, 100)
    assert taken.hold(points).mean() > 0.75
    assert taken.grown(1.0).hold(points).all()


def test_cubes_are_larger_where_there_is_too_much() -> None:
    plain = np.array([[(0.0, 0, 0), (80_000, 0, 0), (0, 80_000, 0)]])
    taken = Voxels.of(plain, EDGE)
    assert taken.edge > 50 and taken.words.size < 1 << 22
    assert taken.hold(np.array([[10_000.0, 10_000, 1]])).all()
    sparse = np.array([[(0.0, 0, 0), (1, 0, 0), (0, 1, 0)], [(1e6, 1e6, 1e6)] * 3])
    assert Voxels.of(sparse, EDGE).words.size <= 1 << 22


def test_nothing_is_taken_where_nothing_is() -> None:
    nothing = Voxels.of(np.empty((0, 3, 3)), EDGE)
    places = np.random.default_rng(1).normal(scale=30, size=(50, 3))
    assert not nothing.grown(20.0).hold(places).any()
