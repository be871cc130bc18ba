"""Pictures as bytes for the page."""

import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Pixels = NDArray[np.uint8]
"""(h, w, 3) as displayed, top row first."""

_QUALITY = 88


def jpeg(picture: Pixels) -> bytes:
    """A picture as a file's bytes, at a quality that shows no blocks."""
    file = io.BytesIO()
    Image.fromarray(picture).save(file, "jpeg", quality=_QUALITY)
    return file.getvalue()


def at_most(edge: int, picture: Pixels) -> Pixels:
    """A picture made so small that neither edge is longer."""
    image = Image.fromarray(picture)
    image.thumbnail((edge, edge), Image.Resampling.BOX)
    return np.asarray(image)
