"""What readers of triangle meshes give: surfaces, each in one look."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints
from followspot.assets.binary import run_members
from followspot.errors import AssetError

MAX_VERTICES = 1 << 22
"""Most vertices, and corners of triangles, of all surfaces of a file together."""

MAX_SURFACES = 1 << 12
"""Most surfaces of a file, each at every place where it is."""

CREASE = 40.0
"""Degrees: triangles that meet at a smaller angle are parts of one curved surface."""

_CHUNK = 1 << 18  # corners smoothed at a time
_MAX_ROUND = 64  # corners at one place that smooth one another


@dataclass(frozen=True)
class Look:
    """What a surface wears.

    Attributes:
        color: Red, green, blue, linear, and alpha, that texels are multiplied by.
        image: An image file's name, as the mesh file writes it, or its bytes, where they are in
            the mesh file; none is white.
        cutoff: Alpha from which on a place is there, where the surface is cut out.
        is_blended: Whether alpha mixes it with what is behind.
        is_two_sided: Whether its back is drawn too.
        clamps: Whether the image ends at its border instead of repeating.
    """

    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    image: str | bytes | None = None
    cutoff: float | None = None
    is_blended: bool = False
    is_two_sided: bool = False
    clamps: bool = False


PLAIN = Look()


@dataclass(frozen=True, eq=False)
class MeshSurface:
    """Triangles in one look, in the file's own axes and unit of length.

    Attributes:
        positions: (v, 3) float32, finite.
        normals: (v, 3) float32, unit length.
        texcoords: (v, 2) float32, v down.
        colors: (v, 4) float32, linear, that texels are multiplied by too; none is white.
        indices: (i,) uint32, three a triangle, clockwise from its front as in Quake.
        look: What it wears.
        name: Which of the file's it is.
    """

    positions: NDArray[np.float32]
    normals: NDArray[np.float32]
    texcoords: NDArray[np.float32]
    colors: NDArray[np.float32] | None
    indices: NDArray[np.uint32]
    look: Look
    name: str = ""


@dataclass(frozen=True, eq=False)
class MeshFile:
    """A mesh file's contents.

    Attributes:
        source: Where it was read, for messages.
        surfaces: At least one, none without triangles.
        problems: What it names and what was not found, but for images.
    """

    source: str
    surfaces: tuple[MeshSurface, ...]
    problems: tuple[AssetError, ...] = ()


@dataclass(frozen=True, eq=False)
class RawSurface:
    """A surface as a file has it, not yet checked.

    Attributes:
        place: Which it is, for errors; its name.
        positions: (v, 3).
        triangles: (t, 3) corners, counter-clockwise from the front as in most formats.
        normals: (v, 3), or none where the file has none.
        texcoords: (v, 2), v down, or none.
        colors: (v, 4) linear, or none.
        look: What it wears.
        crease: Degrees up to which normals are made smooth where the file has none.
    """

    place: str
    positions: NDArray[np.floating]
    triangles: NDArray[np.integer]
    normals: NDArray[np.floating] | None = None
    texcoords: NDArray[np.floating] | None = None
    colors: NDArray[np.floating] | None = None
    look: Look = PLAIN
    crease: float = CREASE


def finish(raw: RawSurface, source: str) -> MeshSurface:
    """Check a surface, give it what it lacks, and turn its triangles clockwise.

    Raises:
        AssetError: an index leads nowhere, a number is not finite or too large for float32.
    """
    count, triangles = len(raw.positions), raw.triangles.astype(np.int64)
    wrong = (triangles < 0) | (triangles >= count)
    if wrong.any():
        expected = f"indices below {count}, the number of vertices"
        found = f"{triangles[wrong][0]}"
        raise AssetError(source, place=raw.place, expected=expected, found=found)
    positions = _numbers(raw, "positions", raw.positions, source)
    texcoords = np.zeros((count, 2), np.float32)
    if raw.texcoords is not None:
        texcoords = _numbers(raw, "texcoords", raw.texcoords, source)
    colors = raw.colors
    if colors is not None:
        colors = np.clip(_numbers(raw, "colors", colors, source), 0, 1)
    if raw.normals is None:
        corner = triangles.ravel()
        normals = corner_normals(positions, triangles, raw.crease)
        positions, texcoords = positions[corner], texcoords[corner]
        colors = None if colors is None else colors[corner]
        triangles = np.arange(len(corner)).reshape(-1, 3)
    else:
        normals = _unit(raw.normals.astype(np.float64), positions, triangles)
    indices = np.ascontiguousarray(triangles[:, ::-1]).astype(np.uint32).ravel()
    return MeshSurface(positions, normals, texcoords, colors, indices, raw.look, raw.place)


def _numbers(
    raw: RawSurface, what: str, values: NDArray[np.floating], source: str
) -> NDArray[np.float32]:
    with np.errstate(over="ignore", invalid="ignore"):
        numbers = values.astype(np.float32)
        good = np.isfinite(numbers) & (np.abs(numbers) < 1e15)
    if not good.all():
        k = int(np.argmin(good.all(axis=1)))
        place, found = f"{raw.place}, {what}[{k}]", f"{values[k].tolist()}"
        raise AssetError(source, place=place, expected="numbers below 1e15", found=found)
    return numbers


def _unit(normals: Floats, positions: NDArray[np.float32], triangles: Ints) -> NDArray[np.float32]:
    """Unit normals; those that are none become that of a triangle at the vertex."""
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        good = np.isfinite(length) & (length > 1e-6)
        normals = normals / np.where(good, length, 1)
    if not good.all():
        own = np.tile([0.0, 0.0, 1.0], (len(normals), 1))
        own[triangles.ravel()] = corner_normals(positions, triangles, 0.0)
        normals = np.where(good, normals, own)
    return normals.astype(np.float32)


def corner_normals(
    positions: NDArray[np.float32], triangles: Ints, crease: float
) -> NDArray[np.float32]:
    """Normals for triangles' corners, from the triangles alone.

    A corner's is the mean, by area, of the triangles that share its place (whether or not they
    share the vertex: seams of a texture do not show) and are turned away from its own by less
    than a crease.

    Args:
        positions: (v, 3).
        triangles: (t, 3) counter-clockwise from the front.
        crease: Degrees; 0 leaves every triangle flat.

    Returns:
        (3t, 3) unit normals, corner after corner.
    """
    a, b, c = positions[triangles].astype(np.float64).transpose(1, 0, 2)
    area = np.cross(b - a, c - a)
    length = np.linalg.norm(area, axis=1, keepdims=True)
    flat = np.where(length > 0, area / np.where(length > 0, length, 1), (0.0, 0.0, 1.0))
    corner = triangles.ravel()
    if crease <= 0 or not len(corner):
        return np.repeat(flat, 3, axis=0).astype(np.float32)
    place = np.unique(positions, axis=0, return_inverse=True)[1].ravel()[corner]
    order = np.argsort(place, kind="stable")
    first = np.searchsorted(place[order], place)
    count = np.minimum(np.bincount(place)[place], _MAX_ROUND)
    least = np.cos(np.radians(crease))
    normals = np.repeat(flat, 3, axis=0)
    for start in range(0, len(corner), _CHUNK):
        chunk = slice(start, start + _CHUNK)
        own = np.repeat(np.arange(len(corner))[chunk] // 3, count[chunk])
        other = order[run_members(first[chunk], count[chunk])] // 3
        alike = (np.einsum("ij,ij->i", flat[own], flat[other]) > least) | (own == other)
        starts = np.cumsum(count[chunk]) - count[chunk]
        total = np.add.reduceat(area[other] * alike[:, np.newaxis], starts, axis=0)
        size = np.linalg.norm(total, axis=1, keepdims=True)
        normals[chunk] = np.where(size > 0, total / np.where(size > 0, size, 1), normals[chunk])
    return normals.astype(np.float32)
