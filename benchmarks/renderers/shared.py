"""What the other renderers' scripts share: the exported scene, and how a frame is timed.

Runs in each renderer's own virtual environment, so NumPy is all that it needs.
"""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

WARM = 5


@dataclass
class Part:
    """All triangles of one texture.

    Attributes:
        indices: (t, 3) uint32, counter-clockwise seen from the front.
        image: (h, w, 4) uint8 sRGB, row 0 at v = 0.
        cut_out: Whether texels with little alpha are left out; then both sides are drawn.
    """

    indices: np.ndarray
    image: np.ndarray
    cut_out: bool


@dataclass
class Exported:
    """What renderers.py wrote. Z is up, lengths are Quake units.

    Attributes:
        positions: (v, 3) float32.
        normals: (v, 3) float32, unit.
        texcoords: (v, 2) float32, v down the image.
        parts: The triangles.
        about: Size, camera (position, world_from_view, fov_y, near, far, yaw, pitch), light
            (position, world_from_view, half_angle, power) and shadow_map_size; plain numbers.
        folder: Where pictures go.
    """

    positions: np.ndarray
    normals: np.ndarray
    texcoords: np.ndarray
    parts: list[Part]
    about: dict[str, Any]
    folder: Path


def read() -> tuple[Exported, int]:
    """The scene in the folder that is the first argument, and the frames that are the second."""
    folder, frames = Path(sys.argv[1]), int(sys.argv[2])
    arrays = np.load(folder / "scene.npz")
    about = json.loads((folder / "scene.json").read_text())
    parts = [
        Part(arrays[f"indices{k}"], arrays[f"image{part['image']}"], part["cut_out"])
        for k, part in enumerate(about["parts"])
    ]
    vertices = (arrays[name] for name in ("positions", "normals", "texcoords"))
    return Exported(*vertices, parts, about, folder), frames


def measure(frame: Callable[[], None], frames: int) -> None:
    """Print the milliseconds of each frame; `frame` waits until it is drawn."""
    for _ in range(WARM):
        frame()
    for _ in range(frames):
        start = time.perf_counter()
        frame()
        print(f"{(time.perf_counter() - start) * 1e3:.4f}")


def save(picture: np.ndarray, scene: Exported, name: str) -> None:
    """Keep what was drawn as a PPM file, to look at."""
    height, width = picture.shape[:2]
    pixels = np.ascontiguousarray(picture[..., :3], np.uint8).tobytes()
    (scene.folder / f"{name}.ppm").write_bytes(b"P6 %d %d 255\n" % (width, height) + pixels)
