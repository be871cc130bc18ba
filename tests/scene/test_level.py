"""From a file's records to the mesh: what is drawn, where it stands, what sees it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from followspot.assets.bsp import LUMPS, BspFile, FaceType
from followspot.assets.shader_parser import find_entries
from followspot.assets.surface_flags import Surface
from followspot.scene import level
from followspot.scene.bsp_tree import visible_leafs
from followspot.scene.material import Layer, Material
from synthetic import open_bsp

SQUARE = np.array([(-8, -8, 0), (-8, 8, 0), (8, 8, 0), (8, -8, 0)], np.float32)


def records(lump: str, **fields: Any) -> NDArray[Any]:
    """Records of a lump from columns; what is not given is zero."""
    made = np.zeros(len(next(iter(fields.values()))), LUMPS[lump])
    for name, values in fields.items():
        made[name] = values
    return made


def squares(centres: Any, shader: Any, flags: Any, **fields: Any) -> BspFile:
    """A level of squares that look up, one a centre, each with a shader of its number."""
    centres = np.asarray(centres, np.float32)
    count = len(centres)
    vertices = np.zeros(count * 4, LUMPS["vertices"])
    vertices["position"] = (centres[:, np.newaxis] + SQUARE).reshape(-1, 3)
    vertices["normal"] = 0, 0, 3  # not of length one
    faces = records(
        "faces",
        shader=shader,
        type=np.full(count, FaceType.POLYGON),
        first_vertex=np.arange(count) * 4,
        vertex_count=np.full(count, 4),
        index_count=np.full(count, 6),
    )
    bsp = replace(
        open_bsp(),
        vertices=vertices,
        faces=faces,
        indices=np.array([0, 1, 2, 0, 2, 3], np.int32),
        shaders=records("shaders", surface_flags=flags),
        shader_names=tuple(f"textures/shader{k}" for k in range(len(flags))),
        models=records("models", face_count=[count]),
    )
    return replace(bsp, **fields)


def build(bsp: BspFile) -> level.Level:
    return level.build(bsp, lambda _: None, lambda name: f"{name}.jpg", 1.0)


def test_faces_are_sorted_by_material_with_their_triangles_and_boxes() -> None:
    centres = [(0, 0, 0), (100, 0, 5), (0, 100, 10), (0, 0, 90)]
    built = build(squares(centres, [1, 0, 1, 0], [0, 0]))
    mesh = built.mesh
    assert built.materials == (
        Material("textures/shader0", "textures/shader0.jpg"),
        Material("textures/shader1", "textures/shader1.jpg"),
    )
    assert mesh.faces["material"].tolist() == [0, 0, 1, 1]
    assert built.visibility.level_face.tolist() == [1, 3, 0, 2]
    assert mesh.faces["first_index"].tolist() == [0, 6, 12, 18]
    for face, number in zip(mesh.faces, built.visibility.level_face, strict=True):
        corners = mesh.vertices["position"][mesh.indices[face["first_index"] :][:6]]
        expected = np.asarray(centres[number], np.float32) + SQUARE[[0, 1, 2, 0, 2, 3]]
        np.testing.assert_array_equal(corners, expected)
        assert face["mins"].tolist() == (centres[number] + SQUARE.min(axis=0)).tolist()
        assert face["maxs"].tolist() == (centres[number] + SQUARE.max(axis=0)).tolist()


def test_a_layer_lies_where_vertices_alpha_says() -> None:
    """A polygon's vertices have their own; all of a patch has the mean of its control points'."""
    bsp = squares([(0, 0, 0), (100, 0, 5)], [0, 0], [0])
    patch = np.zeros(9, LUMPS["vertices"])
    patch["position"] = [(x, y, 50) for y in (0, 8, 16) for x in (0, 8, 16)]
    patch["normal"] = 0, 0, 1
    vertices = np.concatenate([bsp.vertices, patch])
    vertices["color"][:, 3] = [0, 51, 102, 255, 5, 6, 7, 8, *range(10, 100, 10)]
    faces = np.concatenate([bsp.faces, bsp.faces[:1]])
    faces[2]["type"], faces[2]["patch_size"] = FaceType.PATCH, 3
    faces[2]["first_vertex"], faces[2]["vertex_count"], faces[2]["index_count"] = 8, 9, 0
    models = records("models", face_count=[3])
    bsp = replace(bsp, vertices=vertices, faces=faces, models=models)
    assert build(bsp).mesh.tints is None
    text = "s\n{\n{\nmap a\n}\n{\nmap b\nblendFunc blend\nalphaGen vertex\n}\n}"
    (entry,), _ = find_entries(text, "s")
    built = level.build(bsp, lambda _: entry.read(), lambda name: name, 1.0)
    assert built.materials[0].layer == Layer("b", fades=True)
    tints = built.mesh.tints
    assert tints is not None and len(tints) == len(built.mesh.vertices) and len(tints) > 8
    assert (tints[:, :3] == 1).all()
    np.testing.assert_allclose(tints[:8, 3], np.array([0, 51, 102, 255, 5, 6, 7, 8]) / 255)
    np.testing.assert_allclose(tints[8:, 3], 50 / 255, rtol=1e-6)


def test_a_scripts_colour_is_on_its_faces_alone() -> None:
    """As linear light, whatever the vertices' own alpha is."""
    bsp = squares([(0, 0, 0), (100, 0, 5), (0, 100, 10)], [0, 1, 0], [0, 0])
    text = "s\n{\n{\nmap a\nrgbGen const ( 1 0.5 0 )\n}\n}"
    (entry,), _ = find_entries(text, "s")
    scripts = {bsp.shader_names[1]: entry.read()}
    built = level.build(bsp, scripts.get, lambda name: name, 1.0)
    assert [m.is_tinted for m in built.materials] == [m.color is not None for m in built.materials]
    tints = built.mesh.tints
    assert tints is not None
    coloured = tints[4:8]  # of the second square
    np.testing.assert_allclose(coloured, [(1, 0.5**2.2, 0, 1)] * 4, rtol=1e-6)
    assert (np.delete(tints, range(4, 8), axis=0)[:, :3] == 1).all()


