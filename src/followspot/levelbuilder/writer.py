"""The IBSP 46 file put together: lumps into bytes, and the tables that records point into.

The records' dtypes are the reader's, `followspot.assets.bsp.LUMPS`; other programs (bsp-tool,
the game engine) are asked in the tests whether both are right.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints
from followspot.assets.bsp import HEADER, LUMPS, MAGIC, VERSION, VISIBILITY_HEADER
from followspot.levelbuilder.material import Material


def bsp_bytes(lumps: Mapping[str, bytes]) -> bytes:
    """Return a whole file from its lumps by name; lumps start at multiples of four."""
    header = np.zeros((), HEADER)
    header["magic"], header["version"] = MAGIC, VERSION
    offset = header.nbytes
    body = []
    for i, name in enumerate(LUMPS):
        content = lumps.get(name, b"")
        header["directory"][i] = offset, len(content)
        body.append(content + b"\0" * (-len(content) % 4))
        offset += len(body[-1])
    return header.tobytes() + b"".join(body)


class PlaneTable:
    """The plane lump under construction: each plane once, next to its opposite."""

    def __init__(self) -> None:
        self._index: dict[tuple[float, ...], int] = {}
        self._rows: list[tuple[float, ...]] = []

    def index(self, normal: Floats, dist: float) -> int:
        """Return the index of a plane, adding it and its opposite where new."""
        row = tuple(round(float(value), 7) + 0.0 for value in (*normal, dist))
        key = _plane_key(row)
        if key not in self._index:
            opposite = tuple(0.0 - value for value in row)
            self._index[key] = len(self._rows)
            self._index.setdefault(_plane_key(opposite), len(self._rows) + 1)
            self._rows += [row, opposite]
        return self._index[key]

    def lump(self) -> bytes:
        """Return the lump."""
        rows = np.array(self._rows)
        planes = np.zeros(len(rows), LUMPS["planes"])
        planes["normal"], planes["distance"] = rows[:, :3], rows[:, 3]
        return planes.tobytes()


def _plane_key(row: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(round(value, 4) + 0.0 for value in row)


class ShaderTable:
    """The shader lump under construction: each material once, in order of first use."""

    def __init__(self) -> None:
        self._index: dict[Material, int] = {}

    def index(self, material: Material) -> int:
        """Return a material's index, adding it where new."""
        return self._index.setdefault(material, len(self._index))

    def lump(self) -> bytes:
        """Return the lump."""
        rows = [(m.name.encode(), int(m.surface), int(m.contents)) for m in self._index]
        return np.array(rows, LUMPS["shaders"]).tobytes()


def all_visible(clusters: int) -> bytes:
    """Return a visibility lump in which every cluster sees every other."""
    row = (clusters + 7) // 8
    head = np.array((clusters, row), VISIBILITY_HEADER).tobytes()
    return head + b"\xff" * (clusters * row)


def runs(counts: Sequence[int] | NDArray[np.int32]) -> Ints:
    """Return where each of several runs begins when they are laid end to end."""
    return np.concatenate([[0], np.cumsum(np.array(counts, dtype=np.int64))])[:-1]
