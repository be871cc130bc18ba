"""Levels to test with: built of the reader's own dtypes, by hand, and OpenArena's."""

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.assets.bsp import HEADER, LUMPS

OPENARENA = Path("/usr/share/games/openarena/baseoa")

Lumps = dict[str, NDArray[Any]]


def openarena_levels() -> Iterator[tuple[str, bytes]]:
    """Every level of OpenArena's paks, also those that later paks replace: source, bytes."""
    paks = sorted(OPENARENA.glob("*.pk3"))
    assert paks, f"OpenArena's data is not installed in {OPENARENA}"
    for pak in paks:
        with zipfile.ZipFile(pak) as file:
            for name in file.namelist():
                if name.lower().endswith(".bsp"):
                    yield f"{pak.name}:{name}", file.read(name)


def openarena_level(pak: str, name: str) -> bytes:
    with zipfile.ZipFile(OPENARENA / pak) as file:
        return file.read(f"maps/{name}.bsp")


def records(lump: str, *rows: tuple[Any, ...]) -> NDArray[Any]:
    return np.array(list(rows), dtype=LUMPS[lump])


def small_level() -> Lumps:
    """Two rooms side by side, with one face of each type, a door, fog and light."""
    entities = b'{\n"classname" "worldspawn"\n"Message" "Two rooms"\n}\n{ "classname" "light" }\n\0'
    box = ((-64, -64, -64), (64, 64, 64))
    vertices = np.zeros(19, LUMPS["vertices"])
    vertices["position"] = np.linspace((-64, -64, -64), (64, 64, 64), 19)
    vertices["normal"] = (0, 0, 1)
    vertices["color"] = np.arange(19 * 4).reshape(19, 4)
    faces = np.zeros(5, LUMPS["faces"])
    faces["type"] = (1, 2, 3, 4, 1)
    faces["effect"] = (-1, 0, -1, -1, -1)
    faces["shader"] = (0, 1, 1, 2, 0)
    faces["first_vertex"] = (0, 4, 13, 16, 0)
    faces["vertex_count"] = (4, 9, 3, 0, 4)
    faces["first_index"] = (0, 0, 6, 0, 0)  # the last face shares the first one's indices
    faces["index_count"] = (6, 0, 3, 0, 6)
    faces["lightmap"] = (0, -3, -2, -1, 0)
    faces["patch_size"][1] = (3, 3)
    lightmaps = np.zeros(1, LUMPS["lightmaps"])
    lightmaps[:] = np.arange(128)[:, np.newaxis, np.newaxis]
    visibility = np.zeros(8 + 2 * 8, "u1")
    visibility[[0, 4]] = (2, 8)
    visibility[[8, 16]] = (0b11, 0b10)  # the first room sees both, the second itself only
    return {
        "entities": np.frombuffer(entities, "u1"),
        "shaders": records(
            "shaders",
            (b"textures/base/wall", 0, 1),
            (b"Textures\\Base\\Arch\0.tga rubbish", 0x400, 0x80000000),
            (b"flareShader", 0, 0),
        ),
        "planes": records(
            "planes",
            ((1, 0, 0), 64),
            ((-1, 0, 0), 64),
            ((0, 1, 0), 64),
            ((0, -1, 0), 64),
            ((0, 0, 1), 64),
            ((0, 0, -1), 64),
            ((1, 0, 0), 0),
        ),
        # Six walls in a chain, everything in front of them solid; then the plane between.
        "nodes": records(
            "nodes",
            *((i, (~1, i + 1), *box) for i in range(6)),
            (6, (~2, ~3), *box),
        ),
        "leafs": records(
            "leafs",
            (0, 0, *box, 0, 0, 0, 0),
            (-1, -1, *box, 0, 0, 0, 1),
            (0, 0, *box, 0, 3, 1, 1),
            (1, 0, *box, 3, 1, 2, 0),
        ),
        "leaf_faces": np.array([0, 1, 2, 3], "<i4"),
        "leaf_brushes": np.array([1, 0], "<i4"),
        "models": records("models", (*box, 0, 4, 0, 1), (*box, 4, 1, 1, 1)),
        "brushes": records("brushes", (0, 6, 0), (6, 6, 1)),
        "brush_sides": records("brush_sides", *((i % 6, i % 3) for i in range(12))),
        "vertices": vertices,
        "indices": np.array([0, 1, 2, 0, 2, 3, 2, 1, 0], "<i4"),
        "effects": records("effects", (b"textures/sfx/fog", 1, 5)),
        "faces": faces,
        "lightmaps": lightmaps,
        "light_grid": records("light_grid", *(((i, 1, 2), (3, 4, 5), (6, 7)) for i in range(4))),
        "visibility": visibility,
    }