@pytest.mark.parametrize("gen", ["vertex", "oneMinusVertex"])
def test_a_reflection_follows_the_vertices_light(gen: str) -> None:
    """Twice a byte, white at most with the hue kept, and half of what that is displayed as."""
    bsp = squares([(0, 0, 0), (100, 0, 5)], [0, 1], [0, 0])
    bsp.vertices["color"][:4] = [(0, 51, 102, 7), (255, 0, 51, 7), (204, 102, 0, 7), (0, 0, 0, 7)]
    shown = np.array([(0, 0.4, 0.8), (1, 0, 0.2), (1, 0.5, 0), (0, 0, 0)])
    text = (
        f"s\n{{\n{{\nmap env\ntcGen environment\nrgbGen {gen}\n}}\n{{\nmap a\nblendFunc add\n}}\n}}"
    )
    (entry,), _ = find_entries(text, "s")
    scripts = {bsp.shader_names[0]: entry.read()}
    built = level.build(bsp, scripts.get, lambda name: name, 1.0)
    tints = built.mesh.tints
    assert tints is not None
    expected = (shown if gen == "vertex" else 1 - shown) / 2
    own = (built.mesh.vertices["position"][:, 0] < 50).nonzero()[0]
    np.testing.assert_allclose(tints[own, :3], expected**2.2, atol=1e-6)
    assert (np.delete(tints, own, axis=0)[:, :3] == 1).all()


@pytest.mark.parametrize("flag", [Surface.SKY, Surface.NODRAW, Surface.HINT, Surface.SKIP])
def test_sky_and_tool_surfaces_are_no_geometry(flag: int) -> None:
    built = build(squares([(0, 0, 0), (9, 9, 9)], [0, 1], [flag, 0]))
    assert [material.name for material in built.materials] == ["textures/shader1"]
    assert built.visibility.level_face.tolist() == [1]


def test_flares_have_no_triangles() -> None:
    bsp = squares([(0, 0, 0), (9, 9, 9)], [0, 0], [0])
    bsp.faces["type"][0] = FaceType.FLARE
    assert build(bsp).visibility.level_face.tolist() == [1]


def test_level_without_anything_to_draw() -> None:
    built = build(squares([(0, 0, 0)], [0], [Surface.SKY]))
    assert len(built.mesh.faces) == 0 and built.materials == ()


