"""From the records of a BSP file to one mesh, its materials and what can see what."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints, Mask
from followspot.assets.binary import run_members
from followspot.assets.bsp import BspFile, FaceType
from followspot.assets.entities import entity_vector, model_number
from followspot.assets.shader_script import ShaderScript
from followspot.scene import bsp_tree, deform, fog, patch, script_material, tints
from followspot.scene.baked import BakedLight, TracedLight
from followspot.scene.fog import Fog
from followspot.scene.material import Material
from followspot.scene.mesh import FACE, VERTEX, Mesh, face_boxes, face_planes
from followspot.scene.script_material import FindImage

PATCH_TOLERANCE = 1.0
"""Units by which a patch's triangles may miss the curved surface: 3 cm."""


FindScript = Callable[[str], ShaderScript | None]


@dataclass(frozen=True, eq=False)
class Visibility:
    """Which faces can be seen from where, by the level's precomputed visibility.

    Attributes:
        bsp: The level.
        level_face: (faces,) the mesh's faces as numbers of the level's faces; -1 for props'.
        everywhere: (level's faces,) those of doors and the like, of which it says nothing.
        prop_leafs: (n, 2) pairs of a prop's face, as a number of the mesh's faces, and a leaf; see
            `bsp_tree.box_leafs_to_see`.
    """

    bsp: BspFile
    level_face: Ints
    everywhere: Mask
    prop_leafs: Ints = field(default_factory=lambda: np.empty((0, 2), np.int64))
    _seen: dict[int, Mask] = field(default_factory=dict)
    _cluster_at: dict[bytes, int] = field(default_factory=dict)  # of one position, the last
    _leafs: dict[int, Mask] = field(default_factory=dict)  # likewise of one cluster

    def faces_from(self, position: Floats) -> Mask:
        """(faces,) of the mesh that may be visible from a world position in units.

        All are where the position is in a wall or outside of the level.
        """
        cluster = self._cluster(position)
        if cluster not in self._seen:
            self._seen[cluster] = self._look(position)
        return self._seen[cluster]

    def leafs_at(self, points: Floats) -> Ints:
        """(n,) numbers of the leafs that (n, 3) world points lie in."""
        return bsp_tree.point_leafs(self.bsp, points)

    def leafs_from(self, position: Floats) -> Mask:
        """(leafs + 1,) which may be visible from a world position, as of `bsp_tree.visible_leafs`.

        The one behind the last stands for everywhere.
        """
        cluster = self._cluster(position)
        if cluster not in self._leafs:
            self._leafs.clear()
            self._leafs[cluster] = np.append(bsp_tree.visible_leafs(self.bsp, position), True)
        return self._leafs[cluster]

    def _cluster(self, position: Floats) -> int:
        """That of a position; a frame asks more than once."""
        key = position.tobytes()
        if key not in self._cluster_at:
            self._cluster_at.clear()
            leaf = bsp_tree.point_leafs(self.bsp, position[np.newaxis])[0]
            self._cluster_at[key] = int(self.bsp.leafs["cluster"][leaf])
        return self._cluster_at[key]

    def _look(self, position: Floats) -> Mask:
        visible = self.leafs_from(position)
        leafs = self.bsp.leafs[visible[:-1]]
        seen = np.append(self.everywhere, False)  # the last one is what props count as
        members = run_members(leafs["first_leaf_face"], leafs["leaf_face_count"])
        seen[self.bsp.leaf_faces[members]] = True
        result = seen[self.level_face]
        face, leaf = self.prop_leafs.T
        result[face[visible[leaf]]] = True
        return np.asarray(result)


@dataclass(frozen=True, eq=False)
class Level:
    """A level's geometry, ready to be lit.

    Attributes:
        bsp: The file's records.
        mesh: Everything that is drawn, brush models at their entities' origins.
        materials: The mesh's faces name them by number.
        visibility: What can be seen from where.
        baked: What its compiler has lit it by, if it has one.
        fogs: What hangs in it.
        traced: Light that has been traced in place of `baked`; `Mesh.baked` is of it then.
    """

    bsp: BspFile
    mesh: Mesh
    materials: tuple[Material, ...]
    visibility: Visibility
    baked: BakedLight | None = None
    fogs: tuple[Fog, ...] = ()
    traced: TracedLight | None = None


