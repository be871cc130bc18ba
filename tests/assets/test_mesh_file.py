from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from followspot.assets.image import srgb_to_linear
from followspot.assets.mesh_file import MESH_SUFFIXES
from followspot.assets.mesh_record import MeshSurface, corner_normals
from followspot.errors import AssetError
from mesh_fixtures import Y_UP, Document, cube, gltf_cube, obj, ply, read
from model_fixtures import facing

MODELS = Path("/usr/share/assimp/models")
NAN, INFINITY = float("nan"), float("inf")
CUBE = cube()


def one(data: bytes, suffix: str, files: Mapping[str, bytes] | None = None) -> MeshSurface:
    (surface,) = read(data, suffix, files).surfaces
    return surface


def corners(surface: MeshSurface) -> Any:
    """Every triangle's corners with all that they have, in an order that no writer decides."""
    rows = np.concatenate([surface.positions, surface.normals, surface.texcoords], axis=1)
    triangles = rows[surface.indices].reshape(-1, 3, 8).round(5) + 0.0
    first = [int(np.lexsort(t.T[::-1])[0]) for t in triangles]
    turned = np.stack([np.roll(t, -k, axis=0) for t, k in zip(triangles, first, strict=True)])
    return turned[np.lexsort(turned.reshape(len(turned), -1).T[::-1])]


WANTED = MeshSurface(
    CUBE.positions.astype(np.float32),
    CUBE.normals.astype(np.float32),
    CUBE.texcoords.astype(np.float32),
    None,
    CUBE.triangles[:, ::-1].ravel().astype(np.uint32),
    None,  # type: ignore[arg-type]
)


@pytest.mark.parametrize(
    ("data", "suffix"),
    [(obj(CUBE), ".obj"), (ply(CUBE), ".ply"), (ply(CUBE, binary=True), ".ply")],
)
def test_a_cube_is_the_same_from_every_format(data: bytes, suffix: str) -> None:
    assert_allclose(corners(one(data, suffix)), corners(WANTED), atol=1e-4)


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_a_gltf_cube_comes_in_its_own_axes_and_metres(suffix: str) -> None:
    document = gltf_cube(CUBE)
    surface = one(document.glb() if suffix == ".glb" else document.gltf(), suffix)
    assert_allclose(surface.positions, CUBE.positions @ Y_UP.T * 0.03, rtol=1e-6)
    assert_allclose(surface.normals, CUBE.normals @ Y_UP.T)
    assert_allclose(surface.texcoords, CUBE.texcoords)
    assert surface.indices.tolist() == CUBE.triangles[:, ::-1].ravel().tolist()
    assert (facing(surface.positions, surface.normals, surface.indices) > 0).all()


def test_what_trimesh_makes_of_the_same_glb() -> None:
    """An independent reader, of a file with a tree of nodes: turned, stretched, mirrored."""
    import io

    import trimesh

    document = gltf_cube(
        CUBE,
        scenes=[{"nodes": [0, 3]}],
        nodes=[
            {"translation": [1, 2, 3], "rotation": [0.5, 0.5, 0.5, 0.5], "children": [1, 2]},
            {"mesh": 0, "scale": [2, 1, 0.5]},
            {"mesh": 0, "translation": [0, 5, 0], "rotation": [0, 0.6, 0, 0.8],
             "scale": [-1, 1, 1]},
            {"mesh": 0, "matrix": [0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 7, 8, 9, 1]},
        ],
    )  # fmt: skip
    mesh = read(document.glb(), ".glb")
    scene = trimesh.load_scene(io.BytesIO(document.glb()), file_type="glb", process=False)
    assert len(mesh.surfaces) == 3
    theirs = {}
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        points = scene.geometry[name].vertices @ matrix[:3, :3].T + matrix[:3, 3]
        theirs[tuple(points.mean(axis=0).round(3) + 0.0)] = points
    for surface in mesh.surfaces:
        points = theirs.pop(tuple(surface.positions.mean(axis=0).astype(float).round(3) + 0.0))
        assert_allclose(surface.positions, points, atol=1e-5)
        assert (facing(surface.positions, surface.normals, surface.indices) > 0).all()


def test_integers_are_shares_of_their_range() -> None:
    document = gltf_cube(CUBE)
    document.attribute("TEXCOORD_0", (CUBE.texcoords * 255).astype("u1"), normalized=True)
    colors = np.tile(np.array([(0, 65535, 32768)], "<u2"), (24, 1))
    document.attribute("COLOR_0", colors, normalized=True)
    surface = one(document.glb(), ".glb")
    assert_allclose(surface.texcoords, CUBE.texcoords)
    assert surface.colors is not None
    assert_allclose(surface.colors[5], (0, 1, 32768 / 65535, 1), atol=1e-7)


