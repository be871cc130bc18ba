"""pk3 files, the same bytes from the same content."""

import io
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from followspot.levelbuilder.material import Material

_EPOCH = (1980, 1, 1, 0, 0, 0)
_STORED = (".jpg", ".png")


def pk3_bytes(files: Mapping[str, bytes]) -> bytes:
    """Return a pk3 archive of the files by their names, in the names' order, without a clock."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name in sorted(files):
            info = zipfile.ZipInfo(name, _EPOCH)
            info.create_system = 3
            info.external_attr = 0o644 << 16
            stored = name.endswith(_STORED)
            info.compress_type = zipfile.ZIP_STORED if stored else zipfile.ZIP_DEFLATED
            archive.writestr(info, files[name], compresslevel=9)
    return buffer.getvalue()


def write_pk3(path: Path, files: Mapping[str, bytes]) -> None:
    """Write a pk3 whole or not at all: readers never see half a file."""
    temporary = path.with_name(path.name + ".tmp")
    temporary.write_bytes(pk3_bytes(files))
    temporary.replace(path)


def image_file(image: NDArray[np.uint8], quality: int = 85) -> tuple[str, bytes]:
    """Encode an image and return its extension and bytes: JPEG, or PNG where it has alpha.

    Args:
        image: (height, width, 3 or 4) uint8, sRGB.
        quality: JPEG quality.
    """
    buffer = io.BytesIO()
    if image.shape[2] == 4:
        Image.fromarray(image, "RGBA").save(buffer, "PNG", optimize=True)
        return ".png", buffer.getvalue()
    Image.fromarray(image, "RGB").save(buffer, "JPEG", quality=quality, subsampling=0)
    return ".jpg", buffer.getvalue()


def material_files(name: str, materials: Sequence[Material], quality: int = 85) -> dict[str, bytes]:
    """Return the texture files of materials and their shader script ``scripts/<name>.shader``."""
    files = {}
    for material in materials:
        if material.image is not None:
            extension, content = image_file(material.image, quality)
            files[material.name + extension] = content
    entries = [material.script_entry() for material in materials if material.script]
    files[f"scripts/{name}.shader"] = "\n".join(entries).encode()
    return files
