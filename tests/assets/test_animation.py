import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.assets.animation import (
    ANIMATION_NAMES,
    TEAM_ANIMATION_NAMES,
    Animation,
    parse_animation_config,
)
from followspot.errors import AssetError
from model_fixtures import animation_config, openarena_files

CONFIG = animation_config()


def frames_of(animation: Animation, steps: int) -> list[int]:
    """The key frame of each step, with the next one checked against it."""
    pose = animation.pose(np.arange(steps) / animation.fps)
    assert np.array_equal(pose.blend, np.zeros(steps))
    assert np.array_equal(pose.next_frame[:-1], pose.frame[1:])
    return [int(frame) for frame in pose.frame]


@pytest.mark.parametrize(
    ("animation", "frames"),
    [
        (Animation(10, 3, 3, 8), [10, 11, 12, 10, 11, 12, 10]),
        (Animation(10, 3, 0, 8), [10, 11, 12, 12, 12]),
        (Animation(10, 4, 2, 8), [10, 11, 12, 13, 12, 13, 12]),
        (Animation(10, 4, 1, 8), [10, 11, 12, 13, 13]),
        (Animation(5, 1, 0, 8), [5, 5]),
        (Animation(10, 3, 3, 8, is_reversed=True), [12, 11, 10, 12, 11]),
        (Animation(10, 4, 0, 8, is_reversed=True), [13, 12, 11, 10, 10]),
    ],
)
def test_key_frames_are_met_exactly(animation: Animation, frames: list[int]) -> None:
    assert frames_of(animation, len(frames)) == frames


def test_moments_between_key_frames() -> None:
    run = Animation(40, 6, 6, 10.0)
    assert run.seconds == 0.6
    pose = run.pose([-1, 0.05, 0.575, 0.625])
    assert pose.frame.tolist() == [40, 40, 45, 40]
    assert pose.next_frame.tolist() == [41, 41, 40, 41]
    np.testing.assert_allclose(pose.blend, [0, 0.5, 0.75, 0.25], atol=1e-12)
    single = run.pose(0.05)
    assert (single.frame.shape, single.blend.shape) == ((), ())


def test_clipped_animations_fit() -> None:
    run = Animation(10, 6, 6, 8)
    assert run.clipped(16) == run
    assert run.clipped(13) == Animation(10, 3, 3, 8)
    assert run.clipped(5) == Animation(4, 1, 1, 8)


def test_config() -> None:
    head = (
        "// a /* comment\nsex f\n/* headoffset\n1 2 */ headoffset -4 .5 1.\nfootsteps Boot unknown"
    )
    config = parse_animation_config(animation_config(head + "\nFixedLegs fixedtorso"), "a.cfg")
    assert (config.sex, config.footsteps) == ("f", "boot")
    assert list(config.head_offset) == [-4, 0.5, 1]
    assert all([config.fixed_legs, config.fixed_torso])
    assert tuple(config.animations) == ANIMATION_NAMES
    # Rows 6 to 12 are the torso's own, and taken off the frames of the legs, rows 13 to 24.
    assert [a.first for a in config.animations.values()] == [*range(13), *range(6, 18)]
    assert config.animations["legs_run"] == Animation(8, 1, 1, 25.0)


def test_config_says_little() -> None:
    config = parse_animation_config(CONFIG.replace("sex m", ""), "a.cfg")
    assert (config.sex, config.footsteps, config.head_offset) == ("m", "default", (0, 0, 0))
    assert not any([config.fixed_legs, config.fixed_torso])


def test_what_real_configs_do_is_taken() -> None:
    """No frames at no rate (OpenArena's merman), counts below zero, rows of Team Arena."""
    rows = CONFIG.replace("24\t1\t1\t34", "24 0 0 0")
    rows = rows.replace("23\t1\t1\t33", "23 -4 9 12.5")
    team = [f"{30 + i} 1 0 5" for i in range(len(TEAM_ANIMATION_NAMES))]
    config = parse_animation_config("\n".join([rows, *team, "7 7 7 7 rest"]), "a.cfg")
    assert config.animations["legs_turn"] == Animation(17, 1, 0, 1.0)
    assert config.animations["legs_idlecr"] == Animation(16, 4, 4, 12.5, is_reversed=True)
    assert tuple(config.animations) == (*ANIMATION_NAMES, *TEAM_ANIMATION_NAMES)
    assert config.animations["torso_negative"].first == 35  # of the torso: nothing taken off


@pytest.mark.parametrize(
    ("old", "new", "place", "message"),
    [
        ("sex m", "headoffset 1 2 x", "line 1", "a number of units, found x"),
        ("sex m", "headoffset 1 2 nan", "line 1", "a number of units, found nan"),
        ("7\t1\t1\t17", "-7 1 1 17", "line 10", "the first frame of torso_attack, found -7"),
        ("7\t1\t1\t17", "7 one 1 17", "line 10", "the number of frames of torso_attack, found one"),
        ("7\t1\t1\t17", "7 1 1.5 17", "line 10", "looping frames of torso_attack, found 1.5"),
        ("7\t1\t1\t17", "7 1 -1 17", "line 10", "not below 0, found -1 and 17"),
        ("7\t1\t1\t17", "7 1 1 1e9", "line 10", "frames a second of torso_attack, found 1e9"),
        (
            "7\t1\t1\t17",
            f"7 {'9' * 5000} 1 1",
            "line 10",
            "number of frames of torso_attack, found 9",
        ),
        ("15\t1\t1\t25", "3 1 1 1", "line 18", "a frame of the legs for legs_run, found 3, which"),
        (CONFIG, "", "line 1", "25 animations, found 0"),
        (CONFIG, "sex", "line 1", "m, f or n, found the end of the file"),
        ("24\t1\t1\t34", "", "line 26", "25 animations, found 24"),
    ],
)
def test_configs_that_lie(old: str, new: str, place: str, message: str) -> None:
    assert old in CONFIG
    with pytest.raises(AssetError) as error:
        parse_animation_config(CONFIG.replace(old, new, 1), "lie.cfg")
    assert error.value.place == place
    assert message in str(error.value)


def test_every_truncation_is_an_asset_error() -> None:
    """Up to the last number: a prefix of it is a number too."""
    last = CONFIG.index("34\t// legs_turn")
    for length in range(last + 1):
        with pytest.raises(AssetError):
            parse_animation_config(CONFIG[:length], "cut.cfg")


@given(st.integers(0, len(CONFIG) - 1), st.text(max_size=12))
def test_any_text_parses_or_is_an_asset_error(at: int, change: str) -> None:
    text = CONFIG[:at] + change + CONFIG[at + len(change) :]
    try:
        config = parse_animation_config(text, "changed.cfg")
    except AssetError as error:
        assert error.source == "changed.cfg"
        assert error.place.startswith("line ")
    else:
        for animation in config.animations.values():
            assert animation.first >= 0
            assert 0 <= animation.looping <= animation.count
            assert animation.count >= 1
            assert animation.fps > 0


@pytest.mark.openarena
def test_all_configs_of_openarena_parse() -> None:
    configs = dict(openarena_files("animation.cfg"))
    assert len(configs) >= 20
    for source, data in configs.items():
        config = parse_animation_config(data.decode("latin-1"), source)
        assert set(config.animations) >= set(ANIMATION_NAMES)
        assert config.sex in ("m", "f", "n")
