"""One picture, from what was typed to the file."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from followspot.errors import AssetError, UsageError
from followspot.passes import lighting
from followspot.passes.overlay import Overlay
from followspot.passes.view import View
from followspot.present import arguments, pictures
from followspot.present.renderer import Renderer, named
from followspot.scene import bounce, figure_file
from followspot.scene.camera import Camera
from followspot.scene.load import Step, load, load_figure
from followspot.scene.scene import Scene

FARTHEST_TIME = 1e6
"""Seconds from 0 at which characters can be looked at."""


@dataclass(frozen=True)
class Wish:
    """How a scene is to be drawn, as typed; what is not given comes from the scene."""

    view: str = "final"
    camera: str | None = None
    fov: float | None = None
    size: str = "640x480"
    supersample: int = 1
    lights: Sequence[str] = ()
    albedo: float | None = None
    assets: Sequence[Path] = ()
    settings: Sequence[str] = ()
    shadows: bool = True
    sky_light: bool = True
    animation: str | None = None
    time: float = 0.0
    items: bool = False
    bake: bool = False
    overlays: str | None = None
    culled_from: str | None = None


def open_scene(name: str, wish: Wish, on_step: Step = lambda _: None) -> tuple[Scene, Camera]:
    """The scene that a wish describes and the camera that looks at it.

    Raises:
        AssetError: the scene cannot be opened.
        UsageError: something in the wish makes no sense for it, or its lights are too many.
    """
    scene, camera = open_any(name, wish, on_step)
    require_drawable(scene, wish)
    return scene, camera


def require_drawable(scene: Scene, wish: Wish) -> None:
    """See that a frame holds a scene's lights.

    Raises:
        UsageError: it does not; tells who asks for them.
    """
    try:
        lighting.in_order(scene.lights)
    except UsageError as error:
        asked_by = "--light" if wish.lights else f"{scene.name}: lights"
        raise UsageError(f"{asked_by}: {error}") from None


def open_any(name: str, wish: Wish, on_step: Step = lambda _: None) -> tuple[Scene, Camera]:
    """As `open_scene`, however many lights the scene has."""
    if not abs(wish.time) <= FARTHEST_TIME:
        expected = f"{-FARTHEST_TIME:g} to {FARTHEST_TIME:g} s"
        raise UsageError(f"--time: expected {expected}, found {wish.time:g}")
    lights = [arguments.parse_light(text) for text in wish.lights]
    seen_by = partial(arguments.parse_camera, wish.camera, wish.fov)
    if figure_file.is_model(name):
        if wish.items:
            raise UsageError(f"--items: expected a level or a scene, found {name}")
        scene = load_figure(name, wish.assets, wish.animation, on_step=on_step)
    elif wish.animation is not None:
        raise UsageError(f"--animation: expected a model or player, found {name}")
    else:
        scene = load(name, wish.assets, with_items=wish.items, seen_by=seen_by, on_step=on_step)
    camera = seen_by(scene)
    if lights:
        scene = scene.with_lights(*lights)
    settings = arguments.parse_settings(
        scene,
        wish.settings,
        albedo=wish.albedo,
        shadows=wish.shadows,
        sky_light=wish.sky_light,
    )
    return replace(scene, settings=settings), camera


def render(name: str, output: Path, wish: Wish) -> list[AssetError]:
    """Draw the picture and write it.

    Returns:
        What cannot be read and was passed over: images, of a model or player its parts, too.

    Raises:
        AssetError: the scene cannot be opened.
        ContextError: there is no OpenGL.
        UsageError: something in the wish makes no sense, or the file cannot be written.
    """
    linear = pictures.is_linear(output)
    view = named(View, wish.view)
    size = arguments.parse_size(wish.size)
    overlays = [named(Overlay, each.strip()) for each in (wish.overlays or "").split(",") if each]
    if view is View.SHADOW_MAP and overlays:
        raise UsageError(f"--overlay: expected none over a shadow map, found {wish.overlays}")
    if view is View.SHADOW_MAP and wish.supersample > 1:
        raise UsageError(f"--supersample: expected 1 for a shadow map, found {wish.supersample}")
    arguments.require_drawable(size, wish.supersample)
    scene, camera = open_scene(name, wish)
    if wish.bake:
        scene = bounce.bake(scene)
    culled_from = None
    if wish.culled_from is not None:
        culled_from = arguments.parse_camera(wish.culled_from, wish.fov, scene, "--culled-from")
    width, height = size
    with Renderer((width * wish.supersample, height * wish.supersample)) as renderer:
        picture = renderer.render(
            scene,
            camera,
            [view],
            time=wish.time,
            linear=linear,
            overlays=overlays,
            culled_from=culled_from,
        )[view]
        passed_over = list(renderer.open(scene).problems)
    if wish.supersample > 1:
        encoded = view.is_encoded and not linear
        picture = pictures.averaged(picture, wish.supersample, encoded=encoded)
    depth = view in (View.DEPTH, View.SHADOW_MAP)
    pictures.save(output, picture, channel="Z" if depth else "Y")
    return [*(scene.problems if figure_file.is_model(name) else ()), *passed_over]
