"""Matrices against pylinalg, an independent library, and against the conventions' own words."""

import math

import numpy as np
import pylinalg as la
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from followspot import spaces
from followspot.arrays import Floats

coordinates = st.floats(-1e4, 1e4).map(lambda x: round(x, 3))
points = st.tuples(coordinates, coordinates, coordinates).map(spaces.vec3)
yaws = st.floats(-720, 720)
pitches = st.floats(-90, 90)
fovs = st.floats(1, 170)


def perspective_by_pylinalg(fov_x: float, fov_y: float, near: float, far: float) -> Floats:
    right, top = near * math.tan(math.radians(fov_x) / 2), near * math.tan(math.radians(fov_y) / 2)
    return np.asarray(la.mat_perspective(-right, right, top, -top, near, far, depth_range=(-1, 1)))


@given(fovs, fovs, st.floats(0.01, 100), st.floats(1.01, 1e5))
def test_clip_from_view_is_the_usual_perspective(
    fov_x: float, fov_y: float, near: float, ratio: float
) -> None:
    ours = spaces.clip_from_view(fov_x, fov_y, near, near * ratio)
    theirs = perspective_by_pylinalg(fov_x, fov_y, near, near * ratio)
    np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-12)


@given(fovs, st.floats(0.2, 5), st.floats(0.1, 10), st.floats(20, 1e5))
def test_near_and_far_planes_and_the_pictures_edges(
    fov: float, aspect: float, near: float, far: float
) -> None:
    fov_y = spaces.vertical_fov(fov, aspect)
    matrix = spaces.clip_from_view(fov, fov_y, near, far)
    x, y = math.tan(math.radians(fov) / 2), math.tan(math.radians(fov_y) / 2)
    for distance, depth in ((near, -1), (far, 1)):
        corner = matrix @ (x * distance, y * distance, -distance, 1)
        np.testing.assert_allclose(corner[:3] / corner[3], (1, 1, depth), atol=1e-6)
        assert corner[3] == pytest.approx(distance)  # clip w is the distance along the axis
    assert x / y == pytest.approx(aspect)


