"""Things that never move: read, and put at their places."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from followspot.assets import image
from followspot.assets.archive import BESIDE, Archive, normalise
from followspot.assets.mesh_file import MESH_SUFFIXES, read_mesh
from followspot.assets.mesh_record import Look, MeshSurface
from followspot.assets.model_file import MODEL_SUFFIXES, find_model_image
from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.errors import AssetError, asked_by
from followspot.game import STEP_HEIGHT
from followspot.scene.entry import FARTHEST
from followspot.scene.figure import Figure
from followspot.scene.figure_file import FigureFiles
from followspot.scene.ground import Ground
from followspot.scene.material import Material
from followspot.scene.mesh import VERTEX
from followspot.scene.prop_file import PropEntry, Up
from followspot.spaces import METRES_PER_UNIT, Mat4

Z_UP_FROM_Y_UP: Mat4 = np.array(
    [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=np.float64
)
"""glTF's axes (Y up, a thing's front towards +Z, its left +X) to Quake's (Z, +X and +Y)."""

_BLENDED = BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA


@dataclass(frozen=True, eq=False)
class PropSurface:
    """Triangles in one material.

    Attributes:
        vertices: (v,) of VERTEX.
        tints: (v, 4) float32 as in `Mesh.tints`, or none.
        indices: (i,) uint32, clockwise triangles.
        material: What it is made of.
        name: Which of its file's it is; of a model's, none.
    """

    vertices: NDArray[np.void]
    tints: NDArray[np.float32] | None
    indices: NDArray[np.uint32]
    material: Material
    name: str = ""


@dataclass(frozen=True, eq=False)
class Prop:
    """A thing that never moves.

    Attributes:
        name: Its file, in the archive or from the scene file's folder.
        surfaces: In its file's own axes and unit, or where it was put in the world.
    """

    name: str
    surfaces: tuple[PropSurface, ...]

    @property
    def bounds(self) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(3,) mins and (3,) maxs."""
        points = np.concatenate([surface.vertices["position"] for surface in self.surfaces])
        return points.min(axis=0), points.max(axis=0)

    @property
    def triangle_count(self) -> int:
        """Number of triangles."""
        return sum(len(surface.indices) for surface in self.surfaces) // 3


class PropFiles:
    """Reads props from an archive, each once.

    Args:
        archive: Where files and images are looked for; images inside of mesh files are added.
        figures: Reads Quake's own models; what is missing is listed there.
    """

    def __init__(self, archive: Archive, figures: FigureFiles) -> None:
        self._archive = archive
        self._figures = figures
        self._props: dict[str, Prop] = {}
        self._embedded: dict[bytes, str] = {}

    def open(self, name: str) -> Prop:
        """Read a mesh file, or the first frame of a model, by its name in the archive.

        Raises:
            AssetError: there is no such file, or it cannot be read.
        """
        entry = normalise(name)
        if entry not in self._props:
            self._props[entry] = self._read(name, entry)
        return self._props[entry]

    def _read(self, name: str, entry: str) -> Prop:
        if entry.endswith(MODEL_SUFFIXES):
            return _first_frame(entry.removeprefix(BESIDE), self._figures.open(entry))
        suffix = next((s for s in MESH_SUFFIXES if entry.endswith(s)), None)
        if suffix is None:
            expected = f"a file {', '.join((*MESH_SUFFIXES, *MODEL_SUFFIXES))}"
            raise AssetError(name, expected=expected, found="another name")
        data, source = self._archive.read(entry), self._archive.source(entry)
        file = read_mesh(data, source, suffix, partial(self._beside, entry))
        self._figures.problems += file.problems
        surfaces = (self._surface(entry, surface) for surface in file.surfaces)
        return Prop(entry.removeprefix(BESIDE), tuple(surfaces))

    def _beside(self, entry: str, name: str) -> bytes | None:
        """A file by its name in a mesh file's folder."""
        path = entry.rpartition("/")[0] + "/" + name
        return self._archive.read(path) if self._archive.exists(path) else None

    def _surface(self, entry: str, surface: MeshSurface) -> PropSurface:
        vertices = np.zeros(len(surface.positions), VERTEX)
        vertices["position"], vertices["normal"] = surface.positions, surface.normals
        vertices["texcoord"] = surface.texcoords
        look, tints = surface.look, surface.colors
        if tints is not None or look.color != Look.color:
            white = np.ones((len(vertices), 4), np.float32)
            tints = np.array(look.color, np.float32) * (white if tints is None else tints)
        material = self._material(entry, look, is_tinted=tints is not None)
        return PropSurface(vertices, tints, surface.indices, material, surface.name)

    def _material(self, entry: str, look: Look, *, is_tinted: bool) -> Material:
        cutoff = look.cutoff or 0.0  # nothing is below 0
        return Material(
            entry.removeprefix(BESIDE),
            self._image(entry, look.image),
            sides=Sides.BOTH if look.is_two_sided else Sides.FRONT,
            alpha_test=AlphaTest.GE128 if cutoff else None,
            alpha_scale=look.color[3] * 128 / 255 / cutoff if cutoff else 1.0,
            blend=_BLENDED if look.is_blended else None,
            clamps=look.clamps,
            is_tinted=is_tinted,
        )

    def _image(self, entry: str, wanted: str | bytes | None) -> str | None:
        """An image's name in the archive; those inside of the file are put there."""
        if wanted is None:
            return None
        if isinstance(wanted, bytes):
            if wanted not in self._embedded:
                number = len(self._embedded)
                self._embedded[wanted] = self._archive.add(
                    f"{entry}#{number}", wanted, f"{self._archive.source(entry)}: image {number}"
                )
            return self._embedded[wanted]
        found, tried = image.find_image(self._archive, entry.rpartition("/")[0] + "/" + wanted)
        if found is None:
            found, more = find_model_image(self._archive, entry, wanted)
            if found is None:
                self._figures.missing[wanted] = list(dict.fromkeys([*tried, *more]))
        return found


