"""The courtyard's materials: textures with their sizes, flags and shader scripts."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from followspot.builtin import courtyard_ornaments as ornaments
from followspot.builtin import courtyard_textures as textures
from followspot.levelbuilder import Contents, Material, Surface
from followspot.levelbuilder.material import PLAIN

FOLDER = "textures/courtyard"

SUN_YAW, SUN_PITCH = 236.0, 32.0
"""Where the sun stands, degrees from +x and over the horizon: late in the afternoon."""

SUN_COLOR = (1.0, 0.84, 0.62)

_GHOST = Surface.NONSOLID | Surface.NOMARKS | Surface.NOLIGHTMAP
_AIRY = Contents.TRANSLUCENT


def _plain(
    name: str,
    image: NDArray[np.uint8],
    units_per_texel: float = 0.25,
    surface: Surface = PLAIN,
) -> Material:
    """Return a material that needs no script: the image has its name."""
    height, width = image.shape[:2]
    return Material(
        f"{FOLDER}/{name}", (width, height), units_per_texel, surface=surface, image=image
    )


def _leafy(name: str, image: NDArray[np.uint8], opacity: float) -> Material:
    """Return a material for flat cut-outs, seen and lit from both sides."""
    script = f"""
        cull none
        {{
        map {FOLDER}/{name}.png
        alphaFunc GE128
        depthWrite
        rgbGen vertex
        }}"""
    return Material(
        f"{FOLDER}/{name}",
        (image.shape[1], image.shape[0]),
        surface=_GHOST | Surface.ALPHASHADOW,
        contents=_AIRY,
        opacity=opacity,
        script=script,
        image=image,
    )


def _water(image: NDArray[np.uint8]) -> Material:
    script = f"""
        qer_trans 0.5
        cull none
        {{
        map {FOLDER}/water.jpg
        blendFunc GL_ONE GL_ONE_MINUS_SRC_COLOR
        tcMod scroll 0.013 0.021
        tcMod turb 0 0.03 0 0.2
        }}
        {{
        map {FOLDER}/water.jpg
        blendFunc GL_ONE GL_ONE
        rgbGen const ( 0.35 0.35 0.35 )
        tcMod scale 1.7 1.7
        tcMod scroll -0.017 0.008
        }}"""
    return Material(
        f"{FOLDER}/water",
        (256, 256),
        0.25,
        surface=Surface.NOMARKS | Surface.NOLIGHTMAP,
        contents=Contents.WATER | Contents.TRANSLUCENT,
        opacity=0.35,
        script=script,
        image=image,
    )


FLAME_FRAMES = tuple(f"{FOLDER}/flame{i}" for i in range(4))

_FLAME_SCRIPT = f"""
    cull none
    q3map_surfacelight 300
    {{
    animMap 9 {" ".join(name + ".jpg" for name in FLAME_FRAMES)}
    blendFunc GL_ONE GL_ONE
    rgbGen wave sin 0.85 0.15 0 5
    }}"""

_SKY_SCRIPT = f"""
    qer_editorimage env/courtyard_up.jpg
    q3map_sun {SUN_COLOR[0]} {SUN_COLOR[1]} {SUN_COLOR[2]} 150 {SUN_YAW:g} {SUN_PITCH:g}
    q3map_skyLight 80 3
    skyParms env/courtyard 512 -"""


@dataclass(frozen=True)
class Materials:
    """Every material of the courtyard; see `courtyard_textures` for what each looks like."""

    ashlar: Material
    stone: Material
    brick: Material
    ochre: Material
    rose: Material
    vault: Material
    paving: Material
    tiles: Material
    wood: Material
    iron: Material
    clay: Material
    bark: Material
    soil: Material
    door: Material
    window: Material
    banner: Material
    leaves: Material
    blossom: Material
    water: Material
    flame: Material
    sky: Material

    def all(self) -> list[Material]:
        """Return them in a fixed order."""
        return [getattr(self, field.name) for field in fields(self)]


def make_materials() -> Materials:
    """Paint all textures and return the materials."""
    return Materials(
        ashlar=_plain("ashlar", textures.dressed_stone()),
        stone=_plain("stone", textures.trim_stone()),
        brick=_plain("brick", textures.brick()),
        ochre=_plain("ochre", textures.plaster((0.79, 0.70, 0.55), 41)),
        rose=_plain("rose", textures.plaster((0.78, 0.66, 0.56), 51)),
        vault=_plain("vault", textures.vault_plaster()),
        paving=_plain("paving", textures.paving()),
        tiles=_plain("tiles", textures.roof_tiles()),
        wood=_plain("wood", textures.planks()),
        iron=_plain("iron", textures.iron(), surface=Surface.METALSTEPS),
        clay=_plain("clay", textures.clay()),
        bark=_plain("bark", textures.bark()),
        soil=_plain("soil", textures.soil()),
        door=_plain("door", ornaments.door()),
        window=_plain("window", ornaments.window()),
        banner=_leafy("banner", ornaments.banner(), 0.95),
        leaves=_leafy("leaves", ornaments.leaves(), 0.45),
        blossom=_leafy("blossom", ornaments.leaves(seed=162, blossom=0.7), 0.45),
        water=_water(ornaments.water()),
        flame=Material(
            f"{FOLDER}/flame",
            (64, 128),
            surface=_GHOST,
            contents=_AIRY,
            opacity=0.0,
            script=_FLAME_SCRIPT,
        ),
        sky=Material(
            f"{FOLDER}/sky",
            surface=Surface.SKY | Surface.NOIMPACT | Surface.NOMARKS | Surface.NOLIGHTMAP,
            script=_SKY_SCRIPT,
        ),
    )
