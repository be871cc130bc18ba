"""How bright a picture is displayed when nobody says."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.assets.image import LUMINANCE

MIDDLE = 0.18
"""Linear display value that the surfaces' geometric mean comes to."""

BRIGHT_PERCENT, HIGHLIGHT = 95, 0.65
"""So many percent of the surfaces stay below this linear display value."""

SKY = 0.8
"""Largest linear display value of the sky's median."""

SKY_COUNTS = 0.25
"""Share of the picture from which on the sky counts in full; a sliver of it may burn out."""

SURFACES_COUNT, WHOLE = 0.1, 0.4
"""Share of the picture from which on surfaces count in full; where there are fewer, the whole
picture's mean comes to at most about this linear display value."""

MAX_EXPOSURE = 1e6
"""Largest display value per radiance: that of a black picture."""

_PLACES = 100  # looked at along a picture's shorter edge


def automatic(picture: NDArray[Any]) -> float:
    """The display value per radiance that suits a picture.

    It brings the geometric mean of the surfaces' luminances to `MIDDLE` (the log-average of
    Reinhard et al., Photographic Tone Reproduction for Digital Images, 2002), unless more than a
    few percent of them, or most of the sky, would burn out. Where there is little of either, it
    counts for less.

    Args:
        picture: (h, w, 4) float32 radiance; the fourth is above 0.5 where there is a surface.
    """
    step = max(1, min(picture.shape[:2]) // _PLACES)
    values = picture[::step, ::step].reshape(-1, 4)
    luminance = values[:, :3] @ LUMINANCE
    luminance = np.where(np.isfinite(luminance), np.maximum(luminance, 0), 0)
    is_surface = values[:, 3] > 0.5
    surface, sky = luminance[is_surface & (luminance > 0)], luminance[~is_surface]
    exposure = MAX_EXPOSURE
    if luminance.any():
        exposure = min(exposure, WHOLE / float(luminance.mean()))
    if len(surface):
        middle = MIDDLE / float(np.exp(np.log(surface).mean()))
        bright = HIGHLIGHT / float(np.percentile(surface, BRIGHT_PERCENT))
        share = len(surface) / len(luminance) / SURFACES_COUNT
        own = min(middle, bright, MAX_EXPOSURE)
        exposure = min(own, _between(exposure, own, share))
    if len(sky) and np.median(sky) > 0:
        limit = SKY / float(np.median(sky))
        share = len(sky) / len(luminance) / SKY_COUNTS
        exposure = min(exposure, _between(exposure, limit, share))
    return exposure


def _between(a: float, b: float, share: float) -> float:
    """From one exposure to another by a share, stop by stop."""
    return float(a * (b / a) ** min(share, 1.0))
