"""Models to test with: built of the readers' own dtypes, by hand, and OpenArena's."""

import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.assets import md2, md3
from followspot.assets.animation import ANIMATION_NAMES

OPENARENA = Path("/usr/share/games/openarena/baseoa")
MD2_MODELS = Path("/usr/share/assimp/models/MD2")

Lumps = dict[str, NDArray[Any]]


def from_hex(text: str) -> bytes:
    return bytes.fromhex("".join(line.partition("#")[0] for line in text.splitlines()))


def openarena_files(suffix: str) -> Iterator[tuple[str, bytes]]:
    """Every file of OpenArena's paks that ends so, also those that later paks replace."""
    paks = sorted(OPENARENA.glob("*.pk3"))
    assert paks, f"OpenArena's data is not installed in {OPENARENA}"
    for pak in paks:
        with zipfile.ZipFile(pak) as file:
            for name in file.namelist():
                if name.lower().endswith(suffix):
                    yield f"{pak.name}:{name}", file.read(name)


def md2_models() -> list[Path]:
    models = sorted(MD2_MODELS.glob("*.md2"))
    assert len(models) >= 2, f"assimp-testmodels is not installed in {MD2_MODELS}"
    return models


def facing(positions: NDArray[Any], normals: NDArray[Any], indices: NDArray[Any]) -> NDArray[Any]:
    """(triangles,) > 0 where a triangle, seen as clockwise, faces the way of its normals."""
    a, b, c = positions[indices.reshape(-1, 3)].astype(np.float64).transpose(1, 0, 2)
    mean = normals[indices.reshape(-1, 3)].mean(axis=1)
    dots: NDArray[Any] = (np.cross(c - a, b - a) * mean).sum(axis=1)
    return dots


MD2_ORDER = ("skins", "texcoords", "triangles", "frames", "gl_commands")


def small_md2() -> Lumps:
    """A folded square whose fold is a seam of the skin, in three frames."""
    frames = np.zeros(3, md2.frame_dtype(4))
    frames["scale"] = [(1, 1, 1), (0.5, 1, 2), (1, 1, 1)]
    frames["translate"] = [(0, 0, 0), (1, 2, 3), (-1, -1, -1)]
    frames["name"] = [b"run1", b"run2", b"stand01\0rubbish"]
    frames["vertices"]["position"] = [(0, 0, 0), (0, 2, 0), (2, 2, 0), (2, 0, 1)]
    frames["vertices"]["normal"] = [[5, 5, 5, 5], [0, 1, 2, 161], [5, 5, 5, 5]]
    triangles = np.array([((0, 1, 2), (0, 1, 2)), ((0, 2, 3), (0, 4, 3))], md2.TRIANGLE)
    strip = [4, 0, 0, 1, 0, 0, 0, 0, 0, 2, 0, 0, 3]
    fan = [-3, 0, 0, 0, 0, 0, 1, 0, 0, 2]
    return {
        "skins": np.array([b"players/Bot\\Skin.PCX\0xx"], md2.SKIN),
        "texcoords": np.array([(0, 0), (0, 8), (8, 8), (8, 0), (9, -1)], "<i2"),
        "triangles": triangles,
        "frames": frames,
        "gl_commands": np.array([*strip, *fan, 0], md2.GL_COMMAND),
    }


def write_md2(lumps: Lumps, **fields: Any) -> bytes:
    """Write lumps one behind the other; ``fields`` replace the header's."""
    header = np.zeros((), md2.HEADER)
    frames = lumps["frames"]
    header["magic"], header["version"], header["skin_size"] = b"IDP2", 8, (16, 8)
    header["frame_bytes"] = frames.itemsize
    header["vertices_count"] = frames.dtype["vertices"].shape[0]
    body = b""
    for name in MD2_ORDER:
        header[f"{name}_count"] = len(lumps[name])
        header[f"{name}_offset"] = md2.HEADER.itemsize + len(body)
        body += np.ascontiguousarray(lumps[name]).tobytes()
    header["end_offset"] = md2.HEADER.itemsize + len(body)
    for field, value in fields.items():
        header[field] = value
    return header.tobytes() + body


