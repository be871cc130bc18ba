"""Colours of a level's vertices, where materials ask for some.

Light is held as by ioquake3 with its one bit for what is brighter than white: twice a file's byte,
white at most, and stages are multiplied by half of that (``R_ColorShiftLightingBytes`` of
``tr_bsp.c``, ``ComputeColors`` of ``tr_shade.c``).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from followspot.assets.binary import run_members
from followspot.scene.material import ByVertex, Material
from followspot.scene.mesh import Mesh
from followspot.scene.motion import DISPLAY_GAMMA


def of_level(
    mesh: Mesh, colors: NDArray[np.float32], materials: Sequence[Material]
) -> NDArray[np.float32] | None:
    """What is to be `Mesh.tints`.

    Args:
        mesh: Without tints.
        colors: (v, 4) RGBA of its vertices as their file has them, from 0 to 1: light that the
            level's compiler has found there, and how far a layer covers them.
        materials: The mesh's.
    """
    if not any(each.reads_tints for each in materials):
        return None
    tints = np.ones((len(mesh.vertices), 4), np.float32)
    tints[:, 3] = colors[:, 3]
    for number, each in enumerate(materials):
        by_vertex = each.layer.by_vertex if each.layer else None
        if each.color is None and by_vertex is None:
            continue
        faces = mesh.faces[mesh.faces["material"] == number]
        own = mesh.indices[run_members(faces["first_index"], faces["index_count"])]
        if each.color is not None:
            tints[own] = *each.color, 1.0
        else:
            light = 2 * colors[own, :3]
            light /= np.maximum(light.max(axis=1, keepdims=True), 1)
            shown = (1 - light if by_vertex is ByVertex.DIMS else light) / 2
            tints[own, :3] = shown ** np.float32(DISPLAY_GAMMA)
    return tints
