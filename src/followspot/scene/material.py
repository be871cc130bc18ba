"""What a surface is made of, worked out from Quake's shader scripts.

A script is a program of stages for the game's own renderer, which has lightmaps and vertex
colours. Here light comes from lights, so of the stages one is chosen: the image that tells the
surface's colour; and perhaps another one, which is laid over it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise

from followspot.assets.bsp import BspFile
from followspot.assets.shader_script import ShaderScript, Stage
from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.assets.surface_flags import Surface
from followspot.scene.deform import RIGID, Deforms
from followspot.scene.motion import DISPLAY_GAMMA, STILL, Motion

Blend = tuple[BlendFactor, BlendFactor]
Color = tuple[float, float, float]

_HIDDEN = Surface.SKY | Surface.NODRAW | Surface.HINT | Surface.SKIP

_COVERS = (BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA)
_BRIGHTENS = (BlendFactor.DST_COLOR, BlendFactor.ONE)
_OF_SOURCE = {
    BlendFactor.ONE,
    BlendFactor.SRC_COLOR,
    BlendFactor.ONE_MINUS_SRC_COLOR,
    BlendFactor.SRC_ALPHA,
    BlendFactor.ONE_MINUS_SRC_ALPHA,
}
_MULTIPLIES = {
    _BRIGHTENS,
    (BlendFactor.DST_COLOR, BlendFactor.ZERO),
    (BlendFactor.ZERO, BlendFactor.SRC_COLOR),
    (BlendFactor.DST_COLOR, BlendFactor.SRC_COLOR),
    (BlendFactor.ZERO, BlendFactor.ONE_MINUS_SRC_COLOR),
    (BlendFactor.DST_COLOR, BlendFactor.ONE_MINUS_DST_ALPHA),
}


class Shade(Enum):
    """Where the light of a surface comes from."""

    LIT = "lit"
    """A Lambertian surface under the frame's lights."""
    EMISSIVE = "emissive"
    """It shines by itself: flames, beams, coronas."""
    FILTER = "filter"
    """It only colours what is behind it: stains, tinted glass."""


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
        layer: Path of an image that is laid over the base one as its own alpha says.
        fades: Whether the alpha of the mesh's tints says so, too: terrain that passes from one
            ground into another.
        layer_alpha_test: Which of the layer's texels are laid over it at all.
        mirrors: Whether the base image is a reflection's, that is looked up by where the surface
            would mirror the eye's ray to.
        motion: What the base image does as time goes by.
        layer_motion: What the layer's does.
        deforms: What vertices do.
        color: What a level's texels are multiplied by, linear, if its script says so; they are
            tinted then.
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
    layer: str | None = None
    fades: bool = False
    layer_alpha_test: AlphaTest | None = None
    mirrors: bool = False
    motion: Motion = STILL
    layer_motion: Motion = STILL
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
        images = self.image or "", self.layer or ""
        return self.blend is not None, self.alpha_test is not None, *state, *images

    @property
    def images(self) -> tuple[str | None, ...]:
        """The base image and the layer's, then those that follow them in time."""
        return self.image, self.layer, *self.motion.frames[1:], *self.layer_motion.frames[1:]

    @property
    def moves(self) -> bool:
        """Whether time or the camera's angles matter to it."""
        return (self.motion, self.layer_motion, self.deforms) != (STILL, STILL, RIGID)

    @property
    def casts(self) -> bool:
        """Whether it is drawn into shadow maps: not what is seen through, nor what turns to you."""
        return self.blend is None and self.deforms.sprite is None

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


FindImage = Callable[[str], str | None]
"""A name as scripts and levels write it to the path of the image, if there is one."""


def is_drawn(bsp: BspFile, shader: int, script: ShaderScript | None) -> bool:
    """Whether faces of a level's shader are seen: no sky, no tool surfaces, no dim mirrors."""
    if int(bsp.shaders["surface_flags"][shader]) & _HIDDEN:
        return False
    if script is None:
        return True
    if not script.stages or script.surfaceparms & {"sky", "nodraw", "hint", "skip"}:
        return False
    # Glass whose reflections are as bright as its place is lit: they would shine in the dark.
    shown = [stage for stage in script.stages if _has_image(stage)]
    is_glass = script.stages[0].blend is not None and bool(shown) and all(map(_reflects, shown))
    return not (is_glass and any(stage.image == "$lightmap" for stage in script.stages))


