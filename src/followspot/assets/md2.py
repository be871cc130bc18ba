"""Quake II models (MD2: IDP2 version 8): byte vertices, frame by frame, under one skin.

The file shares vertices between triangles but keeps texture coordinates apart, so that a vertex
on a seam has several. `read_md2` splits such vertices: what it returns can be drawn as it is.

Sources: ``qfiles.h`` and ``anorms.h`` of id Software's Quake II; GL commands as in David Henry's
"MD2 file format (Quake 2's models)". That triangles' front faces are clockwise follows from the
models: there they, not the other sides, face the way of the vertices' own normals.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.assets.animation import MAX_POSED_VERTICES, Animation
from followspot.assets.archive import normalise
from followspot.assets.binary import BinaryFile, run_members, text_until_nul
from followspot.errors import AssetError

MAGIC = b"IDP2"
VERSION = 8

_COUNTS = {  # what may be counted, and the format's own bound: numbers are 16 bits in triangles
    "skins": (0, 1 << 16),
    "vertices": (1, 1 << 16),
    "texcoords": (1, 1 << 16),
    "triangles": (1, 1 << 16),
    "gl_commands": (0, 1 << 20),
    "frames": (1, 1 << 16),
}
HEADER = np.dtype(
    [
        ("magic", "S4"),
        ("version", "<i4"),
        ("skin_size", "<i4", 2),
        ("frame_bytes", "<i4"),
        *((f"{name}_count", "<i4") for name in _COUNTS),
        *((f"{name}_offset", "<i4") for name in ("skins", "texcoords", "triangles", "frames")),
        ("gl_commands_offset", "<i4"),
        ("end_offset", "<i4"),
    ]
)
SKIN = np.dtype("S64")
TEXCOORD = np.dtype(("<i2", 2))
TRIANGLE = np.dtype([("vertices", "<u2", 3), ("texcoords", "<u2", 3)])
VERTEX = np.dtype([("position", "u1", 3), ("normal", "u1")])
GL_COMMAND = np.dtype("<i4")


def frame_dtype(vertex_count: int) -> np.dtype[Any]:
    """The record of a frame of so many vertices."""
    head = [("scale", "<f4", 3), ("translate", "<f4", 3), ("name", "S16")]
    return np.dtype([*head, ("vertices", VERTEX, (vertex_count,))])


COORDINATE_LIMIT = 65536.0
"""Largest scale times 255, and largest shift, in Quake units: the engine's world ends there."""

FRAMES_PER_SECOND = 10.0
"""The file tells no rate; the game moves on one frame at each of its server's ten a second
(FRAMETIME in ``g_local.h``)."""

_HELD = ("death", "crdeath", "crdeth")
_DIGITS = "0123456789"


def _icosphere_normals() -> NDArray[np.float32]:
    """The (162, 3) unit normals that a vertex's normal index counts, in the game's order.

    They are the corners of an icosahedron whose edges are halved twice, pushed out to the sphere
    at the end. The order is that of first appearance in a recursion into four triangles. The
    icosahedron is numbered as in the OpenGL Programming Guide; that this makes the table in
    ``anorms.h``, the tests show.
    """
    x, z = np.sqrt(0.5 - np.sqrt(0.05)), np.sqrt(0.5 + np.sqrt(0.05))
    corners = np.array(
        [
            *((-x, 0, z), (x, 0, z), (-x, 0, -z), (x, 0, -z)),
            *((0, z, x), (0, z, -x), (0, -z, x), (0, -z, -x)),
            *((z, x, 0), (-z, x, 0), (z, -x, 0), (-z, -x, 0)),
        ]
    )
    faces = (
        *((0, 4, 1), (0, 9, 4), (9, 5, 4), (4, 5, 8), (4, 8, 1)),
        *((8, 10, 1), (8, 3, 10), (5, 3, 8), (5, 2, 3), (2, 7, 3)),
        *((7, 10, 3), (7, 6, 10), (7, 11, 6), (11, 0, 6), (0, 1, 6)),
        *((6, 1, 10), (9, 0, 11), (9, 11, 2), (9, 2, 5), (7, 2, 11)),
    )
    triangles = corners[np.array(faces)]
    for _ in range(2):
        a, b, c = triangles.transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        quarters = np.array([(a, ab, ca), (b, ab, bc), (c, ca, bc), (ab, bc, ca)])
        triangles = quarters.transpose(2, 0, 1, 3).reshape(-1, 3, 3)
    points = triangles.reshape(-1, 3)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    _, first = np.unique(points.round(6) + 0.0, axis=0, return_index=True)
    normals: NDArray[np.float32] = points[np.sort(first)].astype(np.float32)
    return normals


