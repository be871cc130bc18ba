"""The compiled level as lumps: shared tables filled, indices given out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats
from followspot.assets.bsp import LUMPS, FaceType
from followspot.levelbuilder.brush import Brush
from followspot.levelbuilder.bsp_tree import Node, leafs, nodes
from followspot.levelbuilder.faces import Face
from followspot.levelbuilder.material import Material
from followspot.levelbuilder.writer import PlaneTable, ShaderTable, all_visible, runs


@dataclass(frozen=True)
class Model:
    """Model 0, the world, or a brush model: its faces and its brushes."""

    faces: list[Face]
    brushes: list[Brush]


def gather(tree: Node, models: Sequence[Model]) -> dict[str, bytes]:
    """Return every lump but entities, lightmaps and light grid.

    Args:
        tree: The world's tree, its leafs filled with indices into the first model.
        models: The world and the brush models.
    """
    planes, shaders = PlaneTable(), ShaderTable()
    faces = [face for model in models for face in model.faces]
    brushes = [brush for model in models for brush in model.brushes]
    lumps = _face_lumps(faces, shaders)
    lumps |= _brush_lumps(brushes, planes, shaders)
    lumps |= _tree_lumps(tree, planes)
    lumps["models"] = _model_lump(models)
    lumps["planes"] = planes.lump()
    lumps["shaders"] = shaders.lump()
    return lumps


def _face_lumps(faces: Sequence[Face], shaders: ShaderTable) -> dict[str, bytes]:
    rows = np.zeros(len(faces), LUMPS["faces"])
    rows["shader"] = [shaders.index(face.material) for face in faces]
    rows["effect"] = -1
    rows["type"] = [face.kind for face in faces]
    rows["vertex_count"] = [len(face.points) for face in faces]
    rows["first_vertex"] = runs(rows["vertex_count"])
    rows["index_count"] = [face.triangles.size for face in faces]
    rows["first_index"] = runs(rows["index_count"])
    rows["lightmap"] = [face.lightmap for face in faces]
    rects = np.array([face.lightmap_rect for face in faces])
    rows["lightmap_corner"], rows["lightmap_size"] = rects[:, :2], rects[:, 2:]
    rows["lightmap_axes"] = [_lightmap_axes(face) for face in faces]
    rows["normal"] = [
        np.zeros(3) if face.kind == FaceType.PATCH else face.normals[0] for face in faces
    ]
    rows["lightmap_origin"] = [face.lightmap_origin for face in faces]
    rows["patch_size"] = [face.patch_size for face in faces]
    vertices = np.zeros(int(rows["vertex_count"].sum()), LUMPS["vertices"])
    vertices["position"] = np.concatenate([face.points for face in faces])
    vertices["texcoord"] = np.concatenate([face.st for face in faces])
    vertices["lightmap_texcoord"] = np.concatenate([face.lightmap_st for face in faces])
    vertices["normal"] = np.concatenate([face.normals for face in faces])
    vertices["color"] = np.concatenate([face.colors for face in faces])
    indices = np.concatenate([face.triangles.reshape(-1) for face in faces])
    return {
        "faces": rows.tobytes(),
        "vertices": vertices.tobytes(),
        "indices": indices.astype(LUMPS["indices"]).tobytes(),
    }


def _lightmap_axes(face: Face) -> Floats:
    """Return the lightmap's axes; a patch keeps the box there that rules its level of detail."""
    if face.kind == FaceType.PATCH:
        return np.stack([face.points.min(axis=0), face.points.max(axis=0)])
    return face.lightmap_axes


def _brush_lumps(
    brushes: Sequence[Brush], planes: PlaneTable, shaders: ShaderTable
) -> dict[str, bytes]:
    sides = [_collision_sides(brush) for brush in brushes]
    rows = np.zeros(len(brushes), LUMPS["brushes"])
    rows["side_count"] = [len(own) for own in sides]
    rows["first_side"] = runs(rows["side_count"])
    rows["shader"] = [shaders.index(brush.material) for brush in brushes]
    side_rows = [
        (planes.index(normal, dist), shaders.index(material))
        for own in sides
        for normal, dist, material in own
    ]
    return {
        "brushes": rows.tobytes(),
        "brush_sides": np.array(side_rows, LUMPS["brush_sides"]).tobytes(),
    }


