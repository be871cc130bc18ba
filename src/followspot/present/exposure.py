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

MAX_EXPOSURE = 1e6
"""Largest display value per radiance: that of a black picture."""

_PLACES = 100  # looked at along a picture's shorter edge


def automatic(picture: NDArray[Any]) -> float:
    """The display value per radiance that suits a picture.

    It brings the geometric mean of the surfaces' luminances to `MIDDLE` (the log-average of
    Reinhard et al., Photographic Tone Reproduction for Digital Images, 2002), unless more than a
    few percent of them, or most of the sky, would burn out.

    Args:
        picture: (h, w, 4) float32 radiance; the fourth is above 0.5 where there is a surface.
    """
    step = max(1, min(picture.shape[:2]) // _PLACES)
    values = picture[::step, ::step].reshape(-1, 4)
    luminance = values[:, :3] @ LUMINANCE
    luminance = np.where(np.isfinite(luminance), luminance, 0)
    is_surface = values[:, 3] > 0.5
    surface, sky = luminance[is_surface & (luminance > 0)], luminance[~is_surface]
    limits = [MAX_EXPOSURE]
    if len(surface):
        limits.append(MIDDLE / float(np.exp(np.log(surface).mean())))
        limits.append(HIGHLIGHT / float(np.percentile(surface, BRIGHT_PERCENT)))
    if len(sky) and np.median(sky) > 0:
        limits.append(SKY / float(np.median(sky)))
    return min(limits)
