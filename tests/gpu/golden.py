"""Comparing pictures with those that were looked at and kept, in ``tests/golden``."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

GOLDEN = Path(__file__).parent.parent / "golden"
FAILURES = Path(__file__).parent.parent.parent / "out" / "golden-failures"

Picture = NDArray[np.uint8]

THRESHOLDS = (0, 1, 2, 4, 8, 16, 32, 64)
"""Differences that the sweep counts pixels above."""

MAX_DIFFERENCE = 8
"""Steps of 255 by which a pixel may be off: other drivers round otherwise."""

MAX_SHARE = 0.005
"""Share of pixels that may be off by more: edges and shadows that fall on the next pixel."""


def check(name: str, picture: Picture, *, update: bool) -> None:
    """Compare a picture with the golden one of its name, or put it in that one's place.

    Args:
        name: What the picture protects.
        picture: (h, w, 3) uint8.
        update: Whether to write instead of comparing.

    Raises:
        AssertionError: the pictures differ; the result, the difference and a sweep of thresholds
            are in ``out/golden-failures``.
    """
    path = GOLDEN / f"{name}.png"
    if update:
        path.parent.mkdir(exist_ok=True)
        Image.fromarray(picture).save(path, optimize=True)
        return
    assert path.is_file(), f"{path} is missing: pytest --update-golden makes it"
    with Image.open(path) as image:
        golden = np.asarray(image.convert("RGB"))
    assert golden.shape == picture.shape, f"{name}: {picture.shape} instead of {golden.shape}"
    difference = np.abs(golden.astype(np.int16) - picture).astype(np.uint8)
    worst = difference.max(axis=2)
    share = float((worst > MAX_DIFFERENCE).mean())
    if share <= MAX_SHARE:
        return
    sweep = "\n".join(f"above {t:3}: {(worst > t).mean():.4%}" for t in THRESHOLDS)
    FAILURES.mkdir(parents=True, exist_ok=True)
    Image.fromarray(picture).save(FAILURES / f"{name}.png")
    Image.fromarray(np.minimum(difference.astype(np.uint16) * 4, 255).astype(np.uint8)).save(
        FAILURES / f"{name}-difference-x4.png"
    )
    (FAILURES / f"{name}.txt").write_text(f"pixels that differ\n{sweep}\n", encoding="utf-8")
    raise AssertionError(f"{name} differs from its golden picture; see {FAILURES}\n{sweep}")
