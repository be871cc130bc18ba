"""glTF 2.0 and GLB: the triangles of a file's scene where its nodes put them, and their looks.

What moves (skins, morph targets, animations) stands still here. Source: "glTF 2.0 Specification",
version 2.0.1, The Khronos Group, whose section numbers are given.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints
from followspot.assets.binary import BinaryFile
from followspot.assets.gltf_document import (
    TRIANGLES,
    Document,
    Head,
    Material,
    Node,
    Primitive,
    Sampler,
    Texture,
    TextureInfo,
    Transform,
    decode,
)
from followspot.assets.gltf_records import FindFile, Records
from followspot.assets.mesh_record import (
    MAX_SURFACES,
    MAX_VERTICES,
    PLAIN,
    Look,
    MeshFile,
    MeshSurface,
    RawSurface,
    finish,
)
from followspot.errors import AssetError

_GLB = np.dtype([("magic", "S4"), ("version", "<u4"), ("length", "<u4")])
_CHUNK = np.dtype([("length", "<u4"), ("kind", "S4")])
_STRIP, _FAN = 5, 6
_CLAMP_TO_EDGE = 33071

_KNOWN = ("KHR_texture_transform", "KHR_materials_", "KHR_lights_punctual", "KHR_xmp")
"""Beginnings of the names of extensions that are read, or that change nothing of what is where."""


def read_gltf(data: bytes, source: str, find_file: FindFile) -> MeshFile:
    """Read a glTF or GLB file, told apart by its first bytes.

    Positions are in metres, Y up, as the format has them.

    Args:
        data: The whole file.
        source: Its name for errors.
        find_file: Reads the buffers that it names. Images are not read here.

    Raises:
        AssetError: it is no such file, lies about its own size, or needs what is not read here.
    """
    text, body = _chunks(BinaryFile(data, source)) if data[:4] == b"glTF" else (data, None)
    head = decode(text, Head, source)
    if head.asset.version.partition(".")[0] != "2":
        found = head.asset.version
        raise AssetError(source, place="asset.version", expected="2.0", found=found)
    for name in head.extensions_required:
        if not name.startswith(_KNOWN):
            expected = "none that changes what is where"
            raise AssetError(source, place="extensionsRequired", expected=expected, found=name)
    records = Records(decode(text, Document, source), body, source, find_file)
    with np.errstate(all="ignore"):  # numbers that are none are told of when all is in place
        return _Reader(records).read()


def _chunks(file: BinaryFile) -> tuple[bytes, bytes | None]:
    """A GLB file's JSON and its binary buffer (section 4.4)."""
    header = file.record(_GLB, 0, "header")
    if header["version"] != 2:
        found = str(header["version"])
        raise AssetError(file.source, place="header", expected="version 2", found=found)
    chunks: dict[bytes, bytes] = {}
    at = _GLB.itemsize
    while at + _CHUNK.itemsize <= len(file.data):
        chunk = file.record(_CHUNK, at, "chunk")
        at += _CHUNK.itemsize
        place = f"chunk at byte {at}"
        body = file.array("u1", at, int(chunk["length"]), place).tobytes()
        chunks.setdefault(bytes(chunk["kind"]), body)
        at += len(body) + -len(body) % 4
    if b"JSON" not in chunks:
        raise AssetError(file.source, expected="a chunk of JSON", found="none")
    return chunks[b"JSON"], chunks.get(b"BIN")