@pytest.mark.parametrize(
    ("mode", "expected"),
    [
        (4, [[0, 1, 2]]),
        (5, [[0, 1, 2], [2, 1, 3], [2, 3, 4]]),
        (6, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]),
    ],
)
def test_lists_strips_and_fans(mode: int, expected: list[list[int]]) -> None:
    document = Document()
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0.5), (1, 2, 1)], "<f4")
    document.attribute("POSITION", points)
    document.primitive["mode"] = mode
    surface = one(document.glb(), ".glb")
    wanted = points[np.array(expected)]
    found = surface.positions[surface.indices].reshape(-1, 3, 3)[:, ::-1]
    shifts = [np.stack([np.roll(t, k, axis=0) for k in range(3)]) for t in wanted]
    assert len(found) == len(wanted)
    assert all((turns == t).all(axis=(1, 2)).any() for turns, t in zip(shifts, found, strict=True))


def test_interleaved_values() -> None:
    document = Document()
    rows = np.zeros(3, [("position", "<f4", 3), ("normal", "<f4", 3)])
    rows["position"], rows["normal"] = [(0, 0, 0), (1, 0, 0), (0, 1, 0)], (0, 0, 1)
    view = document.view(rows.tobytes())
    document.json["bufferViews"][view]["byteStride"] = 24
    for offset in (0, 12):
        document.json["accessors"].append(
            {"bufferView": view, "byteOffset": offset, "componentType": 5126, "count": 3,
             "type": "VEC3"}
        )  # fmt: skip
    document.primitive["attributes"] = {"POSITION": 0, "NORMAL": 1}
    surface = one(document.glb(), ".glb")
    assert_allclose(surface.positions, rows["position"])
    assert_allclose(surface.normals, rows["normal"])


def test_looks_of_gltf() -> None:
    document = gltf_cube(
        CUBE,
        textures=[{"source": 0, "sampler": 0}, {"source": 1}],
        samplers=[{"wrapS": 33071, "wrapT": 33071}],
        materials=[
            {
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.5, 0.25, 1, 0.5],
                    "baseColorTexture": {"index": 0},
                },
                "alphaMode": "MASK",
                "alphaCutoff": 0.3,
                "doubleSided": True,
            },
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}, "alphaMode": "BLEND"},
        ],
    )
    document.json["images"] = [
        {"uri": "wood%20of%20oak.png"},
        {"bufferView": document.view(b"picture"), "mimeType": "image/png"},
    ]
    document.primitive["material"] = 0
    first = one(document.glb(), ".glb").look
    assert list(first.color) == [0.5, 0.25, 1, 0.5]
    assert first.image == "wood of oak.png"
    assert (first.cutoff, first.is_blended, first.is_two_sided, first.clamps) == (
        0.3,
        False,
        True,
        True,
    )
    document.primitive["material"] = 1
    second = one(document.glb(), ".glb").look
    assert second.image == b"picture"
    assert (second.cutoff, second.is_blended, second.clamps) == (None, True, False)
    del document.primitive["material"]
    assert one(document.glb(), ".glb").look.image is None


def test_texture_transform_moves_scales_and_turns() -> None:
    move = {"offset": [0.25, 0.5], "scale": [2, 4], "rotation": np.pi / 2}
    info = {"index": 0, "extensions": {"KHR_texture_transform": move}}
    document = gltf_cube(CUBE, textures=[{}], materials=[
        {"pbrMetallicRoughness": {"baseColorTexture": info}}
    ])  # fmt: skip
    document.primitive["material"] = 0
    u, v = CUBE.texcoords.T
    # A quarter counter-clockwise, where v points down.
    wanted = np.stack([0.25 + 4 * v, 0.5 - 2 * u], axis=1)
    assert_allclose(one(document.glb(), ".glb").texcoords, wanted, atol=1e-6)


def test_materials_of_obj() -> None:
    library = (
        b"newmtl Dark wood\nKd 0.5 0.25 1\nmap_Kd -s 1 1 1 wood.png\nd 0.75\nnewmtl b\nKd 0 0 0"
    )
    surface = one(obj(CUBE, "my box.mtl", "Dark wood"), ".obj", {"my box.mtl": library})
    red, green, blue, alpha = surface.look.color
    assert_allclose([red, green, blue], srgb_to_linear(np.array([0.5, 0.25, 1])))
    assert alpha == 0.75 and surface.look.is_blended
    assert surface.look.image == "wood.png"
    tabs = library.replace(b" 0.", b"\t0.").replace(b"Kd -s", b"Kd\t-s").replace(b"l D", b"l\tD")
    shouted = tabs.replace(b"Kd", b"KD").replace(b"\nd\t", b"\nD\t").replace(b"newmtl", b"NewMtl")
    for spelled in (tabs, shouted):
        found = one(obj(CUBE, "m.mtl", "Dark wood"), ".obj", {"m.mtl": spelled})
        assert found.look == surface.look
    mesh = read(obj(CUBE, "no.mtl", "x"), ".obj")
    assert [str(p) for p in mesh.problems] == [
        "x.obj: mtllib: expected a material library beside it, found no.mtl"
    ]