def build(bsp: BspFile, find_script: FindScript, find_image: FindImage, tolerance: float) -> Level:
    """Assemble a level.

    Args:
        bsp: Its records.
        find_script: A shader's name to its script, if it has one.
        find_image: A shader's or stage's image name to its path, if there is one.
        tolerance: Units by which the triangles of a patch may miss the curve.
    """
    scripts = [find_script(name) for name in bsp.shader_names]
    drawn = np.array(
        [script_material.is_drawn(bsp, number, script) for number, script in enumerate(scripts)],
        bool,
    )
    used = np.zeros(len(scripts), bool)
    used[bsp.faces["shader"]] = True
    found = {
        int(number): script_material.from_script(
            bsp.shader_names[number], scripts[number], find_image
        )
        for number in np.flatnonzero(drawn & used)
    }
    order = sorted(found, key=lambda number: (found[number].order, number))
    material_of_shader = np.full(len(scripts), -1, np.int32)
    material_of_shader[order] = np.arange(len(order))

    has_triangles = (bsp.faces["index_count"] > 0) | (bsp.faces["type"] == FaceType.PATCH)
    wanted = material_of_shader[bsp.faces["shader"]] >= 0
    wanted &= has_triangles & (bsp.faces["type"] != FaceType.FLARE)
    offsets = _model_offsets(bsp)
    baked = BakedLight(bsp)
    parts = [_polygons(baked, wanted, offsets), _patches(baked, wanted, offsets, tolerance)]
    # In a level, where vertices can have it, a script's colour is theirs.
    materials = tuple(
        replace(found[number], is_tinted=found[number].color is not None) for number in order
    )
    mesh, level_face = _join(parts, material_of_shader[bsp.faces["shader"]])
    colors = np.concatenate([part.colors for part in parts])
    mesh = replace(mesh, tints=tints.of_level(mesh, colors, materials))
    mesh = deform.deformed(mesh, [each.deforms for each in materials])

    visibility = Visibility(bsp, level_face, _seen_from_everywhere(bsp))
    return Level(bsp, mesh, materials, visibility, baked, fog.volumes(bsp, find_script))


def _seen_from_everywhere(bsp: BspFile) -> Mask:
    """(faces,) those that precomputed visibility says nothing of.

    The faces of brush models lie in leafs of their own, which hang on no node of the tree and
    whose cluster number means nothing; a few faces of some levels lie in no leaf at all.
    """
    everywhere = np.ones(len(bsp.faces), bool)
    everywhere[bsp.leaf_faces] = False
    world = bsp.models[0]
    everywhere[: world["first_face"]] = True
    everywhere[world["first_face"] + world["face_count"] :] = True
    return everywhere


_VERTEX = np.dtype([*VERTEX.descr, ("baked", "<f4", 5)])
"""With a row of `Mesh.baked`."""


@dataclass(frozen=True, eq=False)
class _Part:
    """Triangles of some of the level's faces: vertices, indices, and each face's run of them.

    `vertices` are of _VERTEX; `colors` are their own RGBA, (v, 4) from 0 to 1.
    """

    vertices: NDArray[np.void]
    colors: NDArray[np.float32]
    indices: NDArray[np.uint32]
    level_face: Ints
    first_index: Ints
    index_count: Ints


def _model_offsets(bsp: BspFile) -> NDArray[np.float32]:
    """(faces, 3) units by which a face moves: the origin of the entity that places its model."""
    origins = np.zeros((len(bsp.models), 3), np.float32)
    for entity in bsp.entities:
        number, origin = model_number(bsp, entity), entity_vector(entity, "origin")
        if number is not None and origin is not None:
            origins[number] = origin
    offsets = np.zeros((len(bsp.faces), 3), np.float32)
    for model, moved in zip(bsp.models, origins, strict=True):
        first = model["first_face"]
        offsets[first : first + model["face_count"]] = moved
    return offsets


def _moved_vertices(
    baked: BakedLight, faces: Ints, offsets: NDArray[np.float32]
) -> tuple[NDArray[np.void], NDArray[np.float32], Ints]:
    """The vertices of some faces at their places, their colours, and where each face's begin."""
    bsp = baked.bsp
    count = bsp.faces["vertex_count"][faces].astype(np.int64)
    source = run_members(bsp.faces["first_vertex"][faces], count)
    vertices = np.empty(len(source), _VERTEX)
    for name in ("position", "normal", "texcoord"):
        vertices[name] = bsp.vertices[name][source]
    vertices["position"] += np.repeat(offsets[faces], count, axis=0)
    vertices["baked"] = baked.at_vertices(source, np.repeat(faces, count))
    colors = bsp.vertices["color"][source].astype(np.float32) / np.float32(255)
    return vertices, colors, np.cumsum(count) - count


