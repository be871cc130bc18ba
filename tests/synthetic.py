"""Tiny scenes built straight from arrays, and their geometry worked out a second time.

`piece` functions make triangles with clockwise fronts; `make_scene` puts them into a `Scene`.
`rays`, `on_plane` and `srgb_decoded` are this folder's own mathematics, written without the
package's, so that a test compares two independent answers.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from followspot.arrays import Floats
from followspot.assets.archive import Archive
from followspot.assets.bsp import LUMPS, BspFile
from followspot.scene.camera import Camera
from followspot.scene.level import Level, Visibility
from followspot.scene.light import Light, PointLight, SpotLight
from followspot.scene.material import Material
from followspot.scene.mesh import FACE, VERTEX, Mesh
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.scene.sky import CubeMap
from followspot.spaces import vec3

SIZE = (160, 120)
"""(width, height) of the pictures of the session's one renderer."""

WHITE = Material("white")
DIM = Settings(sky_light=False, exposure=1.0)


@dataclass(frozen=True)
class Piece:
    """Triangles that become one face of the mesh; vertices are (n,) of VERTEX."""

    vertices: NDArray[np.void]
    indices: NDArray[np.uint32]
    material: Material = WHITE


def of(material: Material, *pieces: Piece) -> list[Piece]:
    """The same pieces made of another material."""
    return [replace(piece, material=material) for piece in pieces]


def quad(centre: ArrayLike, u: ArrayLike, v: ArrayLike) -> Piece:
    """The parallelogram centre +-u +-v, its front towards u x v; s runs along u, t against v."""
    c, u, v = (np.asarray(each, np.float64) for each in (centre, u, v))
    normal = np.cross(u, v)
    vertices = np.zeros(4, VERTEX)
    vertices["position"] = [c - u - v, c + u - v, c + u + v, c - u + v]
    vertices["normal"] = normal / np.linalg.norm(normal)
    vertices["texcoord"] = [(0, 1), (1, 1), (1, 0), (0, 0)]
    return Piece(vertices, np.array([0, 2, 1, 0, 3, 2], np.uint32))


def box(mins: ArrayLike, maxs: ArrayLike, *, inward: bool = False) -> list[Piece]:
    """Six quads that look outwards, or inwards as a room does."""
    low, high = np.asarray(mins, np.float64), np.asarray(maxs, np.float64)
    centre, half = (low + high) / 2, np.diag((high - low) / 2)
    quads = []
    for axis in range(3):
        for sign in (1, -1):
            u, v = half[(axis + 1) % 3], half[(axis + 2) % 3]
            if (sign < 0) != inward:
                u, v = v, u
            quads.append(quad(centre + sign * half[axis], u, v))
    return quads


def floor(size: float = 1000.0, z: float = 0.0) -> Piece:
    """A square of half-size `size` that looks up."""
    return quad((0, 0, z), (size, 0, 0), (0, size, 0))


