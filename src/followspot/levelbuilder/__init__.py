r"""The level builder: Quake 3 levels by script, for the built-in courtyard and for teaching.

A level is brushes (convex solids), Bezier patches, loose meshes and entities, added to a `Level`
and turned into an IBSP 46 file by `compile_level`: hidden faces cut away, space split into a BSP
tree, light baked. Lengths are Quake units, Z is up, a player is 56 units tall. A room:

    from pathlib import Path
    import numpy as np
    from followspot.levelbuilder import (
        Level, Material, Surface, arch, box, compile_level, material_files, room, write_pk3)

    grey = np.full((64, 64, 3), 150, np.uint8)
    grey[::16] = 100
    stone = Material("textures/demo/stone", (64, 64), 1.0, image=grey)
    sky = Material("textures/demo/sky", surface=Surface.SKY | Surface.NOLIGHTMAP,
                   script="q3map_sun 1 0.9 0.7 150 215 40\nq3map_skyLight 60 3")
    level = Level("A room with an arch")
    level.add(room((-256, -256, 0), (256, 256, 192), stone, faces={"+z": sky}))
    level.add(box((-200, -32, 0), (-48, 32, 160), stone), box((48, -32, 0), (200, 32, 160), stone))
    level.add(arch((-48, -32, 64), (96, 0, 0), (0, 64, 0), 48, stone, top=160))
    level.spawn(0, -160, floor=0, angle=90)
    level.light((0, 128, 96), 200, color=(1, 0.7, 0.4))
    files = material_files("demo", [stone, sky]) | {"maps/demo.bsp": compile_level(level)}
    write_pk3(Path("demo.pk3"), files)

The same script always writes the same bytes. Mistakes raise `followspot.errors.UsageError`.
This package stands outside the renderer: nothing there imports it.
"""

from followspot.assets.surface_flags import Contents, Surface
from followspot.levelbuilder.brush import Brush, box, brush_from_planes, hull, prism, room
from followspot.levelbuilder.compiler import compile_level
from followspot.levelbuilder.level import Level
from followspot.levelbuilder.material import CAULK, CLIP, Material
from followspot.levelbuilder.mesh import Mesh, quads
from followspot.levelbuilder.patches import (
    Patch,
    arc,
    arch,
    flat,
    flipped,
    groin_vault,
    lathe,
    polyline,
    ruled,
)
from followspot.levelbuilder.pk3 import image_file, material_files, pk3_bytes, write_pk3
from followspot.levelbuilder.projection import fitted, world_aligned

__all__ = [
    "CAULK",
    "CLIP",
    "Brush",
    "Contents",
    "Level",
    "Material",
    "Mesh",
    "Patch",
    "Surface",
    "arc",
    "arch",
    "box",
    "brush_from_planes",
    "compile_level",
    "fitted",
    "flat",
    "flipped",
    "groin_vault",
    "hull",
    "image_file",
    "lathe",
    "material_files",
    "pk3_bytes",
    "polyline",
    "prism",
    "quads",
    "room",
    "ruled",
    "world_aligned",
    "write_pk3",
]