def write_bsp(lumps: Lumps, version: int = 46) -> bytes:
    """Write lumps one behind the other, in the directory's order."""
    header = np.zeros((), HEADER)
    header["magic"], header["version"] = b"IBSP", version
    body = b""
    for i, name in enumerate(LUMPS):
        raw = np.ascontiguousarray(lumps[name]).tobytes()
        header["directory"][i] = (HEADER.itemsize + len(body), len(raw))
        body += raw
    return header.tobytes() + body


# A level written out by hand from the format's description, so that a wrong dtype cannot agree
# with a file that was made of it. Numbers are little-endian; 0000803f is 1.0, 00000040 is 2.0,
# 00004040 is 3.0, 00008040 is 4.0, 0000a040 is 5.0 and so on.
HEX_HEADER = """
    # magic, version; then offset and length of each lump
    49425350 2e000000   90000000 09000000   9c000000 48000000   e4000000 10000000
    f4000000 24000000   18010000 60000000   78010000 04000000   7c010000 04000000
    80010000 28000000   a8010000 0c000000   b4010000 08000000   bc010000 58000000
    14020000 14000000   28020000 48000000   70020000 68000000   d8020000 00c00000
    d8c20000 08000000   e0c20000 09000000
"""
HEX_LUMPS = """
    7b 226122 226222 7d 00 000000  # { "a" "b" }, NUL; 3 bytes of padding

    412f425c43 00 78787878 00000000 00000000 00000000  # shader: A/B\\C, NUL, rubbish
    0000000000000000000000000000000000000000
    00000000000000000000000000000000000000000000
    84000000 01000080  # surface flags, content flags

    00000000 00000000 0000803f 00000041  # plane: normal 0 0 1, distance 8

    00000000 feffffff ffffffff  # node: plane 0, leaf 1 before, 0 behind
    ffffffff feffffff fdffffff 04000000 05000000 06000000

    00000000 07000000  # leaf 0: cluster 0, area 7
    01000000 02000000 03000000 04000000 05000000 06000000
    00000000 01000000 01000000 00000000  # 1 face from 0, 0 brushes from 1
    ffffffff ffffffff  # leaf 1: cluster -1, area -1
    00000000 00000000 00000000 00000000 00000000 00000000
    01000000 00000000 00000000 01000000  # 0 faces from 1, 1 brush from 0

    00000000  # leaf face 0

    00000000  # leaf brush 0

    000080bf 000000c0 000040c0 0000803f 00000040 00004040  # model: box from -1 -2 -3 to 1 2 3
    00000000 01000000 01000000 00000000  # 1 face from 0, 0 brushes from 1

    00000000 01000000 00000000  # brush: 1 side from 0, shader 0

    00000000 00000000  # brush side: plane 0, shader 0

    00000000 00000000 00000000 00000000 00000000 00000000  # vertex 0: all zero
    00000000 00000000 00000000 00000000 00000000
    0000803f 00000040 00004040  # vertex 1: position 1 2 3
    00008040 0000a040 0000c040 0000e040  # texture 4 5, lightmap 6 7
    00000000 000080bf 00000000 0a141eff  # normal 0 -1 0, color 10 20 30 255

    05000000 04000000 00000000 00000000 00000000  # indices 5 4 0 0 0

    666f67 00 00000000 00000000 00000000 00000000 00000000  # effect: fog
    00000000000000000000000000000000000000000000000000000000
    000000000000000000000000
    00000000 ffffffff  # brush 0, no side

    00000000 ffffffff 03000000  # face: shader 0, effect -1, a mesh
    01000000 01000000 02000000 03000000  # 1 vertex from 1, 3 indices from 2
    00000000 08000000 09000000 0a000000 0b000000  # lightmap 0 at 8 9, size 10 11
    0000803f 00000040 00004040  # lightmap origin 1 2 3
    00008040 0000a040 0000c040 0000e040 00000041 00001041  # lightmap axes 4 5 6, 7 8 9
    00000000 0000803f 00000000 0c000000 0d000000  # normal 0 1 0, patch 12 13
"""
HEX_TAIL = """
    010203 040506 0708  # light grid: ambient, directed, direction

    01000000 01000000 01  # 1 cluster in rows of 1 byte: sees itself
"""


def hand_written_level() -> bytes:
    lightmap = bytes.fromhex("ff8040") + bytes(128 * 128 * 3 - 6) + bytes.fromhex("0a0b0c")
    return _from_hex(HEX_HEADER) + _from_hex(HEX_LUMPS) + lightmap + _from_hex(HEX_TAIL)


def _from_hex(text: str) -> bytes:
    return bytes.fromhex("".join(line.partition("#")[0] for line in text.splitlines()))
