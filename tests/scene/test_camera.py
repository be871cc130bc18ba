"""The camera in the game's terms."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.errors import UsageError
from followspot.scene.camera import Camera
from followspot.spaces import box_corners, vec3

numbers = st.floats(-5000, 5000)


def test_forward_follows_the_games_angles() -> None:
    np.testing.assert_allclose(Camera(vec3((1, 2, 3)), yaw=90).forward, (0, 1, 0), atol=1e-12)
    assert Camera(vec3((0, 0, 0)), pitch=30).forward[2] == pytest.approx(-0.5)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        *(({"fov": fov}, "fov") for fov in (180, 0, -90, math.nan)),
        *(({"near": near}, "near") for near in (0, -1, math.nan, math.inf)),
        ({"yaw": math.nan}, "finite"),
        ({"pitch": 100}, "expected a pitch of -90 to 90 degrees, found 100"),
        ({"pitch": -90.001}, "expected a pitch of -90 to 90 degrees, found -90.001"),
        ({"pitch": math.inf}, "finite"),
        ({"position": vec3((0, math.nan, 0))}, "finite"),
    ],
)
def test_cameras_that_make_no_sense(change: dict[str, Any], told: str) -> None:
    with pytest.raises(UsageError, match=told):
        replace(Camera(vec3((0, 0, 0))), **change)


def test_what_rounding_adds_to_the_steepest_pitch_is_cut_off() -> None:
    """Paths and flights work pitches out between others."""
    assert Camera(vec3((0, 0, 0)), pitch=math.nextafter(90, 91)).pitch == 90
    assert Camera(vec3((0, 0, 0)), pitch=math.nextafter(-90, -91)).pitch == -90


def test_fov_is_horizontal() -> None:
    """A point on the right edge stays there whatever the picture's height."""
    camera = Camera(vec3((0, 0, 0)), fov=90)
    for aspect in (0.5, 1.0, 16 / 9):
        clip = camera.clip_from_view(aspect, 1000) @ camera.view_from_world @ (100, -100, 0, 1)
        assert clip[0] / clip[3] == pytest.approx(1)
        top = (
            camera.clip_from_view(aspect, 1000) @ camera.view_from_world @ (100, 0, 100 / aspect, 1)
        )
        assert top[1] / top[3] == pytest.approx(1)


@given(
    st.tuples(numbers, numbers, numbers),
    st.tuples(numbers, numbers, numbers),
    st.tuples(numbers, numbers, numbers),
    st.floats(-180, 180),
    st.floats(-90, 90),
)
def test_far_plane_holds_the_box_whichever_way_the_camera_turns(
    a: tuple[float, ...], b: tuple[float, ...], eye: tuple[float, ...], yaw: float, pitch: float
) -> None:
    low, high = np.minimum(a, b).astype(np.float32), np.maximum(a, b).astype(np.float32)
    camera = Camera(vec3(eye), yaw, pitch)
    far = camera.far_for(low, high)
    assert far > camera.near
    corners = box_corners(low.astype(np.float64), high.astype(np.float64))
    assert ((corners - camera.position) @ camera.forward).max() < far