@given(points, yaws, pitches)
def test_view_from_world_is_a_rigid_motion_of_the_eye_to_the_origin(
    position: spaces.Vec3, yaw: float, pitch: float
) -> None:
    view = spaces.view_from_world(position, yaw, pitch)
    np.testing.assert_allclose(view[:3, :3] @ view[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(view[:3, :3]) == pytest.approx(1)
    np.testing.assert_allclose(view @ (*position, 1), (0, 0, 0, 1), atol=1e-8)
    np.testing.assert_array_equal(view[3], (0, 0, 0, 1))


@given(points, yaws, st.floats(-89, 89))
def test_view_from_world_agrees_with_look_at(
    position: spaces.Vec3, yaw: float, pitch: float
) -> None:
    """pylinalg's looks along +Z with its x axis to the left: a half turn about y from OpenGL's."""
    forward = spaces.forward_from_angles(yaw, pitch)
    rotation = la.mat_look_at((0, 0, 0), forward, (0, 0, 1)) @ np.diag([-1, 1, -1, 1])
    world_from_view = la.mat_from_translation(position) @ rotation
    view_from_world = spaces.view_from_world(position, yaw, pitch)
    np.testing.assert_allclose(view_from_world @ world_from_view, np.eye(4), atol=1e-7)


@given(points, yaws, pitches)
def test_view_from_world_is_the_inverse_of_placing_the_camera(
    position: spaces.Vec3, yaw: float, pitch: float
) -> None:
    """The camera placed by turns about Z and Y, as pylinalg composes them."""
    turn_z = la.mat_from_axis_angle((0, 0, 1), math.radians(yaw))
    turn_y = la.mat_from_axis_angle((0, 1, 0), math.radians(pitch))
    world_from_eye = la.mat_from_translation(position) @ turn_z @ turn_y
    expected = spaces.VIEW_FROM_EYE @ la.mat_inverse(world_from_eye)
    np.testing.assert_allclose(spaces.view_from_world(position, yaw, pitch), expected, atol=1e-7)


@given(points, points, yaws, pitches, fovs, st.floats(0.5, 2))
def test_clip_and_back(
    position: spaces.Vec3,
    target: spaces.Vec3,
    yaw: float,
    pitch: float,
    fov: float,
    aspect: float,
) -> None:
    """A point in front of the near plane survives the way to clip space and back."""
    view = spaces.view_from_world(position, yaw, pitch)
    far = 1e5
    clip = spaces.clip_from_view(fov, spaces.vertical_fov(fov, aspect), 4, far) @ view
    there = clip @ (*target, 1)
    assume(there[3] > 4)
    back = la.vec_transform(there[:3] / there[3], la.mat_inverse(clip))
    np.testing.assert_allclose(back, target, rtol=1e-5, atol=there[3] ** 2 * 1e-9 + 1e-4)


@given(yaws, pitches)
def test_angles_and_forward_are_inverses(yaw: float, pitch: float) -> None:
    forward = spaces.forward_from_angles(yaw, pitch)
    assert np.linalg.norm(forward) == pytest.approx(1)
    again = spaces.forward_from_angles(*spaces.angles_from_forward(forward))
    np.testing.assert_allclose(again, forward, atol=1e-9)


@pytest.mark.parametrize(
    ("yaw", "pitch", "forward"),
    [
        (0, 0, (1, 0, 0)),
        (90, 0, (0, 1, 0)),  # counter-clockwise from above
        (180, 0, (-1, 0, 0)),
        (-90, 0, (0, -1, 0)),
        (0, 90, (0, 0, -1)),  # positive pitch looks down
        (45, -90, (0, 0, 1)),
        (90, 45, (0, math.sqrt(0.5), -math.sqrt(0.5))),
    ],
)
def test_quake_angles(yaw: float, pitch: float, forward: tuple[float, float, float]) -> None:
    np.testing.assert_allclose(spaces.forward_from_angles(yaw, pitch), forward, atol=1e-12)


def test_view_axes() -> None:
    """Looking along +X: ahead is -Z, Quake's left (+Y) is -X, up stays up."""
    view = spaces.view_from_world(spaces.vec3((0, 0, 0)), 0, 0)[:3, :3]
    np.testing.assert_allclose(view @ (1, 0, 0), (0, 0, -1), atol=1e-12)
    np.testing.assert_allclose(view @ (0, 1, 0), (-1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(view @ (0, 0, 1), (0, 1, 0), atol=1e-12)
    assert np.linalg.det(spaces.VIEW_FROM_EYE) == pytest.approx(1)


def test_shadow_from_clip_maps_the_clip_cube_to_the_unit_cube() -> None:
    corners = spaces.box_corners(-np.ones(3), np.ones(3))
    mapped = la.vec_transform(corners, spaces.SHADOW_FROM_CLIP)
    np.testing.assert_array_equal(mapped, spaces.box_corners(np.zeros(3), np.ones(3)))


@given(points, points)
def test_box_corners(a: spaces.Vec3, b: spaces.Vec3) -> None:
    low, high = np.minimum(a, b), np.maximum(a, b)
    corners = spaces.box_corners(low, high)
    assert corners.shape == (8, 3)
    assert (corners.min(axis=0) == low).all() and (corners.max(axis=0) == high).all()
    sides = (corners == low).astype(int) + 2 * (corners == high)
    assert (sides > 0).all()
    if (low < high).all():
        assert len({tuple(corner) for corner in corners}) == 8


@given(points)
def test_normalised(vector: spaces.Vec3) -> None:
    assume(np.linalg.norm(vector) > 1e-3)
    unit = spaces.normalised(vector)
    assert np.linalg.norm(unit) == pytest.approx(1)
    np.testing.assert_allclose(np.cross(unit, vector), 0, atol=1e-8)
    assert unit @ vector > 0


@pytest.mark.parametrize("bad", [(0, 0, 0), (math.nan, 0, 1), (math.inf, 0, 0)])
def test_no_direction(bad: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="no direction"):
        spaces.normalised(spaces.vec3(bad))


def test_vec3_is_a_read_only_copy() -> None:
    source = np.array([1.0, 2, 3])
    vector = spaces.vec3(source)
    source[0] = 5
    assert vector.tolist() == [1, 2, 3] and vector.dtype == np.float64
    with pytest.raises(ValueError, match="read-only"):
        vector[0] = 0
    with pytest.raises(ValueError, match="reshape"):
        spaces.vec3((1, 2))


pyramid = st.tuples(st.floats(10, 8000), st.floats(-1, 1), st.floats(-0.8, 0.8))
triangles = st.lists(pyramid, min_size=3, max_size=3).map(
    lambda corners: np.array([(z, -x * z, y * z, 1) for z, x, y in corners])
)
"""(3, 4) corners in sight of a camera at the origin that looks along +X."""
weights = st.tuples(st.floats(0.01, 1), st.floats(0.01, 1), st.floats(0.01, 1)).map(
    lambda w: np.array(w) / sum(w)
)


@given(triangles, weights, points, st.floats(10, 150))
def test_projecting_before_interpolation_equals_projecting_after_it(
    vertices: Floats, screen: Floats, position: spaces.Vec3, fov: float
) -> None:
    """What the rasteriser does to a varying, against the matrix at the pixel's own position.

    The vertex stage multiplies by the light's matrix in float32; the rasteriser interpolates the
    homogeneous result with weights corrected by the camera's w; the pixel stage divides. A
    linear map commutes with that, so the division at the end gives the same place.
    """
    camera = spaces.clip_from_view(90, 80, 4, 1e5) @ spaces.view_from_world(
        spaces.vec3((0, 0, 0)), 0, 0
    )
    w = vertices @ camera[3]
    corrected = screen / w / (screen / w).sum()
    at_pixel = corrected @ vertices
    assume(np.linalg.norm(at_pixel[:3] - position) > 100)
    yaw, pitch = spaces.angles_from_forward(at_pixel[:3] - position)
    shadow = spaces.SHADOW_FROM_CLIP @ spaces.clip_from_view(fov, fov, 10, 3e4)
    shadow = shadow @ spaces.view_from_world(position, yaw + 3, np.clip(pitch + 2, -90, 90))

    varying = vertices.astype(np.float32) @ shadow.T.astype(np.float32)
    before = corrected.astype(np.float32) @ varying
    after = shadow @ at_pixel
    # float32 keeps 24 bits of the largest term that goes into a sum.
    error = 2.0**-21 * (np.abs(shadow) @ np.abs(vertices).max(axis=0)) + 1e-6
    assert (np.abs(before - after) <= error).all()
    assume(after[3] > 50 * error[3])
    place, expected = before[:3] / before[3], after[:3] / after[3]
    slack = 1.1 * (error[:3] + error[3] * np.abs(expected)) / after[3]
    assert (np.abs(place - expected) <= slack).all()


@pytest.mark.parametrize("up", [1.0, -1.0])
def test_straight_up_and_down_have_no_yaw_from_rounding(up: float) -> None:
    for noise in (0.0, 3e-17, -5e-17):
        assert spaces.angles_from_forward(spaces.vec3([-3e-17, noise, up])) == (0.0, -90.0 * up)
    assert spaces.angles_from_forward(spaces.vec3([-1e-6, 0, up]))[0] == 180.0