def from_script(name: str, script: ShaderScript | None, find_image: FindImage) -> Material:
    """The material that stands for a script, or for the plain image where there is none."""
    if script is None:
        return Material(name, find_image(name))
    stage = _base_stage(script)
    if stage is None:  # only lightmaps or plain white: the name may still be an image
        return Material(name, find_image(name), sides=script.cull)
    first = script.stages[0]
    alpha_test = first.alpha_test or stage.alpha_test
    # What is cut out stands for itself, whatever it is mixed with, unless it only brightens.
    is_blended = first.blend is not None and (alpha_test is None or first.blend == _BRIGHTENS)
    blend = (stage.blend or first.blend) if is_blended else None
    over = None if is_blended or alpha_test else _layer(script, stage)
    image, motion = _shown(stage, find_image, pulses=blend is not None)
    layer, layer_motion = (None, STILL) if over is None else _shown(over, find_image)
    over = None if layer is None else over
    return Material(
        name,
        image,
        sides=script.cull,
        alpha_test=alpha_test,
        blend=blend,
        shade=_shade(blend),
        clamps=stage.clamps,
        polygon_offset=script.is_polygonoffset,
        layer=layer,
        fades=over is not None and over.alpha_gen == "vertex",
        layer_alpha_test=None if over is None else over.alpha_test,
        mirrors=_reflects(stage),
        motion=motion,
        layer_motion=layer_motion,
        deforms=Deforms.of(script.deforms),
        color=None if layer else _linear(stage.color),
    )


def _linear(color: Color | None) -> Color | None:
    """A factor of what is displayed as one of linear light; none where it changes nothing."""
    if color is None or color == (1.0, 1.0, 1.0):
        return None
    red, green, blue = (channel**DISPLAY_GAMMA for channel in color)
    return red, green, blue


def _shown(
    stage: Stage, find_image: FindImage, *, pulses: bool = False
) -> tuple[str | None, Motion]:
    """A stage's (first) image, and what it does; nothing where there is none.

    Stages whose images follow each other pulse to fade into one another, two and two. One of the
    two is drawn: it stays as bright as both.
    """
    first, *others = stage.images
    image = find_image(first)
    if image is None:
        return None, STILL
    frames = image, *(find_image(name) or image for name in others)
    if len(frames) > 1 and stage.frame_rate != 0:
        return image, Motion(stage.tc_mods, frames, stage.frame_rate)
    waves = (stage.color_wave, stage.alpha_wave) if pulses else (None, None)
    return image, Motion(stage.tc_mods, (), 0.0, *waves)


def _base_stage(script: ShaderScript) -> Stage | None:
    """The stage whose image tells the surface's colour.

    Stages with a reflection's coordinates or that only add a glow come last; among the others the
    first one counts, which is the base in ``base, lightmap`` and in ``lightmap, base`` alike. But
    water whose first stage darkens the ground is seen by the ripples that another adds, and metal
    by the reflections that its image lies over as its alpha says.
    """
    candidates = [stage for stage in script.stages if _has_image(stage)]
    if script.stages and script.stages[0].blend is None and script.stages[0].alpha_test is None:
        for under, over in pairwise(candidates):
            if _reflects(under) and under.blend is None and _layer(script, under) is over:
                return under
    base = min(candidates, key=lambda stage: (_reflects(stage), _adds(stage)), default=None)
    if base is None or script.stages[0].alpha_test is not None:
        return base
    if base.blend in _MULTIPLIES and script.stages[0] is base:
        return next((s for s in candidates if _adds(s) and not _reflects(s)), base)
    return base


def _layer(script: ShaderScript, base: Stage) -> Stage | None:
    """The stage that lies over the base as its alpha, and perhaps its vertices', say."""
    for stage in script.stages[1:]:
        lies_over = stage.blend == _COVERS and stage.alpha_gen in ("", "identity", "vertex")
        if lies_over and stage is not base and _has_image(stage) and not _reflects(stage):
            return stage
    return None


def _has_image(stage: Stage) -> bool:
    return stage.image is not None and not stage.image.startswith(("$", "*"))


def _reflects(stage: Stage) -> bool:
    return stage.tc_gen[0].startswith("env")


def _adds(stage: Stage) -> bool:
    return stage.blend is not None and stage.blend[1] is BlendFactor.ONE


def _shade(blend: Blend | None) -> Shade:
    if blend in _MULTIPLIES:
        return Shade.FILTER
    if blend is not None and blend[1] in (BlendFactor.ONE, BlendFactor.ONE_MINUS_SRC_COLOR):
        return Shade.EMISSIVE
    return Shade.LIT
