"""Quake III models (MD3: IDP3 version 15): surfaces, key frames, and tags that join models.

Sources: ``qfiles.h``, ``R_LoadMD3`` and ``R_LerpTag`` of ioquake3; PhaethonH, "Description of MD3
Format". Where they leave open what is legal, the models of OpenArena decided.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.assets.animation import MAX_POSED_VERTICES, Pose
from followspot.assets.binary import BinaryFile, text_until_nul
from followspot.errors import AssetError
from followspot.spaces import Mat4

MAGIC = b"IDP3"
VERSION = 15

HEADER = np.dtype(
    [
        ("magic", "S4"),
        ("version", "<i4"),
        ("name", "S64"),
        ("flags", "<i4"),
        *((f"{name}_count", "<i4") for name in ("frames", "tags", "surfaces", "skins")),
        *((f"{name}_offset", "<i4") for name in ("frames", "tags", "surfaces", "end")),
    ]
)
FRAME = np.dtype(
    [
        ("mins", "<f4", 3),
        ("maxs", "<f4", 3),
        ("origin", "<f4", 3),
        ("radius", "<f4"),
        ("name", "S16"),
    ]
)
TAG = np.dtype([("name", "S64"), ("origin", "<f4", 3), ("axes", "<f4", (3, 3))])
SURFACE = np.dtype(
    [
        ("magic", "S4"),
        ("name", "S64"),
        ("flags", "<i4"),
        *((f"{name}_count", "<i4") for name in ("frames", "shaders", "vertices", "triangles")),
        *((f"{name}_offset", "<i4") for name in ("triangles", "shaders", "texcoords", "vertices")),
        ("end_offset", "<i4"),
    ]
)
SHADER = np.dtype([("name", "S64"), ("index", "<i4")])
TRIANGLE = np.dtype(("<i4", 3))
TEXCOORD = np.dtype(("<f4", 2))
VERTEX = np.dtype([("position", "<i2", 3), ("zenith", "u1"), ("azimuth", "u1")])

UNITS_PER_STEP = 1 / 64
"""Quake units between neighbouring positions."""

_HIGHEST = np.iinfo(np.int32).max
_HEADER_LIMITS = {"frames_count": (1, 1024), "tags_count": (0, 16), "surfaces_count": (0, 32)}
_SURFACE_LIMITS = {
    "shaders_count": (0, 256),
    "vertices_count": (0, 4096),
    "triangles_count": (0, 8192),
    "triangles_offset": (0, _HIGHEST),
    "shaders_offset": (0, _HIGHEST),
    "texcoords_offset": (0, _HIGHEST),
    "vertices_offset": (0, _HIGHEST),
    "end_offset": (SURFACE.itemsize, _HIGHEST),
}
_ANGLES = np.arange(256) * (2 * np.pi / 256)
_COS, _SIN = np.cos(_ANGLES).astype(np.float32), np.sin(_ANGLES).astype(np.float32)

_TINY = float(np.finfo(np.float32).tiny)

_SMALLEST_AREA = 1e-6  # squared, of the parallelogram of two axes that were unit vectors

Records = NDArray[np.void]


@dataclass(frozen=True, eq=False)
class Surface:
    """One surface of a model, with a texture of its own. Every array is read-only."""

    name: str
    """What skins call it: lower case, without the ``_1`` or ``_2`` that some tools append."""
    shaders: tuple[str, ...]
    """What it wears without a skin: names of shaders or images, mostly one, in lower case."""
    positions: NDArray[np.float32]
    """(frames, vertices, 3), Quake units."""
    normals: NDArray[np.float32]
    """(frames, vertices, 3), unit length."""
    texcoords: NDArray[np.float32]
    """(vertices, 2), 0 to 1 from the image's top left corner."""
    indices: NDArray[np.uint32]
    """(3 * triangles,); there may be none, as in effects that are only tags."""


@dataclass(frozen=True, eq=False)
class Md3Model:
    """One model as its file has it: Quake units, X forward, Z up, clockwise front faces."""

    source: str
    """The file's name for errors."""
    frames: Records
    """(frames,) of `FRAME`: box and sphere round each frame, and its name; all numbers finite."""
    surfaces: tuple[Surface, ...]
    """In the file's order; two may share a name."""
    tags: dict[str, Mat4]
    """(frames, 4, 4) float64 ``model_from_tag`` by name, read-only: rotation and shift alone."""


