"""Quake II models (MD2) from animated triangles.

The records' dtypes are the reader's, `followspot.assets.md2`; other programs are asked in the tests
whether both are right. The bounds are those of ``qfiles.h`` of id Software's Quake II, so that the
game itself could load what is written here.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from followspot.arrays import Floats, Ints
from followspot.assets import md2
from followspot.errors import UsageError

MAX_VERTICES = 2048
MAX_TRIANGLES = 4096
MAX_FRAMES = 512
MAX_NAME = 13
"""Letters of an animation's name: two digits and a NUL share the frame's 16 bytes with it."""


@dataclass(frozen=True, eq=False)
class Md2Skin:
    """How an image is laid on the triangles.

    Attributes:
        image: The image's name in the game, ``models/robot/skin.jpg``; at most 63 letters.
        size: Its width and height in texels.
        texels: (k, 2) column and row of whole texels, whose middles are meant.
        triangles: (m, 3) indices into `texels`, corner by corner of the model's triangles.
    """

    image: str
    size: tuple[int, int]
    texels: Ints
    triangles: Ints


def md2_bytes(
    animations: Mapping[str, tuple[Floats, Floats]], triangles: Ints, skin: Md2Skin
) -> bytes:
    """Return a whole MD2 file; the same model always gives the same bytes.

    A vertex's coordinates are bytes on a grid that each frame lays for itself. All frames of an
    animation get the same one here, so that what stands still does not tremble.

    Args:
        animations: By name, the (frames, vertices, 3) positions in Quake units and unit normals.
            A frame is called by its animation's name and its number from ``01`` on.
        triangles: (m, 3) indices of vertices, clockwise from the front.
        skin: What they wear.

    Raises:
        UsageError: The model is beyond the game's bounds, or a name does not fit.
    """
    frames = np.concatenate([_frames(name, *moves) for name, moves in animations.items()])
    vertex_count = frames.dtype["vertices"].shape[0]
    for thing, count, limit in (
        ("vertices", vertex_count, MAX_VERTICES),
        ("triangles", len(triangles), MAX_TRIANGLES),
        ("frames", len(frames), MAX_FRAMES),
        ("letters in the skin's name", len(skin.image), md2.SKIN.itemsize - 1),
    ):
        if count > limit:
            raise UsageError(f"an MD2 model has at most {limit} {thing}, not {count}")
    corners = np.zeros(len(triangles), md2.TRIANGLE)
    corners["vertices"], corners["texcoords"] = triangles, skin.triangles
    lumps: dict[str, NDArray[Any]] = {
        "skins": np.array([skin.image.encode()], md2.SKIN),
        "texcoords": skin.texels.astype("<i2"),
        "triangles": corners,
        "frames": frames,
        "gl_commands": gl_commands(triangles, skin),
    }
    header = np.zeros((), md2.HEADER)
    header["magic"], header["version"], header["skin_size"] = md2.MAGIC, md2.VERSION, skin.size
    header["frame_bytes"], header["vertices_count"] = frames.itemsize, vertex_count
    offset = header.nbytes
    for name, lump in lumps.items():
        header[f"{name}_count"], header[f"{name}_offset"] = len(lump), offset
        offset += lump.nbytes
    header["end_offset"] = offset
    return b"".join([header.tobytes(), *(lump.tobytes() for lump in lumps.values())])


def _frames(name: str, positions: Floats, normals: Floats) -> NDArray[Any]:
    """One animation's frames as the file holds them, all on one grid."""
    if len(name) > MAX_NAME or name[-1:].isdigit() or len(positions) > 99:
        expected = f"a name of at most {MAX_NAME} letters, no digit last, and at most 99 frames"
        raise UsageError(f"an MD2 animation has {expected}: {name!r} has {len(positions)} frames")
    frames = np.zeros(len(positions), md2.frame_dtype(positions.shape[1]))
    low, high = positions.min(axis=(0, 1)), positions.max(axis=(0, 1))
    step = np.where(high > low, (high - low) / 255, 1.0)
    frames["name"] = [f"{name}{i + 1:02}" for i in range(len(frames))]
    frames["scale"], frames["translate"] = step, low
    frames["vertices"]["position"] = np.rint((positions - low) / step)
    frames["vertices"]["normal"] = (normals @ md2.NORMALS.T).argmax(axis=2)
    return frames


def gl_commands(triangles: Ints, skin: Md2Skin) -> NDArray[np.int32]:
    """Return the triangles once more as the fans that the game's renderer draws.

    Triangles in a row that turn round one corner make a fan: a negative count of vertices, then s,
    t (floats, 0 to 1) and number of each. A count of 0 ends them.
    """
    corners = np.stack([triangles, skin.triangles], axis=2)
    before, after = corners[:-1], corners[1:]
    same = (before[:, [0, 2]] == after[:, [0, 1]]).all(axis=(1, 2))
    starts = np.flatnonzero(np.concatenate([[True], ~same]))
    lengths = np.diff(starts, append=len(triangles))
    heads = np.concatenate([[0], np.cumsum(1 + 3 * (lengths + 2))])
    words = np.zeros(heads[-1] + 1, md2.GL_COMMAND)
    words[heads[:-1]] = -(lengths + 2)
    # where each triangle's last corner goes, and the first two corners of each fan
    place = np.arange(len(triangles)) - np.repeat(starts, lengths) + 2
    slots = np.concatenate([np.repeat(heads[:-1], lengths) + 1 + 3 * place, heads[:-1] + 1])
    slots = np.concatenate([slots, heads[:-1] + 4])
    drawn = np.concatenate([corners[:, 2], corners[starts, 0], corners[starts, 1]])
    st = ((skin.texels + 0.5) / skin.size).astype("<f4")[drawn[:, 1]]
    words[slots[:, None] + [0, 1]] = st.view(md2.GL_COMMAND)
    words[slots + 2] = drawn[:, 0]
    return words
