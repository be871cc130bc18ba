"""Images as RGBA bytes, and the sRGB transfer functions.

Textures are tga, jpg, png, pcx or bmp files; Pillow decodes them. What Pillow would get wrong for
a game's textures is put right here: alpha that a tga's footer disowns, 16-bit grey, png files with
rows missing.
"""

import io
import os
import struct
import zlib
from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from math import ceil
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image as PillowImage
from PIL.BmpImagePlugin import BmpImageFile
from PIL.ImageFile import ImageFile
from PIL.JpegImagePlugin import JpegImageFile
from PIL.PcxImagePlugin import PcxImageFile
from PIL.PngImagePlugin import PngImageFile
from PIL.TgaImagePlugin import TgaImageFile

from followspot.assets.archive import Archive, normalise
from followspot.errors import AssetError

MAX_SIDE = 8192
"""Largest width and height, in pixels."""

IMAGE_SUFFIXES = (".tga", ".jpg", ".png", ".jpeg", ".pcx", ".bmp")
"""Endings of image files, in the order in which they are tried."""

Float = TypeVar("Float", np.float32, np.float64)


class _Jpeg(JpegImageFile):
    def _read_dpi_from_exif(self) -> None:
        """Read no EXIF: a texture has no use for it, and Pillow warns of damage in it."""


# Pillow's format classes are named one by one, for its `open` would try all the formats it knows
# and warn about sizes through the process-wide warning filters, which threads must not touch.
_FORMATS: tuple[tuple[tuple[bytes, ...], type[ImageFile]], ...] = (
    ((b"\x89PNG\r\n\x1a\n",), PngImageFile),
    ((b"\xff\xd8\xff",), _Jpeg),
    ((b"BM",), BmpImageFile),
    ((b"\n\0\1", b"\n\2\1", b"\n\3\1", b"\n\5\1"), PcxImageFile),
    ((b"",), TgaImageFile),  # has no mark of its own
)
_TGA_RUNS = 8  # a bit of the image type: run-length encoded
_TGA_MODES = {8: "L", 16: "LA", 24: "RGB", 32: "RGBA"}  # as many bytes per pixel, by depth
_TGA_FOOTER_BYTES = 26
_TGA_FOOTER_END = b"TRUEVISION-XFILE.\0"
_PCX_PALETTE_MARK = b"\x0c"  # stands before the 768 bytes of a 256-colour palette

# Samples per pixel by a png file's colour type, and first column, first row, column step and row
# step of each pass of an interlaced one (PNG specification, sections 11.2.1 and 8.2).
_PNG_SAMPLES = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
_PNG_PASSES = (
    *((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4)),
    *((0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)),
)
_PNG_STEP_BYTES = 1 << 20  # inflated at a time, to count and drop


@dataclass(frozen=True, eq=False)
class Image:
    """A decoded image.

    Args:
        pixels: (height, width, 4) uint8, sRGB and straight linear alpha, row 0 at the top;
            read-only. What a file says of its gamma is passed over, as in the games.
        has_alpha: Whether any alpha is below 255.
        source: The file that it comes from, for messages.
    """

    pixels: NDArray[np.uint8]
    has_alpha: bool
    source: str

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.pixels.shape[1], self.pixels.shape[0]


def decode(data: bytes, source: str) -> Image:
    """Decode a whole image file of any supported format, told by its first bytes.

    A jpg file with an end mark before its last row is taken, as by any viewer; the rows that it
    lacks are grey.

    Raises:
        AssetError: The bytes are no such image, are cut short, or the image's sides are not
            between 1 and `MAX_SIDE`, which is told from the header, before pixels are allocated.
    """
    reader = next(cls for marks, cls in _FORMATS if data.startswith(marks))
    if reader is TgaImageFile and data.endswith(_TGA_FOOTER_END):
        # The footer may say that the fourth channel is no alpha, and Pillow then drops it. The
        # games look at no footer; more than a hundred of OpenArena's files would lose their alpha.
        data = data[:-_TGA_FOOTER_BYTES]
    try:
        opened = reader(io.BytesIO(data))
        _check_size(opened.size, source)
        if reader is PngImageFile:
            _check_png_rows(data, opened.size, source)
        if reader is PcxImageFile and opened.mode == "L" and data[-769:-768] != _PCX_PALETTE_MARK:
            raise AssetError(source, expected="a palette at the pcx file's end", found="none")
        if reader is TgaImageFile and data[2] & _TGA_RUNS:
            opened = reader(io.BytesIO(_without_runs(data, opened.tile[0].offset, opened.size)))
        pixels = np.asarray(_eight_bits(opened).convert("RGBA"))
    except AssetError:
        raise
    except Exception as error:  # Pillow answers damage with whatever its decoders stumble over
        kind = reader.format if reader is not TgaImageFile else "tga, jpg, png, bmp or pcx"
        found = f"{len(data)} bytes that are not ({str(error) or type(error).__name__})"
        raise AssetError(source, expected=f"a whole {kind} image", found=found) from error
    return Image(pixels, bool(pixels[..., 3].min() < 255), source)


def _check_size(size: tuple[int, int], source: str) -> None:
    if not (0 < size[0] <= MAX_SIDE and 0 < size[1] <= MAX_SIDE):
        expected = f"a width and height from 1 to {MAX_SIDE}"
        raise AssetError(source, place="header", expected=expected, found=f"{size[0]} x {size[1]}")


