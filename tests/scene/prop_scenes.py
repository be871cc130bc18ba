"""A cube in every format, and where it is put: what tests of props have in common."""

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from followspot.assets.archive import Archive
from followspot.scene import scene_file
from followspot.scene.deform import RIGID
from followspot.scene.figure_file import FigureFiles
from followspot.scene.ground import Ground
from followspot.scene.level import Level
from followspot.scene.mesh import face_boxes, face_planes
from followspot.scene.props import PropFiles, props
from mesh_fixtures import cube, gltf_cube, md3_cube, obj, ply
from synthetic import box, floor, make_scene

CUBE = cube()
FLOOR = make_scene([floor(1000, z=-16), *box((90, -50, -16), (300, 50, 0))]).level


FILES = ["cube.glb", "cube.obj", "cube.ply", "cube.md3"]


def cube_files(folder: Path) -> Path:
    """Write a cube of 32 units in every format, and its image, into a folder."""
    document = gltf_cube(
        CUBE,
        images=[{"uri": "wood.png"}],
        textures=[{"source": 0}],
        materials=[{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
    )
    document.primitive["material"] = 0
    (folder / "cube.glb").write_bytes(document.glb())
    (folder / "cube.obj").write_bytes(obj(CUBE, "cube.mtl", "wood"))
    (folder / "cube.mtl").write_text("newmtl wood\nmap_Kd wood.png\n")
    (folder / "cube.ply").write_bytes(ply(CUBE, "wood.png"))
    (folder / "cube.md3").write_bytes(md3_cube(CUBE, "wood.png"))
    Image.new("RGB", (4, 4), (200, 100, 50)).save(folder / "wood.png")
    return folder


def place(folder: Path, *texts: str, ground: Level = FLOOR, metres: float = 0.03) -> Any:
    text = "".join(f"[[props]]\n{text}\n" for text in texts)
    entries = scene_file.parse(f'level = "x"\n{text}', "x.toml").props
    archive = Archive.open([folder])
    files = PropFiles(archive, FigureFiles(archive, lambda _: None))
    return props(entries, files, metres, "x.toml", Ground(ground))


def require_whole(level: Level) -> None:
    """All that holds of a mesh's table of faces."""
    mesh = level.mesh
    first, count = mesh.faces["first_index"], mesh.faces["index_count"]
    assert first.tolist() == (np.cumsum(count) - count).tolist() and count.sum() == len(
        mesh.indices
    )
    assert (np.diff(mesh.faces["material"]) >= 0).all()
    orders = [m.order for m in level.materials]
    assert orders == sorted(orders)
    runs = mesh.vertices["position"], mesh.indices, first
    is_rigid = np.array([m.deforms == RIGID for m in level.materials])[mesh.faces["material"]]
    for name, value in zip(("mins", "maxs"), face_boxes(*runs), strict=True):
        assert (mesh.faces[name] == value)[is_rigid].all()
    own = level.visibility.level_face < 0
    normal, _ = face_planes(*runs)
    assert (mesh.faces["normal"][own] == normal[own]).all()