def _collision_sides(brush: Brush) -> list[tuple[Floats, float, Material]]:
    """Return the brush's planes, the six of its box first, in the order -x +x -y +y -z +z.

    The game reads a brush's box off its first six sides; and it sweeps boxes through the level,
    for which a slanted brush needs the planes of its box (bevels) lest corners catch on nothing.
    """
    own = {tuple(np.round(side.normal, 6) + 0.0): side for side in brush.sides}
    found = []
    for axis in range(3):
        for sign in (-1.0, 1.0):
            normal = np.zeros(3)
            normal[axis] = sign
            side = own.pop(tuple(normal + 0.0), None)
            dist = float(brush.maxs[axis] if sign > 0 else -brush.mins[axis])
            found.append((normal, dist, side.material if side else brush.material))
    return found + [(side.normal, side.dist, side.material) for side in own.values()]


def _tree_lumps(tree: Node, planes: PlaneTable) -> dict[str, bytes]:
    all_nodes, all_leafs = nodes(tree), leafs(tree)
    number = {id(node): i for i, node in enumerate(all_nodes)}
    number |= {id(leaf): -1 - i for i, leaf in enumerate(all_leafs)}
    node_rows = np.zeros(len(all_nodes), LUMPS["nodes"])
    node_rows["plane"] = [planes.index(node.normal, node.dist) for node in all_nodes]
    node_rows["children"] = [[number[id(node.front)], number[id(node.back)]] for node in all_nodes]
    rows = np.zeros(len(all_leafs), LUMPS["leafs"])
    for table, cells in ((node_rows, all_nodes), (rows, all_leafs)):
        table["mins"] = np.floor([cell.mins for cell in cells])
        table["maxs"] = np.ceil([cell.maxs for cell in cells])
    open_ = np.array([not leaf.solid for leaf in all_leafs])
    rows["cluster"] = np.where(open_, np.cumsum(open_) - 1, -1)
    rows["area"] = np.where(open_, 0, -1)
    rows["leaf_face_count"] = [len(leaf.faces) for leaf in all_leafs]
    rows["first_leaf_face"] = runs(rows["leaf_face_count"])
    rows["leaf_brush_count"] = [len(leaf.brushes) for leaf in all_leafs]
    rows["first_leaf_brush"] = runs(rows["leaf_brush_count"])
    leaf_faces = [face for leaf in all_leafs for face in leaf.faces]
    leaf_brushes = [brush for leaf in all_leafs for brush in leaf.brushes]
    return {
        "nodes": node_rows.tobytes(),
        "leafs": rows.tobytes(),
        "leaf_faces": np.array(leaf_faces, LUMPS["indices"]).tobytes(),
        "leaf_brushes": np.array(leaf_brushes, LUMPS["indices"]).tobytes(),
        "visibility": all_visible(int(open_.sum())),
    }


def model_box(model: Model) -> tuple[Floats, Floats]:
    """Return the least and greatest corner of a model's brushes and faces, (3,) each."""
    corners = [corner for brush in model.brushes for corner in (brush.mins, brush.maxs)]
    points = np.concatenate([np.array(corners), *(face.points for face in model.faces)])
    return points.min(axis=0), points.max(axis=0)


def _model_lump(models: Sequence[Model]) -> bytes:
    rows = np.zeros(len(models), LUMPS["models"])
    rows["mins"], rows["maxs"] = np.array([model_box(model) for model in models]).swapaxes(0, 1)
    rows["face_count"] = [len(model.faces) for model in models]
    rows["first_face"] = runs(rows["face_count"])
    rows["brush_count"] = [len(model.brushes) for model in models]
    rows["first_brush"] = runs(rows["brush_count"])
    return rows.tobytes()
