"""Reads from a binary file with every bound checked before NumPy sees it.

A reader describes its format as a table of little-endian dtypes and asks here for arrays of
them. What the arrays point at (indices, runs of records) is checked here too, in bulk, so that
a number out of a file is never used as an index before it is known to be one.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from followspot.arrays import Ints, Mask
from followspot.errors import AssetError

MAX_RUN_TOTAL = 1 << 22
"""Most records that all runs of one kind may name together.

Runs may overlap (q3map2 lets equal faces share their indices), so that a small file could name
far more records than it holds; whoever writes the runs out one after the other needs this bound.
"""


@dataclass(frozen=True)
class BinaryFile:
    """A file's bytes with the name that its errors carry.

    Args:
        data: The whole file.
        source: The file's name for errors, as in `AssetError`.
    """

    data: bytes
    source: str

    def array(self, dtype: DTypeLike, offset: int, count: int, place: str) -> NDArray[Any]:
        """View ``count`` records from a byte offset on.

        Args:
            dtype: The record; its byte order must be explicit.
            offset: Of the first record, in bytes from the file's start.
            count: Number of records.
            place: What the records are, for the error.

        Returns:
            A read-only view of the file's bytes, shape (count, *subarray shape of dtype).

        Raises:
            AssetError: The records do not lie wholly inside the file.
        """
        dtype = np.dtype(dtype)
        # Plain integers: a NumPy int32 out of a header would wrap round.
        offset, count = int(offset), int(count)
        end = offset + count * dtype.itemsize
        if offset < 0 or count < 0 or end > len(self.data):
            raise AssetError(
                self.source,
                place=place,
                expected=f"{count} x {dtype.itemsize} bytes from offset {offset} on",
                found=f"a file of {len(self.data)} bytes",
            )
        return np.frombuffer(self.data, dtype=dtype, count=count, offset=offset)

    def record(self, dtype: DTypeLike, offset: int, place: str) -> Any:
        """View one record at a byte offset; as `array`, without its first axis."""
        return self.array(dtype, offset, 1, place)[0]

    def require_magic(self, magic: bytes, offset: int = 0, place: str = "byte 0") -> None:
        """Require the letters that tell a format.

        Raises:
            AssetError: Other ones stand there, or none.
        """
        found = self.data[offset : offset + len(magic)]
        if found == magic:
            return
        end = f"the end of {len(self.data)} bytes" if self.data else "an empty file"
        raise AssetError(
            self.source,
            place=place,
            expected=f"the letters {magic.decode('latin-1')}",
            found=repr(found.decode("latin-1")) if found else end,
        )

    def require(self, good: Mask, values: Any, place: str, expected: str) -> None:
        """Raise an error that names the first record that is not good.

        Args:
            good: (n,) or (n, ...) bool; a record is good where all its elements are.
            values: (n,) or (n, ...), what to show as found.
            place: With ``{}`` where the record's number belongs: ``faces[{}].shader``.
            expected: What a good record would hold.

        Raises:
            AssetError: Some element of ``good`` is False.
        """
        if good.all():
            return
        i = int(np.argmin(good.reshape(len(good), -1).all(axis=1)))
        found = np.asarray(values)[i].tolist()
        raise AssetError(self.source, place=place.format(i), expected=expected, found=f"{found}")

    def require_indices(
        self, values: NDArray[np.integer[Any]], count: int, place: str, lowest: int = 0
    ) -> None:
        """Require ``lowest <= values < count``, which `require` reports.

        A lowest index below zero is for formats whose negative numbers mean something else.
        """
        expected = f"an index from {lowest} to {count - 1}" if count > lowest else "no index"
        self.require((values >= lowest) & (values < count), values, place, expected)

    def require_runs(
        self,
        first: NDArray[np.integer[Any]],
        length: NDArray[np.integer[Any]],
        count: int,
        place: str,
    ) -> None:
        """Require each run of records, ``first`` and on, to lie inside ``count`` records.

        Args:
            first: (n,) int, number of each run's first record; even an empty run's must be
                from 0 to ``count``.
            length: (n,) int, records in each run.
            count: Records that there are.
            place: As in `require`.

        Raises:
            AssetError: A run sticks out, or all together name more than `MAX_RUN_TOTAL` records.
        """
        first, length = first.astype(np.int64), length.astype(np.int64)
        good = (first >= 0) & (length >= 0) & (first + length <= count)
        runs = np.stack([first, length], axis=-1)
        self.require(good, runs, place, f"a run [first, count] within {count} records")
        if (total := int(length.sum())) > MAX_RUN_TOTAL:
            raise AssetError(
                self.source,
                place=place.format(""),
                expected=f"runs of at most {MAX_RUN_TOTAL} records together",
                found=f"{total}",
            )


def text_until_nul(raw: bytes) -> str:
    """Decode a fixed-size text field: Latin-1, up to the first NUL, whatever follows it."""
    return raw.partition(b"\0")[0].decode("latin-1")


def run_members(first: NDArray[np.integer[Any]], length: NDArray[np.integer[Any]]) -> Ints:
    """Write runs of records out as the records' numbers, run after run.

    Args:
        first: (n,) int, number of each run's first record.
        length: (n,) int, records in each run, none negative; see `BinaryFile.require_runs`.

    Returns:
        (sum of length,) int64: ``first[0], first[0] + 1, ..., first[1], ...``.
    """
    length = length.astype(np.int64)
    ends = np.cumsum(length)
    shift = np.repeat(first - (ends - length), length)
    members: Ints = np.arange(len(shift), dtype=np.int64) + shift
    return members
