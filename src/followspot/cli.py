"""The command line: what is typed, taken apart and handed to ``present``."""

import itertools
import os
import sys
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperGroup

from followspot import __version__
from followspot.errors import FollowspotError, UsageError, printable
from followspot.options import (
    AlbedoOption,
    AnimationOption,
    AssetsOption,
    CameraOption,
    FovOption,
    ItemsOption,
    JobsOption,
    LightOption,
    MaxBytesOption,
    NoShadowsOption,
    NoSkyLightOption,
    PathOption,
    SceneArgument,
    SecondsOption,
    SetOption,
    SizeOption,
    TimeOption,
    folder,
)

# NumPy's matrix products here are small: threads that spin for them cost more than they bring.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


class _Interrupted(Exception):  # noqa: N818 - no error
    """Ctrl-C, which typer would swallow."""


class _Commands(TyperGroup):
    def invoke(self, ctx: Any) -> Any:
        """Run the command that was typed."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise _Interrupted from None


app = typer.Typer(
    cls=_Commands,
    help="Open a Quake 3 level, light it, and see every stage of how the picture is made.\n\n"
    "Try: followspot render courtyard -o courtyard.png",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _tell_version(wanted: bool) -> None:
    if wanted:
        print(f"followspot {__version__}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option("--version", help="Tell it.", is_eager=True, callback=_tell_version),
    ] = False,
) -> None:
    """Options of the program itself."""


@app.command()
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

    still.render(
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
            overlays=overlay,
            culled_from=culled_from,
        ),
    )


@app.command()
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


@app.command()
def inspect(
    level: SceneArgument,
    json: Annotated[bool, typer.Option("--json", help="All of it, for programs.")] = False,
    assets: AssetsOption = None,
) -> None:
    """Tell what is in a level, a model (x.md2, x.md3) or a player (player:sarge), and what is not.

    Counts, bounds, entities, views, materials; parts, surfaces, tags, skins, animations.
    """
    from followspot.present import tell

    tell.inspect(level, assets or (), as_json=json)


@app.command()
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


@app.command()
def doctor() -> None:
    """Tell which ways to OpenGL work on this machine, and what to install if none does."""
    from followspot.present import doctor as examination

    raise typer.Exit(examination.print_report())


@app.command()
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


@app.command()
def film(
    scene: SceneArgument,
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
    supersample: Annotated[
        int,
        typer.Option(
            "--supersample", min=1, max=16, help="Pixels drawn along an edge of each of the film's."
        ),
    ] = 1,
    jobs: JobsOption = 1,
    light: LightOption = None,
    albedo: AlbedoOption = None,
    assets: AssetsOption = None,
    set_: SetOption = None,
    no_shadows: NoShadowsOption = False,
    no_sky_light: NoSkyLightOption = False,
    items: ItemsOption = False,
) -> None:
    """Film a flight through a scene or level; the same frames whatever the machine's speed.

    Interrupted (Ctrl-C, kill), it leaves a film of the frames done so far.

    \b
    followspot film courtyard -o yard.mp4
    followspot film oa_dm5 -o fly.mp4 --seconds 20 --max-bytes 2000000 --jobs 2
    """  # noqa: D301
    from followspot.present import film as film_
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
    )
    film_wish = film_.FilmWish(path, seconds, fps, samples, supersample, max_bytes, jobs)
    raise typer.Exit(film_.run(scene, output, wish, film_wish))


@app.command()
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
            "--size", metavar="WxH", help="Pixels of the film; pictures have twice as many a side."
        ),
    ] = "960x540",
    film: Annotated[bool, typer.Option("--film/--no-film", help="Whether there is a film.")] = True,
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
    from followspot.present.film import FilmWish
    from followspot.present.report import run as report_
    from followspot.present.still import Wish

    wish = Wish(
        camera=camera,
        fov=fov,
        size=size,
        lights=light or (),
        assets=assets or (),
        settings=set_ or (),
    )
    film_wish = FilmWish(path, seconds, max_bytes=max_bytes, jobs=jobs) if film else None
    raise typer.Exit(report_.run(scene, output, wish, film_wish))


@app.command()
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
    )
    window.run(scene, wish)


def main() -> NoReturn:
    """Run the command line; what a user caused is one line on stderr and exit code 2."""
    try:
        sys.exit(app(sys.argv[1:] or ["--help"], standalone_mode=False) or 0)
    except FollowspotError as error:
        _fail(str(error) if isinstance(error, UsageError) else f"error: {error}")
    except (KeyboardInterrupt, _Interrupted):
        _fail("interrupted", 130)
    except Exception as error:
        tell = getattr(error, "format_message", None)  # typer's own, whose class has no public name
        if tell is None:
            raise
        _fail(printable(" ".join(tell().split()).rstrip(".") + _found(error)))


def _found(error: Exception) -> str:
    """What was typed for the option that typer complains of."""
    found = ""
    for option in getattr(getattr(error, "param", None), "opts", ()):
        for typed, following in itertools.pairwise([*sys.argv, ""]):
            if typed == option:
                found = f", found {following!r}"
            elif typed.startswith(f"{option}="):
                found = f", found {typed.partition('=')[2]!r}"
    return found


def _fail(text: str, code: int = 2) -> NoReturn:
    print(f"followspot: {text}", file=sys.stderr)
    sys.exit(code)
