"""Settings from text, as ``--set`` gives them."""

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.errors import UsageError
from followspot.scene.settings import CullFace, Settings, with_changes


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("shadows", "false", False),
        ("sky_light", "true", True),
        ("shadows", "0", False),
        ("albedo", "0.5", 0.5),
        ("albedo", "none", None),
        ("exposure", "auto", None),
        ("exposure", "2", 2.0),
        ("environment_mip", "9", 9.0),
        ("shadow_map_size", "2048", 2048),
        ("shadow_cull", "none", CullFace.NONE),
        ("shadow_cull", "back", CullFace.BACK),
        ("shadow_bias", "-0.5", -0.5),
        ("culling", "false", False),
        ("anisotropy", "16", 16.0),
    ],
)
def test_values(name: str, text: str, value: object) -> None:
    changed = with_changes(Settings(), {name: text})
    assert getattr(changed, name) == value
    assert changed == msgspec.structs.replace(Settings(), **{name: value})


def test_later_settings_keep_earlier_ones() -> None:
    changed = with_changes(Settings(albedo=0.3), {"exposure": "2", "shadow_bias": "1"})
    assert changed == Settings(albedo=0.3, exposure=2, shadow_bias=1)
    assert with_changes(changed, {}) == changed


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("brightness", "1", "there are shadows, sky_light, albedo"),
        ("albedo", "1.5", "<= 1"),
        ("albedo", "white", "'white'"),
        ("exposure", "0", "> 0"),
        ("exposure", "nan", "nan"),
        ("exposure", "inf", "inf"),
        ("shadow_bias", "nan", "nan"),
        ("shadow_bias", "inf", "inf"),
        ("shadow_slope_bias", "nan", "nan"),
        ("emission", "inf", "inf"),
        ("environment_mip", "inf", "inf"),
        ("exposure", "1e300", "<= 1000000.0"),
        ("emission", "1e300", "<= 1000000.0"),
        ("environment_mip", "1e300", "<= 1000000.0"),
        ("shadow_bias", "-1e300", ">= -1000000.0"),
        ("shadow_normal_offset", "1e300", "<= 1000000.0"),
        ("shadow_slope_bias", "1e300", "<= 1000000.0"),
        ("shadow_map_size", "12", "expected a whole number >= 16, found '12'"),
        ("shadow_map_size", "", "expected a whole number, found ''"),
        ("exposure", "bright", "expected a number, found 'bright'"),
        ("shadow_map_size", "99999999999999999999", "99999999999999999999"),
        ("shadow_cull", "left", "front"),
        ("shadows", "maybe", "expected true or false, found 'maybe'"),
        ("shadows", "", "expected true or false, found ''"),
        ("culling", "none", "expected true or false, found 'none'"),
    ],
)
def test_wrong_values_are_told(name: str, text: str, told: str) -> None:
    with pytest.raises(UsageError) as caught:
        with_changes(Settings(), {name: text})
    assert name in str(caught.value) and told in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("exposure", -1.0),
        ("exposure", math.nan),
        ("exposure", np.float32(0)),
        ("shadow_map_size", 4),
        ("shadow_map_size", 64.5),
        ("shadow_cull", "left"),
        ("culling", None),
    ],
)
def test_settings_of_a_program_are_checked_too(name: str, value: object) -> None:
    with pytest.raises(UsageError, match=f"setting {name}: expected "):
        Settings(**{name: value})  # type: ignore[arg-type]
    with pytest.raises(UsageError, match=f"setting {name}: expected "):
        msgspec.structs.replace(Settings(), **{name: value})


def test_settings_of_a_program_are_made_what_they_mean() -> None:
    made = Settings(exposure=np.float32(0.5), shadow_cull="back")  # type: ignore[arg-type]
    assert made == Settings(exposure=0.5, shadow_cull=CullFace.BACK)
    assert type(made.exposure) is float


@given(st.sampled_from([f.name for f in msgspec.structs.fields(Settings)]), st.text(max_size=12))
def test_any_text_gives_settings_or_the_one_error(name: str, text: str) -> None:
    try:
        changed = with_changes(Settings(), {name: text})
    except UsageError as error:
        assert name in str(error)
    else:
        value = getattr(changed, name)
        assert not isinstance(value, float) or math.isfinite(value)
