"""Mesh files that are cut short, damaged or lie: one line that says where, or a mesh."""

import json
import struct
import tracemalloc
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from followspot.assets.gltf import read_gltf
from followspot.assets.mesh_file import MESH_SUFFIXES
from followspot.errors import AssetError
from mesh_fixtures import Document, cube, gltf_cube, obj, ply, read

NAN, INFINITY = float("nan"), float("inf")
CUBE = cube()


FILES: dict[str, bytes] = {
    ".obj": obj(CUBE),
    ".ply": ply(CUBE, binary=True),
    ".glb": gltf_cube(CUBE).glb(),
    ".gltf": gltf_cube(CUBE).gltf(),
}


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
def test_truncations_end_in_an_asset_error_or_a_mesh(suffix: str) -> None:
    """What is cut short is refused; OBJ is text without an end, so it may be a smaller mesh."""
    data = FILES[suffix]
    for length in range(0, len(data) - 1, 1 + len(data) // 400):
        try:
            read(data[:length], suffix)
        except AssetError as error:
            assert error.source == f"x{suffix}"
            continue
        assert suffix == ".obj"


_WORDS = "\n|f |v |vt |/|//|-1|0|nan|1e999|99999999999|list |element |char|uint64|null|[|]|{|}|true"
WORDS = [word.encode() for word in _WORDS.split("|")]


@pytest.mark.parametrize("suffix", MESH_SUFFIXES)
@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_damage_ends_in_an_asset_error_or_a_mesh(suffix: str, data: st.DataObject) -> None:
    damaged = bytearray(FILES[suffix])
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(damaged)))
        end = at + data.draw(st.integers(0, 6))
        damaged[at:end] = data.draw(st.sampled_from(WORDS) | st.binary(max_size=2))
    try:
        read(bytes(damaged), suffix)
    except AssetError as error:
        assert "\n" not in str(error)


@given(st.binary(max_size=300))
@settings(deadline=None)
def test_noise_is_no_mesh(noise: bytes) -> None:
    for suffix, start in (
        (".obj", b"v 0 0 0\nf "),
        (".ply", b"ply\nformat ascii 1.0\nelement "),
        (".glb", b"glTF\2\0\0\0"),
        (".gltf", b"{"),
    ):
        for data in (noise, start + noise):
            try:
                read(data, suffix)
            except AssetError as error:
                assert "\n" not in str(error)


TREE: list[tuple[str, Any, str]] = [
    ("asset", {"version": "1.0"}, "asset.version: expected 2.0, found 1.0"),
    ("asset", None, "asset: expected object, found null"),
    ("asset", {}, "asset.version: expected a value, which glTF requires, found none"),
    ("scene", 3, "scene: expected one of 1 scenes, found 3"),
    ("scenes", [{"nodes": [7]}], "expected one of 1 nodes, found 7"),
    ("nodes", [{"children": [0]}], "nodes[0]: expected a node of one parent"),
    ("nodes", [{"mesh": 1}], "nodes[0].mesh: expected one of 1 meshes, found 1"),
    ("nodes", [{"mesh": 0, "matrix": [1, 2]}], "nodes[0].matrix: expected array of length >= 16"),
    ("nodes", [{"mesh": 0, "scale": [1e300, 1, 1]}], "positions[0]: expected numbers below"),
    ("nodes", [{}], "expected triangles in a scene, found none"),
    ("meshes", {}, "meshes: expected array, found object"),
    ("accessors", [], "expected one of 0 accessors, found 0"),
    ("bufferViews", [], "expected one of 0 buffer_views, found 0"),
    ("bufferViews", [{"buffer": 1, "byteLength": 4}] * 9, "expected one of 1 buffers, found 1"),
    ("bufferViews", [{"buffer": 0, "byteLength": 2**39}] * 9, "bufferViews[0]: expected bytes up"),
    ("bufferViews", [{"buffer": 0, "byteLength": 4}] * 9, "accessors[0]: expected 24 values"),
    ("extensionsRequired", ["KHR_draco_mesh_compression"], "found KHR_draco_mesh_compression"),
]


def test_a_document_without_what_gltf_requires() -> None:
    with pytest.raises(AssetError) as error:
        read(b"{}", ".gltf")
    assert str(error.value).endswith(": asset: expected a value, which glTF requires, found none")