def _check_png_rows(data: bytes, size: tuple[int, int], source: str) -> None:
    """Refuse a png file that holds fewer rows than it states; Pillow leaves those black."""
    width, height = size
    bits = data[24] * _PNG_SAMPLES[data[25]]  # depth, colour type
    expected = 0
    for left, top, right, down in _PNG_PASSES if data[28] else ((0, 0, 1, 1),):
        columns, rows = ceil((width - left) / right), ceil((height - top) / down)
        if columns > 0 and rows > 0:
            expected += rows * (1 + ceil(columns * bits / 8))
    inflater = zlib.decompressobj()
    found = 0
    at = 8
    while at + 8 <= len(data) and found < expected:
        length, tag = struct.unpack_from(">I4s", data, at)
        if tag == b"IDAT":
            rest, inflated = data[at + 8 : at + 8 + length], _PNG_STEP_BYTES
            while inflated == _PNG_STEP_BYTES and found < expected:  # a full step may leave more
                inflated = len(inflater.decompress(rest, _PNG_STEP_BYTES))
                rest = inflater.unconsumed_tail
                found += inflated
        at += length + 12
    if found < expected:
        wanted = f"{expected} bytes for {width} x {height} pixels"
        raise AssetError(source, place="IDAT", expected=wanted, found=str(found))


def _without_runs(data: bytes, start: int, size: tuple[int, int]) -> bytes:
    """Make a plain tga file of a run-length encoded one, whose packets begin at byte `start`.

    The format's first version lets a run go on into the next row, and the games take such files;
    Pillow, which checks row by row, does not. So its decoder is given one long row.
    """
    depth, packets = data[16], data[start:]
    mode = _TGA_MODES[depth]
    row = PillowImage.frombytes(mode, (size[0] * size[1], 1), packets, "tga_rle", mode, 1, depth)
    return data[:2] + bytes([data[2] & ~_TGA_RUNS]) + data[3:start] + row.tobytes()


def _eight_bits(image: PillowImage.Image) -> PillowImage.Image:
    if image.mode == "I;16":  # Pillow's own conversion clips at 255 in place of scaling
        return PillowImage.fromarray((np.asarray(image) >> 8).astype(np.uint8))
    return image


def find_image(archive: Archive, name: str) -> tuple[str | None, list[str]]:
    """Find the file that a texture's name means, much as the engine (``R_LoadImage``) does.

    A name with an image's ending is tried as it stands; then its stem with each of
    `IMAGE_SUFFIXES`, which engines try in various orders. The first file that there is counts,
    where they go on if they cannot read it.

    Returns:
        The file's normalised name, or None, and the names that were tried, in order.
    """
    name = normalise(name)
    stem = name.rpartition(".")[0] if name.endswith(IMAGE_SUFFIXES) else name
    candidates = [stem + suffix for suffix in IMAGE_SUFFIXES]
    candidates.sort(key=lambda candidate: candidate != name)  # the name itself in front
    for count, candidate in enumerate(candidates, 1):
        if archive.exists(candidate):
            return candidate, candidates[:count]
    return None, candidates


def decode_all(
    archive: Archive, names: Sequence[str], workers: int | None = None
) -> Generator[tuple[int, Image | AssetError], None, None]:
    """Read and decode images in threads, and yield them in the order of `names`.

    At most twice as many images as there are workers are decoded ahead of the consumer.

    Args:
        archive: Where the files are read from.
        names: Names of files in it.
        workers: Number of threads; None for one per processor.

    Yields:
        An index into `names`, and its image or why there is none.
    """

    def decode_one(name: str) -> Image | AssetError:
        try:
            return decode(archive.read(name), archive.source(name))
        except AssetError as error:
            return error

    workers = workers or os.cpu_count() or 1
    pool = ThreadPoolExecutor(workers)
    ahead: deque[Future[Image | AssetError]] = deque()
    try:
        for index in range(len(names)):
            while len(ahead) < 2 * workers and index + len(ahead) < len(names):
                ahead.append(pool.submit(decode_one, names[index + len(ahead)]))
            yield index, ahead.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)


LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Shares of linear sRGB's channels in luminance (ITU-R BT.709)."""


def srgb_to_linear(values: NDArray[Float]) -> NDArray[Float]:
    """Decode sRGB to linear light, by IEC 61966-2-1.

    Args:
        values: Encoded values of any shape, 1 being white; beyond 0 and 1 the curve goes on.
    """
    curve = ((np.maximum(values, 0) + 0.055) / 1.055) ** 2.4
    return np.where(values <= 0.04045, values / 12.92, curve).astype(values.dtype)


def linear_to_srgb(values: NDArray[Float]) -> NDArray[Float]:
    """Encode linear light as sRGB, by IEC 61966-2-1: the inverse of `srgb_to_linear`."""
    curve = 1.055 * np.maximum(values, 0) ** (1 / 2.4) - 0.055
    return np.where(values <= 0.0031308, values * 12.92, curve).astype(values.dtype)


_BYTE_TO_UNIT = np.arange(256, dtype=np.float64) / 255
BYTE_TO_LINEAR = srgb_to_linear(_BYTE_TO_UNIT).astype(np.float32)
"""(256,) linear light of sRGB bytes."""


def to_linear(pixels: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Decode (..., 4) RGBA bytes, sRGB with linear alpha, to linear float32 from 0 to 1."""
    linear = BYTE_TO_LINEAR.take(pixels)
    linear[..., 3] = pixels[..., 3] / np.float32(255)
    return linear
