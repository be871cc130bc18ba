"""Props in a level's mesh, where they are culled, shaded and shadowed as walls are.

They stand in the shadow map that is kept, and are there for whatever looks at the mesh: floors,
camera paths, the ray tracer.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Ints
from followspot.assets.binary import run_members
from followspot.scene import bsp_tree
from followspot.scene.level import Level, Visibility
from followspot.scene.mesh import FACE, Mesh, face_boxes, face_planes
from followspot.scene.props import Prop, PropSurface


def with_props(level: Level, props: Sequence[Prop]) -> Level:
    """A level with props in its mesh, one face a surface.

    A surface is seen from wherever one of the leafs is seen that its box reaches into; from
    everywhere, if all of those are solid or outside of the level.
    """
    surfaces = [surface for prop in props for surface in prop.surfaces]
    if not surfaces:
        return level
    mesh = level.mesh
    found = list(dict.fromkeys([*level.materials, *(s.material for s in surfaces)]))
    materials = sorted(found, key=lambda material: material.order)
    number = {material: k for k, material in enumerate(materials)}

    vertices = np.concatenate([mesh.vertices, *(s.vertices for s in surfaces)])
    starts = np.cumsum([len(mesh.vertices), *(len(s.vertices) for s in surfaces)])
    indices = np.concatenate(
        [mesh.indices, *(s.indices + np.uint32(k) for s, k in zip(surfaces, starts, strict=False))]
    )
    faces = np.zeros(len(surfaces), FACE)
    faces["index_count"] = [len(s.indices) for s in surfaces]
    faces["first_index"] = len(mesh.indices) + np.cumsum(faces["index_count"])
    faces["first_index"] -= faces["index_count"]
    faces["material"] = [number[s.material] for s in surfaces]
    first = faces["first_index"] - len(mesh.indices)
    runs = vertices["position"], indices[len(mesh.indices) :], first
    faces["mins"], faces["maxs"] = face_boxes(*runs)
    faces["normal"], faces["distance"] = face_planes(*runs)

    own = mesh.faces.copy()
    own["material"] = np.array([number[m] for m in level.materials], np.int32)[own["material"]]
    faces = np.concatenate([own, faces])
    order = np.argsort(faces["material"], kind="stable")
    faces = faces[order]
    indices = indices[run_members(faces["first_index"], faces["index_count"])]
    faces["first_index"] = np.cumsum(faces["index_count"]) - faces["index_count"]
    joined = Mesh(
        vertices,
        indices,
        faces,
        _tints(mesh, surfaces),
        _sprites(mesh, len(vertices)),
        _baked(level, vertices),
    )
    visibility = _visibility(level, joined, order)
    return replace(level, mesh=joined, materials=tuple(materials), visibility=visibility)


def _tints(mesh: Mesh, surfaces: Sequence[PropSurface]) -> NDArray[np.float32] | None:
    if mesh.tints is None and all(surface.tints is None for surface in surfaces):
        return None
    counts = [len(mesh.vertices), *(len(surface.vertices) for surface in surfaces)]
    given = [mesh.tints, *(surface.tints for surface in surfaces)]
    return np.concatenate(
        [
            np.ones((count, 4), np.float32) if tints is None else tints
            for count, tints in zip(counts, given, strict=True)
        ]
    )


def _sprites(mesh: Mesh, vertices: int) -> NDArray[np.float32] | None:
    """The level's, of a mesh with so many vertices: props turn to nobody."""
    if mesh.sprites is None:
        return None
    return np.pad(mesh.sprites, ((0, vertices - len(mesh.vertices)), (0, 0)))


def _baked(level: Level, vertices: NDArray[np.void]) -> NDArray[np.float32] | None:
    """What lights the level's vertices, and props' behind them by the places they are at."""
    if level.baked is None or level.mesh.baked is None:
        return None
    places = vertices["position"][len(level.mesh.vertices) :].astype(np.float64)
    return np.concatenate([level.mesh.baked, level.baked.at_points(places)])


def _visibility(level: Level, mesh: Mesh, order: Ints) -> Visibility:
    """What sees what in a level whose faces, and props' behind them, come in a new order."""
    bsp, before = level.bsp, level.visibility
    count = len(order) - len(before.level_face)
    level_face = np.concatenate([before.level_face, np.full(count, -1)])[order]
    prop_faces = np.flatnonzero(level_face < 0)
    mins, maxs = (mesh.faces[name][prop_faces] for name in ("mins", "maxs"))
    box, leaf = bsp_tree.box_leafs_to_see(bsp, mins, maxs)
    pairs = np.stack([prop_faces[box], leaf], axis=1)
    return Visibility(bsp, level_face, before.everywhere, pairs)