@pytest.mark.parametrize(("table", "value", "message"), TREE)
def test_documents_that_lie(table: str, value: Any, message: str) -> None:
    document = gltf_cube(CUBE)
    document.json[table] = value
    with pytest.raises(AssetError) as error:
        read(document.glb(), ".glb")
    assert message in str(error.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"count": 2**31}, "accessors[0].count: expected int <= 4194304, found 2147483648"),
        ({"count": 0}, "accessors[0].count: expected int >= 1, found 0"),
        ({"count": 4_000_000}, "accessors[0]: expected 4000000 values"),
        ({"byteOffset": 2**40}, "accessors[0]: expected 24 values"),
        ({"byteOffset": -1}, "accessors[0].byteOffset: expected int >= 0"),
        ({"componentType": 5124}, "expected a component type"),
        ({"componentType": 5121}, "expected float32 or normalized integers"),
        ({"type": "MAT4"}, "accessors[0]: expected 3 a value, found MAT4"),
        ({"sparse": {"count": 1}}, "expected values in a buffer view"),
        ({"bufferView": None}, "expected values in a buffer view"),
        ({"bufferView": 99}, "accessors[0]: expected one of 4 buffer_views, found 99"),
    ],
)
def test_accessors_that_lie(changes: dict[str, Any], message: str) -> None:
    document = gltf_cube(CUBE)
    document.json["accessors"][0] |= changes
    with pytest.raises(AssetError) as error:
        read(document.glb(), ".glb")
    assert message in str(error.value)


@pytest.mark.parametrize("number", [NAN, 1e20])
def test_numbers_that_are_none(number: float) -> None:
    positions = CUBE.positions.copy()
    positions[7, 1] = number
    broken = CUBE._replace(positions=positions)
    for data, suffix in ((ply(broken, binary=True), ".ply"), (gltf_cube(broken).glb(), ".glb")):
        with pytest.raises(AssetError, match=r"positions\[7\]: expected numbers below 1e15"):
            read(data, suffix)


def test_lists_for_colours_are_no_colours() -> None:
    """trimesh hands them on as they are: rows of arrays of different lengths."""
    header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    header += "property float z\nproperty list uchar int red\nproperty uchar green\n"
    header += "property uchar blue\nelement face 1\nproperty list uchar int vertex_indices\n"
    rows = "0 0 0 1 5 0 0\n1 0 0 2 5 6 0 0\n0 1 0 0 0 0\n3 0 1 2\n"
    try:
        (surface,) = read((header + "end_header\n" + rows).encode(), ".ply").surfaces
        assert surface.colors is None
    except AssetError as error:
        assert error.expected == "a whole mesh"


@pytest.mark.parametrize(
    "uri",
    ["../secret.bin", "/etc/passwd", "file:///etc/passwd", "http://localhost/x.bin", "%2e%2e/x"],
)
def test_nothing_is_read_but_by_the_one_who_was_asked(uri: str) -> None:
    """The reader opens no file and no connection: it asks for the name as it stands."""
    document = gltf_cube(CUBE)
    document.gltf()
    document.json["buffers"][0]["uri"] = uri
    asked: list[str] = []

    def find(name: str) -> None:
        asked.append(name)

    with pytest.raises(AssetError, match=r"buffers\[0\]: expected \d+ bytes, found none"):
        read_gltf(json.dumps(document.json).encode(), "x.gltf", find)
    assert asked == [uri.replace("%2e%2e", "..")]


def test_a_small_file_cannot_ask_for_much_memory() -> None:
    many = gltf_cube(CUBE, scenes=[{"nodes": list(range(9_000))}], nodes=[{"mesh": 0}] * 9_000)
    large = Document()
    large.attribute("POSITION", np.zeros((100_000, 3), "<f4"))
    large.json["meshes"][0]["primitives"] *= 4_000
    header = "ply\nformat {} 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n"
    header += "property float z\nelement face 4000000000\nproperty list uint int i\nend_header\n"
    bomb = struct.pack("<4sII", b"glTF", 2, 2**32 - 1) + struct.pack("<I4s", 2**32 - 1, b"JSON")
    for data, suffix in (
        (many.glb(), ".glb"),
        (large.glb(), ".glb"),
        (bomb, ".glb"),
        (header.format("ascii").encode() + b"1 2 3\n", ".ply"),
        (header.format("binary_little_endian").encode() + b"\xff" * 64, ".ply"),
        (b"v 0 0 0\nf 1 1 999999999999\n", ".obj"),
        (b"v 0 0 0\nf 1 1 -5\n", ".obj"),
    ):
        tracemalloc.start()
        try:
            with pytest.raises(AssetError):
                read(data, suffix)
            assert tracemalloc.get_traced_memory()[1] < 3e8
        finally:
            tracemalloc.stop()
