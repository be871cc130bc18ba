"""What the exposure promises that is chosen when nobody says."""

import numpy as np
import pytest
from numpy.typing import NDArray

from followspot.present.exposure import BRIGHT_PERCENT, HIGHLIGHT, MAX_EXPOSURE, MIDDLE, automatic

SHAPE = (60, 80)
SURFACE, SKY = 1.0, 0.0

Picture = NDArray[np.float32]


def picture(radiance: float | NDArray[np.float64], kind: float = SURFACE) -> Picture:
    """(h, w, 4) greys."""
    made = np.empty((*SHAPE, 4), np.float32)
    made[..., :3] = np.broadcast_to(radiance, SHAPE)[..., np.newaxis]
    made[..., 3] = kind
    return made


def varied(spread: float) -> NDArray[np.float64]:
    """(h, w) radiances around 0.02, log-normal."""
    return 0.02 * np.exp(spread * np.random.default_rng(4).normal(size=SHAPE))


def test_the_log_average_comes_to_middle_grey() -> None:
    radiance = varied(0.3)
    shown = radiance * automatic(picture(radiance))
    assert np.exp(np.log(shown).mean()) == pytest.approx(MIDDLE, rel=1e-5)


@pytest.mark.parametrize("spread", [0.3, 1.0, 2.0, 4.0])
def test_few_surfaces_are_brighter_than_highlights_may_be(spread: float) -> None:
    radiance = varied(spread)
    shown = radiance * automatic(picture(radiance))
    assert (shown > HIGHLIGHT * 1.0001).mean() <= 1 - BRIGHT_PERCENT / 100
    assert np.exp(np.log(shown).mean()) <= MIDDLE * 1.0001


def test_most_of_the_sky_does_not_burn_out() -> None:
    bright = picture(varied(0.3))
    bright[:30] = picture(3.0, SKY)[:30]
    assert automatic(bright) * 3 == pytest.approx(0.8)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 0.0])
def test_what_is_no_light_is_not_counted(wrong: float) -> None:
    some = picture(varied(0.3))
    whole = automatic(some)
    half = some.copy()
    half[::2] = some[1::2]  # so that each row that is left out is there once more
    expected = automatic(half)
    half[::2, :, :3] = wrong
    assert automatic(half) == pytest.approx(expected, rel=1e-5)
    assert whole == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("kind", [SURFACE, SKY])
@pytest.mark.parametrize("radiance", [0.0, np.nan])
def test_a_black_picture(radiance: float, kind: float) -> None:
    assert automatic(picture(radiance, kind)) == MAX_EXPOSURE


@pytest.mark.parametrize("factor", [0.01, 0.5, 7.0, 1000.0])
def test_a_brighter_picture_is_exposed_less(factor: float) -> None:
    for spread in (0.3, 2.0):
        some = picture(varied(spread))
        some[:20, :, 3] = SKY
        brighter = some.copy()
        brighter[..., :3] *= factor
        assert automatic(brighter) == pytest.approx(automatic(some) / factor, rel=1e-4)


def test_a_sliver_of_sky_may_burn_out() -> None:
    """It counts by its share, so that nothing jumps when it comes into view."""
    surfaces = picture(varied(0.3))
    exposures = []
    for columns in (0, 1, 4, 20):
        some = surfaces.copy()
        some[:, :columns] = picture(30.0, SKY)[:, :columns]
        exposures.append(automatic(some))
    none, sliver, strip, quarter = exposures
    assert quarter == pytest.approx(0.8 / 30) and none > sliver > strip > quarter
    assert sliver > 0.7 * none


@pytest.mark.parametrize("dark", [1e-2, 1e-5])
def test_few_dark_surfaces_do_not_burn_a_sky_of_stars(dark: float) -> None:
    stars = picture(0.0, SKY)
    stars[::3, ::3, :3] = 0.5  # most of the sky is black
    alone = automatic(stars)
    stars[30, :8] = picture(dark)[30, :8]
    assert 0.5 * alone < automatic(stars) < 2 * alone
    assert alone * stars[..., :3].mean() == pytest.approx(0.4, rel=0.1)
