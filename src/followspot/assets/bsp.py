"""Quake III levels (IBSP version 46): seventeen lumps as NumPy arrays over the file's bytes.

A lump is an array of records of one dtype; `bsp_reader` makes them from a file.

Sources: Kekoa Proudfoot, "Unofficial Quake 3 Map Specs"; `qfiles.h` of ioquake3.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Mask

MAGIC = b"IBSP"
VERSION = 46

LUMPS: dict[str, np.dtype[Any]] = {
    "entities": np.dtype("u1"),
    "shaders": np.dtype([("name", "S64"), ("surface_flags", "<u4"), ("content_flags", "<u4")]),
    "planes": np.dtype([("normal", "<f4", 3), ("distance", "<f4")]),
    "nodes": np.dtype(
        [("plane", "<i4"), ("children", "<i4", 2), ("mins", "<i4", 3), ("maxs", "<i4", 3)]
    ),
    "leafs": np.dtype(
        [
            ("cluster", "<i4"),
            ("area", "<i4"),
            ("mins", "<i4", 3),
            ("maxs", "<i4", 3),
            ("first_leaf_face", "<i4"),
            ("leaf_face_count", "<i4"),
            ("first_leaf_brush", "<i4"),
            ("leaf_brush_count", "<i4"),
        ]
    ),
    "leaf_faces": np.dtype("<i4"),
    "leaf_brushes": np.dtype("<i4"),
    "models": np.dtype(
        [
            ("mins", "<f4", 3),
            ("maxs", "<f4", 3),
            ("first_face", "<i4"),
            ("face_count", "<i4"),
            ("first_brush", "<i4"),
            ("brush_count", "<i4"),
        ]
    ),
    "brushes": np.dtype([("first_side", "<i4"), ("side_count", "<i4"), ("shader", "<i4")]),
    "brush_sides": np.dtype([("plane", "<i4"), ("shader", "<i4")]),
    "vertices": np.dtype(
        [
            ("position", "<f4", 3),
            ("texcoord", "<f4", 2),
            ("lightmap_texcoord", "<f4", 2),
            ("normal", "<f4", 3),
            ("color", "u1", 4),
        ]
    ),
    "indices": np.dtype("<i4"),
    "effects": np.dtype([("name", "S64"), ("brush", "<i4"), ("visible_side", "<i4")]),
    "faces": np.dtype(
        [
            ("shader", "<i4"),
            ("effect", "<i4"),
            ("type", "<i4"),
            ("first_vertex", "<i4"),
            ("vertex_count", "<i4"),
            ("first_index", "<i4"),
            ("index_count", "<i4"),
            ("lightmap", "<i4"),
            ("lightmap_corner", "<i4", 2),
            ("lightmap_size", "<i4", 2),
            ("lightmap_origin", "<f4", 3),
            ("lightmap_axes", "<f4", (2, 3)),
            ("normal", "<f4", 3),
            ("patch_size", "<i4", 2),
        ]
    ),
    "lightmaps": np.dtype(("u1", (128, 128, 3))),
    "light_grid": np.dtype([("ambient", "u1", 3), ("directed", "u1", 3), ("direction", "u1", 2)]),
    "visibility": np.dtype("u1"),
}
"""The record of each lump, in the order of the header's directory."""

HEADER = np.dtype(
    [
        ("magic", "S4"),
        ("version", "<i4"),
        ("directory", [("offset", "<i4"), ("length", "<i4")], len(LUMPS)),
    ]
)
VISIBILITY_HEADER = np.dtype([("cluster_count", "<i4"), ("bytes_per_cluster", "<i4")])

WORLD_LIMIT = 128.0 * 1024.0
"""Largest coordinate of the level compilers and the engine, in Quake units."""

Records = NDArray[np.void]


class FaceType(IntEnum):
    """What a face's vertices mean."""

    POLYGON = 1
    PATCH = 2
    MESH = 3
    FLARE = 4


@dataclass(frozen=True, eq=False)
class BspFile:
    """One level as its file has it: Quake units, Z up, clockwise front faces.

    Every array is read-only, most are views of the file. The records' fields are those of
    `LUMPS`; the comments say what a number refers to. Runs are (first, count) pairs. All
    references are checked, so they are safe to index with, save where a negative number has a
    meaning of its own, and those to lightmaps.
    """

    source: str
    """The file's name for errors."""
    entities: tuple[dict[str, str], ...]
    """Key to value, in file order; keys in lower case, as the engine compares them."""
    shaders: Records
    """(n,) surface: what it is called and how the level treats it."""
    shader_names: tuple[str, ...]
    """The shaders' names, cleaned: lower case, forward slashes, nothing behind the NUL."""
    planes: Records
    """(n,) the points p with dot(normal, p) == distance."""
    nodes: Records
    """(n,) binary tree with node 0 as root; children in front of and behind the plane, a node's
    number or, where negative, ``~leaf``. No node has two parents: every walk down ends."""
    leafs: Records
    """(n,) convex cells; cluster -1 is solid or outside; runs of leaf_faces, leaf_brushes. Leafs
    that hang on no node hold the faces and brushes of models, and a meaningless cluster 0."""
    leaf_faces: NDArray[np.int32]
    """(n,) face numbers."""
    leaf_brushes: NDArray[np.int32]
    """(n,) brush numbers."""
    models: Records
    """(n,) 0 is the world, the others doors and the like; box, runs of faces and brushes."""
    brushes: Records
    """(n,) convex solids, the space behind all planes of their run of brush_sides."""
    brush_sides: Records
    """(n,) plane and shader."""
    vertices: Records
    """(n,) position in Quake units; all finite, except that lightmap_texcoord may hold NaN or
    infinity at the vertices of faces without lightmap."""
    indices: NDArray[np.int32]
    """(n,) relative to the first vertex of the face that uses them; faces may share runs."""
    effects: Records
    """(n,) fog volumes: shader name, brush, and the brush's side that is seen or -1."""
    faces: Records
    """(n,) see `FaceType`; effect is -1 for none, or 0 in a level without effects; lightmap is
    negative for none, and past the lump where level compilers wrote lightmaps to image files;
    patch_size is (width, height) of a patch's control points, row by row; index_count is a
    multiple of 3."""
    lightmaps: NDArray[np.uint8]
    """(n, 128, 128, 3) RGB, row 0 at texture coordinate 0."""
    light_grid: Records
    """(n,) x fastest, then y, z; direction is two angles of 256 steps to the circle."""
    cluster_count: int
    """Number of clusters."""
    cluster_visible: NDArray[np.uint8]
    """(clusters, bytes): bit c of row k, lowest bit first, is set where k may see c."""

    def visible_clusters(self, cluster: int) -> Mask:
        """Tell which clusters can be seen from a cluster.

        Args:
            cluster: Its number; -1, outside of all clusters, sees everything.

        Returns:
            (cluster_count,) bool.
        """
        if cluster < 0:
            return np.ones(self.cluster_count, dtype=np.bool_)
        bits = np.unpackbits(
            self.cluster_visible[cluster], count=self.cluster_count, bitorder="little"
        )
        return bits.view(np.bool_)
