"""Baking: lightmap pages for polygons and patches, colours for meshes, and the light grid."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats
from followspot.assets.bsp import LUMPS, FaceType
from followspot.assets.surface_flags import Surface
from followspot.levelbuilder.bsp_tree import Node, leaf_at
from followspot.levelbuilder.faces import BY_VERTEX, Face, patch_normals
from followspot.levelbuilder.lights import Lights, lit, lit_volume
from followspot.levelbuilder.patches import evaluate, lengths
from followspot.levelbuilder.raycast import Occluders
from followspot.levelbuilder.winding import plane_axes

PAGE = 128
"""Luxels along a side of a page."""

LUXEL = 16.0
"""Units from luxel to luxel, where the face fits its page."""

GRID = np.array([64.0, 64.0, 128.0])
"""Size of a cell of the light grid, in units: the game's default."""

_LIFT = 2.0  # units that samples float over their surface, so that it does not shadow itself
_INSET = 1.0  # units that samples keep from a polygon's edges, so that neighbours do not, either


@dataclass(frozen=True)
class _Samples:
    """A face's luxels, row by row: where they are and which way they face."""

    columns: int
    rows: int
    points: Floats
    normals: Floats


def occluders(faces: Sequence[Face]) -> Occluders:
    """Return the triangles of all faces that stop light."""
    corners, opacity = [], []
    for face in faces:
        material = face.material
        if material.opacity > 0 and _visible(face):
            corners.append(_triangles(face))
            opacity.append(np.full(len(corners[-1]), material.opacity))
    return Occluders(np.concatenate(corners), np.concatenate(opacity))


def _triangles(face: Face) -> Floats:
    if face.kind != FaceType.PATCH:
        return face.points[face.triangles]
    columns, rows = face.patch_size
    grid = evaluate(
        face.points.reshape(rows, columns, 3),
        np.arange(rows) / 2,
        np.arange(columns) / 2,
    )
    a, b, c, d = grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]
    halves = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)])
    return halves.reshape(-1, 3, 3)


def bake(faces: Sequence[Face], lights: Lights) -> NDArray[np.uint8]:
    """Light all faces; gives them their places and coordinates on the pages.

    Returns:
        The pages, (n, 128, 128, 3).
    """
    mapped = [face for face in faces if face.material.lightmapped and face.kind != FaceType.MESH]
    samples = [
        _patch_samples(face) if face.kind == FaceType.PATCH else _polygon_samples(face)
        for face in mapped
    ]
    pages = _pack(mapped, samples)
    shadow = occluders(faces)
    bare = [face for face in faces if face.lightmap == BY_VERTEX and _visible(face)]
    points = [s.points for s in samples]
    points += [face.points + _LIFT * face.normals for face in bare]
    normals = [s.normals for s in samples] + [face.normals for face in bare]
    light = lit(lights, shadow, np.concatenate(points), np.concatenate(normals))
    texels = np.minimum(light, 255).round().astype(np.uint8)
    start = 0
    for face in mapped:
        x, y, width, height = face.lightmap_rect
        block = texels[start : start + width * height].reshape(height, width, 3)
        pages[face.lightmap, y : y + height, x : x + width] = block
        start += width * height
    for face in bare:
        face.colors[:, :3] = texels[start : start + len(face.points)]
        start += len(face.points)
    return pages


def _visible(face: Face) -> bool:
    return face.material.drawn and not face.material.surface & Surface.SKY


def _polygon_samples(face: Face) -> _Samples:
    """Lay luxels over a polygon at whole multiples of their spacing from the world's origin.

    Luxels beyond the edges are lit where the polygon is nearest to them: none ends up in a wall.
    """
    normal = face.normals[0]
    axes = np.stack(plane_axes(normal))
    flat = face.points @ axes.T
    spacing = LUXEL
    while np.ptp(flat, axis=0).max() / spacing > PAGE - 3:
        spacing *= 2
    low = np.floor(flat.min(axis=0) / spacing)
    columns, rows = (np.ceil(flat.max(axis=0) / spacing) - low).astype(int) + 1
    u, v = np.meshgrid(low[0] + np.arange(columns), low[1] + np.arange(rows))
    grid = np.stack([u, v], axis=2).reshape(-1, 2) * spacing
    dist = float(normal @ face.points[0])
    inside = _pulled_inside(grid, flat)
    face.lightmap_st = flat / spacing - low  # in luxels, until the place on the page is known
    face.lightmap_axes = axes * spacing
    face.lightmap_origin = normal * dist + low * spacing @ axes
    points = normal * (dist + _LIFT) + inside @ axes
    return _Samples(columns, rows, points, np.broadcast_to(normal, points.shape))


