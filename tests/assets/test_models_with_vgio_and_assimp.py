"""Independent readers of the same files must find the same numbers."""

from contextlib import closing
from pathlib import Path

import assimp_py
import numpy as np
import pytest
from vgio import quake2
from vgio.quake2.md2 import Md2

from followspot.assets.md2 import read_md2
from followspot.assets.md3 import read_md3
from model_fixtures import md2_models, openarena_files


@pytest.mark.openarena
def test_md2_agrees_with_vgio() -> None:
    """Every corner of every triangle in every frame; the GL commands use the same texels."""
    for path in md2_models():
        ours = read_md2(path.read_bytes(), path.name)
        with closing(Md2.open(str(path))) as theirs:
            assert ours.frame_names == tuple(frame.name for frame in theirs.frames)
            vertex = np.array([triangle.vertexes for triangle in theirs.triangles]).ravel()
            texcoord = np.array([triangle.st_vertexes for triangle in theirs.triangles]).ravel()
            for i, frame in enumerate(theirs.frames):
                raw = np.array([(*v[:3], v.light_normal_index) for v in frame.vertexes])
                positions = raw[:, :3] * np.array(frame.scale) + frame.translate
                normals = np.array(quake2.anorms)[raw[:, 3]]
                corners = ours.positions[i, ours.indices], ours.normals[i, ours.indices]
                np.testing.assert_allclose(corners[0], positions[vertex], atol=1e-5)
                np.testing.assert_allclose(corners[1], normals[vertex], atol=1e-6)
            texels = np.array([(v.s, v.t) for v in theirs.st_vertexes])[texcoord] + 0.5
            size = np.array([theirs.skin_width, theirs.skin_height])
            np.testing.assert_allclose(ours.texcoords[ours.indices] * size, texels, atol=1e-4)
            drawn = [(v.s, v.t) for command in theirs.gl_commands for v in command.vertexes]
            used = {tuple(texel) for texel in (texels - 0.5).tolist()}
            assert {tuple(t) for t in (np.array(drawn) * size - 0.5).round(3).tolist()} <= used


@pytest.mark.openarena
def test_md2_agrees_with_assimp() -> None:
    """Assimp's front faces are counter-clockwise, so it turns each triangle of the file round."""
    for path in md2_models():
        ours = read_md2(path.read_bytes(), path.name)
        (theirs,) = assimp_py.import_file(str(path), 0).meshes
        order = np.array(theirs.indices).reshape(-1, 3)[:, ::-1].ravel()
        positions = np.array(theirs.vertices).reshape(-1, 3)[order]
        np.testing.assert_allclose(ours.positions[0, ours.indices], positions, atol=1e-5)
        normals = np.array(theirs.normals).reshape(-1, 3)[order]
        np.testing.assert_allclose(ours.normals[0, ours.indices], normals, atol=1e-6)


@pytest.mark.openarena
def test_md3_agrees_with_assimp(tmp_path: Path) -> None:
    """Assimp turns triangles round and textures upside down, and reads frame 0 alone."""
    compared = 0
    for source, data in openarena_files(".md3"):
        ours = read_md3(data, source)
        sizes = [surface.indices.size for surface in ours.surfaces]
        if "/weapons2/" not in source or not sizes or min(sizes) == 0:
            continue
        path = tmp_path / source.rpartition("/")[2]
        path.write_bytes(data)
        theirs = {}  # in an order of its own
        for mesh in assimp_py.import_file(str(path), 0).meshes:
            order = np.array(mesh.indices).reshape(-1, 3)[:, [0, 2, 1]].ravel()
            positions = np.array(mesh.vertices, np.float32).reshape(-1, 3)[order]
            normals = np.array(mesh.normals).reshape(-1, 3)[order]
            texcoords = np.array(mesh.texcoords[0]).reshape(-1, mesh.num_uv_components[0])[order]
            theirs[positions.tobytes()] = normals, texcoords[:, :2] * (1, -1) + (0, 1)
        for surface in ours.surfaces:
            corners = surface.indices
            normals, texcoords = theirs[surface.positions[0, corners].tobytes()]
            # It divides the circle with a rounded pi.
            np.testing.assert_allclose(surface.normals[0, corners], normals, atol=2e-3)
            np.testing.assert_allclose(surface.texcoords[corners], texcoords, atol=1e-6)
            compared += 1
    assert compared > 50
