"""Commands that tell and measure: a file, frame times, OpenGL, the picture's truth."""

from pathlib import Path
from typing import Annotated

import typer

from followspot.commands.options import (
    AlbedoOption,
    AssetsOption,
    CameraOption,
    FovOption,
    LightOption,
    SceneArgument,
    SetOption,
    SizeOption,
    folder,
)


def inspect(
    level: SceneArgument,
    json: Annotated[bool, typer.Option("--json", help="All of it, for programs.")] = False,
    assets: AssetsOption = None,
) -> None:
    """Tell what is in a level, a model (x.md2, x.md3, x.glb, ...) or a player (player:sarge).

    Counts, bounds, entities, views, materials; parts, surfaces, tags, skins, animations.
    """
    from followspot.present import tell

    tell.inspect(level, assets or (), as_json=json)


def bench(
    scene: SceneArgument,
    camera: CameraOption = None,
    fov: FovOption = None,
    size: SizeOption = "640x480",
    frames: Annotated[int, typer.Option("--frames", min=1, help="Frames counted a view.")] = 100,
    sweep: Annotated[
        bool, typer.Option("--sweep", help="All named views and spawn points, one after another.")
    ] = False,
    redraw_shadows: Annotated[
        bool, typer.Option("--redraw-shadows", help="Draw the shadow maps anew in every frame.")
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="All figures, for programs.")] = False,
    light: LightOption = None,
    assets: AssetsOption = None,
    set_: SetOption = None,
) -> None:
    """Measure frame times, with the GPU drained after each frame; also loading and memory.

    \b
    followspot bench oa_dm5 --redraw-shadows
    """  # noqa: D301
    from followspot.present import tell
    from followspot.present.still import Wish

    settings = [*(set_ or ()), *(["redraw_shadows=true"] if redraw_shadows else [])]
    wish = Wish(
        camera=camera,
        fov=fov,
        size=size,
        lights=light or (),
        assets=assets or (),
        settings=settings,
    )
    tell.bench(scene, wish, frames, sweep=sweep, as_json=json)


def doctor() -> None:
    """Tell which ways to OpenGL work on this machine, and what to install if none does."""
    from followspot.present import doctor as examination

    raise typer.Exit(examination.print_report())


def validate(
    scene: SceneArgument,
    output: Annotated[
        Path,
        typer.Option(
            "-o",
            "--output",
            metavar="DIR",
            help="Gets the pictures and figures.json.",
            parser=folder,
        ),
    ],
    camera: CameraOption = None,
    fov: FovOption = None,
    size: SizeOption = "320x240",
    light: LightOption = None,
    albedo: AlbedoOption = 0.5,
    assets: AssetsOption = None,
    set_: SetOption = None,
) -> None:
    """Compare radiance and shadows with the ray tracer Mitsuba 3 (extra: validate).

    \b
    followspot validate courtyard -o out/validate
    followspot validate oa_dm5 --set shadow_cull=back -o out/validate
    """  # noqa: D301
    from followspot.present import validate as validation
    from followspot.present.still import Wish

    wish = Wish(
        camera=camera,
        fov=fov,
        size=size,
        lights=light or (),
        albedo=albedo,
        assets=assets or (),
        settings=set_ or (),
    )
    validation.run(scene, output, wish)