def _polygons(baked: BakedLight, wanted: Mask, offsets: NDArray[np.float32]) -> _Part:
    """Polygons and triangle soups, whose triangles are in the file."""
    bsp = baked.bsp
    faces = np.flatnonzero(wanted & (bsp.faces["type"] != FaceType.PATCH))
    vertices, colors, starts = _moved_vertices(baked, faces, offsets)
    count = bsp.faces["index_count"][faces].astype(np.int64)
    in_face = bsp.indices[run_members(bsp.faces["first_index"][faces], count)]
    indices = (in_face + np.repeat(starts, count)).astype(np.uint32)
    _renormalise(vertices, indices)
    return _Part(vertices, colors, indices, faces, np.cumsum(count) - count, count)


def _renormalise(vertices: NDArray[np.void], indices: NDArray[np.uint32]) -> None:
    """Unit normals in place; where a file has none, that of a triangle at the vertex."""
    length = np.linalg.norm(vertices["normal"], axis=1, keepdims=True)
    vertices["normal"] /= np.where(length > 1e-6, length, 1)
    lacks = length[:, 0] <= 1e-6
    if lacks.any():
        triangles = indices.reshape(-1, 3)
        a, b, c = (vertices["position"][triangles[:, k]].astype(np.float64) for k in range(3))
        normal = np.cross(c - a, b - a)  # clockwise front
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        given = np.tile([0.0, 0.0, 1.0], (len(vertices), 1))
        given[triangles.ravel()] = np.repeat(normal, 3, axis=0)
        vertices["normal"][lacks] = given[lacks]


def _patches(
    baked: BakedLight, wanted: Mask, offsets: NDArray[np.float32], tolerance: float
) -> _Part:
    """Bezier patches, cut into triangles; all of one has the mean colour of its control points."""
    bsp = baked.bsp
    faces = np.flatnonzero(wanted & (bsp.faces["type"] == FaceType.PATCH))
    control, colors, starts = _moved_vertices(baked, faces, offsets)
    made = patch.tessellate(control, starts, bsp.faces["patch_size"][faces], tolerance)
    if len(faces):
        control_count = np.diff(starts, append=len(colors))[:, np.newaxis]
        vertex_count = np.diff(made.first_vertex, append=len(made.vertices))
        colors = np.repeat(np.add.reduceat(colors, starts) / control_count, vertex_count, axis=0)
    colors = colors.astype(np.float32)
    return _Part(made.vertices, colors, made.indices, faces, made.first_index, made.index_count)


def _join(parts: list[_Part], material_of_face: NDArray[np.int32]) -> tuple[Mesh, Ints]:
    """One mesh with its faces sorted by material, and the level's number of each of them."""
    given = np.concatenate([part.vertices for part in parts])
    vertices = np.empty(len(given), VERTEX)
    for name in VERTEX.names or ():
        vertices[name] = given[name]
    shift = np.cumsum([0, *(len(part.vertices) for part in parts)])
    indices = np.concatenate(
        [part.indices + np.uint32(s) for part, s in zip(parts, shift, strict=False)]
    )
    shift = np.cumsum([0, *(len(part.indices) for part in parts)])
    first = np.concatenate([p.first_index + s for p, s in zip(parts, shift, strict=False)])
    count = np.concatenate([part.index_count for part in parts])
    level_face = np.concatenate([part.level_face for part in parts])

    keep = np.flatnonzero(count > 0)
    order = keep[np.lexsort((level_face[keep], material_of_face[level_face[keep]]))]
    count, level_face = count[order], level_face[order]
    indices = indices[run_members(first[order], count)]
    faces = np.zeros(len(order), FACE)
    faces["index_count"] = count
    faces["first_index"] = np.cumsum(count) - count
    faces["material"] = material_of_face[level_face]
    if len(faces):
        runs = vertices["position"], indices, faces["first_index"]
        faces["mins"], faces["maxs"] = face_boxes(*runs)
        faces["normal"], faces["distance"] = face_planes(*runs)
    baked = np.ascontiguousarray(given["baked"])
    return Mesh(vertices, indices, faces, baked=baked), level_face
