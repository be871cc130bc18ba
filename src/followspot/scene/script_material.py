"""Materials out of Quake's shader scripts.

A script is a program of stages for the game's own renderer, which has lightmaps and vertex
colours. Here light comes from lights, so of the stages one is chosen: the image that tells the
surface's colour; and perhaps another one, which is laid on it.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import pairwise

from followspot.assets.bsp import BspFile
from followspot.assets.shader_script import ShaderScript, Stage
from followspot.assets.shader_values import BlendFactor
from followspot.assets.surface_flags import Surface
from followspot.scene.deform import Deforms
from followspot.scene.material import (
    ADDS_BY_ALPHA,
    BRIGHTENS,
    Blend,
    ByVertex,
    Color,
    Laid,
    Layer,
    Material,
    Shade,
)
from followspot.scene.motion import DISPLAY_GAMMA, STILL, Motion

FindImage = Callable[[str], str | None]
"""A name as scripts and levels write it to the path of the image, if there is one."""

_HIDDEN = Surface.SKY | Surface.NODRAW | Surface.HINT | Surface.SKIP

_LIGHTMAP = "$lightmap"
_BY_VERTEX = {
    "vertex": ByVertex.BRIGHTENS,
    "exactvertex": ByVertex.BRIGHTENS,
    "oneminusvertex": ByVertex.DIMS,
}
_LIT_GENS = {*_BY_VERTEX, "lightingdiffuse"}

_COVERS = (BlendFactor.SRC_ALPHA, BlendFactor.ONE_MINUS_SRC_ALPHA)
_ADDS = (BlendFactor.ONE, BlendFactor.ONE)
_DOUBLES = (BlendFactor.DST_COLOR, BlendFactor.SRC_COLOR)
_COLORS = {
    (BlendFactor.DST_COLOR, BlendFactor.ZERO),
    (BlendFactor.ZERO, BlendFactor.SRC_COLOR),
}
_MULTIPLIES = {
    *_COLORS,
    BRIGHTENS,
    _DOUBLES,
    (BlendFactor.ZERO, BlendFactor.ONE_MINUS_SRC_COLOR),
    (BlendFactor.DST_COLOR, BlendFactor.ONE_MINUS_DST_ALPHA),
}


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
    return not (is_glass and any(stage.image == _LIGHTMAP for stage in script.stages))


def from_script(name: str, script: ShaderScript | None, find_image: FindImage) -> Material:
    """The material that stands for a script, or for the plain image where there is none."""
    if script is None:
        return Material(name, find_image(name))
    script = _from_last_opaque(script)
    stage = _base_stage(script)
    if stage is None:  # only lightmaps or plain white: the name may still be an image
        return Material(name, find_image(name), sides=script.cull)
    first = script.stages[0]
    alpha_test = first.alpha_test or stage.alpha_test
    # What is cut out stands for itself, whatever it is mixed with, unless it dims or brightens.
    is_solid = any(each.image == _LIGHTMAP and each.blend is None for each in script.stages)
    changes = first.blend == BRIGHTENS or (first.blend in _MULTIPLIES and not is_solid)
    is_blended = first.blend is not None and (alpha_test is None or changes)
    blend = (stage.blend or first.blend) if is_blended else None
    shade = _shade(blend)
    shines = blend is None or _is_flame(script, blend)
    if shines and not _reflects(stage) and not _is_lit(script):
        shade = Shade.EMISSIVE
    image, motion = _shown(stage, find_image, pulses=shade is Shade.EMISSIVE or blend is not None)
    layer = None if alpha_test else _layer(script, stage, blend, find_image)
    return Material(
        name,
        image,
        sides=script.cull,
        alpha_test=alpha_test,
        blend=blend,
        shade=shade,
        clamps=stage.clamps,
        polygon_offset=script.is_polygonoffset,
        layer=layer,
        mirrors=_reflects(stage),
        motion=motion,
        deforms=Deforms.of(script.deforms),
        color=None if layer and layer.reads_tints else _linear(stage.color),
    )


def _from_last_opaque(script: ShaderScript) -> ShaderScript:
    """Without the stages that a later one paints over; a reflection counts as laid on them."""
    opaque = [
        number
        for number, stage in enumerate(script.stages)
        if stage.blend is None and stage.alpha_test is None
        if _has_image(stage) and not _reflects(stage)
    ]
    return replace(script, stages=script.stages[opaque[-1] :]) if opaque[1:] else script


def _linear(color: Color | None) -> Color | None:
    """A factor of what is displayed as one of linear light; none where it changes nothing."""
    if color is None or color == (1.0, 1.0, 1.0):
        return None
    red, green, blue = (channel**DISPLAY_GAMMA for channel in color)
    return red, green, blue


def _is_alike(stage: Stage, other: Stage) -> bool:
    """Whether two look the same, but for how they move."""
    looks = "image", "blend", "color", "color_wave"
    return all(getattr(stage, name) == getattr(other, name) for name in looks)


def _times(count: int, color: Color | None) -> Color | None:
    """A linear factor of what is displayed so many times."""
    if count == 1:
        return color
    red, green, blue = (channel * count**DISPLAY_GAMMA for channel in color or (1.0, 1.0, 1.0))
    return red, green, blue


def _shown(stage: Stage, find_image: FindImage, *, pulses: bool) -> tuple[str | None, Motion]:
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

    Stages with a reflection's coordinates or that only add a glow come last, after those that only
    make it rougher; among the others the first one counts, which is the base in ``base, lightmap``
    and in ``lightmap, base`` alike. But water whose first stage darkens the ground is seen by the
    ripples that another adds, and metal by the reflections that its image lies over as its alpha
    says.
    """
    candidates = [stage for stage in script.stages if _has_image(stage)]
    if script.stages and script.stages[0].blend is None and script.stages[0].alpha_test is None:
        for under, over in pairwise(candidates):
            if _reflects(under) and under.blend is None and _lies_over(over):
                return under

    def rank(stage: Stage) -> tuple[bool, ...]:
        return _reflects(stage), _adds(stage), stage.blend == _DOUBLES

    base = min(candidates, key=rank, default=None)
    if base is None or script.stages[0].alpha_test is not None:
        return base
    if base.blend in _MULTIPLIES and script.stages[0] is base:
        return next((s for s in candidates if _adds(s) and not _reflects(s)), base)
    return base


