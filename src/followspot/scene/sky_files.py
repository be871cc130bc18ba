"""From a level's sky shaders to its sky: images of a box, clouds before it, or both."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from followspot.assets import image
from followspot.assets.archive import Archive
from followspot.assets.bsp import BspFile
from followspot.assets.image import Image
from followspot.assets.shader_script import ShaderScript, Stage
from followspot.assets.surface_flags import Surface
from followspot.errors import AssetError
from followspot.scene import sky
from followspot.scene.clouds import Clouds, Layer
from followspot.scene.search import BUILTIN
from followspot.scene.sky import CubeMap

BUILTIN_SKY = "env/courtyard"

_WHITE = ("$whiteimage", "*white")


def shaders(bsp: BspFile) -> list[str]:
    """Names of the shaders of the level's sky faces, the most used first."""
    flags = bsp.shaders["surface_flags"][bsp.faces["shader"]]
    used = bsp.faces["shader"][(flags & Surface.SKY) != 0].tolist()
    return [bsp.shader_names[n] for n in sorted(set(used), key=lambda n: (-used.count(n), n))]


class Found(NamedTuple):
    """A sky.

    Attributes:
        sky: With its clouds as they are at first.
        clouds: They, where there are some.
        problems: What is wrong with those that were passed over.
    """

    sky: CubeMap
    clouds: Clouds | None
    problems: list[AssetError]


def of_scripts(archive: Archive, scripts: Sequence[ShaderScript]) -> Found:
    """The first script's that has anything to show; else the sky that comes with the package."""
    problems: list[AssetError] = []
    for script in scripts:
        if script.sky_box is None:
            continue
        far, height, _ = script.sky_box
        box = None
        if far not in (None, "full"):  # a word of old scripts that says there are clouds
            try:
                box = read(archive, str(far))
            except AssetError as error:
                problems.append(error)
        layers = _layers(archive, script.stages, problems)
        if layers:
            clouds = Clouds(box, tuple(layers), max(height, 1.0))
            return Found(clouds.sky(script.name), clouds, problems)
        if box is not None:
            return Found(box, None, problems)
    with Archive.open([BUILTIN / "courtyard.pk3"]) as builtin:
        return Found(read(builtin, BUILTIN_SKY), None, problems)


def _layers(archive: Archive, stages: Sequence[Stage], problems: list[AssetError]) -> list[Layer]:
    """Clouds; images that are not there, or cannot be read, are left out and told."""
    found: list[Layer] = []
    for stage in stages:
        if stage.image in _WHITE:
            white = Image(np.full((1, 1, 4), 255, np.uint8), has_alpha=False, source=stage.image)
            found.append(Layer(stage, white))
            continue
        if stage.image is None or stage.image.startswith(("$", "*")):
            continue
        path, tried = image.find_image(archive, stage.image)
        if path is None:
            expected, none = "an image of clouds", f"none of {tried}"
            problems.append(AssetError(stage.image, expected=expected, found=none))
            continue
        for _, read_image in image.decode_all(archive, [path]):
            if isinstance(read_image, Image):
                found.append(Layer(stage, read_image))
            else:
                problems.append(read_image)
    return found


def read(archive: Archive, base: str) -> CubeMap:
    """The box of six images ``base_rt`` to ``base_dn``.

    Raises:
        AssetError: one of them is missing or unusable.
    """
    paths: list[str] = []
    for suffix in sky.SUFFIXES:
        found, tried = image.find_image(archive, base + suffix)
        if found is None:
            raise AssetError(base + suffix, expected="a sky image", found=f"none of {tried}")
        paths.append(found)
    sides: list[Image] = []
    for _, side in image.decode_all(archive, paths):
        if isinstance(side, AssetError):
            raise side
        sides.append(side)
    return sky.from_quake_images(base, sides)