def test_every_material_of_obj_is_a_surface() -> None:
    lines = obj(CUBE, "m.mtl").decode().splitlines()
    faces = [k for k, line in enumerate(lines) if line.startswith("f ")]
    lines.insert(faces[4], "usemtl blue")
    lines.insert(faces[0], "usemtl red")
    library = b"newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n"
    surfaces = read("\n".join(lines).encode(), ".obj", {"m.mtl": library}).surfaces
    found = {s.look.color: len(s.indices) // 3 for s in surfaces}
    assert found == {(1, 0, 0, 1): 4, (0, 0, 1, 1): 8}


@pytest.mark.parametrize("binary", [False, True])
def test_colours_and_image_of_ply(binary: bool) -> None:
    colors = np.arange(72, dtype=np.uint8).reshape(24, 3) * 3
    surface = one(ply(CUBE, colors=colors, binary=binary), ".ply")
    assert surface.colors is not None
    # It has no normals: every corner becomes a vertex.
    index = CUBE.triangles.ravel()
    assert_allclose(surface.colors[:, :3], srgb_to_linear(colors[index] / 255), atol=1e-6)
    assert_allclose(surface.colors[:, 3], 1)
    assert one(ply(CUBE, "wood of oak.png", binary=binary), ".ply").look.image == "wood of oak.png"


def test_normals_are_made_smooth_up_to_a_crease() -> None:
    """A cylinder of 16 sides is round, its caps are flat; a cube has no round edge."""
    angle = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    low, high = (np.c_[ring, np.full(16, z)] for z in (0.0, 2.0))
    points = np.concatenate([low, high, [(0, 0, 0), (0, 0, 2)]]).astype(np.float32)
    k = np.arange(16)
    n = (k + 1) % 16
    sides = np.concatenate([np.c_[k, n, n + 16], np.c_[k, n + 16, k + 16]])
    caps = np.concatenate([np.c_[n, k, 0 * k + 32], np.c_[k + 16, n + 16, 0 * k + 33]])
    normals = corner_normals(points, np.concatenate([sides, caps]), 40.0)
    outward = points[sides.ravel()] * (1, 1, 0)
    assert np.einsum("ij,ij->i", normals[:96], outward).min() > 0.995
    assert_allclose(normals[:96, 2], 0, atol=1e-6)
    assert_allclose(np.abs(normals[96:, 2]), 1, atol=1e-6)
    eight = np.unique(CUBE.positions, axis=0)
    number = {tuple(p): k for k, p in enumerate(eight)}
    shared = np.array([[number[tuple(CUBE.positions[k])] for k in t] for t in CUBE.triangles])
    found = corner_normals(eight.astype(np.float32), shared, 40.0)
    assert_allclose(found, CUBE.normals[CUBE.triangles.ravel()], atol=1e-6)


def test_gltf_without_normals_is_flat() -> None:
    document = gltf_cube(CUBE)
    del document.primitive["attributes"]["NORMAL"]
    surface = one(document.glb(), ".glb")
    assert (facing(surface.positions, surface.normals, surface.indices) > 0).all()
    assert_allclose(np.abs(surface.normals).max(axis=1), 1, atol=1e-6)


def test_polygons_become_triangles() -> None:
    quads = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 2 0\nf 1 2 3 4\nf 4 3 5\n"
    assert len(one(quads, ".obj").indices) == 9
    five = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 2 0\nv 0 1 0\nf 1 2 3 4 5\n"
    surface = one(five, ".obj")
    a, b, c = surface.positions[surface.indices].reshape(-1, 3, 3).transpose(1, 0, 2)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(1.5)
    assert_allclose(surface.normals, np.tile([0, 0, 1], (len(surface.normals), 1)), atol=1e-6)


def test_every_mesh_of_the_sample_models_is_read_or_told_in_one_line() -> None:
    paths = [p for p in sorted(MODELS.rglob("*")) if p.suffix.lower() in MESH_SUFFIXES]
    assert len(paths) > 50, f"assimp-testmodels is not installed in {MODELS}"
    refused = set()
    for path in paths:
        files = {p.name: p.read_bytes() for p in path.parent.iterdir() if p.is_file()}
        try:
            read(path.read_bytes(), path.suffix.lower(), files)
        except AssetError as error:
            assert "\n" not in str(error)
            refused.add(path.relative_to(MODELS).parts[0] + "/" + path.name)
    # Refused: points and lines, glTF 1, files that are broken on purpose, Draco's compression.
    whole = ["OBJ/spider.obj", "OBJ/box_UTF16BE.obj", "OBJ/regr01.obj", "PLY/cube_binary.ply"]
    whole += ["glTF2/2CylinderEngine.glb", "glTF2/TextureTransformTest.gltf"]
    assert refused.isdisjoint(whole)
    assert len(refused) < len(paths) / 2
