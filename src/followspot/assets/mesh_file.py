"""Triangle meshes of other programs: glTF, GLB, OBJ and PLY files.

`gltf` reads the first two. OBJ and PLY are taken apart by trimesh, which is handed nothing but
bytes: it opens no file and decodes no image, and what it stumbles over is an `AssetError`. Their
colours are display values, as painted in a picture, and are decoded as such; glTF's are linear.

Sources: Wavefront's "Advanced Visualizer Manual", appendix B (OBJ and MTL); Turk, "The PLY Polygon
File Format" (1994).
"""

import codecs
import io
import logging
import math
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from followspot.arrays import Floats
from followspot.assets.gltf import read_gltf
from followspot.assets.gltf_records import FindFile
from followspot.assets.image import srgb_to_linear
from followspot.assets.mesh_record import (
    MAX_SURFACES,
    MAX_VERTICES,
    PLAIN,
    Look,
    MeshFile,
    RawSurface,
    finish,
)
from followspot.errors import AssetError

MESH_SUFFIXES = (".glb", ".gltf", ".obj", ".ply")
"""Endings of the files that are read here."""

_MAX_BYTES = 1 << 28

_IMAGE = re.compile(rb"^comment\s+TextureFile\s+(.+?)\s*$", re.MULTILINE | re.IGNORECASE)
_LIBRARY = re.compile(r"^\s*mtllib[ \t]+(.+?)[ \t\r]*$", re.MULTILINE)
_USED = re.compile(r"^usemtl\b.*$", re.MULTILINE)
_RELATIVE = re.compile(r"^f[ \t][^\n]*?[\s/]-", re.MULTILINE)


def read_mesh(data: bytes, source: str, suffix: str, find_file: FindFile) -> MeshFile:
    """Read a mesh file.

    glTF's positions are metres with Y up, as the format says; the others' are as they come.

    Args:
        data: The whole file.
        source: Its name for errors.
        suffix: Which format it is, one of `MESH_SUFFIXES`.
        find_file: Reads what it names beside it: buffers, material libraries. Images are named,
            not read.

    Raises:
        AssetError: it is no such file, is cut short, lies, or holds no triangles.
    """
    if len(data) > _MAX_BYTES:
        raise AssetError(source, expected=f"at most {_MAX_BYTES} bytes", found=f"{len(data)}")
    if suffix in (".glb", ".gltf"):
        return read_gltf(data, source, find_file)
    read = _read_obj if suffix == ".obj" else _read_ply
    return read(data, source, find_file)


def _read_obj(data: bytes, source: str, find_file: FindFile) -> MeshFile:
    from trimesh.exchange.obj import load_obj

    text = _decoded(data)
    if (relative := _RELATIVE.search(text)) is not None:
        # trimesh counts them from the file's end, not from the line that they stand in.
        line = text.count("\n", 0, relative.start()) + 1
        expected, found = "indices from 1 on", "one that counts back"
        raise AssetError(source, place=f"line {line}", expected=expected, found=found)
    if len(set(_USED.findall(text))) > MAX_SURFACES:
        raise AssetError(source, expected=f"at most {MAX_SURFACES} materials", found="more")
    looks: dict[str, Look] = {}
    problems = []
    for name in dict.fromkeys(_LIBRARY.findall(text)):
        library = find_file(name)
        if library is None:
            expected = "a material library beside it"
            problems.append(AssetError(source, place="mtllib", expected=expected, found=name))
        else:
            looks |= _library(_decoded(library))
    stub = "\n".join(f"newmtl {name}" for name in looks).encode()
    loaded = _ask(load_obj, text.encode(), source, resolver=_Resolver(stub))
    surfaces = (
        _raw(name, values, looks.get(_material_name(values), PLAIN))
        for name, values in loaded.get("geometry", {}).items()
    )
    return _finished(surfaces, source, tuple(problems))


