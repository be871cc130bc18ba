"""Reading Quake III levels: each lump is viewed where it lies in the file's bytes.

Then every number that points somewhere is checked, so that code behind it may index without a
second thought. Where the sources that `bsp` names leave open what is legal, the levels of OpenArena
decided.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.assets.binary import BinaryFile, run_members, text_until_nul
from followspot.assets.bsp import (
    HEADER,
    LUMPS,
    MAGIC,
    VERSION,
    VISIBILITY_HEADER,
    WORLD_LIMIT,
    BspFile,
    FaceType,
    Records,
)
from followspot.assets.entities import parse_entities
from followspot.errors import AssetError


def read_bsp(data: bytes, source: str) -> BspFile:
    """Read and check a Quake III level.

    Args:
        data: The whole file.
        source: The file's name for errors, as in `AssetError`.

    Returns:
        The level; its arrays keep ``data`` alive.

    Raises:
        AssetError: The file isn't IBSP version 46, is truncated, or something in it refers to
            what isn't there.
    """
    file = BinaryFile(data, source)
    lumps = _read_lumps(file)
    text = text_until_nul(lumps.pop("entities").tobytes())
    visibility = lumps.pop("visibility")
    cluster_count, cluster_visible = _read_visibility(file, visibility, lumps["leafs"])
    names = (text_until_nul(name) for name in lumps["shaders"]["name"].tolist())
    bsp = BspFile(
        source=source,
        entities=parse_entities(text, source),
        shader_names=tuple(name.replace("\\", "/").lower() for name in names),
        cluster_count=cluster_count,
        cluster_visible=cluster_visible,
        **lumps,
    )
    _check_tree(file, bsp)
    _check_solids(file, bsp)
    _check_faces(file, bsp)
    return bsp


def _read_lumps(file: BinaryFile) -> dict[str, NDArray[Any]]:
    """View every lump as an array of its records."""
    file.require_magic(MAGIC)
    header = file.record(HEADER, 0, "header")
    if header["version"] != VERSION:
        game = " (Return to Castle Wolfenstein or Quake Live)" if header["version"] == 47 else ""
        raise AssetError(
            file.source,
            place="byte 4",
            expected=f"version {VERSION} (Quake III Arena)",
            found=f"version {header['version']}{game}",
        )
    lumps = {}
    for (name, dtype), entry in zip(LUMPS.items(), header["directory"], strict=True):
        offset, length = entry.tolist()
        count, rest = divmod(length, dtype.itemsize)
        if rest:
            raise AssetError(
                file.source,
                place=f"{name} lump",
                expected=f"a length in whole records of {dtype.itemsize} bytes",
                found=f"{length} bytes",
            )
        lumps[name] = file.array(dtype, offset, count, f"{name} lump")
    for name in ("nodes", "leafs", "models"):
        if len(lumps[name]) == 0:
            raise AssetError(
                file.source, place=f"{name} lump", expected="at least one record", found="none"
            )
    return lumps


def _read_visibility(
    file: BinaryFile, lump: NDArray[np.uint8], leafs: Records
) -> tuple[int, NDArray[np.uint8]]:
    """Return cluster_count and cluster_visible; a missing lump lets every cluster see all."""
    if len(lump) == 0:
        # Every cluster holds a leaf, which bounds a count that only the leafs' own numbers give.
        file.require_indices(leafs["cluster"], len(leafs), "leafs[{}].cluster", lowest=-1)
        count = int(leafs["cluster"].max()) + 1
        return count, np.broadcast_to(np.uint8(0xFF), (count, (count + 7) // 8))
    size = VISIBILITY_HEADER.itemsize
    count, row_bytes = 0, 0
    if len(lump) >= size:
        count, row_bytes = lump[:size].view(VISIBILITY_HEADER)[0].tolist()
    if count < 0 or row_bytes * 8 < count or size + count * row_bytes != len(lump):
        raise AssetError(
            file.source,
            place="visibility lump",
            expected=f"{size} bytes and a row of bits for each cluster in {len(lump)} bytes",
            found=f"{count} clusters in rows of {row_bytes} bytes",
        )
    file.require_indices(leafs["cluster"], count, "leafs[{}].cluster", lowest=-1)
    return count, lump[size:].reshape(count, row_bytes)


def _check_tree(file: BinaryFile, bsp: BspFile) -> None:
    """Check planes, nodes, leafs and what the leafs hold."""
    planes, nodes, leafs = bsp.planes, bsp.nodes, bsp.leafs
    _require_finite(file, planes, "planes", ("normal", "distance"))
    file.require_indices(nodes["plane"], len(planes), "nodes[{}].plane")
    children = nodes["children"]
    file.require_indices(children, len(nodes), "nodes[{}].children", lowest=-len(leafs))
    # With at most one parent a node, and none for the root, no loop can be reached from the root.
    parents = np.bincount(children[children >= 0], minlength=len(nodes))
    most = np.ones(len(nodes), dtype=np.int64)
    most[0] = 0
    file.require(parents <= most, parents, "nodes[{}]", "a tree: one parent, none for node 0")

    file.require(leafs["area"] >= -1, leafs["area"], "leafs[{}].area", "an index or -1")
    file.require_runs(
        leafs["first_leaf_face"], leafs["leaf_face_count"], len(bsp.leaf_faces), "leafs[{}].faces"
    )
    file.require_runs(
        leafs["first_leaf_brush"],
        leafs["leaf_brush_count"],
        len(bsp.leaf_brushes),
        "leafs[{}].brushes",
    )
    file.require_indices(bsp.leaf_faces, len(bsp.faces), "leaf_faces[{}]")
    file.require_indices(bsp.leaf_brushes, len(bsp.brushes), "leaf_brushes[{}]")


def _check_solids(file: BinaryFile, bsp: BspFile) -> None:
    """Check models, brushes and effects."""
    models, brushes, sides, effects = bsp.models, bsp.brushes, bsp.brush_sides, bsp.effects
    _require_inside_world(file, models, "models", ("mins", "maxs"))
    file.require_runs(
        models["first_face"], models["face_count"], len(bsp.faces), "models[{}].faces"
    )
    file.require_runs(
        models["first_brush"], models["brush_count"], len(brushes), "models[{}].brushes"
    )
    file.require_runs(brushes["first_side"], brushes["side_count"], len(sides), "brushes[{}].sides")
    file.require_indices(brushes["shader"], len(bsp.shaders), "brushes[{}].shader")
    file.require_indices(sides["plane"], len(bsp.planes), "brush_sides[{}].plane")
    file.require_indices(sides["shader"], len(bsp.shaders), "brush_sides[{}].shader")
    file.require_indices(effects["brush"], len(brushes), "effects[{}].brush")
    side, side_count = effects["visible_side"], brushes["side_count"][effects["brush"]]
    file.require(
        (side >= -1) & (side < side_count),
        side,
        "effects[{}].visible_side",
        "a side of the effect's brush or -1",
    )


def _check_faces(file: BinaryFile, bsp: BspFile) -> None:
    """Check faces, vertices and indices."""
    faces, vertices = bsp.faces, bsp.vertices
    _require_inside_world(file, vertices, "vertices", ("position",))
    _require_finite(file, vertices, "vertices", ("texcoord", "normal"))

    file.require_indices(faces["shader"], len(bsp.shaders), "faces[{}].shader")
    # OpenArena's first `aggressor` has faces in effect 0 and no effects at all.
    file.require_indices(faces["effect"], max(len(bsp.effects), 1), "faces[{}].effect", lowest=-1)
    # -1 is no lightmap, -2 a white one, -3 colours at the vertices. For one past the lump the game
    # takes the colours at the vertices: such levels keep their lightmaps in image files.
    lightmap = faces["lightmap"]
    file.require(lightmap >= -3, lightmap, "faces[{}].lightmap", "an index, -1, -2 or -3")
    kind = faces["type"]
    file.require(
        (kind >= min(FaceType)) & (kind <= max(FaceType)), kind, "faces[{}].type", "1, 2, 3 or 4"
    )
    vertex_count, index_count = faces["vertex_count"], faces["index_count"]
    file.require_runs(faces["first_vertex"], vertex_count, len(vertices), "faces[{}].vertices")
    file.require_runs(faces["first_index"], index_count, len(bsp.indices), "faces[{}].indices")
    file.require(
        index_count % 3 == 0, index_count, "faces[{}].index_count", "whole triangles of 3 indices"
    )

    used = bsp.indices[run_members(faces["first_index"], index_count)]
    starts = np.cumsum(index_count, dtype=np.int64) - index_count
    drawn = index_count > 0
    reach = np.zeros((len(faces), 2), dtype=np.int64)
    if drawn.any():
        reach[drawn, 0] = np.minimum.reduceat(used, starts[drawn])
        reach[drawn, 1] = np.maximum.reduceat(used, starts[drawn])
    file.require(
        ~drawn | ((reach[:, 0] >= 0) & (reach[:, 1] < vertex_count)),
        reach,
        "faces[{}], lowest and highest index",
        "indices of the face's own vertices",
    )

    size = faces["patch_size"].astype(np.int64)
    whole = (size >= 3).all(axis=1) & (size % 2 == 1).all(axis=1)
    file.require(
        (kind != FaceType.PATCH) | (whole & (size.prod(axis=1) == vertex_count)),
        np.column_stack([size, vertex_count]),
        "faces[{}], patch width, height and vertices",
        "width and height odd, at least 3, and a vertex for each point",
    )


def _require_finite(file: BinaryFile, records: Records, lump: str, fields: tuple[str, ...]) -> None:
    for field in fields:
        values = records[field]
        file.require(np.isfinite(values), values, f"{lump}[{{}}].{field}", "finite numbers")


def _require_inside_world(
    file: BinaryFile, records: Records, lump: str, fields: tuple[str, ...]
) -> None:
    for field in fields:
        values = records[field]
        file.require(
            np.abs(values) <= WORLD_LIMIT,  # False for NaN too
            values,
            f"{lump}[{{}}].{field}",
            f"coordinates of magnitude {WORLD_LIMIT:g} at most",
        )
