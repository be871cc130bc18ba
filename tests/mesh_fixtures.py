"""One cube in four formats, written here by hand, and small glTF documents."""

import base64
import json
import struct
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.testing import assert_allclose
from numpy.typing import NDArray

from followspot.assets import md3
from followspot.assets.mesh_file import read_mesh
from followspot.assets.mesh_record import MeshFile
from model_fixtures import write_md3


class Cube(NamedTuple):
    """Six square faces with four vertices each; triangles counter-clockwise, v down."""

    positions: NDArray[np.float64]
    normals: NDArray[np.float64]
    texcoords: NDArray[np.float64]
    triangles: NDArray[np.int64]


def cube(half: float = 16.0) -> Cube:
    """On the sides an image stands upright with Z up; units, front faces outwards."""
    positions, normals = [], []
    for normal in np.concatenate([np.eye(3), -np.eye(3)]):
        up = np.array([0.0, 0, 1]) if normal[2] == 0 else np.array([1.0, 0, 0])
        right = np.cross(up, normal)  # as seen from outside
        positions += [normal - right + up, normal + right + up]
        positions += [normal + right - up, normal - right - up]
        normals += [normal] * 4
    texcoords = np.tile([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)], (6, 1))
    square = np.array([(0, 2, 1), (0, 3, 2)])
    triangles = (4 * np.arange(6)[:, np.newaxis, np.newaxis] + square).reshape(-1, 3)
    return Cube(half * np.array(positions), np.array(normals), texcoords, triangles)


