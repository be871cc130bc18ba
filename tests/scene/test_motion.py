"""Texture coordinates at a time, against the engine's way: mod after mod, vertex by vertex."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from followspot.arrays import Floats
from followspot.assets.shader_motion import (
    Rotate,
    Scale,
    Scroll,
    Shape,
    Stretch,
    TcMod,
    Transform,
    Turbulence,
    Wave,
)
from followspot.scene.motion import Motion, value

PLACES = np.random.default_rng(1).uniform(-3000, 3000, (40, 3))
COORDINATES = np.random.default_rng(2).uniform(-2, 2, (40, 2))


def moved(mods: tuple[TcMod, ...], seconds: float) -> Floats:
    """(40, 2) what `Motion.terms` makes of COORDINATES at PLACES."""
    terms = np.array(Motion(mods).terms(seconds))
    x = math.tau * (PLACES[:, 0] + PLACES[:, 2]) / 1024
    y = math.tau * PLACES[:, 1] / 1024
    s, t = COORDINATES.T
    weights = [s, t, np.ones(40), np.sin(x), np.sin(y), np.cos(x), np.cos(y)]
    return np.asarray(np.stack(weights[: len(terms)], axis=1) @ terms)


@pytest.mark.parametrize(
    ("shape", "heights"),
    [
        (Shape.SIN, (0, math.sqrt(0.5), 1, math.sqrt(0.5), 0, -1)),
        (Shape.TRIANGLE, (0, 0.5, 1, 0.5, 0, -1)),
        (Shape.SQUARE, (1, 1, 1, 1, -1, -1)),
        (Shape.SAWTOOTH, (0, 0.125, 0.25, 0.375, 0.5, 0.75)),
        (Shape.INVERSE_SAWTOOTH, (1, 0.875, 0.75, 0.625, 0.5, 0.25)),
    ],
)
def test_waves(shape: Shape, heights: tuple[float, ...]) -> None:
    for at, height in zip((0, 0.125, 0.25, 0.375, 0.5, 0.75), heights, strict=True):
        for period in (-2, 0, 7):
            assert value(Wave(shape, 0, 1, at, 0), 99) == pytest.approx(height, abs=1e-12)
            seconds = (at - 0.3 + period) / 0.4
            wave = Wave(shape, 5, -2, 0.3 + 1e-9, 0.4)  # a hair behind a square's edge
            assert value(wave, seconds) == pytest.approx(5 - 2 * height, abs=1e-6)


def test_noise_goes_straight_from_one_number_to_the_next() -> None:
    """Twice as fast at twice the frequency, phases included; the numbers keep within its range."""
    wave = Wave(Shape.NOISE, 0, 1, 0, 1)
    whole = np.array([value(wave, at) for at in range(-20, 300)])
    assert np.abs(whole).max() <= 1 and whole.std() > 0.4 and abs(whole.mean()) < 0.1
    assert len(np.unique(whole)) == 256
    np.testing.assert_array_equal(whole[:64], whole[256:])
    for share in (0.25, 0.5):
        between = [value(wave, at + share) for at in range(-20, 299)]
        np.testing.assert_allclose(between, whole[:-1] + share * np.diff(whole), atol=1e-12)
    fast = Wave(Shape.NOISE, 3, 0.5, 0.25, 2)
    assert value(fast, 1.0) == pytest.approx(3 + 0.5 * value(wave, 2.5))


@pytest.mark.parametrize(
    ("mod", "seconds", "s_t", "expected"),
    [
        (Scroll(0.25, -0.5), 3, (0.1, 0.2), (0.85, 0.7)),  # 0.75 and -1.5: whole numbers come off
        (Scale(7, -2), 3, (0.1, 0.2), (0.7, -0.4)),
        (Rotate(90), 1, (1, 0.5), (0.5, 0)),  # by -90 degrees about the middle
        (Rotate(-90), 1, (1, 0.5), (0.5, 1)),
        (Rotate(10), 18, (0.2, 0.9), (0.8, 0.1)),
        (Stretch(Wave(Shape.SQUARE, 0, 4, 0, 1)), 0.1, (0.9, 0.1), (0.6, 0.4)),
        (Stretch(Wave(Shape.SAWTOOTH, 0.5, 1, 0, 1)), 0, (0.6, 0.4), (0.7, 0.3)),
        (Transform(1, 2, 3, 4, 5, 6), 3, (0.1, 0.2), (0.1 + 0.6 + 5, 0.2 + 0.8 + 6)),
    ],
)
def test_one_change_worked_out_by_hand(
    mod: TcMod, seconds: float, s_t: tuple[float, float], expected: tuple[float, float]
) -> None:
    of_s, of_t, of_1 = np.array(Motion((mod,)).terms(seconds))
    np.testing.assert_allclose(s_t[0] * of_s + s_t[1] * of_t + of_1, expected, atol=1e-12)


def test_turbulence_worked_out_by_hand() -> None:
    """Where x + z is a quarter of a wave and y three quarters, a period and an eighth later."""
    motion = Motion((Turbulence(0.1, 0.5, 0.25),))
    terms = np.array(motion.terms(2.5))  # phase 1.125 periods
    half = math.sqrt(0.5)
    x, y = math.tau / 4, math.tau * 3 / 4
    sway = terms[3:].T @ [math.sin(x), math.sin(y), math.cos(x), math.cos(y)]
    np.testing.assert_allclose(sway, [0.1 * half, -0.1 * half], atol=1e-12)
    assert motion.is_turbulent and not Motion((Scale(2, 2),)).is_turbulent
    assert terms[:3].tolist() == [[1, 0], [0, 1], [0, 0]]


def test_changes_are_made_in_the_scripts_order() -> None:
    scale, scroll = Scale(2, 2), Scroll(0.25, 0)
    s, t = COORDINATES.T
    np.testing.assert_allclose(moved((scale, scroll), 1), np.c_[2 * s + 0.25, 2 * t])
    np.testing.assert_allclose(moved((scroll, scale), 1), np.c_[2 * (s + 0.25), 2 * t])


def test_a_stretch_of_nothing_is_a_number() -> None:
    for sign in (1, -1):
        gone = Stretch(Wave(Shape.SAWTOOTH, 0, sign, 0, 1))
        assert np.abs(Motion((gone,)).terms(0)).max() == 1024


@pytest.mark.parametrize("seconds", [0, 0.09, 0.11, 0.79, 0.81, 12.34, -0.01])
def test_images_follow_each_other(seconds: float) -> None:
    motion = Motion(frames=tuple("abcdefgh"), rate=10)
    assert motion.frame(seconds) == math.floor(seconds * 10) % 8


def test_a_pulse_is_a_share_of_what_is_displayed() -> None:
    motion = Motion(color=Wave(Shape.SAWTOOTH, 0, 1, 0, 1), alpha=Wave(Shape.SIN, 1, 9, 0, 1))
    assert motion.pulses and not Motion().pulses
    color, alpha = motion.pulse(0.5)
    assert color == pytest.approx(0.5**2.2) and alpha == 1
    assert motion.pulse(0.75)[1] == 0
    assert Motion(alpha=motion.alpha).pulse(0.5)[0] == 1


def step_by_step(mods: tuple[TcMod, ...], seconds: float) -> Floats:
    """The engine's loop, written anew from its description: each mod over all vertices."""
    s, t = COORDINATES.T
    for mod in mods:
        match mod:
            case Scroll(ds, dt):
                s, t = s + np.modf(ds * seconds)[0], t + np.modf(dt * seconds)[0]
            case Scale(by_s, by_t):
                s, t = s * by_s, t * by_t
            case Rotate(degrees):
                angle = -np.radians(degrees * seconds)
                u, v = s - 0.5, t - 0.5
                s = u * np.cos(angle) - v * np.sin(angle) + 0.5
                t = u * np.sin(angle) + v * np.cos(angle) + 0.5
            case Stretch(wave):
                s, t = (
                    (s - 0.5) / value(wave, seconds) + 0.5,
                    (t - 0.5) / value(wave, seconds) + 0.5,
                )
            case Transform(a, b, c, d, e, f):
                s, t = s * a + t * c + e, s * b + t * d + f
            case Turbulence(amplitude, phase, frequency):
                now = phase + seconds * frequency
                x, y, z = PLACES.T
                s = s + amplitude * np.sin(math.tau * ((x + z) / 128 * 0.125 + now))
                t = t + amplitude * np.sin(math.tau * (y / 128 * 0.125 + now))
    return np.stack([s, t], axis=1)


NUMBERS = st.floats(-3, 3, allow_subnormal=False)
POSITIVE = st.floats(0, 3, allow_subnormal=False)
MODS = st.one_of(
    st.builds(Scroll, POSITIVE, POSITIVE),
    st.builds(Scale, NUMBERS, NUMBERS),
    st.builds(Rotate, st.floats(-400, 400)),
    st.builds(Stretch, st.builds(Wave, st.just(Shape.SIN), st.just(2.0), st.just(1.0), NUMBERS,
                                 NUMBERS)),
    st.builds(Transform, NUMBERS, NUMBERS, NUMBERS, NUMBERS, NUMBERS, NUMBERS),
    st.builds(Turbulence, NUMBERS, NUMBERS, NUMBERS),
)  # fmt: skip


@given(st.lists(MODS, max_size=4).map(tuple), st.floats(0, 100))
def test_all_changes_put_together_are_those_made_one_after_the_other(
    mods: tuple[TcMod, ...], seconds: float
) -> None:
    np.testing.assert_allclose(moved(mods, seconds), step_by_step(mods, seconds), atol=1e-6)
