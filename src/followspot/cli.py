"""The command line: what is typed, taken apart and handed to ``present``."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from followspot.errors import FollowspotError, UsageError

app = typer.Typer(
    help="Open a Quake 3 level, light it, and see every stage of how the picture is made.\n\n"
    "Try: followspot render courtyard -o courtyard.png",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)



@app.callback()
def _common() -> None:
    """Keeps typer from folding the commands together."""


SceneArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCENE_OR_LEVEL",
        help="A built-in scene (courtyard), a scene file (x.toml), a level's file (x.bsp, x.pk3, "
        "x.pk3:name), or the name of an installed level (oa_dm5).",
    ),
]
AssetsOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--assets",
        metavar="DIR",
        help="A game folder or pk3 file to look in first; repeatable. Then come the folders in "
        "FOLLOWSPOT_ASSETS and the usual installs of OpenArena and Quake 3.",
    ),
]
CameraOption = Annotated[
    str | None,
    typer.Option(
        "--camera",
        metavar="NAME|x,y,z,yaw,pitch",
        help="A named view (`inspect` lists them), or an eye in Quake units with the game's "
        "angles in degrees: positive pitch looks down. By default the first view or spawn point.",
    ),
]
FovOption = Annotated[
    float | None, typer.Option("--fov", metavar="DEGREES", help="Horizontal angle of view.")
]
SizeOption = Annotated[str, typer.Option("--size", metavar="WxH", help="Pixels.")]
LightOption = Annotated[
    list[str] | None,
    typer.Option(
        "--light",
        metavar="LIGHT",
        help="A light in place of the scene's own; repeatable. "
        "spot:x,y,z:dx,dy,dz:half_angle_radians:power or point:x,y,z:power, in Quake units and "
        "watts (one number, or red,green,blue).",
    ),
]
AlbedoOption = Annotated[
    float | None,
    typer.Option("--albedo", help="One Lambertian coefficient for all opaque surfaces, no textures."),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Any other setting; repeatable: exposure, environment_mip, emission, "
        "shadow_map_size, shadow_cull (front, back, none), shadow_bias, shadow_slope_bias, "
        "anisotropy, culling.",
    ),
]
NoShadowsOption = Annotated[bool, typer.Option("--no-shadows", help="Lights pass through walls.")]
NoSkyLightOption = Annotated[
    bool, typer.Option("--no-sky-light", help="The environment lights nothing.")
]


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
) -> None:
    """Draw one picture of a scene or level.

    \b
    followspot render courtyard -o yard.png
    followspot render oa_dm5 --view normals -o normals.png
    followspot render oa_dm5 --camera 1096,-432,246,225,5 --fov 90 -o spawn.exr
    """
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
        ),
    )


def main() -> None:
    """Run the command line; what a user caused is one line on stderr and exit code 2."""
    try:
        app()
    except FollowspotError as error:
        kind = "" if isinstance(error, UsageError) else "error: "
        print(f"followspot: {kind}{error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print("followspot: interrupted", file=sys.stderr)
        sys.exit(130)
