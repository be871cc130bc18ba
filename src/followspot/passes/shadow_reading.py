"""Lights' shadow maps read back as distances, for pictures of them."""

import numpy as np
from numpy.typing import NDArray

from followspot.passes import shadow_fit, shadow_tiles
from followspot.passes.shadow import ShadowPass

UNFOLDED = ((1, 1), (1, 3), (1, 0), (1, 2), (0, 1), (2, 1))
"""Row and column of each side of a point light's cube in the picture of it: +Y +X -Y -X around the
horizon, +Z above and -Z below +X, as they are seen from the light.
"""


def read_distance(shadow: ShadowPass, number: int) -> NDArray[np.float32]:
    """(size, size) distances along light `number`'s axis in units, top row first.

    What its wide tile covers, but from the near one where that holds a pixel's middle, of which
    lookups use all but the outermost texels. Infinite where the light's rays hit nothing.
    """
    wide, *near = shadow.tiles_of(number)
    places = np.tile((np.arange(shadow.size) + 0.5) / shadow.size, (2, 1))
    depths = shadow.map.depths_at(wide.place, *places)
    if near:
        scale, shift = wide.finer_from_here
        places = places * scale[:, np.newaxis] + shift[:, np.newaxis]
        columns, rows = (places >= 0) & (places < 1)
        finer = shadow.map.depths_at(near[0].place, places[0][columns], places[1][rows])
        depths[np.ix_(rows, columns)] = finer
    return wide.frustum.distances(depths[::-1]).astype(np.float32)


def read_cube(shadow: ShadowPass) -> NDArray[np.float32]:
    """(3 size, 4 size) distances along their axes of the first point light's sides, in units.

    Laid out as `UNFOLDED`. Infinite where the light's rays hit nothing.
    """
    size, first = shadow.size, shadow_tiles.spot_count(shadow.layout.lights)
    picture = np.full((3, 4, size, size), np.inf, np.float32)
    places = (((np.arange(size) * 2 + 1) / size - 1) / shadow_fit.side_reach(size) + 1) / 2
    for number, cell in enumerate(UNFOLDED):
        (tile,) = shadow.tiles_of(first + number)
        depths = shadow.map.depths_at(tile.place, places, places)
        picture[cell] = tile.frustum.distances(depths[::-1])
    return picture.swapaxes(1, 2).reshape(3 * size, 4 * size)