def read_md3(data: bytes, source: str) -> Md3Model:
    """Read and check a Quake III model.

    Args:
        data: The whole file.
        source: The file's name for errors, as in `AssetError`.

    Raises:
        AssetError: The file isn't IDP3 version 15, is truncated, exceeds the engine's limits, or
            something in it refers to what isn't there.
    """
    file = BinaryFile(data, source)
    file.require_magic(MAGIC)
    header = file.record(HEADER, 0, "header")
    if header["version"] != VERSION:
        found = f"version {header['version']}"
        raise AssetError(source, place="byte 4", expected=f"version {VERSION}", found=found)
    end = {"end_offset": (HEADER.itemsize, len(data))}
    _check_fields(file, header, _HEADER_LIMITS | end, "header")
    frame_count = int(header["frames_count"])
    frames = file.array(FRAME, header["frames_offset"], frame_count, "frames")
    for field in ("mins", "maxs", "origin", "radius"):
        values = frames[field]
        file.require(np.isfinite(values), values, f"frames[{{}}].{field}", "finite numbers")
    return Md3Model(
        source=source,
        frames=frames,
        surfaces=tuple(_read_surfaces(file, header)),
        tags=_read_tags(file, header),
    )


def between(keys: Mat4, pose: Pose) -> Mat4:
    """Place a tag between key frames.

    Like vertices, shift and axes move along straight lines from key to key; the axes are then
    made a rotation again.

    Args:
        keys: (frames, 4, 4) ``model_from_tag``, one of `Md3Model.tags`.
        pose: Of one figure or of n.

    Returns:
        (4, 4) or (n, 4, 4) ``model_from_tag``: a key itself where the pose is one.
    """
    before, behind = keys.take(pose.frame, axis=0), keys.take(pose.next_frame, axis=0)
    blend = np.asarray(pose.blend)
    mixed = before + (behind - before) * blend[..., np.newaxis, np.newaxis]
    mixed[..., :3, :3], area = orthonormalised(mixed[..., :3, :3])
    # Axes that turn by half a circle meet in the middle, and are no axes there.
    is_key = (blend <= 0) | (blend >= 1) | (area < _SMALLEST_AREA)
    if is_key.any():
        is_before = blend < 0.5
        for key, wanted in ((before, is_key & is_before), (behind, is_key & ~is_before)):
            mixed[wanted] = key[wanted]
    return mixed


def orthonormalised(
    rotations: Floats,
) -> tuple[Floats, Floats]:
    """Make columns unit vectors at right angles, keeping the first one's direction (Gram-Schmidt).

    Args:
        rotations: (..., 3, 3) whose first two columns have different directions; others make no
            rotation.

    Returns:
        (..., 3, 3), and (...) the square of the area that the first two columns spanned.
    """
    columns = np.moveaxis(rotations, (-1, -2), (0, 1))
    x, y = np.ascontiguousarray(columns[:2])  # coordinates first: NumPy loops over the many
    z = _cross(x, y)
    x, z, area = _unit(x), _unit(z), _dot(z, z)
    found = np.empty_like(rotations)
    for column, axis in zip(
        np.moveaxis(found, (-1, -2), (0, 1)), (x, _cross(z, x), z), strict=True
    ):
        column[...] = axis
    return found, area


def _unit(vectors: Floats) -> Floats:
    unit: Floats = vectors / np.maximum(np.sqrt(_dot(vectors, vectors)), _TINY)
    return unit


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _cross(a: Floats, b: Floats) -> Floats:
    """`np.cross` of (3, ...) vectors, which is slow for a few."""
    product = np.empty_like(a)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        product[i] = a[j] * b[k] - a[k] * b[j]
    return product


def _check_fields(
    file: BinaryFile, record: Any, limits: dict[str, tuple[int, int]], place: str
) -> None:
    """Require each field to lie within its lowest and highest value."""
    for field, (lowest, highest) in limits.items():
        if not lowest <= record[field] <= highest:
            expected = f"{lowest} to {highest}" if lowest < highest else f"{lowest}"
            found = f"{record[field]}"
            raise AssetError(file.source, place=f"{place}.{field}", expected=expected, found=found)


