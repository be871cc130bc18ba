"""Build the courtyard: ``python -m followspot.builtin.build_courtyard [courtyard.pk3]``.

Camera positions worth a look: the eye in world units, then yaw and pitch in degrees, where
positive pitch looks down; made for a horizontal field of view of 80 degrees.

    title     -352 -118  78   36  -5   arcade, fountain and tower in the evening sun
    arcade    -500  436  62   -7   0   along the vaulted north walk
    cloister  -482 -280  58   84   0   along the shadowed west walk, the yard beyond
    gallery   -400  440 268  -38   9   over the balustrade to the hills
    stair      120 -150  70   42  -4   the stair and the ivy on the east wing
    gate        60  230  64  255  -2   against the light: fountain, olive tree and gate
    passage    452 -150  56   90   0   the low passage in the east wing, lit by its torch
    fountain   150 -190  66  125   6   the fountain before both arcades
    overview   340  250 262  215   8   the whole yard from above the stair

The sun stands at yaw 236, 32 degrees over the horizon: the direction of `SUN_YAW` and `SUN_PITCH`,
and the sky's bright spot. Torches burn at (-531, 0, 106), (64, 467, 106), (-104, -295, 110),
(475, 120, 80) and (200, 467, 298).
"""

import sys
from pathlib import Path

from followspot.builtin.courtyard_level import courtyard
from followspot.builtin.courtyard_materials import FLAME_FRAMES, SUN_PITCH, SUN_YAW, make_materials
from followspot.builtin.courtyard_ornaments import flames
from followspot.builtin.courtyard_sky import sky_images
from followspot.levelbuilder import compile_level, image_file, material_files, write_pk3
from followspot.spaces import forward_from_angles


def courtyard_files() -> dict[str, bytes]:
    """Return every file of the courtyard's pk3 by name."""
    materials = make_materials()
    files = {"maps/courtyard.bsp": compile_level(courtyard(materials))}
    files |= material_files("courtyard", materials.all())
    for name, frame in zip(FLAME_FRAMES, flames(), strict=True):
        extension, content = image_file(frame)
        files[name + extension] = content
    for suffix, image in sky_images(forward_from_angles(SUN_YAW, -SUN_PITCH)).items():
        extension, content = image_file(image, quality=92)
        files[f"env/courtyard_{suffix}{extension}"] = content
    return files


def main() -> None:
    """Write the pk3 next to this file, or where the argument says."""
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("courtyard.pk3")
    write_pk3(target, courtyard_files())


if __name__ == "__main__":
    main()