def _decoded(data: bytes) -> str:
    """Text in UTF-8, or UTF-16 if a mark says so, else in Latin-1, which takes everything."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", "replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _read_ply(data: bytes, source: str, find_file: FindFile) -> MeshFile:
    from trimesh.exchange.ply import load_ply

    header, end, _ = data.partition(b"end_header")
    if not data.startswith(b"ply") or not end:
        raise AssetError(source, place="header", expected="ply to end_header", found="another")
    image = _IMAGE.search(header)
    look = PLAIN if image is None else Look(image=_decoded(image[1]))
    loaded = _ask(load_ply, data, source, skip_materials=True)
    return _finished(iter([_raw("mesh", loaded, look)]), source, ())


class _Resolver(dict[str, bytes]):
    """What trimesh finds under every name: a material library that tells names alone."""

    def __init__(self, library: bytes) -> None:
        self._library = library

    def __getitem__(self, name: str) -> bytes:
        return self._library


def _ask(
    load: Callable[..., dict[str, Any]], data: bytes, source: str, **options: Any
) -> dict[str, Any]:
    """What one of trimesh's readers makes of a file; whatever it stumbles over is the file's."""
    logging.getLogger("trimesh").addHandler(logging.NullHandler())  # nothing on stderr
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # NumPy's, at text that is cut off
            return load(io.BytesIO(data), **options)
    except Exception as error:
        found = f"bytes that are not ({' '.join(str(error).split()) or type(error).__name__})"
        raise AssetError(source, expected="a whole mesh", found=found[:200]) from error


def _material_name(values: Mapping[str, Any]) -> str:
    return getattr(getattr(values.get("visual"), "material", None), "name", None) or ""


def _raw(place: str, values: Mapping[str, Any], look: Look) -> RawSurface:
    """A surface from what trimesh hands to its own classes."""
    positions = _numbers(values.get("vertices"), 3)
    faces = np.asarray(values.get("faces"))
    if positions is None or faces.ndim != 2 or faces.dtype.kind not in "iu":
        return RawSurface(place, np.empty((0, 3)), np.empty((0, 3), np.int64))
    corner = np.arange(1, faces.shape[-1] - 1)  # polygons are fans
    fans = np.stack([np.zeros_like(corner), corner, corner + 1], axis=1)
    texcoords = _numbers(getattr(values.get("visual"), "uv", None), 2, count=len(positions))
    if texcoords is not None:
        texcoords = np.stack([texcoords[:, 0], 1 - texcoords[:, 1]], axis=1)  # v was upwards
    return RawSurface(
        place,
        positions,
        faces[:, fans].reshape(-1, 3),
        normals=_numbers(values.get("vertex_normals"), 3, count=len(positions)),
        texcoords=texcoords,
        colors=_colors(values.get("vertex_colors"), len(positions)),
        look=look,
    )


def _numbers(given: Any, *widths: int, count: int | None = None) -> Floats | None:
    """(count, width) of finite or other numbers, or none where trimesh made something else."""
    values = np.asarray(given)
    if values.dtype.kind not in "iuf" or values.ndim != 2 or values.shape[-1] not in widths:
        return None
    return values.astype(np.float64) if count in (None, len(values)) else None


def _colors(given: Any, count: int) -> Floats | None:
    """(v, 4) linear from bytes or numbers from 0 to 1, both display values."""
    colors = _numbers(given, 3, 4, count=count)
    if colors is None:
        return None
    if np.asarray(given).dtype.kind != "f" or colors.max(initial=0) > 1:
        colors = colors / 255
    linear = srgb_to_linear(np.clip(colors[:, :3], 0, 1))
    alpha = colors[:, 3:] if colors.shape[-1] == 4 else np.ones((count, 1))
    return np.concatenate([linear, alpha], axis=1)


def _finished(
    surfaces: Iterator[RawSurface], source: str, problems: tuple[AssetError, ...]
) -> MeshFile:
    done, corners = [], 0
    for raw in surfaces:
        corners += max(len(raw.positions), raw.triangles.size)
        if corners > MAX_VERTICES:
            expected = f"at most {MAX_VERTICES} vertices and corners of triangles"
            raise AssetError(source, place=raw.place, expected=expected, found="more")
        if raw.triangles.size:
            done.append(finish(raw, source))
    if not done:
        raise AssetError(source, expected="triangles", found="none")
    return MeshFile(source, tuple(done), problems)


def _library(text: str) -> dict[str, Look]:
    """A material library's entries by name: diffuse colour, its image, opacity."""
    looks: dict[str, Look] = {}
    name = ""
    for line in text.splitlines():
        key, rest = [*line.strip().split(maxsplit=1), "", ""][:2]
        key, words = key.lower(), rest.split()
        if key == "newmtl" and words:
            name = " ".join(words)
            looks[name] = PLAIN
        if name not in looks or not words:
            continue
        look = looks[name]
        color, numbers = look.color, [_number(word) for word in words]
        match key:
            case "kd":
                grey_or_rgb = numbers * 3 if len(numbers) < 3 else numbers
                red, green, blue = srgb_to_linear(np.array(grey_or_rgb[:3])).tolist()
                looks[name] = replace(look, color=(red, green, blue, color[3]))
            case "d" | "tr":
                alpha = numbers[-1] if key == "d" else 1 - numbers[-1]
                looks[name] = replace(look, color=(*color[:3], alpha), is_blended=alpha < 1)
            case "map_kd":
                # Options begin with a minus; without any, all of the line is the name.
                image = words[-1] if words[0].startswith("-") else rest
                looks[name] = replace(look, image=image)
    return looks


def _number(word: str) -> float:
    """A number from 0 to 1; 1 for what is none."""
    try:
        return min(max(float(word), 0.0), 1.0) if math.isfinite(float(word)) else 1.0
    except ValueError:
        return 1.0