# Models written out by hand from the formats' descriptions, so that a wrong dtype cannot agree
# with a file that was made of it. Numbers are little-endian; 0000803f is 1.0, 00000040 is 2.0.
HAND_MD2 = from_hex("""
    49445032 08000000   # magic, version
    04000000 02000000 34000000  # skin 4 x 2, frames of 52 bytes
    01000000 03000000 03000000 01000000 0b000000 01000000  # skins vertices st triangles gl frames
    44000000 84000000 90000000 9c000000 d0000000 fc000000  # skins st triangles frames gl end

    412f622e706378 00 78787878 00000000  # skin: A/b.pcx, NUL, rubbish
    000000000000000000000000000000000000000000000000
    000000000000000000000000000000000000000000000000

    0000 0000   0300 0100   ffff 0200  # st: 0 0, 3 1, -1 2

    0000 0100 0200   0200 0100 0000  # triangle: vertices 0 1 2, st 2 1 0

    0000803f 00000040 0000003f  # frame: scale 1 2 0.5
    000080bf 00000000 00000041  # translate -1 0 8
    73616c757465 3031 00 ff000000000000  # salute01, NUL, rubbish
    000000 00   ff0000 05   01020a 20  # vertices: x y z normal

    03000000 00000000 0000803f 00000000  0000003f 00000000 01000000  00000000 00000000 02000000
    00000000  # strip of 3: s t vertex; end
""")


def small_md3() -> dict[str, Any]:
    """Two triangles in two surfaces, two frames and two tags."""
    frames = np.zeros(2, md3.FRAME)
    frames["mins"], frames["maxs"], frames["radius"] = (-1, -1, -1), (1, 1, 1), 1.75
    frames["name"] = [b"one", b"two"]
    tags = np.zeros((2, 2), md3.TAG)
    tags["name"] = [b"tag_torso", b"Tag_Flash\0rubbish"]
    tags["origin"] = [[(0, 0, 8), (1, 0, 0)], [(0, 2, 8), (0, 1, 0)]]
    tags["axes"] = np.eye(3)
    tags["axes"][1, 0] = [(0, 3, 0), (-3, 0, 0), (0, 0, 3)]  # a quarter turn about Z, stretched
    return {"frames": frames, "tags": tags, "surfaces": [_surface(b"L_Legs_1"), _surface(b"belt")]}


def _surface(name: bytes) -> Lumps:
    vertices = np.zeros((2, 3), md3.VERTEX)
    vertices["position"] = [(0, 0, 0), (0, 64, 0), (64, 64, 32)]
    vertices["position"][1] += 640
    vertices["zenith"], vertices["azimuth"] = [0, 64, 128], [7, 64, 0]
    return {
        "name": np.array(name),
        "triangles": np.array([(0, 1, 2)], "<i4"),
        "shaders": np.array([(b"Models\\Bot.tga\0xx", 0)], md3.SHADER),
        "texcoords": np.array([(0, 0), (0, 1), (1, 0.5)], "<f4"),
        "vertices": vertices,
    }


