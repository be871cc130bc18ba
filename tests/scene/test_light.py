"""Lights: the intensity that holds the power, integrated over the sphere."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.errors import UsageError
from followspot.scene.light import PointLight, SpotLight
from followspot.spaces import Vec3, vec3

powers = st.tuples(*[st.just(0.0) | st.floats(1e-6, 1e6)] * 3).map(vec3)


@given(powers)
def test_point_light_spreads_its_power_over_the_sphere(power: Vec3) -> None:
    light = PointLight(vec3((0, 0, 0)), power)
    np.testing.assert_allclose(light.intensity * 4 * math.pi, power)


@given(powers, st.floats(0.01, 1.55), st.floats(0, 1))
def test_spot_light_holds_its_power(power: Vec3, half_angle: float, softness: float) -> None:
    """Intensity times the smoothstep profile, integrated over the cone in its cosine."""
    light = SpotLight(vec3((0, 0, 0)), vec3((0, 0, 1)), half_angle, power, softness)
    assert light.cos_rim <= light.cos_full <= 1
    edges = np.linspace(light.cos_rim, 1, 20001)
    cosine = (edges[1:] + edges[:-1]) / 2
    t = np.clip((cosine - light.cos_rim) / max(light.cos_full - light.cos_rim, 1e-12), 0, 1)
    solid_angle = 2 * math.pi * (t * t * (3 - 2 * t)).sum() * (edges[1] - edges[0])
    np.testing.assert_allclose(light.intensity * solid_angle, power, rtol=1e-3)


def test_hard_cone_in_closed_form() -> None:
    """A half-angle of 60 degrees is a solid angle of pi."""
    light = SpotLight(vec3((0, 0, 0)), vec3((0, 0, 1)), math.pi / 3, vec3((math.pi, 0, 1)))
    np.testing.assert_allclose(light.intensity, (1, 0, 1 / math.pi))


def test_directions_are_made_unit_length() -> None:
    light = SpotLight(vec3((0, 0, 0)), vec3((0, 3, 4)), 0.5, vec3((1, 1, 1)))
    np.testing.assert_allclose(light.direction, (0, 0.6, 0.8))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"direction": vec3((0, 0, 0))}, "a direction"),
        ({"direction": vec3((0, 0, math.nan))}, "a direction"),
        ({"position": vec3((0, math.nan, 0))}, "finite position"),
        ({"power": vec3((0, -1, 0))}, "watts"),
        ({"power": vec3((0, math.inf, 0))}, "watts"),
        ({"half_angle": 0.0}, "half-angle"),
        ({"half_angle": math.pi / 2}, "half-angle"),
        ({"half_angle": math.nan}, "half-angle"),
        ({"softness": 1.5}, "softness"),
    ],
)
def test_lights_that_make_no_sense(change: dict[str, Any], told: str) -> None:
    good = SpotLight(vec3((0, 0, 0)), vec3((0, 0, 1)), 0.5, vec3((1, 1, 1)))
    with pytest.raises(UsageError, match=told):
        replace(good, **change)
    if change.keys() <= {"position", "power"}:
        with pytest.raises(UsageError, match=told):
            replace(PointLight(good.position, good.power), **change)