def obj(of: Cube, library: str = "", material: str = "") -> bytes:
    lines = [f"mtllib {library}"] if library else []
    lines += [f"v {x} {y} {z}" for x, y, z in of.positions]
    lines += [f"vt {u} {1 - v}" for u, v in of.texcoords]
    lines += [f"vn {x} {y} {z}" for x, y, z in of.normals]
    lines += [f"usemtl {material}"] if material else []
    lines += ["f " + " ".join(f"{k}/{k}/{k}" for k in t) for t in (of.triangles + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()


def ply(
    of: Cube, image: str = "", colors: NDArray[np.uint8] | None = None, binary: bool = False
) -> bytes:
    """With normals and texture coordinates, or with colours and neither."""
    columns: list[NDArray[Any]] = [of.positions]
    if colors is None:
        columns += [of.normals, of.texcoords]
    names = ["x", "y", "z", *([] if colors is not None else ["nx", "ny", "nz", "s", "t"])]
    fields = [(name, "<f4") for name in names]
    header = ["ply", f"format {'binary_little_endian' if binary else 'ascii'} 1.0"]
    header += [f"comment TextureFile {image}"] if image else []
    header += [f"element vertex {len(of.positions)}"]
    header += [f"property float {name}" for name in names]
    if colors is not None:
        fields += [(name, "u1") for name in ("red", "green", "blue")]
        header += [f"property uchar {name}" for name in ("red", "green", "blue")]
        columns.append(colors)
    header += [f"element face {len(of.triangles)}", "property list uchar int vertex_indices"]
    rows = np.zeros(len(of.positions), fields)
    for (name, _), column in zip(fields, np.concatenate(columns, axis=1).T, strict=True):
        rows[name] = 1 - column if name == "t" else column
    text = ("\n".join([*header, "end_header"]) + "\n").encode()
    if binary:
        faces = np.zeros(len(of.triangles), [("count", "u1"), ("index", "<i4", 3)])
        faces["count"], faces["index"] = 3, of.triangles
        return text + rows.tobytes() + faces.tobytes()
    body = [" ".join(map(str, row)) for row in rows.tolist()]
    body += ["3 " + " ".join(map(str, t)) for t in of.triangles.tolist()]
    return text + ("\n".join(body) + "\n").encode()


def md3_cube(of: Cube, *images: str) -> bytes:
    """One for each image, in steps of a 64th unit; normals along an axis are exact enough."""
    vertices = np.zeros((1, len(of.positions)), md3.VERTEX)
    vertices["position"] = of.positions * 64
    vertices["zenith"] = np.round(np.arccos(of.normals[:, 2]) / (2 * np.pi) * 256)
    around = np.arctan2(of.normals[:, 1], of.normals[:, 0]) / (2 * np.pi) * 256
    vertices["azimuth"] = np.round(around) % 256
    frame = np.zeros(1, md3.FRAME)
    surfaces = [
        {
            "name": np.array(b"cube"),
            "triangles": of.triangles[:, ::-1].astype("<i4"),
            "shaders": np.array([(image.encode(), 0)], md3.SHADER),
            "texcoords": of.texcoords.astype("<f4"),
            "vertices": vertices,
        }
        for image in images
    ]
    return write_md3({"frames": frame, "tags": np.zeros((1, 0), md3.TAG), "surfaces": surfaces})


class Document:
    """A glTF document that grows by attributes."""

    def __init__(self, **tables: Any) -> None:
        self.body = b""
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {}}]}],
            "accessors": [],
            "bufferViews": [],
            **tables,
        }

    @property
    def primitive(self) -> dict[str, Any]:
        found: dict[str, Any] = self.json["meshes"][0]["primitives"][0]
        return found

    def view(self, data: bytes) -> int:
        """Put bytes into the buffer; returns the view's number."""
        view = {"buffer": 0, "byteOffset": len(self.body), "byteLength": len(data)}
        self.json["bufferViews"].append(view)
        self.body += data + bytes(-len(data) % 4)
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values: NDArray[Any], **fields: Any) -> int:
        """Put an array into the buffer; returns the accessor's number."""
        kinds = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
        width = 1 if values.ndim == 1 else values.shape[1]
        self.json["accessors"].append(
            {
                "bufferView": self.view(values.tobytes()),
                "componentType": kinds[values.dtype.str[1:]],
                "count": len(values),
                "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[width],
                **fields,
            }
        )
        return len(self.json["accessors"]) - 1

    def attribute(self, name: str, values: NDArray[Any], **fields: Any) -> None:
        self.primitive["attributes"][name] = self.accessor(values, **fields)

    def glb(self) -> bytes:
        self.json["buffers"] = [{"byteLength": len(self.body)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(self.body), b"BIN\0") + self.body
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def gltf(self) -> bytes:
        """With its buffer in a data URI."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.body).decode()
        self.json["buffers"] = [{"byteLength": len(self.body), "uri": uri}]
        return json.dumps(self.json).encode()


Y_UP = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
"""Quake's axes in glTF's: its Y is Quake's Z, its Z is X, its X is Y."""


def gltf_cube(of: Cube, metres_per_unit: float = 0.03, **tables: Any) -> Document:
    """The same cube in glTF's axes and metres."""
    document = Document(**tables)
    document.attribute("POSITION", (of.positions @ Y_UP.T * metres_per_unit).astype("<f4"))
    document.attribute("NORMAL", (of.normals @ Y_UP.T).astype("<f4"))
    document.attribute("TEXCOORD_0", of.texcoords.astype("<f4"))
    document.primitive["indices"] = document.accessor(of.triangles.astype("<u2").ravel())
    return document


def read(data: bytes, suffix: str, files: Mapping[str, bytes] | None = None) -> MeshFile:
    """A mesh whose neighbours are `files`, checked for what code behind the reader relies on."""
    mesh = read_mesh(data, "x" + suffix, suffix, lambda name: (files or {}).get(name))
    assert mesh.surfaces
    for surface in mesh.surfaces:
        count = len(surface.positions)
        assert surface.positions.shape == surface.normals.shape == (count, 3)
        assert surface.texcoords.shape == (count, 2)
        assert surface.indices.dtype == np.uint32 and len(surface.indices) % 3 == 0
        assert len(surface.indices) and surface.indices.max() < count
        arrays = [surface.positions, surface.normals, surface.texcoords]
        if surface.colors is not None:
            assert surface.colors.shape == (count, 4)
            assert surface.colors.min() >= 0 and surface.colors.max() <= 1
            arrays.append(surface.colors)
        for array in arrays:
            assert array.dtype == np.float32 and np.isfinite(array).all()
        assert_allclose(np.linalg.norm(surface.normals, axis=1), 1, atol=1e-5)
    return mesh
