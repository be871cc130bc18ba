"""The classic sequence: one viewpoint, one stage more in each picture, and a sheet of them all."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from followspot.passes import lighting
from followspot.passes.overlay import Overlay
from followspot.passes.view import View
from followspot.present import arguments, files, pictures
from followspot.present.renderer import Renderer
from followspot.present.still import Wish, open_scene
from followspot.scene.camera import Camera
from followspot.scene.load import Step
from followspot.scene.scene import Scene


@dataclass(frozen=True)
class Figure:
    """One picture of the sequence: its file's name, its caption, and what it shows."""

    name: str
    caption: str
    view: View
    shadows: bool = True
    sky_light: bool = True
    overlays: tuple[Overlay, ...] = ()


SEQUENCE = (
    Figure("1-normals", "Surface normals", View.NORMALS),
    Figure("2-lambertian", "Lambertian coefficients: texture only", View.LAMBERTIAN),
    Figure("3-shading", "Shading without texture", View.SHADING),
    Figure("4-light", "Light and texture", View.FINAL, shadows=False, sky_light=False),
    Figure("5-environment", "... and light from all around", View.FINAL, shadows=False),
    Figure("6-shadows", "... and shadows: the final picture", View.FINAL),
    Figure("7-shadow-map", "What the key light sees: its depth map", View.SHADOW_MAP),
    Figure(
        "8-bounds",
        "Bounds: objects, scene, and what that map covers",
        View.FINAL,
        overlays=(Overlay.BOXES, Overlay.SCENE, Overlay.LIGHT_FRUSTUM),
    ),
)

SHEET = "contact-sheet"


def make(
    name: str, folder: Path, wish: Wish, on_step: Step, on_picture: Callable[[Path], None]
) -> None:
    """Draw the sequence of a scene into a folder.

    Args:
        name: Scene or level.
        folder: Gets one png a figure, and ``contact-sheet.png``.
        wish: Camera, lights and settings.
        on_step: Told of each step of loading.
        on_picture: Told of each file when it is there.

    Raises:
        AssetError: the scene cannot be opened.
        UnwritableError: the folder is a file, or cannot be written into.
        UsageError: something in the wish makes no sense.
    """
    files.require_folder(folder)
    size = arguments.parse_size(wish.size)
    scene, camera = open_scene(name, wish, on_step)
    with Renderer(size) as renderer:
        renderer.open(scene)
        on_step("upload")
        drawn = []
        for figure in SEQUENCE:
            picture = draw(renderer, scene, camera, figure)
            path = folder / f"{figure.name}.png"
            pictures.save(path, picture)
            drawn.append(picture)
            on_picture(path)
    sheet = folder / f"{SHEET}.png"
    pictures.save(sheet, contact_sheet(drawn, [figure.caption for figure in SEQUENCE]))
    on_picture(sheet)


def draw(renderer: Renderer, scene: Scene, camera: Camera, figure: Figure) -> NDArray[np.uint8]:
    """One figure, (h, w, 3); the final pictures share the exposure of the full one."""
    settings = msgspec.structs.replace(
        scene.settings,
        exposure=renderer.exposure(scene, camera, view=figure.view.metered),
        shadows=figure.shadows and scene.settings.shadows,
        sky_light=figure.sky_light and scene.settings.sky_light,
    )
    if figure.view is View.SHADOW_MAP and not lighting.shadowed(scene.lights, settings):
        return np.zeros((64, 64, 3), np.uint8)
    drawn = renderer.render(
        scene, camera, [figure.view], settings=settings, overlays=figure.overlays
    )
    return drawn[figure.view]


def contact_sheet(
    drawn: list[NDArray[Any]], captions: list[str], columns: int = 4, width: int = 400
) -> NDArray[np.uint8]:
    """Pictures in rows with a caption under each.

    Args:
        drawn: (h, w, 3) uint8 each; the first one's aspect is that of every cell, within 1 pixel
            and twice the width.
        captions: One a picture.
        columns: Cells in a row.
        width: Pixels of a cell.
    """
    height = round(width * drawn[0].shape[0] / drawn[0].shape[1])
    height = min(max(height, 1), 2 * width)
    gap, strip = 12, 30
    rows = -(-len(drawn) // columns)
    paper = Image.new(
        "RGB", (columns * (width + gap) + gap, rows * (height + strip + gap) + gap), "#f4f2ee"
    )
    pen = ImageDraw.Draw(paper)
    font = ImageFont.load_default(16)
    for number, (picture, caption) in enumerate(zip(drawn, captions, strict=True)):
        row, column = divmod(number, columns)
        x, y = gap + column * (width + gap), gap + row * (height + strip + gap)
        small = Image.fromarray(picture)
        small.thumbnail((width, height), Image.Resampling.LANCZOS)
        paper.paste(small, (x + (width - small.width) // 2, y + (height - small.height) // 2))
        pen.text((x, y + height + 5), f"{number + 1}  {caption}", fill="#222222", font=font)
    return np.asarray(paper)