def _read_tags(file: BinaryFile, header: Any) -> dict[str, Mat4]:
    frame_count, tag_count = int(header["frames_count"]), int(header["tags_count"])
    flat = file.array(TAG, header["tags_offset"], frame_count * tag_count, "tags")
    tags = flat.reshape(frame_count, tag_count)
    names = [[text_until_nul(name).lower() for name in row] for row in tags["name"].tolist()]
    alike = np.array([row == names[0] for row in names])
    file.require(alike, tags["name"], "tags of frame {}", f"the names {names[0]} of frame 0")

    origins, axes = tags["origin"].astype(np.float64), tags["axes"].astype(np.float64)
    file.require(np.isfinite(origins), origins, "tags of frame {}, origin", "finite numbers")
    # A tool's scale stretches the axes of many models; the game, too, takes their directions alone.
    with np.errstate(invalid="ignore"):  # axes that are no numbers, told below
        lengths = np.linalg.norm(axes, axis=-1, keepdims=True)
        directions = axes / np.maximum(lengths, _TINY)
        volume = np.linalg.det(directions) if tag_count else np.ones((frame_count, 0))
    expected = "three axes about at right angles, right-handed"
    file.require(volume > 0.5, axes, "tags of frame {}, axes", expected)

    model_from_tag = np.zeros((frame_count, tag_count, 4, 4))
    model_from_tag[..., :3, :3], _ = orthonormalised(axes.swapaxes(-1, -2))
    model_from_tag[..., :3, 3] = origins
    model_from_tag[..., 3, 3] = 1
    model_from_tag.setflags(write=False)
    # Of tags that share a name the engine finds the first.
    return {name: model_from_tag[:, names[0].index(name)] for name in names[0]}


def _read_surfaces(file: BinaryFile, header: Any) -> Iterator[Surface]:
    start, posed = int(header["surfaces_offset"]), 0
    frame_count = int(header["frames_count"])
    limits = _SURFACE_LIMITS | {"frames_count": (frame_count, frame_count)}
    for number in range(header["surfaces_count"]):
        place = f"surfaces[{number}]"
        record = file.record(SURFACE, start, place)
        file.require_magic(MAGIC, start, place)
        _check_fields(file, record, limits, place)
        posed += frame_count * int(record["vertices_count"])
        if posed > MAX_POSED_VERTICES:
            expected = f"at most {MAX_POSED_VERTICES} vertices in all frames together"
            raise AssetError(file.source, place=place, expected=expected, found=f"{posed}")
        yield _read_surface(file, record, start, place)
        start += int(record["end_offset"])


def _read_surface(file: BinaryFile, record: Any, start: int, place: str) -> Surface:
    frame_count, vertex_count = int(record["frames_count"]), int(record["vertices_count"])

    def lump(name: str, dtype: np.dtype[Any], count: int) -> NDArray[Any]:
        return file.array(dtype, start + int(record[f"{name}_offset"]), count, f"{place}.{name}")

    shaders = lump("shaders", SHADER, int(record["shaders_count"]))
    triangles = lump("triangles", TRIANGLE, int(record["triangles_count"]))
    texcoords = lump("texcoords", TEXCOORD, vertex_count)
    posed = lump("vertices", VERTEX, frame_count * vertex_count).reshape(frame_count, vertex_count)
    file.require_indices(triangles, vertex_count, f"{place}.triangles[{{}}]")
    finite = np.isfinite(texcoords)
    file.require(finite, texcoords, f"{place}.texcoords[{{}}]", "finite numbers")

    # Latitude and longitude are turned about Z from X, and from Z down.
    ring = _SIN[posed["zenith"]]
    normals = np.stack(
        [_COS[posed["azimuth"]] * ring, _SIN[posed["azimuth"]] * ring, _COS[posed["zenith"]]],
        axis=-1,
    )
    name = text_until_nul(bytes(record["name"])).lower()
    names = (text_until_nul(shader) for shader in shaders["name"].tolist())
    surface = Surface(
        # As the engine, which strips any one character behind an underscore.
        name=name[:-2] if len(name) > 2 and name[-2] == "_" else name,
        shaders=tuple(name.replace("\\", "/").lower() for name in names),
        positions=posed["position"] * np.float32(UNITS_PER_STEP),
        normals=normals,
        texcoords=texcoords,
        indices=triangles.reshape(-1).astype(np.uint32),
    )
    for array in (surface.positions, surface.normals, surface.indices):
        array.setflags(write=False)
    return surface
