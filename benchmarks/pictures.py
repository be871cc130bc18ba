"""Pictures of levels as the game engine draws them and as followspot does, side by side.

Both under the light that the level's compiler baked, three spawn points a level. The engine works
in what is displayed and followspot in linear light, and the engine's pictures hold pick-ups, too:
they are compared to see what is missing or looks wrong, not to be the same. The exposure is the one
that makes both as bright in the mean.
"""

import sys
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import common
import engine
import msgspec
import numpy as np
import ours
from common import BenchmarkError, View
from numpy.typing import NDArray
from PIL import Image

from followspot import Camera, Renderer
from followspot.errors import FollowspotError
from followspot.scene.load import load
from followspot.scene.scene import Scene

VIEWS_A_LEVEL = 3
FRAMES = 30
BLOCK = 8
"""Pixels along an edge of what is compared: less would tell of filters and of noise in textures."""

FAR = 50.0
"""Steps of 255 by which a block looks otherwise."""

EXPOSURES = 2.0**-4, 2.0**9
STEPS = 10

Picture = NDArray[np.uint8]


@dataclass(frozen=True)
class Pair:
    """One view's two pictures: steps of 255 between them in the mean; share of blocks far apart."""

    name: str
    mean: float
    far: float


def spawn_cameras(scene: Scene) -> list[Camera]:
    """Some of a level's cameras, spread over all of them."""
    cameras = list(scene.cameras.values())
    numbers = sorted({len(cameras) * n // VIEWS_A_LEVEL for n in range(VIEWS_A_LEVEL)})
    return [cameras[number] for number in numbers]


def drawn_by_us(scene: Scene, cameras: list[Camera], bright: Iterable[float]) -> list[Picture]:
    """A picture from each camera, of some mean display value."""
    baked = msgspec.structs.replace(scene.settings, baked_light=1.0)
    unlit = replace(scene, lights=())
    found = []
    with Renderer(ours.SIZE) as renderer:
        for camera, mean in zip(cameras, bright, strict=True):
            low, high = np.log2(EXPOSURES)
            for _ in range(STEPS):
                middle = (low + high) / 2
                settings = msgspec.structs.replace(baked, exposure=float(2**middle))
                shown = renderer.render(unlit, camera, settings=settings, time=engine.SHOT_AT)
                picture = shown["final"]
                low, high = (middle, high) if picture.mean() < mean else (low, middle)
            found.append(picture)
    return found


def compare(theirs: Picture, own: Picture) -> tuple[float, float]:
    """Mean difference of blocks in steps of 255, and the share of those far apart."""
    apart = np.abs(_blocks(theirs) - _blocks(own)).max(axis=2)
    return float(apart.mean()), float((apart > FAR).mean())


def _blocks(picture: Picture) -> NDArray[np.float64]:
    height, width = (edge // BLOCK for edge in picture.shape[:2])
    cut = picture[: height * BLOCK, : width * BLOCK].reshape(height, BLOCK, width, BLOCK, 3)
    return np.asarray(cut.mean(axis=(1, 3)))


def pairs_of(level: str, proxy: Path, at: str, into: Path) -> list[Pair]:
    """Draw a level's views by both and leave them side by side."""
    try:
        scene = load(level)
    except FollowspotError as error:
        raise BenchmarkError(str(error)) from None
    cameras = spawn_cameras(scene)
    views = []
    for each in cameras:
        x, y, z = map(float, each.position)
        views.append(View(level, (x, y, z, each.yaw, each.pitch)))
    with tempfile.TemporaryDirectory() as folder:
        shots = Path(folder)
        engine.run_engine("gl1hq-noent", views, FRAMES, proxy, at, shots=shots)
        theirs = [
            np.asarray(Image.open(shots / f"view{number:02d}.tga").convert("RGB"))
            for number in range(len(views))
        ]
    pairs = []
    own = drawn_by_us(scene, cameras, [picture.mean() for picture in theirs])
    for number, (a, b) in enumerate(zip(theirs, own, strict=True)):
        name = f"{level}-{number}"
        Image.fromarray(np.concatenate([a, b], axis=1)).save(into / f"{name}.png")
        pairs.append(Pair(name, *compare(a, b)))
    return pairs


def main() -> None:
    """Draw all levels that are named, the worst told first."""
    parser = common.parser(__doc__)
    parser.add_argument("level", nargs="+", help="names of installed levels")
    arguments = parser.parse_args()
    into = common.OUT / "pictures"
    into.mkdir(parents=True, exist_ok=True)
    pairs: list[Pair] = []
    with tempfile.TemporaryDirectory() as folder, engine.display() as at:
        proxy = engine.build_proxy(Path(folder))
        for level in arguments.level:
            print(level, file=sys.stderr)
            pairs += pairs_of(level, proxy, at, into)
    print(f"| picture | mean difference of 255 | blocks more than {FAR:g} apart |")
    print("| --- | ---: | ---: |")
    for each in sorted(pairs, key=lambda pair: -pair.far):
        print(f"| {each.name} | {each.mean:.1f} | {each.far:.1%} |")
    print(f"side by side, the engine left: {into}")


if __name__ == "__main__":
    common.guarded(main)
