"""From a level to a BSP file, step by step."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats
from followspot.errors import UsageError
from followspot.levelbuilder.brush import Brush
from followspot.levelbuilder.bsp_tree import (
    Leaf,
    Node,
    build_tree,
    flood,
    leafs_of_points,
    pieces_in_leafs,
)
from followspot.levelbuilder.csg import Fragment, merge_all, visible_fragments
from followspot.levelbuilder.entities import Entity, entity_lump
from followspot.levelbuilder.faces import Face, mesh_face, patch_face, polygon_face
from followspot.levelbuilder.level import Level
from followspot.levelbuilder.lightmap import bake, bake_grid, occluders
from followspot.levelbuilder.lights import find_lights
from followspot.levelbuilder.lumps import Model, gather, model_box
from followspot.levelbuilder.mesh import Mesh, weld_t_junctions
from followspot.levelbuilder.patches import Patch
from followspot.levelbuilder.winding import area
from followspot.levelbuilder.writer import bsp_bytes


@dataclass(frozen=True)
class _Shown:
    """A visible polygon and the leafs that it can be seen from."""

    fragment: Fragment
    leafs: list[Leaf]


def compile_level(level: Level) -> bytes:
    """Compile a level into the bytes of a BSP file.

    Raises:
        UsageError: The level has no structural brush or nothing to see, or it leaks.
    """
    brushes = [part for part in level.parts if isinstance(part, Brush)]
    structural = [brush for brush in brushes if brush.structural]
    tree = build_tree(visible_fragments(structural), structural)
    flood(tree, level.origins())
    for index, brush in enumerate(brushes):
        corners = np.concatenate([side.winding for side in brush.sides])
        for leaf in leafs_of_points(tree, corners):
            leaf.brushes.append(index)

    models = [Model(_world_faces(tree, level, brushes), brushes)]
    if not any(face.material.lightmapped for face in models[0].faces):
        raise UsageError("a level needs at least one surface that can be seen and lit")
    entities = []
    for item in level.entities:
        keys = dict(item.keys)
        if item.brushes:
            keys["model"] = f"*{len(models)}"
            models.append(Model(_polygons(visible_fragments(item.brushes)), item.brushes))
        entities.append(Entity(keys))
    materials = [face.material for face in models[0].faces]
    lights = find_lights(level.entities, list(dict.fromkeys(materials)), level.ambient)
    pages = bake([face for model in models for face in model.faces], lights)
    mins, maxs = model_box(models[0])
    grid = bake_grid(tree, mins, maxs, lights, occluders(models[0].faces))
    lumps = gather(tree, models)
    lumps["lightmaps"], lumps["light_grid"] = pages.tobytes(), grid.tobytes()
    lumps["entities"] = entity_lump(entities)
    return bsp_bytes(lumps)


def _world_faces(tree: Node, level: Level, brushes: Sequence[Brush]) -> list[Face]:
    """Return the world's faces, and note each in the leafs that it lies in."""
    shown = [
        piece
        for fragment in visible_fragments(brushes)
        if fragment.side.material.drawn
        for piece in _seen_from_inside(tree, fragment)
    ]
    faces = _polygons([piece.fragment for piece in shown])
    places = [piece.leafs for piece in shown]
    for part in level.parts:
        if isinstance(part, Patch):
            faces.append(patch_face(part))
            places.append(_leafs_of_hulls(tree, _pieces(part)))
        elif isinstance(part, Mesh):
            faces.append(mesh_face(part))
            places.append(_leafs_of_hulls(tree, part.points[part.triangles]))
    kept: list[Face] = []
    for face, place in zip(faces, places, strict=True):
        for leaf in place:
            leaf.faces.append(len(kept))
        if place:
            kept.append(face)
    return kept


def _polygons(fragments: Sequence[Fragment]) -> list[Face]:
    drawn = [fragment for fragment in fragments if fragment.side.material.drawn]
    if not drawn:
        return []
    windings = weld_t_junctions([fragment.winding for fragment in drawn])
    return [
        polygon_face(winding, fragment.side)
        for winding, fragment in zip(windings, drawn, strict=True)
    ]


def _seen_from_inside(tree: Node, fragment: Fragment) -> list[_Shown]:
    """Return the fragment, or what of it borders on the inside of the level."""
    pieces = pieces_in_leafs(tree, fragment.winding, fragment.side.normal)
    seen = [(leaf, piece) for leaf, piece in pieces if not leaf.solid]
    if not seen:
        return []
    missing = area(fragment.winding) - sum(area(piece) for _, piece in seen)
    if missing < 0.01 * area(fragment.winding) + 1.0:
        return [_Shown(fragment, _unique([leaf for leaf, _ in seen]))]
    shown = []
    for winding in merge_all([piece for _, piece in seen]):
        part = Fragment(winding, fragment.side, fragment.brush)
        found = pieces_in_leafs(tree, winding, fragment.side.normal)
        shown.append(_Shown(part, _unique([leaf for leaf, _ in found if not leaf.solid])))
    return shown


def _pieces(patch: Patch) -> Floats:
    """Return the control hulls of a patch's biquadratic pieces, (n, 9, 3)."""
    windows = np.lib.stride_tricks.sliding_window_view(patch.points, (3, 3), axis=(0, 1))
    return windows[::2, ::2].transpose(0, 1, 3, 4, 2).reshape(-1, 9, 3)


def _leafs_of_hulls(tree: Node, hulls: Floats) -> list[Leaf]:
    """Return the open leafs that the convex hulls of point sets, (n, k, 3), may touch."""
    return _unique(
        [leaf for hull in hulls for leaf in leafs_of_points(tree, hull) if not leaf.solid]
    )


def _unique(found: list[Leaf]) -> list[Leaf]:
    return list(dict.fromkeys(found))
