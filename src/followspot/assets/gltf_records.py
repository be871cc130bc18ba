"""What a glTF 2.0 document says by number: its records, and the bytes that they lead to.

Accessors are numbers in views, views are runs of a buffer, and buffers are files beside the
document, text in it, or the GLB's own chunk. Section numbers are those of "glTF 2.0 Specification",
version 2.0.1, The Khronos Group.
"""

import base64
import binascii
from collections.abc import Callable
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from followspot.assets.gltf_document import Accessor, Buffer, Document, Image, View
from followspot.errors import AssetError

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}

FindFile = Callable[[str], bytes | None]
"""A name beside the file to the bytes that are there, if any."""


class Records:
    """One document, with its buffers, each read when it is first asked for.

    Args:
        document: Its records.
        body: The GLB's buffer, if it has one.
        source: The file's name for errors.
        find_file: Reads the buffers that it names.

    Raises:
        AssetError: by every method, for a number that leads nowhere or a record that lies.
    """

    def __init__(
        self, document: Document, body: bytes | None, source: str, find_file: FindFile
    ) -> None:
        self.document, self.source = document, source
        self._body, self._find_file = body, find_file
        self._buffers: dict[int, bytes] = {}

    def wrong(self, place: str, expected: str, found: str) -> AssetError:
        """What is to be raised about a place in the document."""
        return AssetError(self.source, place=place, expected=expected, found=found)

    def at(self, table: str, number: int, place: str) -> Any:
        """A record of one of the document's tables by the number that a place has for it."""
        records = getattr(self.document, table)
        if number >= len(records):
            raise self.wrong(place, f"one of {len(records)} {table}", f"{number}")
        return records[number]

    def values(self, number: int, widths: tuple[int, ...], place: str) -> NDArray[Any]:
        """(count, width) of an accessor, in its own type; the width is one of `widths`."""
        accessor: Accessor = self.at("accessors", number, place)
        place = f"accessors[{number}]"
        width = _WIDTHS.get(accessor.type)
        if width not in widths:
            raise self.wrong(place, f"{' or '.join(map(str, widths))} a value", accessor.type)
        if accessor.component_type not in _COMPONENTS:
            found = str(accessor.component_type)
            raise self.wrong(place, "a component type from 5120 to 5126", found)
        if accessor.buffer_view is None or accessor.sparse is not None:
            raise self.wrong(place, "values in a buffer view", "sparse or none")
        dtype = np.dtype(_COMPONENTS[accessor.component_type])
        data = self._view(accessor.buffer_view, place)
        packed = dtype.itemsize * width
        stride = self.document.buffer_views[accessor.buffer_view].byte_stride or packed
        end = accessor.byte_offset + (accessor.count - 1) * stride + packed
        if end > len(data):
            found = f"a buffer view of {len(data)} bytes"
            raise self.wrong(place, f"{accessor.count} values, {end} bytes", found)
        return np.ndarray(
            (accessor.count, width), dtype, data, accessor.byte_offset, (stride, dtype.itemsize)
        )

    def _view(self, number: int, place: str) -> memoryview:
        view: View = self.at("buffer_views", number, place)
        place = f"bufferViews[{number}]"
        data = self._buffer(view.buffer, place)
        end = view.byte_offset + view.byte_length
        if end > len(data):
            found = f"a buffer of {len(data)} bytes"
            raise self.wrong(place, f"bytes up to {end}", found)
        return memoryview(data)[view.byte_offset : end]

    def _buffer(self, number: int, place: str) -> bytes:
        if number not in self._buffers:
            buffer: Buffer = self.at("buffers", number, place)
            place = f"buffers[{number}]"
            data = self._body if number == 0 and buffer.uri is None else None
            if buffer.uri is not None:
                data = self._uri(buffer.uri, place)
            if data is None or len(data) < buffer.byte_length:
                found = "none" if data is None else f"{len(data)}"
                raise self.wrong(place, f"{buffer.byte_length} bytes", found)
            self._buffers[number] = data
        return self._buffers[number]

    def _uri(self, uri: str, place: str) -> bytes | None:
        """A file beside this one, or what stands in the name itself."""
        if not uri.startswith("data:"):
            return self._find_file(unquote(uri))
        encoding, _, text = uri.partition(",")
        if not encoding.endswith(";base64"):
            raise self.wrong(place, "base64 in a data URI", encoding[:40])
        try:
            return base64.b64decode(text, validate=True)
        except (binascii.Error, ValueError) as error:
            raise self.wrong(place, "base64", str(error)) from None

    def image(self, number: int, place: str) -> str | bytes:
        """Name of an image's file, or its bytes where they are in the document."""
        image: Image = self.at("images", number, place)
        place = f"images[{number}]"
        if image.buffer_view is not None:
            return bytes(self._view(image.buffer_view, place))
        if image.uri is None:
            raise self.wrong(place, "uri or bufferView", "neither")
        if image.uri.startswith("data:"):
            return self._uri(image.uri, place) or b""
        return unquote(image.uri)
