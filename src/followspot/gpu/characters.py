"""Figures in GPU memory: all key poses of each, uploaded once, and room for its instances."""

from collections.abc import Sequence

import moderngl
import numpy as np
from numpy.typing import NDArray

from followspot.errors import AssetError
from followspot.scene.character import SLOTS, Crowd
from followspot.scene.figure import Figure, FigurePart, Run
from followspot.scene.material import Material

POSE_ROW_BITS = 11
"""A row of a texture of key poses has two to the power of this many texels."""

VERTEX_FORMAT = "2f 2i"
"""Of `GpuFigure.vertices`, for moderngl: ``in_texcoord`` and ``in_vertex``."""

INSTANCE_FORMAT = " ".join(["12f 4f"] * SLOTS) + "/i"
"""Of `GpuFigure.instances`, for moderngl: ``in_world_from_PART`` and ``in_PART_pose`` by slot."""

_INSTANCE_BYTES = SLOTS * 16 * 4
"""Of one character: `Crowd.instances`."""


class GpuFigure:
    """A figure, whose parts are drawn together.

    Attributes:
        key_poses: Texture of two texels a vertex: position, unit normal; part after part, of each
            frame after frame.
        vertices: Buffer of (s, t), the part's slot, and the number in the texture of the vertex as
            it is in the part's first key pose.
        indices: Buffer of uint32, in the order of `runs`.
        runs: One for each material; solid ones of one state stand next to each other.
        instances: Buffer of the figure's characters, rows of `Crowd.instances`.
        light: Buffer of (r, g, b) of what was baked for their places, linear.

    Raises:
        AssetError: it has more key poses than this OpenGL can hold in a texture.
    """

    def __init__(self, context: moderngl.Context, figure: Figure, characters: int) -> None:
        _require_room(figure, context.info["GL_MAX_TEXTURE_SIZE"])
        self.key_poses = _upload_poses(context, figure)
        # Some of the game's models have tags alone; GL wants a byte or more in every buffer.
        self.vertices = context.buffer(_vertices(figure.parts).tobytes() or bytes(16))
        indices, self.runs = _joined(figure.parts)
        self.indices = context.buffer(indices.tobytes() or bytes(4))
        self.instances = context.buffer(reserve=characters * _INSTANCE_BYTES, dynamic=True)
        self.light = context.buffer(reserve=characters * 12, dynamic=True)

    def release(self) -> None:
        """Give the GL objects back."""
        buffers = self.vertices, self.indices, self.instances, self.light
        for thing in (self.key_poses, *buffers):
            thing.release()


class GpuCrowd:
    """All figures of a crowd.

    Attributes:
        figures: In the crowd's order.

    Raises:
        AssetError: as of `GpuFigure`.
    """

    def __init__(self, context: moderngl.Context, crowd: Crowd) -> None:
        self.figures: list[GpuFigure] = []
        counts = np.bincount(crowd.figure_of).tolist()
        try:
            for figure, count in zip(crowd.figures, counts, strict=True):
                self.figures.append(GpuFigure(context, figure, count))
        except AssetError:
            self.release()
            raise

    def release(self) -> None:
        """Give the GL objects back."""
        for figure in self.figures:
            figure.release()


def _key_vertices(part: FigurePart) -> int:
    """Vertices of all its key poses together."""
    return len(part.positions) * part.vertex_count


def _rows(figure: Figure) -> int:
    """Rows of texels that all its key poses take."""
    texels = 2 * sum(_key_vertices(part) for part in figure.parts)
    return max(-(-texels >> POSE_ROW_BITS), 1)


def _require_room(figure: Figure, limit: int) -> None:
    rows = _rows(figure)
    if max(rows, 1 << POSE_ROW_BITS) > limit:
        raise AssetError(
            figure.name,
            expected=f"at most {limit << (POSE_ROW_BITS - 1)} vertices in all frames together, "
            "for this OpenGL",
            found=f"{rows << (POSE_ROW_BITS - 1)}",
        )


def _upload_poses(context: moderngl.Context, figure: Figure) -> moderngl.Texture:
    """Float texels: whatever a file's own precision is, a key pose comes out as it is there."""
    rows, end = _rows(figure), 0
    texels = np.zeros((rows << POSE_ROW_BITS, 4), "<f4")
    for part in figure.parts:
        start, end = end, end + 2 * _key_vertices(part)
        pairs = texels[start:end].reshape(*part.positions.shape[:2], 2, 4)
        pairs[..., 0, :3] = part.positions
        pairs[..., 1, :3] = part.normals
    texture = context.texture((1 << POSE_ROW_BITS, rows), 4, texels, dtype="f4")
    texture.filter = moderngl.NEAREST, moderngl.NEAREST
    return texture


def _vertices(parts: Sequence[FigurePart]) -> NDArray[np.void]:
    """(vertices of all parts,) in `VERTEX_FORMAT`."""
    vertices = np.zeros(
        sum(part.vertex_count for part in parts),
        [("texcoord", "<f4", 2), ("slot", "<i4"), ("number", "<i4")],
    )
    end = first_key = 0
    for part in parts:
        start, end = end, end + part.vertex_count
        own = vertices[start:end]
        own["texcoord"] = part.texcoords
        own["slot"] = part.slot
        own["number"] = first_key + np.arange(part.vertex_count)
        first_key += _key_vertices(part)
    return vertices


def _joined(parts: Sequence[FigurePart]) -> tuple[NDArray[np.uint32], tuple[Run, ...]]:
    """(i,) indices into `_vertices`, and which of them wear what."""
    worn: dict[Material, list[NDArray[np.uint32]]] = {}
    start = 0
    for part in parts:
        for run in part.runs:
            own = part.indices[run.first : run.first + run.count] + np.uint32(start)
            worn.setdefault(run.material, []).append(own)
        start += part.vertex_count
    indices, runs, end = [np.empty(0, "<u4")], [], 0
    for material in sorted(worn, key=_state):
        own = np.concatenate(worn[material])
        runs.append(Run(material, end, len(own)))
        indices.append(own.astype("<u4"))
        end += len(own)
    return np.concatenate(indices), tuple(runs)


def _state(material: Material) -> tuple[bool, bool, str]:
    """What casters are told apart by."""
    return material.blend is not None, material.alpha_test is not None, material.sides.name
