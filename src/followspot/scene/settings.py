"""Everything about a picture that is a choice and not part of the scene."""

import enum
import math
from typing import Annotated, Any, get_args

import msgspec
import numpy as np
from msgspec import Meta

from followspot.assets import complaints
from followspot.errors import UsageError


class CullFace(enum.Enum):
    """Which faces the shadow pass leaves out."""

    FRONT = "front"
    BACK = "back"
    NONE = "none"


NonNegative = Annotated[float, Meta(ge=0, le=1e6)]
Moderate = Annotated[float, Meta(ge=-1e6, le=1e6)]


class Settings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Switches of a frame. Every field can be given by ``--set NAME=VALUE`` or a scene file.

    Attributes:
        shadows: Whether lights are tested against their shadow maps.
        sky_light: Whether the environment lights surfaces.
        albedo: A constant Lambertian coefficient for all opaque surfaces instead of textures.
        exposure: Display value per radiance; none lets it be chosen to suit.
        environment_mip: MIP level of the six-direction sum; none is the level of one texel.
        emission: Radiance in W/(m^2 sr) of a self-lit texel of value 1: lava, lamps, flames, beams.
            None shows them as they are painted, whatever the exposure.
        baked_light: Radiance in W/(m^2 sr) of a white surface that the level's compiler has lit so
            that textures look as they were painted. What it baked takes the environment's place;
            0 leaves it out.
        grain: Whether images that only make surfaces rougher, to be seen from near, are laid on
            them.
        fog: Whether what is behind the level's fog is seen through it.
        shadow_map_size: Texels along an edge of a spot light's shadow map. One that is fitted
            consists of two square tiles, which together have as many texels; the sides of point
            lights' cubes are tiles as large.
        shadow_fit: Spends a spot light's map on what the camera sees instead of its whole cone: one
            tile for all of that, one for what is near to the camera.
        shadow_taps: Fetches along an edge of the shadow filter's square, each the mean of four
            comparisons; 1 is the hardware's filter alone.
        shadow_cull: Faces left out of the shadow map.
        shadow_bias: Units that a receiver is moved along its normal before the comparison.
        shadow_normal_offset: Texels of the shadow map's tile in use by which a lit point is moved
            before its depth is compared, lest a surface shadow itself: sideways in the map along
            its normal (Holbert 2011). What has its lit side in the map, as two-sided surfaces do
            and with another `shadow_cull` all, is moved towards the light as well, by what its
            plane's depth changes over three times as many texels; under grazing light sideways
            by three times as many.
        shadow_slope_bias: Depth slopes per texel added to casters (glPolygonOffset's factor).
        redraw_shadows: Draws every shadow map in every frame, to measure what that costs.
        culling: Leaves out what the camera cannot see; off is for comparisons.
        anisotropy: Texture samples along the steep direction; 1 is plain trilinear.

    Raises:
        UsageError: a value is none that its field can take.
    """

    shadows: bool = True
    sky_light: bool = True
    albedo: Annotated[float, Meta(ge=0, le=1)] | None = None
    exposure: Annotated[float, Meta(gt=0, le=1e6)] | None = None
    environment_mip: NonNegative | None = None
    emission: NonNegative | None = None
    baked_light: NonNegative = 0.0
    grain: bool = False
    fog: bool = True
    shadow_map_size: Annotated[int, Meta(ge=16, le=8192)] = 1024
    shadow_fit: bool = True
    shadow_taps: Annotated[int, Meta(ge=1, le=4)] = 1
    shadow_cull: CullFace = CullFace.FRONT
    shadow_bias: Moderate = 0.0
    shadow_normal_offset: Moderate = 0.3
    shadow_slope_bias: Moderate = 0.0
    redraw_shadows: bool = False
    culling: bool = True
    anisotropy: Annotated[float, Meta(ge=1, le=16)] = 1.0

    def __post_init__(self) -> None:
        for name in _KINDS:
            value = _converted(name, getattr(self, name))
            msgspec.structs.force_setattr(self, name, value)


_KINDS: dict[str, Any] = {field.name: field.type for field in msgspec.structs.fields(Settings)}
"""Types of the fields, with their ranges."""


def _converted(name: str, value: Any, *, strict: bool = True) -> Any:
    """A field's value, checked; not strictly, from text, too."""
    given = value.item() if isinstance(value, np.generic) else value
    try:
        converted = msgspec.convert(given, _KINDS[name], strict=strict)
        if isinstance(converted, float) and not math.isfinite(converted):
            raise msgspec.ValidationError("Expected a finite number")
    except msgspec.ValidationError as error:
        expected = str(error).removeprefix("Expected ").partition(", got ")[0]
        if _KINDS[name] is CullFace:
            expected = ", ".join(side.value for side in CullFace)
        expected, found = complaints.in_words(expected), complaints.shown(value)
        raise UsageError(f"setting {name}: expected {expected}, found {found}") from None
    return converted


def with_changes(settings: Settings, changes: dict[str, str]) -> Settings:
    """Settings with some fields set from text, as ``--set`` gives them.

    Raises:
        UsageError: no such setting, or a value that it cannot take.
    """
    values: dict[str, Any] = {}
    for name, text in changes.items():
        if name not in _KINDS:
            raise UsageError(f"no setting is named {name!r}; there are {', '.join(_KINDS)}")
        value = None if is_left_open(name, text) else text
        values[name] = _converted(name, value, strict=False)
    return msgspec.structs.replace(settings, **values)


def is_left_open(name: str, value: object) -> bool:
    """Whether a text says that a setting is to be none: ``auto``, or ``none``."""
    may_be_none = type(None) in get_args(_KINDS.get(name))
    return may_be_none and isinstance(value, str) and value.lower() in ("none", "auto")
