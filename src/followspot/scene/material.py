"""What a surface is made of: one image, perhaps another one on it, and how they are drawn."""

from dataclasses import dataclass
from enum import Enum

from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.scene.deform import RIGID, Deforms
from followspot.scene.motion import STILL, Motion

Blend = tuple[BlendFactor, BlendFactor]
Color = tuple[float, float, float]

BRIGHTENS = (BlendFactor.DST_COLOR, BlendFactor.ONE)
"""Blending that adds a share of what is behind."""

ADDS_BY_ALPHA = (BlendFactor.SRC_ALPHA, BlendFactor.ONE)
"""Blending that adds a share of what is in front, by its alpha."""

_OF_SOURCE = {
    BlendFactor.ONE,
    BlendFactor.SRC_COLOR,
    BlendFactor.ONE_MINUS_SRC_COLOR,
    BlendFactor.SRC_ALPHA,
    BlendFactor.ONE_MINUS_SRC_ALPHA,
}


class Shade(Enum):
    """Where the light of a surface comes from."""

    LIT = "lit"
    """A Lambertian surface under the frame's lights."""
    EMISSIVE = "emissive"
    """It shines by itself: lava, screens, flames, beams, coronas."""
    FILTER = "filter"
    """It only colours what is behind it: stains, tinted glass."""


class Laid(Enum):
    """What a layer does with what it is laid on; of several, the first here is drawn."""

    OVER = "over"
    """Covers it as its own alpha says."""
    GLOW = "glow"
    """Adds light of its own: what shines in a lamp."""
    SHEEN = "sheen"
    """Adds to what it reflects."""
    FILTER = "filter"
    """Colours it."""
    GRAIN = "grain"
    """Makes it rougher: texels brighter than middle grey brighten it, others darken it."""


class ByVertex(Enum):
    """What vertices' own colours, the light that a level's compiler found there, do to a layer."""

    BRIGHTENS = "brightens"
    DIMS = "dims"


@dataclass(frozen=True)
class Layer:
    """An image that is laid on another one.

    Attributes:
        image: Its path in the archive.
        laid: What it does there.
        clamps: Whether it ends at its border instead of repeating.
        alpha_test: Which of its texels are laid on at all.
        fades: Whether it covers as the alpha of the mesh's tints says, too: terrain that passes
            from one ground into another.
        by_vertex: What the mesh's tints are to it, if anything.
        mirrors: Whether it is looked up by where the surface would mirror the eye's ray to.
        motion: What it does as time goes by.
        color: What its texels are multiplied by, linear.
    """

    image: str
    laid: Laid = Laid.OVER
    clamps: bool = False
    alpha_test: AlphaTest | None = None
    fades: bool = False
    by_vertex: ByVertex | None = None
    mirrors: bool = False
    motion: Motion = STILL
    color: Color | None = None

    @property
    def reads_tints(self) -> bool:
        """Whether the mesh's tints matter to it."""
        return self.fades or self.by_vertex is not None

    def color_at(self, seconds: float) -> Color:
        """What its texels are multiplied by at a time, linear."""
        pulse, _ = self.motion.pulse(seconds)
        red, green, blue = self.color or (1.0, 1.0, 1.0)
        return red * pulse, green * pulse, blue * pulse


@dataclass(frozen=True)
class Material:
    """One way to draw faces.

    Attributes:
        name: The shader's name in the level.
        image: Path of the base image in the archive; none is plain white.
        sides: Which sides are drawn.
        alpha_test: Which texels are kept, where the surface is cut out.
        blend: Source and destination factors, where the surface is blended.
        shade: Where its light comes from.
        clamps: Whether the image ends at its border instead of repeating.
        polygon_offset: Whether it is a decal that lies on another surface.
        alpha_scale: What the image's alpha is multiplied by before it is tested.
        is_tinted: Whether texels are multiplied by the mesh's tints.
        layer: What is laid on the base image.
        mirrors: Whether the base image is a reflection's, that is looked up by where the surface
            would mirror the eye's ray to.
        motion: What the base image does as time goes by.
        deforms: What vertices do.
        color: What texels are multiplied by, linear, if the script says so. A level's are tinted
            then; models leave it out.
    """

    name: str
    image: str | None = None
    sides: Sides = Sides.FRONT
    alpha_test: AlphaTest | None = None
    blend: Blend | None = None
    shade: Shade = Shade.LIT
    clamps: bool = False
    polygon_offset: bool = False
    alpha_scale: float = 1.0
    is_tinted: bool = False
    layer: Layer | None = None
    mirrors: bool = False
    motion: Motion = STILL
    deforms: Deforms = RIGID
    color: Color | None = None

    @property
    def state(self) -> tuple[object, ...]:
        """What GL is set to for it, beside its image; equal for materials drawn alike."""
        return self.sides, self.alpha_test, self.blend, self.polygon_offset, self.shade

    @property
    def order(self) -> tuple[object, ...]:
        """Sorting by this puts opaque first, then cut out, then blended, each by state."""
        state = [str(part) for part in self.state]
        images = self.image or "", self.layer.image if self.layer else ""
        return self.blend is not None, self.alpha_test is not None, *state, *images

    @property
    def images(self) -> tuple[str | None, ...]:
        """The base image and the layer's, then those that follow them in time."""
        if self.layer is None:
            return self.image, *self.motion.frames[1:]
        later = *self.motion.frames[1:], *self.layer.motion.frames[1:]
        return self.image, self.layer.image, *later

    @property
    def moves(self) -> bool:
        """Whether time or the camera's angles matter to it."""
        layer_moves = self.layer is not None and self.layer.motion != STILL
        return layer_moves or self.motion != STILL or self.deforms != RIGID

    @property
    def reads_tints(self) -> bool:
        """Whether the mesh's tints matter to it."""
        return self.is_tinted or (self.layer is not None and self.layer.reads_tints)

    @property
    def casts(self) -> bool:
        """Whether it is drawn into shadow maps: not what is seen through, nor what turns to you."""
        return self.blend is None and self.deforms.sprite is None

    @property
    def shines(self) -> bool:
        """Whether some of its light is its own."""
        has_glow = self.layer is not None and self.layer.laid is Laid.GLOW
        return self.shade is Shade.EMISSIVE or has_glow

    @property
    def uses_alpha(self) -> bool:
        """Whether the image's alpha matters."""
        return self.alpha_test is not None or self.blend is not None

    @property
    def only_adds(self) -> bool:
        """Whether it adds light to what stands there, and the same whatever that is."""
        if self.blend is None:
            return False
        source, destination = self.blend
        return destination is BlendFactor.ONE and source in _OF_SOURCE

    @property
    def is_two_sided(self) -> bool:
        """Whether both sides are drawn."""
        return self.sides is Sides.BOTH
