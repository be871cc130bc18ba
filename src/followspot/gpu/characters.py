"""Figures in GPU memory: all key poses of each, uploaded once, and room for its instances."""

import moderngl
import numpy as np

from followspot.errors import AssetError
from followspot.scene.character import SLOTS, Crowd
from followspot.scene.figure import Figure, FigurePart

POSE_ROW_BITS = 11
"""A row of a texture of key poses has two to the power of this many texels."""

_INSTANCE_BYTES = SLOTS * 16 * 4
"""Of one character: `Crowd.instances`."""


class GpuPart:
    """One part of a figure.

    Attributes:
        part: What was uploaded.
        figure: Number of its figure in the crowd.
        key_poses: Texture of two texels a vertex, frame after frame: position, unit normal.
        texcoords: Buffer of (s, t) by vertex.
        indices: Buffer of uint32.
        instances: Buffer of the figure's characters; `instance_format` tells where the part's rows
            are in it.
    """

    def __init__(
        self, context: moderngl.Context, figure: int, part: FigurePart, instances: moderngl.Buffer
    ) -> None:
        self.part = part
        self.figure = figure
        self.key_poses = _upload_poses(context, part)
        self.texcoords = context.buffer(part.texcoords.astype("<f4").tobytes())
        self.indices = context.buffer(part.indices.astype("<u4").tobytes())
        self.instances = instances

    @property
    def instance_format(self) -> str:
        """Format for moderngl of ``in_world_from_part`` and ``in_pose`` in `instances`."""
        before, behind = self.part.slot * 64, (SLOTS - 1 - self.part.slot) * 64
        gaps = [f"{gap}x" if gap else "" for gap in (before, behind)]  # moderngl takes no "0x"
        return "{} 12f 4f {}/i".format(*gaps)

    def release(self) -> None:
        """Give the GL objects back."""
        for thing in (self.key_poses, self.texcoords, self.indices):
            thing.release()


class GpuCrowd:
    """All figures of a crowd.

    Attributes:
        crowd: What was uploaded.
        parts: Of all figures, one after another.
        instances: A buffer for each figure, for all its characters.

    Raises:
        AssetError: a figure has more key poses than this OpenGL can hold in a texture.
    """

    def __init__(self, context: moderngl.Context, crowd: Crowd) -> None:
        self.crowd = crowd
        self.instances = [
            context.buffer(reserve=count * _INSTANCE_BYTES, dynamic=True)
            for count in np.bincount(crowd.figure_of).tolist()
        ]
        self.parts: list[GpuPart] = []
        limit = context.info["GL_MAX_TEXTURE_SIZE"]
        try:
            for number, figure in enumerate(crowd.figures):
                _require_room(figure, limit)
                self.parts += [
                    GpuPart(context, number, part, self.instances[number]) for part in figure.parts
                ]
        except AssetError:
            self.release()
            raise

    def release(self) -> None:
        """Give the GL objects back."""
        for part in self.parts:
            part.release()
        for buffer in self.instances:
            buffer.release()


def _rows(part: FigurePart) -> int:
    """Rows of texels that all key poses of a part take."""
    texels = 2 * len(part.positions) * part.vertex_count
    return -(-texels >> POSE_ROW_BITS)


def _require_room(figure: Figure, limit: int) -> None:
    rows = max((_rows(part) for part in figure.parts), default=0)
    if max(rows, 1 << POSE_ROW_BITS) > limit:
        vertices = limit << (POSE_ROW_BITS - 1)
        raise AssetError(
            figure.name,
            expected=f"at most {vertices} vertices in all frames together, for this OpenGL",
            found=f"a part with {rows << (POSE_ROW_BITS - 1)}",
        )


def _upload_poses(context: moderngl.Context, part: FigurePart) -> moderngl.Texture:
    """Float texels: whatever a file's own precision is, a key pose comes out as it is there."""
    frames, vertices = part.positions.shape[:2]
    texels = np.zeros((_rows(part) << POSE_ROW_BITS, 4), "<f4")
    pairs = texels[: 2 * frames * vertices].reshape(frames, vertices, 2, 4)
    pairs[..., 0, :3] = part.positions
    pairs[..., 1, :3] = part.normals
    texture = context.texture((1 << POSE_ROW_BITS, _rows(part)), 4, texels, dtype="f4")
    texture.filter = moderngl.NEAREST, moderngl.NEAREST
    return texture
