"""Commands that draw: pictures, films, a page of both, a window."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from followspot.commands.options import (
    AlbedoOption,
    AnimationOption,
    AssetsOption,
    BakeOption,
    CameraOption,
    FovOption,
    ItemsOption,
    JobsOption,
    LightOption,
    MaxBytesOption,
    NoShadowsOption,
    NoSkyLightOption,
    PathOption,
    PlaceArgument,
    SceneArgument,
    SecondsOption,
    SetOption,
    SizeOption,
    SupersampleOption,
    TimeOption,
    folder,
)
from followspot.errors import printable


def render(
    scene: SceneArgument,
    output: Annotated[
        Path,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE",
            help=".png or .jpg: as displayed. .exr or .npy: float32 radiance in W/(m2 sr), or the "
            "view's own values (depth in Quake units).",
        ),
    ],
    view: Annotated[
        str,
        typer.Option(
            "--view",
            help="final, normals, lambertian, shading, direct, environment, shadow, depth or "
            "shadow-map.",
        ),
    ] = "final",
    camera: CameraOption = None,
    fov: FovOption = None,
    size: SizeOption = "640x480",
    light: LightOption = None,
    albedo: AlbedoOption = None,
    assets: AssetsOption = None,
    set_: SetOption = None,
    no_shadows: NoShadowsOption = False,
    no_sky_light: NoSkyLightOption = False,
    animation: AnimationOption = None,
    time: TimeOption = 0.0,
    items: ItemsOption = False,
    bake: BakeOption = False,
    supersample: SupersampleOption = 1,
    overlay: Annotated[
        str | None,
        typer.Option(
            "--overlay",
            metavar="NAME,...",
            help="To debug by, over the picture: boxes (of objects, red), scene (its bounds, "
            "yellow), light-frustum (what shadow maps cover, blue), camera-frustum (of "
            "--culled-from, white).",
        ),
    ] = None,
    culled_from: Annotated[
        str | None,
        typer.Option(
            "--culled-from",
            metavar="NAME|x,y,z,yaw,pitch",
            help="Another camera, which decides what is drawn and what shadow maps cover.",
        ),
    ] = None,
) -> None:
    """Draw one picture of a scene, a level, or a model or player alone on a plain floor.

    \b
    followspot render courtyard -o yard.png
    followspot render oa_dm5 --view normals -o normals.png
    followspot render oa_dm5 --camera 1096,-432,246,225,5 --fov 90 -o spawn.exr
    followspot render player:sarge --animation run --time 0.4 -o sarge.png
    """  # noqa: D301
    from followspot.present import still

    passed_over = still.render(
        scene,
        output,
        still.Wish(
            view=view,
            camera=camera,
            fov=fov,
            size=size,
            lights=light or (),
            albedo=albedo,
            assets=assets or (),
            settings=set_ or (),
            shadows=not no_shadows,
            sky_light=not no_sky_light,
            animation=animation,
            time=time,
            items=items,
            bake=bake,
            supersample=supersample,
            overlays=overlay,
            culled_from=culled_from,
        ),
    )
    if passed_over:
        more = f" and {len(passed_over) - 1} more" if passed_over[1:] else ""
        print(f"followspot: passed over: {printable(str(passed_over[0]))}{more}", file=sys.stderr)


def figures(
    scene: SceneArgument,
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="DIR", help="Gets the pngs.", parser=folder)
    ],
    camera: CameraOption = None,
    fov: FovOption = None,
    size: SizeOption = "640x480",
    light: LightOption = None,
    assets: AssetsOption = None,
    set_: SetOption = None,
) -> None:
    """Draw the classic sequence from normals to shadows, with a contact sheet.

    \b
    followspot figures courtyard -o out/figures
    """  # noqa: D301
    from followspot.present import tell
    from followspot.present.still import Wish

    wish = Wish(
        camera=camera,
        fov=fov,
        size=size,
        lights=light or (),
        assets=assets or (),
        settings=set_ or (),
    )
    tell.figures(scene, output, wish)


def film(
    scene: PlaceArgument,
    output: Annotated[
        str,
        typer.Option(
            "-o",
            "--output",
            metavar="FILE|DIR/",
            help=".mp4 (H.264), .webm (VP9), or a folder for one png a frame.",
        ),
    ],
    path: PathOption = None,
    size: SizeOption = "640x480",
    fps: Annotated[float, typer.Option("--fps", help="Frames a second.")] = 30,
    seconds: SecondsOption = None,
    max_bytes: MaxBytesOption = None,
    view: Annotated[
        str, typer.Option("--view", help="What it shows, as for render, but for shadow-map.")
    ] = "final",
    samples: Annotated[
        int,
        typer.Option("--samples", min=1, help="Moments averaged a frame: motion blur."),
    ] = 1,
    supersample: SupersampleOption = 1,
    jobs: JobsOption = 1,
    light: LightOption = None,
    albedo: AlbedoOption = None,
    assets: AssetsOption = None,
    set_: SetOption = None,
    no_shadows: NoShadowsOption = False,
    no_sky_light: NoSkyLightOption = False,
    items: ItemsOption = False,
    bake: BakeOption = False,
) -> None:
    """Film a flight through a scene or level; the same frames whatever the machine's speed.

    Interrupted (Ctrl-C, kill), it leaves a film of the frames done so far.

    \b
    followspot film courtyard -o yard.mp4
    followspot film oa_dm5 -o fly.mp4 --seconds 20 --max-bytes 2000000 --jobs 2
    """  # noqa: D301
    from followspot.present import film as film_
    from followspot.present.film_plan import FilmWish
    from followspot.present.still import Wish

    wish = Wish(
        view=view,
        size=size,
        lights=light or (),
        albedo=albedo,
        assets=assets or (),
        settings=set_ or (),
        shadows=not no_shadows,
        sky_light=not no_sky_light,
        items=items,
        bake=bake,
    )
    film_wish = FilmWish(path, seconds, fps, samples, supersample, max_bytes, jobs)
    raise typer.Exit(film_.run(scene, output, wish, film_wish))


def report(
    scene: SceneArgument,
    output: Annotated[
        Path,
        typer.Option("-o", "--output", metavar="DIR", help="Gets index.html and all it shows."),
    ],
    camera: CameraOption = None,
    fov: FovOption = None,
    size: Annotated[
        str,
        typer.Option(
            "--size",
            metavar="WxH",
            help="Pixels of the film, whose edges are made even; pictures have twice as many a "
            "side, 16384 at most.",
        ),
    ] = "960x540",
    film: Annotated[
        bool | None,
        typer.Option(
            "--film/--no-film",
            help="Whether there is a film: by default of scenes and levels; of a model alone "
            "there cannot be any.",
            show_default=False,
        ),
    ] = None,
    path: PathOption = None,
    seconds: SecondsOption = None,
    max_bytes: MaxBytesOption = None,
    jobs: JobsOption = 1,
    light: LightOption = None,
    assets: AssetsOption = None,
    set_: SetOption = None,
) -> None:
    """Make a page that shows and explains how a scene is drawn: pictures, film, measurements.

    The folder needs no server and no network. A step that fails is named in the page, and the exit
    code is 1.

    \b
    followspot report courtyard -o out/report
    followspot report oa_dm5 --no-film -o out/report
    """  # noqa: D301
    from followspot.present.film_plan import FilmWish
    from followspot.present.report import run as report_
    from followspot.present.still import Wish
    from followspot.scene import figure_file

    wish = Wish(
        camera=camera,
        fov=fov,
        size=size,
        lights=light or (),
        assets=assets or (),
        settings=set_ or (),
    )
    film_wish = FilmWish(path, seconds, max_bytes=max_bytes, jobs=jobs)
    if film is None:
        film = film_wish != FilmWish(jobs=jobs) or not figure_file.is_model(scene)
    raise typer.Exit(report_.run(scene, output, wish, film_wish if film else None))


def view(
    scene: SceneArgument,
    camera: CameraOption = None,
    fov: FovOption = None,
    size: SizeOption = "1280x800",
    light: LightOption = None,
    assets: AssetsOption = None,
    set_: SetOption = None,
    animation: AnimationOption = None,
    time: TimeOption = 0.0,
    items: ItemsOption = False,
    bake: BakeOption = False,
) -> None:
    """Open a window: fly through a scene, move its lights, see into every stage.

    W A S D and the right mouse button fly; the panel Keys lists the rest. Tab hides the panels.

    \b
    followspot view courtyard
    """  # noqa: D301
    from followspot.present import still
    from followspot.present.viewer import window

    wish = still.Wish(
        camera=camera,
        fov=fov,
        size=size,
        lights=light or (),
        assets=assets or (),
        settings=set_ or (),
        animation=animation,
        time=time,
        items=items,
        bake=bake,
    )
    window.run(scene, wish)
