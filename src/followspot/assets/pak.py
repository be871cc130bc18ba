"""pk3 files, which are zip archives: their tables of contents and their entries' data.

A zip file ends with a table of contents and a record that says where that lies (PKWARE's
APPNOTE.TXT, sections 4.3.7, 4.3.12 and 4.3.16). Python's zipfile neither bounds what an entry
inflates to nor lets several threads inflate at once, and takes long over ten thousand entries.
"""

import re
import struct
import threading
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from followspot.errors import AssetError

MAX_FILE_BYTES = 256 << 20
"""Largest file that is read; the largest levels and textures stay well below it."""

_END = struct.Struct("<4s4x2H2I2x")  # signature, entries here, in all, table's size, its start
_END_SIGNATURE = b"PK\5\6"
_MAX_COMMENT = 0xFFFF  # bytes that may stand behind the end's record
_ZIP64 = 0xFFFFFFFF  # stands where a number is too large for its field, and is elsewhere

# Signature, flags, method, checksum, stored size, size, lengths of name, extra and comment, start.
_ENTRY = struct.Struct("<4s4x2H4x3I3H8xI")
_ENTRY_SIGNATURE = b"PK\1\2"
_ENCRYPTED, _UTF8 = 1, 0x800  # flags
_STORED, _DEFLATED = 0, 8  # methods

_LOCAL_HEADER = struct.Struct("<4s22xHH")  # signature, length of the name, length of the extra
_LOCAL_SIGNATURE = b"PK\3\4"

_UNSAFE_NAME = re.compile(
    r"\A (?: [/\\] | [A-Za-z]: | \Z ) | (?: \A | [/\\] ) \.\. (?: [/\\] | \Z ) | \0", re.VERBOSE
)


class Pak:
    """One open pk3 file; the lock keeps threads from moving each other's file position.

    Raises:
        AssetError: The file cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock = threading.Lock()
        try:
            self._file = path.open("rb")
            self._size = path.stat().st_size
        except OSError as error:
            raise unreadable(path, error) from error

    def close(self) -> None:
        """Close the file; its entries can no longer be read."""
        self._file.close()

    def entries(self) -> "Iterator[PakEntry]":
        """Read the table of contents; folders, which are entries too, are left out.

        Raises:
            AssetError: There is no whole table, or a name in it leads out of the pak.
        """
        table, shift = self._table()
        at = 0
        while at < len(table):
            if not table.startswith(_ENTRY_SIGNATURE, at) or at + _ENTRY.size > len(table):
                raise self._no_zip(f"no entry at byte {at} of its table")
            _, flags, method, checksum, stored, size, *lengths, start = _ENTRY.unpack_from(
                table, at
            )
            at += _ENTRY.size
            raw = table[at : at + lengths[0]]
            try:
                name = raw.decode("utf-8" if flags & _UTF8 else "cp437")
            except UnicodeDecodeError:
                raise self._no_zip(f"the name {raw!r}, which is not UTF-8") from None
            _refuse_unsafe_name(self.path, name)
            at += sum(lengths)
            if not name.endswith(("/", "\\")):
                yield PakEntry(self, name, flags, method, checksum, stored, size, start + shift)
        if at != len(table):
            raise self._no_zip("its table's last entry cut short")

    def _table(self) -> tuple[bytes, int]:
        """The table's bytes, and how many bytes stand in front of the zip file proper."""
        behind = min(self._size, _MAX_COMMENT + _END.size)
        tail = self.read_at(self._size - behind, behind)
        at = tail.rfind(_END_SIGNATURE, 0, len(tail) - _END.size + len(_END_SIGNATURE))
        if at < 0:
            raise self._no_zip("no record at its end that says so")
        _, _, _, size, start = _END.unpack_from(tail, at)
        if _ZIP64 in (size, start):
            raise self._no_zip("the zip64 format")
        shift = self._size - behind + at - size - start
        table = self.read_at(start + shift, size)
        if shift < 0 or len(table) != size:
            raise self._no_zip(f"a table of {size} bytes that does not fit in")
        return table, shift

    def _no_zip(self, found: str) -> AssetError:
        return AssetError(str(self.path), expected="a pk3 (zip) file", found=found)

    def read_at(self, start: int, count: int) -> bytes:
        """Read `count` bytes, or none where the file has fewer: a lying count allocates nothing."""
        if not 0 <= start <= self._size - count:
            return b""
        try:
            with self._lock:
                self._file.seek(start)
                return self._file.read(count)
        except OSError as error:
            raise unreadable(self.path, error) from error


class PakEntry(NamedTuple):
    """One file in a pk3 file, as the table of contents has it."""

    pak: Pak
    name: str
    flags: int
    method: int
    checksum: int
    stored_size: int
    size: int
    start: int

    @property
    def source(self) -> str:
        """Where the file lies, for messages: ``pak0.pk3:maps/q3dm1.bsp``."""
        return f"{self.pak.path.name}:{self.name}"

    def read(self) -> bytes:
        """Read the whole file.

        Raises:
            AssetError: It is larger than `MAX_FILE_BYTES` or than the table states, damaged,
                encrypted, or compressed by a method other than deflate.
        """
        refuse_absurd_size(self.source, self.size)
        if self.flags & _ENCRYPTED:
            raise self._wrong("plain data", "encrypted data")
        if self.method not in (_STORED, _DEFLATED):
            raise self._wrong("stored or deflated data", f"method {self.method}")
        data = self._raw()
        if self.method == _DEFLATED:
            inflater = zlib.decompressobj(-zlib.MAX_WBITS)
            try:
                # One byte more than the pak states tells data that lies from data that fits.
                data = inflater.decompress(data, self.size + 1)
            except zlib.error as error:
                raise self._wrong("deflated data", f"damage ({error})") from error
        if len(data) != self.size:
            found = "more" if len(data) > self.size else f"{len(data)}"
            raise self._wrong(f"{self.size} bytes", found)
        if zlib.crc32(data) != self.checksum:
            raise self._wrong(f"checksum {self.checksum:08x}", f"{zlib.crc32(data):08x}")
        return data

    def _raw(self) -> bytes:
        header = self.pak.read_at(self.start, _LOCAL_HEADER.size)
        if not header.startswith(_LOCAL_SIGNATURE):
            raise self._wrong("an entry's header", repr(header[:4]), place=f"byte {self.start}")
        _, name_length, extra_length = _LOCAL_HEADER.unpack(header)
        start = self.start + _LOCAL_HEADER.size + name_length + extra_length
        data = self.pak.read_at(start, self.stored_size)
        if len(data) != self.stored_size:
            expected = f"{self.stored_size} bytes of data"
            raise self._wrong(expected, "the pak's end", place=f"byte {start}")
        return data

    def _wrong(self, expected: str, found: str, place: str = "") -> AssetError:
        return AssetError(self.source, place=place, expected=expected, found=found)


def _refuse_unsafe_name(pak: Path, name: str) -> None:
    if _UNSAFE_NAME.search(name):
        expected = "relative names without '..', drive letter or NUL"
        raise AssetError(str(pak), place="an entry's name", expected=expected, found=repr(name))


def refuse_absurd_size(source: str, size: int) -> None:
    """Raise the `AssetError` that a file larger than `MAX_FILE_BYTES` earns."""
    if size > MAX_FILE_BYTES:
        raise AssetError(source, expected=f"at most {MAX_FILE_BYTES} bytes", found=str(size))


def unreadable(path: Path, error: OSError) -> AssetError:
    """Make the error for a file that the system does not let us read."""
    return AssetError(str(path), expected="a readable file", found=error.strerror or str(error))