def test_brush_models_stand_at_their_entities_origins() -> None:
    models = records("models", first_face=[0, 1, 2], face_count=[1, 1, 1])
    entities = (
        {"classname": "worldspawn", "origin": "5 5 5"},
        {"classname": "func_door", "model": "*1", "origin": "100 -20 3.5"},
        {"classname": "func_door", "model": "*2", "origin": "1 nan 2"},
        {"classname": "func_door", "model": "*9", "origin": "1 2 3"},
        {"classname": "misc_model", "model": "models/tree.md3", "origin": "9 9 9"},
        {"classname": "func_door", "model": "*x"},
    )
    built = build(squares([(0, 0, 0)] * 3, [0] * 3, [0], models=models, entities=entities))
    assert built.mesh.faces["mins"].tolist() == [[-8, -8, 0], [92, -28, 3.5], [-8, -8, 0]]


@pytest.mark.parametrize("model", ["*0", "*-1", "*3", "*\u00b2", "*" + "9" * 5000, "*", "* 1"])
def test_what_names_no_brush_model_moves_nothing(model: str) -> None:
    entities = ({"classname": "func_door", "model": model, "origin": "1 2 3"},)
    models = records("models", first_face=[0, 1, 2], face_count=[1, 1, 1])
    built = build(squares([(0, 0, 0)] * 3, [0] * 3, [0], models=models, entities=entities))
    assert built.mesh.faces["mins"].tolist() == [[-8, -8, 0]] * 3


def test_normals_are_of_length_one_and_missing_ones_those_of_the_front() -> None:
    bsp = squares([(0, 0, 0), (50, 0, 0)], [0, 0], [0])
    bsp.vertices["normal"][4:] = 0
    normals = build(bsp).mesh.vertices["normal"]
    np.testing.assert_allclose(normals, np.broadcast_to((0, 0, 1), (8, 3)), atol=1e-6)


def two_rooms() -> BspFile:
    """Cluster 0 in front of x = 0 sees itself; cluster 1 behind sees both; a face in each."""
    bsp = squares([(50, 0, 0), (-50, 0, 0)], [0, 0], [0])
    nodes, planes = bsp.nodes.copy(), bsp.planes.copy()
    nodes["children"] = [(-1, -2)]
    planes["normal"], planes["distance"] = (1, 0, 0), 0
    leafs = records("leafs", cluster=[0, 1, -1], first_leaf_face=[0, 1, 2])
    leafs["leaf_face_count"] = 1, 1, 0
    return replace(
        bsp,
        nodes=nodes,
        planes=planes,
        leafs=leafs,
        leaf_faces=np.array([0, 1], np.int32),
        cluster_count=2,
        cluster_visible=np.array([[0b01], [0b11]], np.uint8),
    )


def test_visibility_is_the_levels_own() -> None:
    visibility = build(two_rooms()).visibility
    for x, seen in ((10.0, [True, False]), (-10.0, [True, True]), (11.0, [True, False])):
        place = np.array([x, 0, 0])
        assert visibility.faces_from(place).tolist() == seen
        leafs = [*visible_leafs(visibility.bsp, place).tolist(), True]
        for _ in range(2):
            assert visibility.leafs_from(place).tolist() == leafs


def test_from_outside_of_all_clusters_everything_is_seen() -> None:
    bsp = two_rooms()
    nodes = bsp.nodes.copy()
    nodes["children"] = [(-1, -3)]  # behind x = 0 is solid now
    visibility = build(replace(bsp, nodes=nodes)).visibility
    assert visibility.faces_from(np.array([-10.0, 0, 0])).tolist() == [True, True]


def test_brush_models_are_seen_from_everywhere() -> None:
    bsp = two_rooms()
    models = records("models", first_face=[0, 1], face_count=[1, 1])
    built = build(replace(bsp, models=models))
    assert built.visibility.faces_from(np.array([10.0, 0, 0])).tolist() == [True, True]


def test_a_face_that_lies_in_no_leaf_is_seen_from_everywhere() -> None:
    bsp = two_rooms()
    bsp.leafs["leaf_face_count"] = 1, 0, 0
    visibility = build(replace(bsp, leaf_faces=np.array([0], np.int32))).visibility
    assert visibility.faces_from(np.array([10.0, 0, 0])).tolist() == [True, True]
    assert visibility.faces_from(np.array([-10.0, 0, 0])).tolist() == [True, True]
