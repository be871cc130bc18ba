"""Faces as the file has them, made from the builder's shapes."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints
from followspot.assets.bsp import FaceType
from followspot.levelbuilder.brush import Side
from followspot.levelbuilder.material import Material
from followspot.levelbuilder.mesh import Mesh, triangulate
from followspot.levelbuilder.patches import Patch, evaluate
from followspot.levelbuilder.projection import apply

BY_VERTEX = -3
"""Lightmap index of faces that are lit by their vertices' colours."""


@dataclass(eq=False)
class Face:
    """One entry of the face lump with its vertices.

    Attributes:
        kind: Polygon, patch or mesh.
        material: Its material.
        points: (n, 3) float64 world units; a patch's control points row by row.
        st: (n, 2) float64 texture coordinates.
        normals: (n, 3) float64 unit normals.
        triangles: (m, 3) indices into the points, clockwise; none for a patch.
        patch_size: Columns and rows of a patch, else (0, 0).
        colors: (n, 4) uint8 vertex colours.
        lightmap: Page, or `BY_VERTEX`.
        lightmap_st: (n, 2) float64 lightmap coordinates, 0 to 1 over the page.
        lightmap_rect: x, y, width and height on the page, in luxels.
        lightmap_origin: World position of the first luxel's centre, (3,) float64.
        lightmap_axes: Step from luxel to luxel along the two axes, (2, 3) float64 units.
    """

    kind: FaceType
    material: Material
    points: Floats
    st: Floats
    normals: Floats
    triangles: Ints
    patch_size: tuple[int, int] = (0, 0)
    colors: NDArray[np.uint8] = field(init=False)
    lightmap: int = BY_VERTEX
    lightmap_st: Floats = field(init=False)
    lightmap_rect: tuple[int, int, int, int] = (0, 0, 0, 0)
    lightmap_origin: Floats = field(default_factory=lambda: np.zeros(3))
    lightmap_axes: Floats = field(default_factory=lambda: np.zeros((2, 3)))

    def __post_init__(self) -> None:
        self.colors = np.full((len(self.points), 4), 255, np.uint8)
        self.lightmap_st = np.zeros((len(self.points), 2))


def polygon_face(winding: Floats, side: Side) -> Face:
    """Return the face of a convex polygon on a brush's side."""
    st = apply(side.texture, winding)
    st -= np.floor(st.mean(axis=0))  # near zero, where float32 is fine
    normals = np.tile(side.normal, (len(winding), 1))
    return Face(FaceType.POLYGON, side.material, winding, st, normals, triangulate(winding))


def patch_face(patch: Patch) -> Face:
    """Return the face of a patch, with the normals of its surface at the controls' parameters."""
    rows, columns = patch.points.shape[:2]
    normals = patch_normals(patch.points, np.arange(rows) / 2, np.arange(columns) / 2)
    return Face(
        FaceType.PATCH,
        patch.material,
        patch.points.reshape(-1, 3),
        patch.st.reshape(-1, 2),
        normals.reshape(-1, 3),
        np.empty((0, 3), np.int64),
        (columns, rows),
    )


def patch_normals(controls: Floats, rows: Floats, columns: Floats) -> Floats:
    """Return unit normals, (m, n, 3), at parameters of a grid of controls as in `evaluate`.

    They come from differences over a small step inside the grid, so that a point where an edge
    has shrunk to nothing still has a normal.
    """
    step = 1e-3
    inner = [
        np.clip(parameters, step, (count - 1) / 2 - step)
        for parameters, count in zip((rows, columns), controls.shape, strict=False)
    ]
    rows, columns = inner
    upwards = evaluate(controls, rows + step, columns) - evaluate(controls, rows - step, columns)
    rightwards = evaluate(controls, rows, columns + step) - evaluate(controls, rows, columns - step)
    normals = np.cross(rightwards, upwards)
    unit: Floats = normals / np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-12)
    return unit


def mesh_face(mesh: Mesh) -> Face:
    """Return the face of a loose mesh."""
    return Face(FaceType.MESH, mesh.material, mesh.points, mesh.st, mesh.normals, mesh.triangles)
