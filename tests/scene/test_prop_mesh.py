"""Props in a level's mesh: one table of faces, seen from where they are."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from prop_scenes import CUBE, FILES, FLOOR, cube_files, place, require_whole

from followspot.assets.bsp import LUMPS
from followspot.scene import bsp_tree
from followspot.scene.fog import Fog
from followspot.scene.level import Level
from followspot.scene.load import load
from followspot.scene.mesh import Mesh
from followspot.scene.prop_mesh import with_props
from mesh_fixtures import gltf_cube
from synthetic import make_scene, open_bsp


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return cube_files(tmp_path)


def test_a_level_with_props_is_one_mesh_in_order(folder: Path) -> None:
    document = gltf_cube(CUBE, materials=[{"alphaMode": "BLEND"}])
    document.primitive["material"] = 0
    (folder / "glass.glb").write_bytes(document.glb())
    texts = [
        f'file = "{n}"\norigin = [0, {60 * k}, 0]' for k, n in enumerate([*FILES, "glass.glb"])
    ]
    placed = place(folder, *texts)
    level = with_props(FLOOR, placed)
    mesh = level.mesh
    require_whole(level)
    before, after = FLOOR.mesh.triangle_count, sum(p.triangle_count for p in placed)
    assert mesh.triangle_count == before + after
    number = level.visibility.level_face
    assert sorted(number[number >= 0].tolist()) == FLOOR.visibility.level_face.tolist()
    assert (number < 0).sum() == len(placed)
    # What was there is there still, and every prop's triangles are in one face's box.
    assert corner_set(FLOOR.mesh) <= corner_set(mesh)
    boxes = {tuple(face["mins"].round(2).tolist()) for face in mesh.faces[number < 0]}
    assert boxes == {tuple(p.bounds[0].round(2).tolist()) for p in placed}
    blended = [m.blend is not None for m in level.materials]
    assert blended == sorted(blended) and any(blended)
    assert with_props(FLOOR, ()) is FLOOR


def corner_set(mesh: Mesh) -> set[Any]:
    corners = mesh.vertices["position"][mesh.indices].reshape(-1, 9).round(3) + 0.0
    return {tuple(row) for row in corners.tolist()}


def test_a_level_keeps_its_fog(folder: Path) -> None:
    fog = Fog(np.zeros(3), np.full(3, 64.0), np.full(3, 0.5), 0.01)
    (prop,) = place(folder, 'file = "cube.obj"\norigin = [0, 0, 0]')
    assert with_props(replace(FLOOR, fogs=(fog,)), (prop,)).fogs == (fog,)


def three_rooms() -> Level:
    """Along x, in planes at 0 and 100: a solid end, then rooms of which neighbours see another."""
    planes, nodes, leafs = (
        np.zeros(n, LUMPS[k]) for n, k in ((3, "planes"), (3, "nodes"), (4, "leafs"))
    )
    planes["normal"], planes["distance"] = (1, 0, 0), (-100, 0, 100)
    nodes["plane"], nodes["children"] = (0, 1, 2), [(1, ~0), (2, ~1), (~3, ~2)]
    leafs["cluster"] = -1, 0, 1, 2
    sees = np.array([(1, 1, 0), (1, 1, 1), (0, 1, 1)], bool)
    bsp = replace(
        open_bsp(),
        planes=planes,
        nodes=nodes,
        leafs=leafs,
        cluster_count=3,
        cluster_visible=np.packbits(sees, axis=1, bitorder="little"),
    )
    empty = make_scene([]).level
    return replace(empty, bsp=bsp, visibility=replace(empty.visibility, bsp=bsp))


@pytest.mark.parametrize(
    ("x", "seen"),
    [
        (-50, (True, True, False)),
        (50, (True, True, True)),
        (150, (False, True, True)),
        (-10, (True, True, True)),  # in two rooms
        (-100, (True, True, False)),  # half in the solid end
        (-300, (True, True, True)),  # in it: visibility knows nothing of it
    ],
)
def test_props_are_seen_from_where_a_leaf_is_that_they_reach_into(
    folder: Path, x: float, seen: tuple[bool, ...]
) -> None:
    placed = place(folder, f'file = "cube.obj"\norigin = [{x}, 0, 0]')
    visibility = with_props(three_rooms(), placed).visibility
    eyes = np.array([(-50.0, 0, 0), (50, 0, 0), (150, 0, 0)])
    assert [visibility.faces_from(eye).tolist() for eye in eyes] == [[each] for each in seen]
    assert visibility.faces_from(np.array([-500.0, 0, 0])).tolist() == [True]


@pytest.mark.openarena
def test_no_prop_of_a_level_is_hidden_from_whom_sees_its_place(folder: Path) -> None:
    """Among many in a real level: seen whenever any point in it is in a leaf that is seen."""
    level = load("oa_dm5").level
    rng = np.random.default_rng(1)
    mins, maxs = level.mesh.bounds
    origins = rng.uniform(mins, maxs, (60, 3)).round(2).tolist()
    placed = place(folder, *(f'file = "cube.obj"\norigin = {o}' for o in origins))
    joined = with_props(level, placed)
    require_whole(joined)
    number = {tuple(f["mins"].tolist()): k for k, f in enumerate(joined.mesh.faces)}
    faces = [number[tuple(prop.bounds[0].tolist())] for prop in placed]
    inside = [
        bsp_tree.point_leafs(level.bsp, rng.uniform(low, high, (200, 3)))
        for low, high in (prop.bounds for prop in placed)
    ]
    hidden = 0
    for eye in rng.uniform(mins, maxs, (400, 3)):
        seen = joined.visibility.faces_from(eye)[faces]
        leafs = bsp_tree.visible_leafs(level.bsp, eye)
        assert (seen >= [leafs[each].any() for each in inside]).all()
        hidden += int((~seen).sum())
    assert hidden > 100
