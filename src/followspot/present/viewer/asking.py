"""What panels want to know about the picture, and what was found out: plain data."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import moderngl

from followspot.arrays import Floats
from followspot.passes.thumbnails import Thumbnail
from followspot.present.pixel import PixelReport
from followspot.scene.material import Material


@dataclass(frozen=True)
class Asked:
    """What is wanted; panels say it anew in every frame that they are seen in.

    Attributes:
        shadow_map: Number of a light with a map, to show that.
        texel: Column and row in it, from the top left.
        pixel: Column and row of the picture, from the top left; stays until another is picked,
            which may be the same again.
        follows: Whether that is looked at again where the picture has changed.
        sky_level: MIP level of the sky's faces.
        thumbnails: Materials that are shown.
    """

    shadow_map: int | None = None
    texel: tuple[int, int] | None = None
    pixel: tuple[int, int] | None = None
    follows: bool = False
    sky_level: int | None = None
    thumbnails: tuple[Material, ...] = ()

    @property
    def standing(self) -> "Asked":
        """What is still wanted when nobody says it again."""
        return Asked(pixel=self.pixel)


@dataclass(frozen=True, eq=False)
class Texel:
    """A shadow map's texel.

    Attributes:
        place: Column and row, from the top left.
        is_near: Whether the light's near tile says what is there.
        depth: In [0, 1]; 1 is nothing.
        distance: Units along the light's axis.
        position: (3,) world units of what is there.
    """

    place: tuple[int, int]
    is_near: bool
    depth: float
    distance: float
    position: Floats


@dataclass(frozen=True, eq=False)
class Found:
    """What was found of what was asked.

    Attributes:
        key_maps: The key light's shadow map, as greys, while a stage shows it; of a point light
            those of the sides of its cube.
        shadow_map: The one that was asked for.
        map_age: Frames since shadow maps were drawn; 0 is this frame.
        finer: How much smaller texels are in the near tile of the one that was asked for, in the
            mean of both axes; none if it has no such tile.
        texel: Of the one that was asked for.
        pixel: How it came about.
        pixel_is_old: Whether the picture has changed since.
        sky: Its six faces as a cross; see `sky_preview.FACES`.
        sheet: All thumbnails.
        thumbnails: Those of what was asked for which there are so far.
    """

    key_maps: tuple[moderngl.Texture, ...]
    shadow_map: moderngl.Texture | None
    map_age: int
    finer: float | None
    texel: Texel | None
    pixel: PixelReport | None
    pixel_is_old: bool
    sky: moderngl.Texture | None
    sheet: moderngl.Texture
    thumbnails: Mapping[Material, Thumbnail] = field(default_factory=dict)