def sphere(centre: ArrayLike, radius: float, rings: int = 24, normals_of: int = 1) -> Piece:
    """A tessellated sphere with exact normals (or inward ones, for `normals_of` -1)."""
    polar, around = np.meshgrid(
        np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, 2 * rings + 1), indexing="ij"
    )
    normal = np.stack(
        [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1
    ).reshape(-1, 3)
    vertices = np.zeros(len(normal), VERTEX)
    vertices["position"] = np.asarray(centre) + radius * normal
    vertices["normal"] = normal * normals_of
    row = 2 * rings + 1
    a = (np.arange(rings)[:, np.newaxis] * row + np.arange(2 * rings)).ravel()
    outward = np.stack([a, a + 1, a + row + 1, a, a + row + 1, a + row], axis=-1)
    triangles = outward.reshape(-1, 3)[:, ::normals_of]
    return Piece(vertices, triangles.ravel().astype(np.uint32))


def turned(pieces: Sequence[Piece], rotation: Floats, shift: ArrayLike = (0, 0, 0)) -> list[Piece]:
    """The pieces rotated by a (3, 3) matrix about the origin, then moved."""
    result = []
    for piece in pieces:
        vertices = piece.vertices.copy()
        vertices["position"] = vertices["position"] @ rotation.T + np.asarray(shift)
        vertices["normal"] = vertices["normal"] @ rotation.T
        result.append(replace(piece, vertices=vertices))
    return result


def rotation(axis: ArrayLike, degrees: float) -> Floats:
    """(3, 3) rotation about an axis by the right-hand rule (Rodrigues)."""
    x, y, z = np.asarray(axis, np.float64) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = math.radians(degrees)
    return np.asarray(np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k)


def cube_map(pixels: ArrayLike, size: int = 4) -> CubeMap:
    """The same (r, g, b) bytes everywhere, or (6, s, s, 3) bytes as they are."""
    rgb = np.asarray(pixels, np.uint8)
    if rgb.ndim == 1:
        rgb = np.broadcast_to(rgb, (6, size, size, 3))
    alpha = np.full((*rgb.shape[:3], 1), 255, np.uint8)
    return CubeMap("test sky", np.ascontiguousarray(np.concatenate([rgb, alpha], axis=3)))


BLACK_SKY = cube_map((0, 0, 0))
WHITE_SKY = cube_map((255, 255, 255))


def open_bsp() -> BspFile:
    """A level without walls, in which every place is outside of all clusters."""
    empty: dict[str, NDArray[Any]] = {
        name: np.empty(0, dtype) for name, dtype in LUMPS.items() if name not in _NO_RECORDS
    }
    nodes = np.zeros(1, LUMPS["nodes"])
    nodes["children"] = -1
    planes = np.zeros(1, LUMPS["planes"])
    planes["normal"] = 0, 0, 1
    leafs = np.zeros(1, LUMPS["leafs"])
    leafs["cluster"] = -1
    return BspFile(
        source="synthetic",
        entities=(),
        shader_names=(),
        cluster_count=0,
        cluster_visible=np.empty((0, 0), np.uint8),
        **(empty | {"nodes": nodes, "planes": planes, "leafs": leafs}),
    )


_NO_RECORDS = ("entities", "visibility")


def make_mesh(pieces: Sequence[Piece]) -> tuple[Mesh, tuple[Material, ...]]:
    """One face for each piece, sorted by material in the renderer's order."""
    materials = tuple(sorted({piece.material for piece in pieces}, key=lambda m: m.order))
    pieces = sorted(pieces, key=lambda piece: materials.index(piece.material))
    shifts = np.cumsum([0, *(len(piece.vertices) for piece in pieces)])
    vertices = np.concatenate([p.vertices for p in pieces]) if pieces else np.empty(0, VERTEX)
    indices = [p.indices + np.uint32(s) for p, s in zip(pieces, shifts, strict=False)]
    faces = np.zeros(len(pieces), FACE)
    faces["index_count"] = [len(piece.indices) for piece in pieces]
    faces["first_index"] = np.cumsum(faces["index_count"]) - faces["index_count"]
    faces["material"] = [materials.index(piece.material) for piece in pieces]
    for face, piece in zip(faces, pieces, strict=True):
        face["mins"] = piece.vertices["position"].min(axis=0)
        face["maxs"] = piece.vertices["position"].max(axis=0)
    joined = np.concatenate(indices) if pieces else np.empty(0, np.uint32)
    return Mesh(vertices, joined, faces), materials


def make_scene(
    pieces: Sequence[Piece],
    *lights: Light,
    sky: CubeMap = BLACK_SKY,
    archive: Archive | None = None,
    **fields: Any,
) -> Scene:
    """A scene of pieces under lights, seen by the cameras that a test gives; `fields` of Scene.

    Images that materials name come from `archive`.
    """
    mesh, materials = make_mesh(pieces)
    bsp = open_bsp()
    visibility = Visibility(bsp, np.arange(len(mesh.faces)), np.ones(len(mesh.faces), bool))
    return Scene(
        name="synthetic",
        archive=archive or Archive.open([]),
        level=Level(bsp, mesh, materials, visibility),
        sky=sky,
        lights=lights,
        **fields,
    )


def image_archive(folder: Path, images: Mapping[str, NDArray[np.uint8]]) -> Archive:
    """An archive of png files, from names to (h, w, 3 or 4) bytes."""
    for name, pixels in images.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(pixels).save(path)
    return Archive.open([folder])


def camera(position: ArrayLike, yaw: float = 0, pitch: float = 0, fov: float = 90) -> Camera:
    """A camera from plain numbers."""
    return Camera(vec3(position), yaw, pitch, fov)


def looking(position: ArrayLike, target: ArrayLike, fov: float = 90) -> Camera:
    """A camera that looks at a point."""
    x, y, z = np.asarray(target, np.float64) - np.asarray(position, np.float64)
    yaw, pitch = math.degrees(math.atan2(y, x)), -math.degrees(math.atan2(z, math.hypot(x, y)))
    return camera(position, yaw, pitch, fov)


def point(position: ArrayLike, power: ArrayLike = (100, 100, 100)) -> PointLight:
    """A point light from plain numbers."""
    return PointLight(vec3(position), vec3(np.broadcast_to(power, 3)))


def spot(
    position: ArrayLike,
    target: ArrayLike,
    degrees: float,
    power: ArrayLike = 100,
    softness: float = 0.0,
    casts_shadow: bool = True,
) -> SpotLight:
    """A spot light aimed at a point, its half-angle in degrees."""
    axis = np.asarray(target, np.float64) - np.asarray(position, np.float64)
    return SpotLight(
        vec3(position),
        vec3(axis / np.linalg.norm(axis)),
        math.radians(degrees),
        vec3(np.broadcast_to(power, 3)),
        softness,
        casts_shadow,
    )


def rays(view: Camera, size: tuple[int, int] = SIZE) -> Floats:
    """(h, w, 3) world directions through the pixels' middles, one unit long along the view axis.

    Quake's convention from scratch: yaw turns from +X towards +Y, positive pitch looks down, the
    picture's right is the camera's right, its first row the top.
    """
    yaw, pitch = math.radians(view.yaw), math.radians(view.pitch)
    ahead = np.array([math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), 0])
    ahead[2] = -math.sin(pitch)
    right = np.array([math.sin(yaw), -math.cos(yaw), 0])
    up = np.cross(right, ahead)
    width, height = size
    half = math.tan(math.radians(view.fov) / 2)
    x = ((np.arange(width) + 0.5) / width * 2 - 1) * half
    y = (1 - (np.arange(height) + 0.5) / height * 2) * half * height / width
    return np.asarray(
        ahead + x[np.newaxis, :, np.newaxis] * right + y[:, np.newaxis, np.newaxis] * up
    )


def on_plane(view: Camera, normal: ArrayLike, distance: float = 0.0) -> tuple[Floats, Floats]:
    """Where each pixel's ray meets the plane ``normal . p = distance``.

    Returns:
        (h, w, 3) points and (h, w) distances along the view axis, infinite where it does not.
    """
    n, towards = np.asarray(normal, np.float64), rays(view)
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = (distance - view.position @ n) / (towards @ n)
        depth = np.where(depth > 0, depth, np.inf)
        return view.position + towards * depth[..., np.newaxis], depth


def srgb_decoded(values: ArrayLike) -> Floats:
    """Display values in [0, 1] to linear ones (IEC 61966-2-1)."""
    v = np.asarray(values, np.float64)
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def srgb_encoded(values: ArrayLike) -> Floats:
    """Linear values to display values, both in [0, 1]."""
    v = np.clip(np.asarray(values, np.float64), 0, 1)
    return np.where(v <= 0.0031308, v * 12.92, 1.055 * v ** (1 / 2.4) - 0.055)
