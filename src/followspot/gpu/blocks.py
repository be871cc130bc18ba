"""Uniform blocks as NumPy records in std140's layout, the same names as in GLSL.

std140 puts every vec3 and vec4 on 16 bytes, so the fields here are all vec4 or mat4; what
sits in a fourth component is said beside it. ``shaders/common/frame.glsl`` is the other half.
"""

import numpy as np
from numpy.typing import NDArray

from followspot.spaces import Mat4

MAX_LIGHTS = 8
"""Lights in one frame; the block has room for so many."""

MAX_SHADOWS = 4
"""Spot lights with a shadow map in one frame, each with its own varyings."""

SIDES = 6
"""Of the cube around a point light, each with a shadow map of its own."""

MAX_FOGS = 8
"""Volumes of fog in one frame; programs are compiled for as many as are in view."""

FRAME = np.dtype(
    [
        ("clip_from_world", "<f4", (4, 4)),
        ("direction_from_clip", "<f4", (4, 4)),  # clip x, y to the world direction of a pixel
        ("shadow_from_world", "<f4", (MAX_SHADOWS, 4, 4)),  # into the wide tile
        ("near_from_wide", "<f4", (MAX_SHADOWS, 4)),  # into the near tile: scale, shift
        ("offset_right", "<f4", (MAX_SHADOWS, 4)),  # axis; w: atlas units at a distance of one
        ("offset_up", "<f4", (MAX_SHADOWS, 4)),  # likewise
        ("light_position", "<f4", (MAX_LIGHTS, 4)),  # world units; w: offset in depth
        ("light_axis", "<f4", (MAX_LIGHTS, 4)),  # towards the light over the rim; w: rim's offset
        ("light_radiance", "<f4", (MAX_LIGHTS, 4)),  # of a white surface at one unit; w unused
        ("output_scale", "<f4", (4,)),  # x: exposure, if displayed; y: of self-lit texels
        ("sky_scale", "<f4", (4,)),  # x: radiance of a sky texel of value 1
        ("eye_position", "<f4", (4,)),  # world units; w unused
        ("fog_mins", "<f4", (MAX_FOGS, 4)),  # from the eye; w unused
        ("fog_maxs", "<f4", (MAX_FOGS, 4)),  # likewise
        ("fog_glow", "<f4", (MAX_FOGS, 4)),  # a: extinction; rgb: that times radiance, as output
    ]
)


def column_major(matrix: Mat4) -> NDArray[np.float32]:
    """A (4, 4) matrix in the column-major order in which GL reads it: the one transposition."""
    return np.ascontiguousarray(matrix.T, np.float32)