def _pulled_inside(points: Floats, corners: Floats) -> Floats:
    """Move flat points, (n, 2), inside a convex outline, (k, 2), some way off its edges."""
    middle = corners.mean(axis=0)
    for _ in range(3):
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            along = b - a
            outward = np.array([along[1], -along[0]]) / max(np.hypot(*along), 1e-9)
            if (middle - a) @ outward > 0:
                outward = -outward
            room = min(_INSET, -((middle - a) @ outward) / 2)
            beyond = np.maximum((points - a) @ outward + room, 0)
            points = points - beyond[:, None] * outward
    return points


def _patch_samples(face: Face) -> _Samples:
    columns, rows = face.patch_size
    controls = face.points.reshape(rows, columns, 3)
    wide = max(lengths(controls[row])[-1] for row in range(0, rows, 2))
    high = max(lengths(controls[:, column])[-1] for column in range(0, columns, 2))
    width, height = (int(np.clip(np.ceil(size / LUXEL) + 1, 2, 64)) for size in (wide, high))
    u = np.linspace(0, (columns - 1) / 2, width)
    v = np.linspace(0, (rows - 1) / 2, height)
    normals = patch_normals(controls, v, u).reshape(-1, 3)
    points = evaluate(controls, v, u).reshape(-1, 3) + _LIFT * normals
    s, t = np.meshgrid(np.linspace(0, width - 1, columns), np.linspace(0, height - 1, rows))
    face.lightmap_st = np.stack([s, t], axis=2).reshape(-1, 2)
    return _Samples(width, height, points, normals)


def _pack(faces: Sequence[Face], samples: Sequence[_Samples]) -> NDArray[np.uint8]:
    """Give each face a rectangle on a page, tallest first, in shelves; return the empty pages."""
    page = x = y = shelf = 0
    order = sorted(range(len(faces)), key=lambda i: (-samples[i].rows, -samples[i].columns, i))
    for i in order:
        face, own = faces[i], samples[i]
        if x + own.columns > PAGE:
            x, y, shelf = 0, y + shelf, 0
        if y + own.rows > PAGE:
            page, x, y, shelf = page + 1, 0, 0, 0
        face.lightmap = page
        face.lightmap_rect = (x, y, own.columns, own.rows)
        face.lightmap_st = (face.lightmap_st + np.array([x, y]) + 0.5) / PAGE
        x, shelf = x + own.columns, max(shelf, own.rows)
    return np.zeros((page + 1 if faces else 0, PAGE, PAGE, 3), np.uint8)


def bake_grid(
    tree: Node, mins: Floats, maxs: Floats, lights: Lights, shadow: Occluders
) -> NDArray[np.void]:
    """Return the light grid over the world model's box; cells in solid stay black, as is usual.

    x runs fastest, then y, then z; the game derives the very same counts from the box.
    """
    first, last = np.ceil(mins / GRID), np.floor(maxs / GRID)
    counts = (last - first + 1).astype(int)
    z, y, x = np.meshgrid(*(first[k] + np.arange(counts[k]) for k in (2, 1, 0)), indexing="ij")
    points = np.stack([x, y, z], axis=3).reshape(-1, 3) * GRID
    open_ = np.flatnonzero([not leaf_at(tree, point).solid for point in points])
    ambient, directed, towards = lit_volume(lights, shadow, points[open_])
    cells = np.zeros(len(points), LUMPS["light_grid"])
    cells["ambient"][open_] = np.clip(ambient.round(), 1, 255)
    cells["directed"][open_] = np.clip(directed.round(), 0, 255)
    polar = np.arccos(np.clip(towards[:, 2], -1, 1))
    azimuth = np.arctan2(towards[:, 1], towards[:, 0])
    angles = np.stack([polar, azimuth], axis=1) * (256 / (2 * np.pi))
    cells["direction"][open_] = angles.round().astype(int) % 256
    return cells