class _Reader:
    """What one document shows."""

    def __init__(self, records: Records) -> None:
        self._records = records
        self._document, self._source = records.document, records.source
        self._looks: dict[int, Look] = {}
        self._corners = 0

    def read(self) -> MeshFile:
        """All that the file's scene shows."""
        surfaces: list[MeshSurface] = []
        shown: dict[int, list[RawSurface]] = {}
        for mesh, matrix in self._placed_meshes():
            if mesh not in shown:
                shown[mesh] = list(self._mesh(mesh))
            for raw in shown[mesh]:
                self._count(len(raw.positions) + raw.triangles.size, raw.place)
                if len(surfaces) == MAX_SURFACES:
                    raise self._records.wrong(raw.place, f"at most {MAX_SURFACES} surfaces", "more")
                surfaces.append(finish(_placed(raw, matrix), self._source))
        if not surfaces:
            raise AssetError(self._source, expected="triangles in a scene", found="none")
        return MeshFile(self._source, tuple(surfaces))

    def _count(self, corners: int, place: str) -> None:
        self._corners += corners
        if self._corners > 2 * MAX_VERTICES:
            expected = f"at most {MAX_VERTICES} vertices and corners of triangles together"
            raise self._records.wrong(place, expected, "more")

    def _placed_meshes(self) -> Iterator[tuple[int, Floats]]:
        """Meshes by number with their nodes' global transforms, down from the scene's roots.

        Nodes are a forest (section 3.5.2): one that is met twice is an error.
        """
        nodes = self._document.nodes
        if self._document.scenes:
            roots = self._records.at("scenes", self._document.scene, "scene").nodes
        else:
            children = {child for node in nodes for child in node.children}
            roots = tuple(n for n in range(len(nodes)) if n not in children)
        met: set[int] = set()
        pending = [(number, np.eye(4)) for number in reversed(roots)]
        while pending:
            number, parent = pending.pop()
            node = self._records.at("nodes", number, "a node's children")
            if number in met:
                raise self._records.wrong(
                    f"nodes[{number}]", "a node of one parent", "several, or a loop"
                )
            met.add(number)
            matrix = parent @ _local(node)
            if node.mesh is not None:
                self._records.at("meshes", node.mesh, f"nodes[{number}].mesh")
                yield node.mesh, matrix
            pending += [(child, matrix) for child in reversed(node.children)]

    def _mesh(self, number: int) -> Iterator[RawSurface]:
        for count, primitive in enumerate(self._document.meshes[number].primitives):
            if primitive.mode in (TRIANGLES, _STRIP, _FAN):
                yield self._primitive(primitive, f"meshes[{number}].primitives[{count}]")

    def _primitive(self, primitive: Primitive, place: str) -> RawSurface:
        if "POSITION" not in primitive.attributes:
            raise self._records.wrong(place, "the attribute POSITION", "none")
        positions = self._attribute(primitive, "POSITION", (3,), place)
        assert positions is not None
        if primitive.indices is None:
            order = np.arange(len(positions), dtype=np.int64)
        else:
            order = self._records.values(primitive.indices, (1,), f"{place}.indices")[:, 0]
            if order.dtype.kind != "u":
                raise self._records.wrong(f"{place}.indices", "unsigned integers", f"{order.dtype}")
        look, info = PLAIN, None
        if primitive.material is not None:
            material = self._records.at("materials", primitive.material, f"{place}.material")
            look = self._looks.get(primitive.material) or self._look(primitive.material)
            self._looks[primitive.material] = look
            info = material.pbr_metallic_roughness.base_color_texture
        colors = self._attribute(primitive, "COLOR_0", (3, 4), place)
        if colors is not None and colors.shape[1] == 3:
            colors = np.pad(colors, ((0, 0), (0, 1)), constant_values=1.0)
        triangles = _triangles(order.astype(np.int64), primitive.mode)
        self._count(len(positions) + triangles.size, place)
        return RawSurface(
            place,
            positions,
            triangles,
            normals=self._attribute(primitive, "NORMAL", (3,), place),
            texcoords=self._texcoords(primitive, info, place),
            colors=colors,
            look=look,
            crease=0.0,  # "client implementations MUST calculate flat normals" (section 3.7.2.1)
        )

    def _texcoords(
        self, primitive: Primitive, info: TextureInfo | None, place: str
    ) -> NDArray[np.floating[Any]] | None:
        channel, move = 0, Transform()
        if info is not None:
            move = info.extensions.transform or move
            channel = info.tex_coord if move.tex_coord is None else move.tex_coord
        given = self._attribute(primitive, f"TEXCOORD_{channel}", (2,), place)
        if given is None:
            return None
        cos, sin = math.cos(move.rotation), math.sin(move.rotation)
        turned = given * move.scale @ np.array([[cos, -sin], [sin, cos]])
        return np.asarray(turned + move.offset)

    def _attribute(
        self, primitive: Primitive, name: str, widths: tuple[int, ...], place: str
    ) -> NDArray[np.floating[Any]] | None:
        """(v, width) floats, one row for each vertex; integers are shares of their range."""
        if name not in primitive.attributes:
            return None
        place = f"{place}.{name}"
        values = self._records.values(primitive.attributes[name], widths, place)
        count = self._records.at("accessors", primitive.attributes["POSITION"], place).count
        if len(values) != count:
            raise self._records.wrong(place, f"{count} values, one a vertex", f"{len(values)}")
        if values.dtype.kind == "f":
            return values
        if not self._document.accessors[primitive.attributes[name]].normalized:
            raise self._records.wrong(place, "float32 or normalized integers", f"{values.dtype}")
        largest = float(np.iinfo(values.dtype).max)
        return np.maximum(values / largest, -1.0)  # section 3.6.2.2

    def _look(self, number: int) -> Look:
        material: Material = self._document.materials[number]
        surface, mode = material.pbr_metallic_roughness, material.alpha_mode
        place, clamps = f"materials[{number}]", False
        image: str | bytes | None = None
        info = surface.base_color_texture
        if info is not None:
            texture: Texture = self._records.at("textures", info.index, f"{place}.baseColorTexture")
            if texture.source is not None:
                image = self._records.image(texture.source, f"textures[{info.index}].source")
            if texture.sampler is not None:
                where = f"textures[{info.index}].sampler"
                sampler: Sampler = self._records.at("samplers", texture.sampler, where)
                clamps = sampler.wrap_s == sampler.wrap_t == _CLAMP_TO_EDGE
        if mode not in ("OPAQUE", "MASK", "BLEND"):
            raise self._records.wrong(f"{place}.alphaMode", "OPAQUE, MASK or BLEND", mode)
        red, green, blue, alpha = (min(max(value, 0.0), 1.0) for value in surface.base_color_factor)
        return Look(
            (red, green, blue, alpha),
            image,
            cutoff=material.alpha_cutoff if mode == "MASK" else None,
            is_blended=mode == "BLEND",
            is_two_sided=material.double_sided,
            clamps=clamps,
        )


