"""What a line of sight crosses: the level's triangles and the characters'."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Mask
from followspot.assets.shader_values import Sides
from followspot.scene.deform import at_time
from followspot.scene.figure import FigurePart
from followspot.scene.material import Material
from followspot.scene.mesh import FACE, VERTEX, Mesh
from followspot.scene.scene import Scene
from followspot.scene.triangle_tree import TriangleTree
from followspot.spaces import Vec3

MARGIN = 0.01
"""Units by which boxes are larger, so that lines within flat ones meet them."""


@dataclass(frozen=True, eq=False)
class Crossing:
    """A triangle where a line crosses it, on a side that is drawn.

    Attributes:
        fraction: Of the line, in (0, 1).
        material: What the triangle is made of.
        face: Number of the mesh's face, if it belongs to the level.
        character: Name of the figure, if it belongs to a character.
        corners: (3,) of VERTEX in world space; of what moves in the level as it rests, which is
            where light finds it.
        weights: (3,) of the corners at the crossing.
    """

    fraction: float
    material: Material
    face: int | None
    character: str | None
    corners: NDArray[np.void]
    weights: Floats


def crossings(scene: Scene, start: Vec3, end: Vec3, seconds: float = 0.0) -> list[Crossing]:
    """All triangles that a line crosses, in order; cut-out ones also where they have holes.

    Args:
        scene: Level and characters.
        start: (3,) world units.
        end: (3,) world units.
        seconds: The time, by which characters and surfaces move; sprites do not turn.
    """
    found = [*_of_level(scene, start, end, seconds), *_of_characters(scene, start, end, seconds)]
    return sorted(found, key=lambda crossing: crossing.fraction)


def _of_level(scene: Scene, start: Vec3, end: Vec3, seconds: float) -> Iterator[Crossing]:
    mesh = scene.mesh
    drawn = at_time(mesh, [material.deforms for material in scene.materials], seconds)
    near = _boxes_met(mesh.faces["mins"], mesh.faces["maxs"], start, end)
    chosen = np.repeat(near, mesh.faces["index_count"] // 3)
    for triangle, fraction, weights, from_front in _met(drawn, chosen, start, end):
        face = int(np.searchsorted(mesh.faces["first_index"], 3 * triangle, side="right")) - 1
        material = scene.materials[mesh.faces["material"][face]]
        if _is_drawn(material, from_front=from_front):
            corners = _corners(mesh, triangle)
            yield Crossing(fraction, material, face, None, corners, weights)


def _of_characters(scene: Scene, start: Vec3, end: Vec3, seconds: float) -> Iterator[Crossing]:
    crowd = scene.crowd
    if not len(crowd):
        return
    places = crowd.places(seconds)
    way = end - start
    share = np.clip((places[:, :3] - start) @ way / (way @ way), 0, 1)[:, np.newaxis]
    apart = np.linalg.norm(start + share * way - places[:, :3], axis=1)
    near = np.flatnonzero(apart <= crowd.radius)
    for number, rows in zip(near.tolist(), crowd.instances(seconds, places, near), strict=True):
        figure = crowd.characters[number].figure
        for part in figure.parts:
            mesh = _posed(part, rows[part.slot])
            chosen = np.ones(mesh.triangle_count, bool)
            for triangle, fraction, weights, from_front in _met(mesh, chosen, start, end):
                run = next(r for r in part.runs if r.first <= 3 * triangle < r.first + r.count)
                if _is_drawn(run.material, from_front=from_front):
                    corners = _corners(mesh, triangle)
                    yield Crossing(fraction, run.material, None, figure.name, corners, weights)


def _boxes_met(
    mins: NDArray[np.float32], maxs: NDArray[np.float32], start: Vec3, end: Vec3
) -> Mask:
    """(n,) which boxes a line meets (Kay and Kajiya, "Ray Tracing Complex Scenes", 1986)."""
    way = end - start
    per_way = 1 / np.where(np.abs(way) < 1e-30, 1e-30, way)
    a, b = (mins - MARGIN - start) * per_way, (maxs + MARGIN - start) * per_way
    enter, leave = np.minimum(a, b).max(axis=1), np.maximum(a, b).min(axis=1)
    return np.asarray((enter <= leave) & (leave >= 0) & (enter <= 1))


def _met(
    mesh: Mesh, chosen: Mask, start: Vec3, end: Vec3
) -> Iterator[tuple[int, float, Floats, bool]]:
    """Triangle, fraction of the line, weights and whether it comes from the front."""
    tree = TriangleTree(mesh, chosen)
    for hits in tree.crossings(start[np.newaxis], end[np.newaxis]):
        yield from zip(
            hits.triangle.tolist(),
            hits.fraction.tolist(),
            hits.weights,
            hits.from_front.tolist(),
            strict=True,
        )


def _is_drawn(material: Material, *, from_front: bool) -> bool:
    return material.sides is Sides.BOTH or (material.sides is Sides.FRONT) == from_front


def _corners(mesh: Mesh, triangle: int) -> NDArray[np.void]:
    return mesh.vertices[mesh.indices[3 * triangle : 3 * triangle + 3]]


def _posed(part: FigurePart, rows: NDArray[np.float32]) -> Mesh:
    """A part as common/object.glsl poses it, from its four rows of `Crowd.instances`."""
    count = part.vertex_count
    before, behind = (int(first) // max(count, 1) for first in rows[3, :2])
    blend = rows[3, 2]
    vertices = np.zeros(count, VERTEX)
    position, normal = (
        (keys[before] + (keys[behind] - keys[before]) * blend) @ rows[:3, :3].T
        for keys in (part.positions, part.normals)
    )
    vertices["position"] = position + rows[:3, 3]
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    vertices["normal"] = normal / np.maximum(length, 1e-6)
    vertices["texcoord"] = part.texcoords
    return Mesh(vertices, part.indices, np.empty(0, FACE))
