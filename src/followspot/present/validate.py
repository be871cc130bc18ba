"""``followspot validate``: the pictures and the figures of a comparison with Mitsuba 3."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from followspot.arrays import Floats, Mask
from followspot.assets.image import linear_to_srgb
from followspot.passes.view import View
from followspot.present import arguments, files, pictures
from followspot.present.comparison import (
    Comparison,
    RadianceFigures,
    Validation,
    VisibilityFigures,
    radiance_figures,
    visibility_figures,
)
from followspot.present.console import as_json, open_console, working
from followspot.present.mitsuba_scene import load_mitsuba
from followspot.present.renderer import Renderer
from followspot.present.sky_irradiance import irradiance, radiance
from followspot.present.still import Wish, open_scene
from followspot.scene.camera import Camera
from followspot.scene.scene import Scene
from followspot.scene.settings import Settings
from followspot.scene.sky import CubeMap

MAP_SIZES = (512, 1024, 2048, 4096)
"""Shadow maps that visibility is compared at, beside that of the settings."""

WHITE_ERROR = 0.05
"""Relative difference of radiance that the error picture shows as white."""


class EnvironmentFigures(Struct, frozen=True):
    """Relative differences of the light from the sky, over the picture and without occlusion.

    Attributes:
        constant_worst: From Mitsuba's constant emitter, with a sky of one colour.
        sky_mean: From the irradiance of all the sky's texels: how far the sum of six directions
            is off with this sky, in the mean over the pixels.
        sky_worst: Likewise at the worst pixel.
    """

    constant_worst: float
    sky_mean: float
    sky_worst: float


class Figures(Struct, frozen=True):
    """All that is told of one picture.

    Attributes:
        same_surface: Share of the pixels at which both see the same surface, or nothing.
        cut_out: Share of the pixels that show, or are lit through, something cut out.
        direct_integrator: Share of the pixels at which Mitsuba's own ``direct`` integrator, which
            sees the backs of one-sided faces, gives the same radiance to a thousandth.
        radiance: Where both say lit.
        visibility: At several sizes of the shadow map.
        environment: Light from the sky.
    """

    scene: str
    camera: tuple[float, ...]
    light: str
    size: tuple[int, int]
    settings: Settings
    gl_renderer: str
    mitsuba: str
    same_surface: float
    cut_out: float
    direct_integrator: float
    radiance: RadianceFigures
    visibility: tuple[VisibilityFigures, ...]
    environment: EnvironmentFigures


def run(name: str, folder: Path, wish: Wish) -> None:
    """Compare a scene's picture with Mitsuba's, write pictures and figures, print the table.

    Raises:
        AssetError: the scene cannot be opened.
        UnwritableError: the folder is a file, or cannot be written into.
        UsageError: Mitsuba is missing, or something in the wish makes no sense.
    """
    files.require_folder(folder)
    load_mitsuba()  # before anything else takes time
    size = arguments.parse_size(wish.size)
    scene, camera = open_scene(name, wish)
    console = open_console()
    with working(console, f"tracing {name}"), Renderer(size) as renderer:
        figures, made = measure(renderer, scene, camera)
    for file, picture in made.items():
        pictures.save(folder / file, picture)
    files.write_whole(folder / "figures.json", lambda to: to.write_bytes(as_json(figures)))
    _print(console, figures)
    console.print(f"pictures and figures.json are in {folder}")


def measure(
    renderer: Renderer, scene: Scene, camera: Camera
) -> tuple[Figures, dict[str, NDArray[Any]]]:
    """Everything of one view: the figures, and the pictures by their files' names.

    The scene's settings have an albedo.
    """
    settings = scene.settings
    assert settings.albedo is not None, settings
    both = Validation(renderer, scene, camera, settings.albedo)
    comparison = both.compare(settings)
    visibility = []
    for map_size in sorted({*MAP_SIZES, settings.shadow_map_size}):
        at_size = both.compare(msgspec.structs.replace(settings, shadow_map_size=map_size))
        visibility.append(visibility_figures(at_size, map_size))
    direct = both.tracer.direct(camera, renderer.size, both.light)
    figures = Figures(
        scene=scene.name,
        camera=(*camera.position.tolist(), camera.yaw, camera.pitch, camera.fov),
        light=repr(both.light),
        size=renderer.size,
        settings=settings,
        gl_renderer=renderer.gl_renderer,
        mitsuba=load_mitsuba().__version__,
        same_surface=float((comparison.same_surface | _both_empty(comparison)).mean()),
        cut_out=float(both.truth.cut_out.mean()),
        direct_integrator=_share_alike(direct, both.truth.radiance),
        radiance=radiance_figures(comparison),
        visibility=tuple(visibility),
        environment=_environment(renderer, both, camera, comparison),
    )
    exposure = renderer.exposure(both.scene, camera, settings, View.DIRECT)
    grey = renderer.render(both.scene, camera, [View.FINAL], settings=settings)[View.FINAL]
    made: dict[str, NDArray[Any]] = {
        "followspot.exr": comparison.radiance,
        "followspot.png": _displayed(comparison.radiance * exposure),
        "mitsuba.exr": both.truth.radiance,
        "mitsuba.png": _displayed(both.truth.radiance * exposure),
        "mitsuba-direct.exr": direct,
        "relative-error.exr": comparison.relative_error,
        "relative-error.png": _grey(comparison.relative_error / WHITE_ERROR * 255),
        "visibility.png": _visibility_picture(comparison, grey),
    }
    return figures, made


def _environment(
    renderer: Renderer, both: Validation, camera: Camera, comparison: Comparison
) -> EnvironmentFigures:
    """Draw the view under a sky of one colour and under its own; compare without occlusion."""
    seen = comparison.same_surface
    rounded = both.truth.normal[seen].round(6)
    normals, which = np.unique(rounded, axis=0, return_inverse=True)
    if not len(normals):
        return EnvironmentFigures(0.0, 0.0, 0.0)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    scene, albedo = both.scene, both.albedo

    def drawn(scene: Scene) -> Floats:
        settings = msgspec.structs.replace(
            scene.settings, albedo=albedo, sky_light=True, baked_light=0.0
        )
        views = renderer.render(scene, camera, [View.ENVIRONMENT], settings=settings, linear=True)
        return views[View.ENVIRONMENT][seen].astype(np.float64)

    white = CubeMap("white", np.full((6, 1, 1, 4), 255, np.uint8))
    uniform = drawn(replace(scene, sky=white, environment_constant=0.7, ambient=0.0))
    truth = both.tracer.under_constant_sky(normals, 0.7)[which.ravel()]
    constant_worst = float(_relative_difference(uniform, truth).max())

    whole = irradiance(normals, [radiance(scene.sky)])[0] * scene.environment_constant
    truth = (albedo * (whole / math.pi + scene.ambient))[which.ravel()].sum(axis=1)
    error = _relative_difference(drawn(scene).sum(axis=1), truth)
    return EnvironmentFigures(constant_worst, float(error.mean()), float(error.max()))


def _relative_difference(ours: Floats, true: Floats) -> Floats:
    """Of each number from the true one; none where both are black."""
    return np.asarray(np.abs(ours - true) / np.maximum(true, 1e-9))


def _both_empty(comparison: Comparison) -> Mask:
    return np.isinf(comparison.depth) & np.isinf(comparison.truth.depth)


def _share_alike(ours: Floats, other: Floats) -> float:
    """Share of the pixels at which two pictures are alike to a thousandth."""
    return float(np.isclose(ours, other, rtol=1e-3, atol=1e-6 * other.max()).all(axis=2).mean())


def _displayed(values: Floats) -> NDArray[np.uint8]:
    """(h, w, 3) linear display values as sRGB bytes."""
    return _bytes(linear_to_srgb(np.clip(values, 0, 1)) * 255)


def _grey(values: Floats) -> NDArray[np.uint8]:
    """(h, w) in 0 to 255 as grey (h, w, 3) bytes."""
    return _bytes(np.repeat(values[..., np.newaxis], 3, axis=2))


def _bytes(values: Floats) -> NDArray[np.uint8]:
    return np.clip(values + 0.5, 0, 255).astype(np.uint8)


def _visibility_picture(comparison: Comparison, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """False light red and false shadow blue over a grey picture."""
    shown = _grey(picture.mean(axis=2) * 0.8)
    shown[comparison.false_light] = 255, 0, 0
    shown[comparison.false_shadow] = 0, 64, 255
    return shown


def _print(console: Console, figures: Figures) -> None:
    width, height = figures.size
    console.print(
        f"{figures.scene} at {width}x{height}, albedo {figures.settings.albedo:g}, by "
        f"{figures.gl_renderer} and Mitsuba {figures.mitsuba}\n{figures.light}",
    )
    radiance, sky = figures.radiance, figures.environment
    table = Table("relative difference of radiance", "pixels", "median", "p99", "worst")
    table.add_row(
        "lit by both, no edge near", str(radiance.pixels), *map(_percent, radiance.shares)
    )
    table.add_row("sky of one colour", "", "", "", _percent(sky.constant_worst))
    table.add_row("this sky (mean, worst)", "", _percent(sky.sky_mean), "", _percent(sky.sky_worst))
    _right(table)
    console.print(table)
    table = Table("shadow map", *(str(row.map_size) for row in figures.visibility))
    for name in ("disagreement", "false_light", "false_shadow"):
        table.add_row(name.replace("_", " "), *_row(figures, name))
    table.add_section()
    for name in ("edges", "cut_out", "leak", "terminator", "acne"):
        table.add_row(name.replace("_", " "), *_row(figures, name))
    table.caption = f"shares of the {figures.visibility[0].pixels} pixels in the cone"
    _right(table)
    console.print(table)
    console.print(
        f"same surface {_percent(figures.same_surface)}, cut out or seen through such "
        f"{_percent(figures.cut_out)}, as Mitsuba's direct integrator "
        f"{_percent(figures.direct_integrator)}",
    )


def _row(figures: Figures, name: str) -> list[str]:
    return [_percent(getattr(row, name)) for row in figures.visibility]


def _right(table: Table) -> None:
    for column in table.columns[1:]:
        column.justify = "right"


def _percent(share: float) -> str:
    return f"{share * 100:.3g} %"
