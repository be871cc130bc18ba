"""Arguments and options that several commands of the command line have."""

from pathlib import Path
from typing import Annotated

import typer


def folder(text: str) -> Path:
    """A folder's name, which an empty text is not."""
    if not text:
        raise typer.BadParameter("expected a folder's name")
    return Path(text)


_PLACES = (
    "A built-in scene (courtyard), a scene file (x.toml), a level's file (x.bsp, x.pk3, "
    "x.pk3:name), the name of an installed level (oa_dm5)"
)
SceneArgument = Annotated[
    str,
    typer.Argument(
        metavar="SCENE_OR_LEVEL",
        help=f"{_PLACES}, or a model alone (x.md2, x.md3, x.glb, x.gltf, x.obj, x.ply, "
        "player:sarge).",
    ),
]
PlaceArgument = Annotated[
    str,
    typer.Argument(metavar="SCENE_OR_LEVEL", help=f"{_PLACES}; no model alone."),
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
    typer.Option(
        "--albedo", help="One Lambertian coefficient for all opaque surfaces, no textures."
    ),
]
SetOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="Any other setting; repeatable: exposure, baked_light, environment_mip, emission, "
        "shadow_map_size, shadow_taps, shadow_cull (front, back, none), shadow_bias, "
        "shadow_normal_offset, shadow_slope_bias, shadow_fit, fog, grain, anisotropy, culling, "
        "redraw_shadows.",
    ),
]
SupersampleOption = Annotated[
    int,
    typer.Option(
        "--supersample",
        min=1,
        max=16,
        help="Pixels drawn along an edge of each that is written, which is their mean.",
    ),
]
NoShadowsOption = Annotated[bool, typer.Option("--no-shadows", help="Lights pass through walls.")]
NoSkyLightOption = Annotated[
    bool, typer.Option("--no-sky-light", help="The environment lights nothing.")
]
PathOption = Annotated[
    str | None,
    typer.Option(
        "--path",
        metavar="NAME|auto",
        help="The camera's path: one of the scene file's, or auto, which is found in the "
        "level. By default the first one.",
    ),
]
SecondsOption = Annotated[
    float | None,
    typer.Option(
        "--seconds",
        help="Length of the film, by default the path's own (auto: 20); one frame at least.",
    ),
]
MaxBytesOption = Annotated[
    int | None,
    typer.Option("--max-bytes", min=1, help="Largest film allowed; quality drops to fit."),
]
JobsOption = Annotated[
    int, typer.Option("--jobs", min=1, help="Processes that draw the film, 64 at most.")
]
AnimationOption = Annotated[
    str | None,
    typer.Option(
        "--animation",
        metavar="NAME",
        help="What a model or player does; `inspect` lists the names. A player's may be "
        "legs+torso, as run+attack.",
    ),
]
ItemsOption = Annotated[
    bool, typer.Option("--items", help="Show the level's pick-ups, turning and bobbing.")
]
BakeOption = Annotated[
    bool,
    typer.Option(
        "--bake",
        help="Trace what the sky and the lights throw from wall to wall first, some seconds long, "
        "and show it in place of the sky's light, which reaches everywhere.",
    ),
]
TimeOption = Annotated[
    float,
    typer.Option("--time", metavar="SECONDS", help="When: characters and surfaces move by it."),
]