def _first_frame(name: str, figure: Figure) -> Prop:
    surfaces = []
    for part in figure.parts:
        vertices = np.zeros(part.vertex_count, VERTEX)
        vertices["position"], vertices["normal"] = part.positions[0], part.normals[0]
        vertices["texcoord"] = part.texcoords
        for run in part.runs:
            # A part's vertices are shared by all its materials; a surface has its own alone.
            used, indices = np.unique(
                part.indices[run.first : run.first + run.count], return_inverse=True
            )
            surfaces.append(
                PropSurface(vertices[used], None, indices.astype(np.uint32), run.material)
            )
    if not surfaces:
        raise AssetError(name, expected="triangles", found="none")
    return Prop(name, tuple(surfaces))


def props(
    entries: Sequence[PropEntry],
    files: PropFiles,
    metres_per_unit: float,
    source: str,
    ground: Ground | None = None,
) -> tuple[Prop, ...]:
    """The props that a scene file names, where it puts them.

    Args:
        entries: In the file's order.
        files: Where they come from.
        metres_per_unit: glTF's unit of length is the metre; others are taken as Quake's.
        source: The scene file's name for errors.
        ground: What those stand on that are dropped.

    Raises:
        AssetError: a prop is not there or cannot be read, or reaches absurdly far.
    """
    found = []
    for number, entry in enumerate(entries):
        with asked_by(source, f"props[{number}].file"):
            read = files.open(entry.file)
        placed = moved(read, _matrix(entry, metres_per_unit))
        mins, maxs = placed.bounds
        if entry.ground and ground is not None:
            x, y, z = entry.origin
            above = z + STEP_HEIGHT  # the origin may lie as far below the floor
            floor = float(ground.below(np.array([[x, y, above]]))[0])
            if floor < above:
                placed = moved(placed, _shift(0, 0, floor - mins[2]))
        farthest = float(np.abs([mins, maxs]).max())
        if not farthest < FARTHEST:
            place, expected = f"props[{number}]", f"a prop within {FARTHEST:g} units of 0"
            raise AssetError(source, place=place, expected=expected, found=f"{farthest:g}")
        found.append(placed)
    return tuple(found)


def alone(entry: str, files: PropFiles, source: str) -> Prop:
    """A prop in Quake's axes and units, where its file puts it.

    Args:
        entry: Its name in the archive.
        files: Where it comes from.
        source: What it was asked for as, for errors.

    Raises:
        AssetError: as `props`; what is wrong with the file is told of the file alone.
    """
    files.open(entry)
    wanted = PropEntry(file=entry, origin=(0.0, 0.0, 0.0))
    (prop,) = props([wanted], files, METRES_PER_UNIT, source)
    return prop


def _matrix(entry: PropEntry, metres_per_unit: float) -> Mat4:
    """``world_from_file``."""
    is_gltf = entry.file.lower().endswith((".glb", ".gltf"))
    up = entry.up or (Up.Y if is_gltf else Up.Z)
    scale = entry.scale / metres_per_unit if is_gltf else entry.scale
    z_up_from_file = Z_UP_FROM_Y_UP if up is Up.Y else np.eye(4)
    world_from_file = _turn(*entry.turn) @ np.diag([scale, scale, scale, 1.0]) @ z_up_from_file
    return np.asarray(_shift(*entry.origin) @ world_from_file)


def _shift(x: float, y: float, z: float) -> Mat4:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def _turn(pitch: float, yaw: float, roll: float) -> Mat4:
    """The game's angles in degrees: about X by roll, then about Y by pitch, then about Z by yaw."""
    matrix = np.eye(4)
    for axis, degrees in ((0, roll), (1, pitch), (2, yaw)):
        angle, (a, b) = math.radians(degrees), ((axis + 1) % 3, (axis + 2) % 3)
        turn = np.eye(4)
        turn[a, a] = turn[b, b] = math.cos(angle)
        turn[b, a] = math.sin(angle)
        turn[a, b] = -turn[b, a]
        matrix = turn @ matrix
    return matrix


def moved(prop: Prop, matrix: Mat4) -> Prop:
    """A prop turned, moved and evenly scaled by (4, 4)."""
    linear = matrix[:3, :3]
    rotation = linear / np.cbrt(np.linalg.det(linear))
    surfaces = []
    for surface in prop.surfaces:
        vertices = surface.vertices.copy()
        vertices["position"] = vertices["position"] @ linear.T + matrix[:3, 3]
        vertices["normal"] = vertices["normal"] @ rotation.T
        surfaces.append(replace(surface, vertices=vertices))
    return Prop(prop.name, tuple(surfaces))