NORMALS = _icosphere_normals()
"""(162, 3) float32 unit vectors."""
NORMALS.setflags(write=False)


@dataclass(frozen=True, eq=False)
class Md2Model:
    """One model as its file has it: Quake units, X forward, Z up, clockwise front faces.

    A player's feet are 24 units below the origin. Every array is read-only.
    """

    source: str
    """The file's name for errors."""
    skins: tuple[str, ...]
    """Names of the images that it may wear, normalised; many files name none."""
    frame_names: tuple[str, ...]
    """As written, up to the NUL."""
    animations: dict[str, Animation]
    """By name in lower case, in the order of their frames; see `animations_from_names`."""
    positions: NDArray[np.float32]
    """(frames, vertices, 3), Quake units."""
    normals: NDArray[np.float32]
    """(frames, vertices, 3), unit length."""
    texcoords: NDArray[np.float32]
    """(vertices, 2), 0 to 1 from the skin's top left corner; outside of that the skin repeats."""
    indices: NDArray[np.uint32]
    """(3 * triangles,)."""


def read_md2(data: bytes, source: str) -> Md2Model:
    """Read and check a Quake II model.

    Args:
        data: The whole file.
        source: The file's name for errors, as in `AssetError`.

    Raises:
        AssetError: The file isn't IDP2 version 8, is truncated, or something in it refers to
            what isn't there.
    """
    file = BinaryFile(data, source)
    header = _read_header(file)

    def lump(name: str, dtype: np.dtype[Any]) -> NDArray[Any]:
        return file.array(dtype, header[f"{name}_offset"], header[f"{name}_count"], f"{name} lump")

    skins = lump("skins", SKIN)
    texcoords, triangles = lump("texcoords", TEXCOORD), lump("triangles", TRIANGLE)
    vertex_count = int(header["vertices_count"])
    frames = lump("frames", frame_dtype(vertex_count))
    file.require_indices(triangles["vertices"], vertex_count, "triangles[{}].vertices")
    file.require_indices(triangles["texcoords"], len(texcoords), "triangles[{}].texcoords")
    _check_frames(file, frames)
    _check_gl_commands(file, lump("gl_commands", GL_COMMAND), vertex_count)

    # A drawn vertex is a pair that some corner uses, written as one number.
    corners = triangles["vertices"].astype(np.uint32) << 16 | triangles["texcoords"]
    pairs, indices = np.unique(corners, return_inverse=True)
    if len(pairs) * len(frames) > MAX_POSED_VERTICES:
        expected = f"at most {MAX_POSED_VERTICES} vertices in all frames together"
        raise AssetError(source, expected=expected, found=f"{len(pairs) * len(frames)}")
    vertex, texcoord = pairs >> 16, pairs & 0xFFFF

    posed = frames["vertices"][:, vertex]
    scale, translate = frames["scale"][:, np.newaxis], frames["translate"][:, np.newaxis]
    names = tuple(text_until_nul(name) for name in frames["name"].tolist())
    # The game's own GL commands put a texel's number at its middle.
    st = (texcoords[texcoord] + np.float32(0.5)) / header["skin_size"].astype(np.float32)
    model = Md2Model(
        source=source,
        skins=tuple(normalise(text_until_nul(name)) for name in skins.tolist()),
        frame_names=names,
        animations=animations_from_names(names),
        positions=posed["position"] * scale + translate,
        normals=NORMALS[posed["normal"]],
        texcoords=st,
        indices=indices.reshape(-1).astype(np.uint32),
    )
    for array in (model.positions, model.normals, model.texcoords, model.indices):
        array.setflags(write=False)
    return model


