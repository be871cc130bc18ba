"""Pictures into files: whole or not at all."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from followspot.assets.image import BYTE_TO_LINEAR, linear_to_srgb
from followspot.errors import UsageError
from followspot.present.files import write_whole

DISPLAY_ENDINGS = (".png", ".jpg", ".jpeg")
LINEAR_ENDINGS = (".exr", ".npy")


def is_linear(path: Path) -> bool:
    """Whether a file of this ending holds numbers as they are, not a displayed picture.

    Raises:
        UsageError: the ending is none that can be written.
    """
    ending = path.suffix.lower()
    if ending not in DISPLAY_ENDINGS + LINEAR_ENDINGS:
        known = ", ".join(DISPLAY_ENDINGS + LINEAR_ENDINGS)
        raise UsageError(f"{path}: expected a file name that ends in {known}")
    return ending in LINEAR_ENDINGS


def averaged(picture: NDArray[Any], edge: int, *, encoded: bool) -> NDArray[Any]:
    """A picture of the means of squares of pixels.

    Args:
        picture: (h, w) or (h, w, 3); h and w are multiples of `edge`.
        edge: Of a square, in pixels.
        encoded: Whether it is sRGB bytes, which are decoded for it and encoded again.

    Returns:
        One pixel for each square, of the same type.
    """
    height, width = (length // edge for length in picture.shape[:2])
    values = BYTE_TO_LINEAR.take(picture) if encoded else picture
    rest = picture.shape[2:]
    mean = values.reshape(height, edge, width, edge, *rest).mean(axis=(1, 3), dtype=np.float64)
    if encoded:
        mean = linear_to_srgb(mean) * 255
    return np.asarray(np.rint(mean) if picture.dtype == np.uint8 else mean, picture.dtype)


def save(path: Path, picture: NDArray[Any], channel: str = "Y") -> None:
    """Write a picture under its final name only when all of it is there.

    Args:
        path: Its ending chooses the format; missing folders above it are made.
        picture: (h, w, 3) uint8 for png and jpg; float32, (h, w) or (h, w, 3), for exr and npy.
        channel: Name of the only channel of a (h, w) exr.

    Raises:
        UnwritableError: the file cannot be written there.
    """
    ending = path.suffix.lower()
    if ending == ".npy":
        write_whole(path, lambda to: _save_npy(to, picture))
    elif ending == ".exr":
        write_whole(path, lambda to: _save_exr(to, picture, channel))
    else:
        image = Image.fromarray(picture)  # each format takes of the options what it knows
        options = {"quality": 95, "subsampling": 0, "compress_level": 1}
        write_whole(path, lambda to: image.save(to, None, **options))


def _save_npy(path: Path, picture: NDArray[Any]) -> None:
    with path.open("wb") as file:
        # A file itself would be written by C, which does not tell why it could not.
        np.save(SimpleNamespace(write=file.write), picture)


def _save_exr(path: Path, picture: NDArray[Any], channel: str) -> None:
    import OpenEXR  # heavy, and only wanted here

    pixels = np.ascontiguousarray(picture, np.float32)
    channels = {"RGB" if pixels.ndim == 3 else channel: pixels}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    file = OpenEXR.File(header, channels)
    try:
        file.write(str(path))
    except RuntimeError as error:  # all that it says of a full disk
        raise OSError(str(error)) from None
