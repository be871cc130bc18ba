"""Places that face a light, and what rays tell of them: the truth that shadow maps are held to.

Near a true edge a map cannot know better than its texels, so places near one are told apart: those
with a place EDGE_TEXELS away, as the light sees it, that is lit unlike them.
"""

from dataclasses import dataclass

import numpy as np

from followspot.arrays import Floats, Mask
from followspot.present.comparison import SAME_SURFACE
from followspot.present.report.visibility import CLEARANCE, Fitted, Places, Rays
from followspot.present.shadow_edges import EDGE_TEXELS, near_edge
from followspot.scene.light import SpotLight
from followspot.scene.settings import Settings

REACH = 64.0
"""Units into a surface that its thickness is looked for; more is not told apart."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Places that face the light within its cone, and what rays tell of them; n of each.

    Attributes:
        places: Where they are.
        lit: Whether they see the light's centre.
        near_edge: Whether a place nearby is lit unlike them.
        through_cut_out: Whether leaves or grates have a say: their edges are their texture's.
        entries: How often the way from the light enters a one-sided surface through its front.
        exits: How often it comes out through such a surface's back.
        sheets: How many two-sided surfaces it meets.
        thickness: Units along the ray from the surface through its solid to the next surface that
            front culling keeps; infinite beyond REACH.
        gap: Units along the ray from the first such surface that the light meets, that of a map
            without front faces; infinite where there is none.
        texel: Units that a texel is wide there, of the tile that the place is looked up in.
    """

    places: Places
    lit: Mask
    near_edge: Mask
    through_cut_out: Mask
    entries: np.ndarray
    exits: np.ndarray
    sheets: np.ndarray
    thickness: Floats
    gap: Floats
    texel: Floats

    @property
    def plain(self) -> Mask:
        """(n,) those where a shadow map has no excuse: no edge, no leaves."""
        return ~self.near_edge & ~self.through_cut_out


def facing(seen: Places, light: SpotLight, depth: Floats) -> tuple[Places, float]:
    """Places that both see alike and that face the light in its cone, and the share left out."""
    way = light.position - seen.position
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    inside = -way @ light.direction > light.cos_rim
    same = np.isclose(depth, seen.depth, rtol=SAME_SURFACE, atol=0)
    smooth = same & inside & (_dot(way, seen.normal) > 0)
    kept = smooth & (_dot(way, seen.face_normal) > 0)
    numbers = np.flatnonzero(kept)
    away = 1 - len(numbers) / max(int(smooth.sum()), 1)
    return seen.chosen(numbers), away


def take(
    rays: Rays, places: Places, light: SpotLight, tiles: Fitted, settings: Settings
) -> Samples:
    """What rays tell of places that face a light, whose map its tiles and settings describe."""
    count, reach = len(places), np.linalg.norm(places.position - light.position, axis=1)
    way = (places.position - light.position) / reach[:, np.newaxis]  # from the light
    above = places.position + places.face_normal * CLEARANCE
    below = places.position - places.face_normal * CLEARANCE
    entries, exits, sheets = (np.zeros(count, np.int64) for _ in range(3))
    cut_out = places.cut_out.copy()
    gap, thickness = np.zeros(count), np.full(count, np.inf)
    for hits in rays.crossings(above, np.broadcast_to(light.position, above.shape)):
        sheet, leaf = rays.is_two_sided[hits.triangle], rays.is_cut_out[hits.triangle]
        into = ~hits.from_front  # seen from the place; the light looks the other way
        np.add.at(sheets, hits.line[sheet], 1)
        np.add.at(entries, hits.line[~sheet & into], 1)
        kept = sheet | ~into
        np.add.at(exits, hits.line[~sheet & ~into], 1)
        cut_out[hits.line[leaf]] = True
        np.maximum.at(gap, hits.line[kept], (hits.fraction * reach[hits.line])[kept])
    for hits in rays.crossings(below, below + way * REACH):
        kept = rays.is_two_sided[hits.triangle] | ~hits.from_front
        np.minimum.at(thickness, hits.line[kept], hits.fraction[kept] * REACH)
    thickness[places.two_sided] = 0.0  # they are in the map themselves
    gap[exits + sheets == 0] = np.inf
    lit = entries + exits + sheets == 0
    along = (places.position - light.position) @ light.direction
    texel = tiles.texels(places.position) * along
    radius = (EDGE_TEXELS + (settings.shadow_taps - 1) / 2) * texel

    def reached(points: Floats, normals: Floats) -> Mask:
        return rays.reach(points, normals, light.position)

    return Samples(
        places,
        lit,
        near_edge(places.position, places.face_normal, lit, light, (radius,), reached),
        cut_out,
        entries,
        exits,
        sheets,
        thickness,
        gap,
        texel,
    )


def _dot(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", a, b))
