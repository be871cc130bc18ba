"""What is in a level, and what is wrong with it."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from followspot.assets.bsp import BspFile, FaceType
from followspot.assets.image import Image, decode_all
from followspot.errors import AssetError
from followspot.present.stopwatch import Steps, peak_memory_mb
from followspot.scene.load import load
from followspot.scene.props import Prop
from followspot.scene.scene import Scene


def inspect(name: str, assets: Sequence[Path]) -> dict[str, Any]:
    """Everything that can be told of a level without drawing it, ready for JSON.

    Raises:
        AssetError: the level cannot be opened.
    """
    steps = Steps()
    scene = load(name, assets, on_step=steps)
    bsp, mesh = scene.level.bsp, scene.mesh
    mins, maxs = mesh.bounds
    return {
        "name": name,
        "file": bsp.source,
        "counts": _counts(bsp, scene),
        "bounds": {"mins": mins.tolist(), "maxs": maxs.tolist(), "unit": "Quake units"},
        "entities": dict(Counter(e.get("classname", "?") for e in bsp.entities).most_common()),
        "cameras": {
            n: [*np.round(c.position, 3).tolist(), c.yaw, c.pitch] for n, c in scene.cameras.items()
        },
        "sky": scene.sky.name,
        "lights": [repr(light) for light in scene.lights] if not scene.lights_chosen else "chosen",
        "props": [_prop(prop) for prop in scene.props],
        "materials": [_material(scene, number) for number in range(len(scene.materials))],
        "missing": [{"name": m.name, "tried": list(m.tried)} for m in scene.missing],
        "problems": [str(problem) for problem in (*scene.problems, *_undecodable(scene))],
        "memory_mb": {
            "vertices": mesh.vertices.nbytes / 2**20,
            "indices": mesh.indices.nbytes / 2**20,
            "sky": scene.sky.faces.nbytes / 2**20,
            "process peak": peak_memory_mb(),
        },
        "load_ms": steps.ms,
    }


def _undecodable(scene: Scene) -> list[AssetError]:
    """Why images that are there stay white."""
    decoded = (found for _, found in decode_all(scene.archive, scene.images))
    return [found for found in decoded if not isinstance(found, Image)]


def _counts(bsp: BspFile, scene: Scene) -> dict[str, int]:
    kinds = {kind.name.lower() + " faces": kind for kind in FaceType}
    return {
        **{name: int((bsp.faces["type"] == kind).sum()) for name, kind in kinds.items()},
        "drawn faces": len(scene.mesh.faces),
        "triangles": scene.mesh.triangle_count,
        "vertices": len(scene.mesh.vertices),
        "materials": len(scene.materials),
        "images": len(scene.images),
        "entities": len(bsp.entities),
        "brush models": max(len(bsp.models) - 1, 0),
        "brushes": len(bsp.brushes),
        "leafs": len(bsp.leafs),
        "clusters": bsp.cluster_count,
        "fog volumes": len(scene.level.fogs),
        "lightmaps": len(bsp.lightmaps),
    }


def _prop(prop: Prop) -> dict[str, Any]:
    mins, maxs = prop.bounds
    return {
        "name": prop.name,
        "triangles": prop.triangle_count,
        "mins": np.round(mins.astype(np.float64), 3).tolist(),
        "maxs": np.round(maxs.astype(np.float64), 3).tolist(),
    }


def _material(scene: Scene, number: int) -> dict[str, Any]:
    material = scene.materials[number]
    faces = scene.mesh.faces[scene.mesh.faces["material"] == number]
    return {
        "name": material.name,
        "image": material.image,
        "layer": material.layer and material.layer.image,
        "laid": material.layer and material.layer.laid.value,
        "sides": material.sides.value,
        "alpha_test": material.alpha_test and material.alpha_test.value,
        "blend": material.blend and [factor.value for factor in material.blend],
        "shade": material.shade.value,
        "tinted": material.is_tinted,
        "moves": material.moves,
        "triangles": int(faces["index_count"].sum()) // 3,
    }