def _layer(
    script: ShaderScript, base: Stage, blend: Blend | None, find_image: FindImage
) -> Layer | None:
    """What is laid on the base image, if anything is; of several that which is seen most of."""
    if blend is not None:
        second = _second(script, base, blend)
        if second is None:
            return None
        found = second, Laid.FILTER if blend == BRIGHTENS else Laid.GLOW
    else:
        laid = {how: stage for stage, how in reversed([*_laid(script, base)])}
        kind = next((how for how in Laid if how in laid), None)
        if kind is None:
            return None
        found = laid[kind], kind
    stage, how = found
    image, motion = _shown(stage, find_image, pulses=how in (Laid.GLOW, Laid.SHEEN))
    if image is None:
        return None
    color = None if how is Laid.OVER else _linear(stage.color)
    if how is Laid.GLOW:
        color = _times(
            sum(_is_alike(each, stage) for each in script.stages if each is not base), color
        )
    return Layer(
        image,
        how,
        clamps=stage.clamps,
        alpha_test=stage.alpha_test if how is Laid.OVER else None,
        fades=how is Laid.OVER and stage.alpha_gen == "vertex",
        by_vertex=_BY_VERTEX.get(stage.rgb_gen) if how is Laid.SHEEN else None,
        mirrors=_reflects(stage),
        motion=motion,
        color=color,
    )


def _second(script: ShaderScript, base: Stage, blend: Blend) -> Stage | None:
    """What adds or brightens besides a blended base: the sum, or product, can as well be drawn."""
    adds = blend[0] is BlendFactor.ONE or blend == ADDS_BY_ALPHA
    for stage in script.stages if adds or blend == BRIGHTENS else ():
        is_alike = stage.blend == (_ADDS if adds else BRIGHTENS) and stage is not base
        fades = base.frame_rate and stage.frame_rate  # the two into one another
        if is_alike and _has_image(stage) and not _reflects(stage) and not fades:
            return stage
    return None


def _laid(script: ShaderScript, base: Stage) -> Iterator[tuple[Stage, Laid]]:
    """The other stages of an opaque surface, each with what it does to the base."""
    lit = max((n for n, s in enumerate(script.stages) if s.image == _LIGHTMAP), default=-1)
    under: Stage | None = None
    for number, stage in enumerate(script.stages):
        before, under = under, stage
        if stage is base or not _has_image(stage):
            continue
        follows = script.stages[number + 1] if number + 1 < len(script.stages) else None
        if _reflects(stage):
            # A reflection, and the image added to it, is the image with the reflection added.
            is_below = stage.blend is None and follows is not None and follows.blend == _ADDS
            if is_below or stage.blend == _ADDS:
                yield stage, Laid.SHEEN
        elif number > 0 and _lies_over(stage):
            yield stage, Laid.OVER
        elif stage.blend == _ADDS and not (before and before.blend is None and _reflects(before)):
            yield stage, Laid.GLOW if number > lit else Laid.SHEEN
        elif number > 0 and stage.blend in _COLORS:
            yield stage, Laid.FILTER
        elif number > 0 and stage.blend == _DOUBLES:
            yield stage, Laid.GRAIN


def _lies_over(stage: Stage) -> bool:
    """Whether it covers what is below as its alpha, and perhaps its vertices', say."""
    is_plain = stage.alpha_gen in ("", "identity", "vertex") and not _reflects(stage)
    return stage.blend == _COVERS and is_plain and _has_image(stage)


def _is_lit(script: ShaderScript) -> bool:
    """Whether the game lights anything of it; else it is as bright everywhere."""
    return any(s.image == _LIGHTMAP or s.rgb_gen in _LIT_GENS for s in script.stages)


def _is_flame(script: ShaderScript, blend: Blend) -> bool:
    """Whether it covers what is behind and is in no lightmap: flames, smoke, signs; not water."""
    parms = script.surfaceparms
    return blend == _COVERS and "nolightmap" in parms and "water" not in parms


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