def write_md3(model: dict[str, Any], **fields: Any) -> bytes:
    """Write a model; ``fields`` replace the header's, and a surface's by ``surface_``."""
    header = np.zeros((), md3.HEADER)
    header["magic"], header["version"] = b"IDP3", 15
    frames, tags = model["frames"], model["tags"]
    header["frames_count"], header["tags_count"] = len(frames), tags.shape[1]
    header["surfaces_count"] = len(model["surfaces"])
    header["frames_offset"] = md3.HEADER.itemsize
    header["tags_offset"] = md3.HEADER.itemsize + frames.nbytes
    header["surfaces_offset"] = md3.HEADER.itemsize + frames.nbytes + tags.nbytes
    body = frames.tobytes() + tags.tobytes()
    for surface in model["surfaces"]:
        record = np.zeros((), md3.SURFACE)
        record["magic"], record["name"] = b"IDP3", surface["name"]
        record["frames_count"] = len(frames)
        record["vertices_count"] = surface["vertices"].shape[1]
        inner = b""
        for lump in ("triangles", "shaders", "texcoords", "vertices"):
            if lump in ("triangles", "shaders"):
                record[f"{lump}_count"] = len(surface[lump])
            record[f"{lump}_offset"] = md3.SURFACE.itemsize + len(inner)
            inner += np.ascontiguousarray(surface[lump]).tobytes()
        record["end_offset"] = md3.SURFACE.itemsize + len(inner)
        for field, value in fields.items():
            if field.startswith("surface_"):
                record[field.removeprefix("surface_")] = value
        body += record.tobytes() + inner
    header["end_offset"] = md3.HEADER.itemsize + len(body)
    for field, value in fields.items():
        if not field.startswith("surface_"):
            header[field] = value
    data: bytes = header.tobytes() + body
    return data


HAND_MD3 = from_hex(f"""
    49445033 0f000000  626f74 00 {"00" * 60}  00000000  # magic, version, name, flags
    01000000 01000000 01000000 00000000  # a frame, a tag, a surface, no skin
    6c000000 a4000000 14010000 00020000  # frames tags surfaces end

    000080bf 00000000 00000000   0000803f 00000040 00004040  # frame: -1 0 0 to 1 2 3
    00000000 0000003f 00000000   00008040   62617365 00 {"ff" * 11}  # origin, radius 4, name

    7461675f 68656164 00 {"78" * 55}  # tag_head, NUL, rubbish
    0000803f 00000040 00004040  # origin 1 2 3
    00000000 0000803f 00000000   000080bf 00000000 00000000  # axes: Y, -X,
    00000000 00000000 0000803f  # Z

    49445033  555f546f72736f5f 31 00 {"00" * 54}  00000000  # magic, U_Torso_1, flags
    01000000 01000000 03000000 01000000  # frame, shader, vertices, triangle
    b0000000 6c000000 bc000000 d4000000 ec000000  # triangles shaders st vertices end

    6d2f412e746761 00 {"00" * 56}  00000000  # shader: m/A.tga, index
    02000000 01000000 00000000  # triangle 2 1 0
    00000000 00000000  0000803f 00000000  0000003f 0000803f  # st: 0 0, 1 0, 0.5 1
    4000 8000 c0ff 00 00  # vertex 1 2 -1, zenith 0
    0000 0000 0000 40 40  # at the origin, zenith and azimuth a quarter: +Y
    ff7f 0080 0100 40 80  # the corners of the range, azimuth a half: -X
""")


def animation_config(head: str = "sex m\n") -> str:
    """A config of 25 animations of one frame each, the legs' behind 7 torso frames."""
    rows = [f"{i}\t1\t1\t{10 + i}\t// {name}" for i, name in enumerate(ANIMATION_NAMES)]
    return "\r\n".join([head, *rows, ""])


def write_player(game: Path, name: str = "bot") -> Path:
    """Write a player of three equal parts into a game folder, and return its own folder."""
    folder = game / "models" / "players" / name
    folder.mkdir(parents=True)
    for part, tags in (
        ("lower", (b"tag_torso", b"tag_x")),
        ("upper", (b"tag_head", b"tag_weapon")),
        ("head", (b"tag_x", b"tag_y")),
    ):
        model = small_md3()
        frames = 25
        model["frames"] = np.repeat(model["frames"][:1], frames)
        model["tags"] = model["tags"][np.arange(frames) % 2]
        model["tags"]["name"] = tags
        for surface in model["surfaces"]:
            surface["vertices"] = surface["vertices"][np.arange(frames) % 2]
        (folder / f"{part}.md3").write_bytes(write_md3(model))
        skin = f"l_legs,models/players/{name}/{part}\r\nbelt,belt.tga\ntag_torso,\n"
        (folder / f"{part}_default.skin").write_text(skin)
    (folder / "animation.cfg").write_text(animation_config())
    return folder