def _local(node: Node) -> Floats:
    """(4, 4) ``parent_from_node``."""
    if node.matrix is not None:
        return np.array(node.matrix).reshape(4, 4).T  # column by column in the file
    x, y, z, w = np.array(node.rotation) / max(float(np.linalg.norm(node.rotation)), 1e-12)
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= node.scale
    matrix[:3, 3] = node.translation
    return matrix


def _placed(raw: RawSurface, matrix: Floats) -> RawSurface:
    """A surface moved by its node; a mirrored one keeps its front (section 3.7.4)."""
    linear = matrix[:3, :3]
    positions = raw.positions.astype(np.float64) @ linear.T + matrix[:3, 3]
    mirrored, normals = np.linalg.det(linear) < 0, raw.normals
    if normals is not None:
        cofactors = np.cross(np.roll(linear, -1, axis=0), np.roll(linear, -2, axis=0))
        normals = normals @ cofactors.T * (-1.0 if mirrored else 1.0)
    triangles = raw.triangles[:, ::-1] if mirrored else raw.triangles
    return replace(raw, positions=positions, triangles=triangles, normals=normals)


def _triangles(order: Ints, mode: int) -> Ints:
    """(t, 3) of a list, strip or fan (section 3.7.2.1); left-over corners are dropped."""
    if mode == TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    k = np.arange(max(len(order) - 2, 0))
    if mode == _FAN:
        return order[np.stack([k + 1, k + 2, np.zeros_like(k)], axis=1)]
    return order[np.stack([k, k + 1 + k % 2, k + 2 - k % 2], axis=1)]
