"""An independent reader of the same files must find the same numbers."""

from collections.abc import Callable
from typing import Any

import bsp_tool
import numpy as np
import pytest
from bsp_fixtures import openarena_level
from bsp_tool.branches.id_software import quake3

from followspot.assets.bsp import LUMPS
from followspot.assets.bsp_reader import read_bsp

Get = Callable[[Any], Any]

# Our fields by bsp-tool's names for its own, lump by lump.
THEIRS: dict[str, tuple[str, dict[str, Get]]] = {
    "shaders": (
        "TEXTURES",
        {
            "name": lambda r: r.name.rstrip(b"\0"),
            "surface_flags": lambda r: int(r.flags.surface) & 0xFFFFFFFF,
            "content_flags": lambda r: int(r.flags.contents) & 0xFFFFFFFF,
        },
    ),
    "planes": ("PLANES", {"normal": lambda r: [*r.normal], "distance": lambda r: r.distance}),
    "nodes": (
        "NODES",
        {
            "plane": lambda r: r.plane,
            "children": lambda r: [r.children.front, r.children.back],
            "mins": lambda r: [*r.bounds.mins],
            "maxs": lambda r: [*r.bounds.maxs],
        },
    ),
    "leafs": (
        "LEAVES",
        {
            "cluster": lambda r: r.cluster,
            "area": lambda r: r.area,
            "mins": lambda r: [*r.bounds.mins],
            "maxs": lambda r: [*r.bounds.maxs],
            "first_leaf_face": lambda r: r.first_leaf_face,
            "leaf_face_count": lambda r: r.num_leaf_faces,
            "first_leaf_brush": lambda r: r.first_leaf_brush,
            "leaf_brush_count": lambda r: r.num_leaf_brushes,
        },
    ),
    "models": (
        "MODELS",
        {
            "mins": lambda r: [*r.bounds.mins],
            "maxs": lambda r: [*r.bounds.maxs],
            "first_face": lambda r: r.first_face,
            "face_count": lambda r: r.num_faces,
            "first_brush": lambda r: r.first_brush,
            "brush_count": lambda r: r.num_brushes,
        },
    ),
    "brushes": (
        "BRUSHES",
        {
            "first_side": lambda r: r.first_side,
            "side_count": lambda r: r.num_sides,
            "shader": lambda r: r.texture,
        },
    ),
    "brush_sides": (
        "BRUSH_SIDES",
        {"plane": lambda r: r.plane, "shader": lambda r: r.texture},
    ),
    "vertices": (
        "VERTICES",
        {
            "position": lambda r: [*r.position],
            "texcoord": lambda r: [r.uv.texture.u, r.uv.texture.v],
            "lightmap_texcoord": lambda r: [r.uv.lightmap.u, r.uv.lightmap.v],
            "normal": lambda r: [*r.normal],
            "color": lambda r: [r.colour.r, r.colour.g, r.colour.b, r.colour.a],
        },
    ),
    "effects": (
        "EFFECTS",
        {
            "name": lambda r: r.shader_name.rstrip(b"\0"),
            "brush": lambda r: r.brush,
            "visible_side": lambda r: r.visible_side,
        },
    ),
    "faces": (
        "FACES",
        {
            "shader": lambda r: r.texture,
            "effect": lambda r: r.effect,
            "type": lambda r: r.type.value,
            "first_vertex": lambda r: r.first_vertex,
            "vertex_count": lambda r: r.num_vertices,
            "first_index": lambda r: r.first_mesh_vertex,
            "index_count": lambda r: r.num_mesh_vertices,
            "lightmap": lambda r: r.lightmap.index,
            "lightmap_corner": lambda r: [*r.lightmap.top_left],
            "lightmap_size": lambda r: [*r.lightmap.size],
            "lightmap_origin": lambda r: [*r.lightmap.origin],
            "lightmap_axes": lambda r: [
                [axis.x, axis.y, axis.z] for axis in (r.lightmap.vector.s, r.lightmap.vector.t)
            ],
            "normal": lambda r: [*r.normal],
            "patch_size": lambda r: [*r.patch],
        },
    ),
    "light_grid": (
        "LIGHT_GRID",
        {
            "ambient": lambda r: [r.ambient.r, r.ambient.g, r.ambient.b],
            "directed": lambda r: [r.directional.r, r.directional.g, r.directional.b],
            "direction": lambda r: [r.direction.phi, r.direction.theta],
        },
    ),
}


@pytest.mark.openarena
@pytest.mark.parametrize(
    ("pak", "level"),
    [
        ("pak1-maps.pk3", "oa_rpg3dm2"),
        ("pak6-patch088.pk3", "oasago2"),
        ("pak6-patch088.pk3", "am_thornish"),
        ("z_oacmp-volume1-v3.pk3", "oacmpdm3"),
    ],
)
def test_every_lump_agrees_with_bsp_tool(pak: str, level: str) -> None:
    data = openarena_level(pak, level)
    ours = read_bsp(data, level)
    theirs = bsp_tool.IdTechBsp.from_bytes(quake3, f"{level}.bsp", data)
    assert not theirs.loading_errors

    for name, (lump, fields) in THEIRS.items():
        assert tuple(fields) == LUMPS[name].names
        array, records = getattr(ours, name), getattr(theirs, lump, [])
        assert len(array) == len(records)
        # Their records are slow to make, so some fifty of each lump, the first and last among them.
        for i in np.unique(np.linspace(0, len(array) - 1, 50).astype(int)) if len(array) else ():
            record = records[int(i)]
            for field, get in fields.items():
                np.testing.assert_array_equal(array[field][i], get(record), f"{name}[{i}].{field}")
    for name, lump in (
        ("leaf_faces", "LEAF_FACES"),
        ("leaf_brushes", "LEAF_BRUSHES"),
        ("indices", "INDICES"),
    ):
        assert getattr(ours, name).tolist() == getattr(theirs, lump)[:]
    assert len(ours.lightmaps) == len(theirs.LIGHTMAPS)
    assert ours.lightmaps[0].tobytes() == theirs.LIGHTMAPS[0].as_bytes()
    assert [row.tobytes() for row in ours.cluster_visible] == list(theirs.VISIBILITY)
    assert len(ours.entities) == len(theirs.ENTITIES)
    for entity, other in zip(ours.entities, theirs.ENTITIES, strict=True):
        # They keep all values of a key that stands twice, as a list.
        last = {
            key: value[-1] if isinstance(value, list) else value for key, value in other.items()
        }
        assert entity == {key.lower(): value for key, value in last.items()}