def animations_from_names(names: tuple[str, ...]) -> dict[str, Animation]:
    """Find the animations of a model in the names of its frames.

    Frames in a row whose names differ by a rising number make one animation, called by what is
    in front of the number: ``run1``, ``run2``, ... are ``run``. Where that number jumps to
    another hundred, the hundred numbers a variant: ``pain101`` to ``pain104`` are ``pain1``,
    ``pain201`` and on ``pain2``. An animation that is called as an earlier one gets ``_2``.

    Deaths hold their last frame; all others repeat.

    Returns:
        By name in lower case, in the order of their frames; together they hold every frame once.
    """
    stems = [name.lower().rstrip(_DIGITS) for name in names]
    digits = [name[len(stem) :] for name, stem in zip(names, stems, strict=True)]
    numbers = [int(text) if text else None for text in digits]

    def follows(i: int) -> bool:
        before, number = numbers[i - 1], numbers[i]
        if stems[i] != stems[i - 1] or (before is None) != (number is None):
            return False
        if before is None or number is None:
            return True
        return number == before + 1 or (number > before and number // 100 == before // 100)

    starts = [i for i in range(len(names)) if i == 0 or not follows(i)]
    animations: dict[str, Animation] = {}
    for start, end in pairwise([*starts, len(names)]):
        number = numbers[start]
        stem = stems[start].strip(" _.-") or "frames"
        stem += str(number // 100) if number and number >= 100 else ""
        name, copy = stem, 1
        while name in animations:
            copy += 1
            name = f"{stem}_{copy}"
        count = end - start
        looping = 0 if name.startswith(_HELD) else count
        animations[name] = Animation(start, count, looping, FRAMES_PER_SECOND)
    return animations


def _read_header(file: BinaryFile) -> Any:
    def require(good: Any, place: str, expected: str, found: Any) -> None:
        if not good:
            raise AssetError(file.source, place=place, expected=expected, found=f"{found}")

    file.require_magic(MAGIC)
    header = file.record(HEADER, 0, "header")
    require(header["version"] == VERSION, "byte 4", f"version {VERSION}", header["version"])
    for name, (lowest, highest) in _COUNTS.items():
        count = int(header[f"{name}_count"])
        place = f"header, count of {name}"
        require(lowest <= count <= highest, place, f"{lowest} to {highest}", count)
    size = header["skin_size"]
    require((size > 0).all(), "header, size of the skin", "pixels", size.tolist())
    frame_bytes = frame_dtype(int(header["vertices_count"])).itemsize
    found = header["frame_bytes"]
    require(found == frame_bytes, "header, bytes of a frame", f"{frame_bytes}", found)
    end = header["end_offset"]
    expected = f"at least {HEADER.itemsize}, within the file's {len(file.data)} bytes"
    require(HEADER.itemsize <= end <= len(file.data), "header, offset of the end", expected, end)
    return header


def _check_frames(file: BinaryFile, frames: NDArray[Any]) -> None:
    for field, limit in (("scale", COORDINATE_LIMIT / 255), ("translate", COORDINATE_LIMIT)):
        values = frames[field]
        file.require(
            np.abs(values) <= limit,  # False for NaN too
            values,
            f"frames[{{}}].{field}",
            f"numbers of magnitude {limit:g} at most",
        )
    normal = frames["vertices"]["normal"]
    expected = f"normals of indices below {len(NORMALS)}"
    file.require(normal < len(NORMALS), normal.max(axis=1), "frames[{}].vertices", expected)


def _check_gl_commands(file: BinaryFile, words: NDArray[np.int32], vertex_count: int) -> None:
    """Check the triangle strips and fans that the game draws in place of the triangles.

    Each is a count, negative for a fan, and as many of s, t and a vertex's number; a count of 0
    ends them. They say nothing that the other lumps do not, so nothing is made of them.
    """
    counts: list[int] = words.tolist()
    starts, lengths, at = [0], [0], 0
    while at < len(counts) and counts[at] != 0:
        starts.append(at + 1)
        lengths.append(3 * abs(counts[at]))
        at += 1 + lengths[-1]
    if counts and at >= len(counts):
        found = f"a command that ends at word {at} of {len(counts)}"
        expected = "commands that end with a count of 0"
        raise AssetError(file.source, place="gl_commands lump", expected=expected, found=found)
    used = words[run_members(np.array(starts), np.array(lengths))[2::3]]
    file.require_indices(used, vertex_count, "gl_commands lump, vertex {}")
