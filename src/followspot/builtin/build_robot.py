"""Build the robot: ``python -m followspot.builtin.build_robot [robot.pk3]``.

The pk3 holds ``models/robot/robot.md2`` and its skin. The robot is 56 units tall, as a player of
the game, with its feet 24 units below the origin, and looks along +X. Its animations are those of
`robot_animation.ANIMATIONS`.
"""

import sys
from pathlib import Path

import numpy as np

from followspot.arrays import Floats
from followspot.builtin.robot_animation import ANIMATIONS
from followspot.builtin.robot_atlas import HEIGHT, WIDTH, bake, pack
from followspot.builtin.robot_model import Part, robot_parts
from followspot.builtin.robot_shapes import Shape
from followspot.builtin.robot_skeleton import Poses, place_bones
from followspot.builtin.robot_skin import robot_skin
from followspot.game import FLOOR_BELOW_PLAYER
from followspot.levelbuilder import image_file, write_pk3
from followspot.levelbuilder.md2_writer import Md2Skin, md2_bytes

MODEL = "models/robot/robot.md2"
SKIN = "models/robot/skin"


def robot_files() -> dict[str, bytes]:
    """Return every file of the robot's pk3 by name."""
    parts = robot_parts()
    texels = pack(parts)
    extension, image = image_file(robot_skin(parts, bake(parts, texels)), quality=93)
    pieces = _pieces(parts)
    counts = [len(shape.points) for _, shape, _ in pieces]
    starts = np.cumsum([0, *counts])[:-1]
    triangles = [s.triangles + n for (_, s, _), n in zip(pieces, starts, strict=True)]
    skin = Md2Skin(
        image=SKIN + extension,
        size=(WIDTH, HEIGHT),
        texels=texels,
        triangles=np.concatenate([shape.st_triangles + st for _, shape, st in pieces]),
    )
    moves = {name: _move(pieces, poses()) for name, poses in ANIMATIONS.items()}
    return {
        MODEL: md2_bytes(moves, np.concatenate(triangles), skin),
        SKIN + extension: image,
    }


def _pieces(parts: list[Part]) -> list[tuple[str, Shape, int]]:
    """Bone, shape and start among all texels of every part, right ones of pairs too."""
    st_starts = np.cumsum([0, *(len(part.shape.st) for part in parts)])[:-1].tolist()
    left = [(p.bone, p.shape, st) for p, st in zip(parts, st_starts, strict=True)]
    right = [
        (p.bone.replace(".l", ".r"), p.shape.mirrored(), st)
        for p, st in zip(parts, st_starts, strict=True)
        if p.is_pair
    ]
    return left + right


def _move(pieces: list[tuple[str, Shape, int]], poses: Poses) -> tuple[Floats, Floats]:
    """(frames, vertices, 3) positions and normals."""
    bones = place_bones(poses)
    points = np.concatenate([bones[bone].points(shape.points) for bone, shape, _ in pieces], axis=1)
    normals = [bones[bone].normals(shape.normals) for bone, shape, _ in pieces]
    return points + np.array([0, 0, -FLOOR_BELOW_PLAYER]), np.concatenate(normals, axis=1)


def main() -> None:
    """Write the pk3 next to this file, or where the argument says."""
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("robot.pk3")
    write_pk3(target, robot_files())


if __name__ == "__main__":
    main()
