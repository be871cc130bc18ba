"""What every step of the report draws and measures with."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from followspot.present.renderer import Renderer
from followspot.scene.camera import Camera
from followspot.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Material:
    """The scene, its one viewpoint, and what draws it; the same for all steps.

    Attributes:
        name: The scene as it was typed.
        scene: What was loaded by that name.
        camera: Where every picture is taken from.
        size: (width, height) of pictures in pixels; also the renderer's.
        assets: Folders and pk3 files to look in first.
        renderer: Draws in this process. It belongs to one thread; whoever draws in another size
            makes one of their own.
        folder: Exists, is the report's while it is made; for files too large for `Section.files`.
        on_progress: Called with the share of the step that is done, in [0, 1], and what is next.
    """

    name: str
    scene: Scene
    camera: Camera
    size: tuple[int, int]
    assets: tuple[Path, ...]
    renderer: Renderer
    folder: Path
    on_progress: Callable[[float, str], None]
