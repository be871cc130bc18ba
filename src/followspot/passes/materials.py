"""How a material is told to GL: the shader variant that draws it and the state it needs."""

from typing import NamedTuple

import moderngl

from followspot.assets.shader_values import AlphaTest, BlendFactor, Sides
from followspot.gpu import gl, program
from followspot.scene.material import (
    ADDS_BY_ALPHA,
    BRIGHTENS,
    Blend,
    Laid,
    Layer,
    Material,
    Shade,
)
from followspot.scene.settings import CullFace


class LayerVariant(NamedTuple):
    """What of a material's layer is compiled into its program."""

    laid: Laid
    alpha_test: AlphaTest | None
    fades: bool
    tinted: bool
    colored: bool
    apart: bool
    moves: bool
    sways: bool
    mirrors: bool

    @property
    def defines(self) -> dict[str, int | str]:
        """Macros of surface.vert and surface.frag."""
        switches = {
            "FADES": self.fades,
            "LAYER_TINTED": self.tinted,
            "LAYER_COLORED": self.colored,
            "LAYER_APART": self.apart,
            "LAYER_MOVES": self.moves,
            "LAYER_SWAYS": self.sways,
            "LAYER_MIRRORS": self.mirrors,
        }
        macros = {"LAYERED": 1, f"LAID_{self.laid.name}": 1} | _macros(switches)
        if self.alpha_test is not None:
            macros["LAYER_TEST"] = "vec2({}, {})".format(*_ALPHA_TESTS[self.alpha_test])
        return macros


class Variant(NamedTuple):
    """What of a material is compiled into its program, apart from the view."""

    cut_out: bool
    shows_backs: bool
    blended: bool
    veils: bool
    brightens: bool
    weighted: bool
    shade: Shade
    tinted: bool
    smoothed: bool
    moves: bool
    sways: bool
    mirrors: bool
    pulses: bool
    displaced: bool
    swells: bool
    sprite: bool
    layer: LayerVariant | None

    @property
    def defines(self) -> dict[str, int | str]:
        """Macros of surface.vert and surface.frag."""
        switches = {
            "ALPHA_TEST": self.cut_out,
            "SHOWS_BACKS": self.shows_backs,
            "BLENDED": self.blended,
            "VEILS": self.veils,
            "BRIGHTENS": self.brightens,
            "WEIGHTED": self.weighted,
            "TINTED": self.tinted,
            "SMOOTHED": self.smoothed,
            "MOVES": self.moves,
            "SWAYS": self.sways,
            "MIRRORS": self.mirrors,
            "PULSES": self.pulses,
            "DISPLACED": self.displaced,
            "SWELLS": self.swells,
            "SPRITE": self.sprite,
        }
        macros = _macros(switches)
        if self.layer is not None:
            macros |= self.layer.defines
        if self.shade is not Shade.LIT:
            macros[self.shade.name] = 1
        return macros

    @property
    def without_grain(self) -> "Variant":
        """The one that leaves a layer out that only makes the base image rougher.

        One program then draws such materials and those without a layer, in fewer changes.
        """
        is_grain = self.layer is not None and self.layer.laid is Laid.GRAIN
        return self._replace(layer=None) if is_grain else self


def _macros(switches: dict[str, bool]) -> dict[str, int | str]:
    return {name: 1 for name, is_on in switches.items() if is_on}


def variant_of(material: Material, *, is_smoothed: bool) -> Variant:
    """The shader variant that draws a material.

    Args:
        material: What to draw.
        is_smoothed: Whether normals are far from those of many triangles; see `Mesh.is_smoothed`.
    """
    motion = material.motion
    is_sprite = material.deforms.sprite is not None
    has_own_shadow = material.sides is Sides.FRONT and material.blend is None and not is_sprite
    return Variant(
        material.alpha_test is not None,
        material.sides is not Sides.FRONT,
        material.blend is not None,
        veils(material),
        material.blend == BRIGHTENS,
        material.blend == ADDS_BY_ALPHA,
        material.shade,
        material.is_tinted,
        is_smoothed and has_own_shadow,
        bool(motion.tc_mods),
        motion.is_turbulent,
        material.mirrors,
        motion.pulses,
        bool(material.deforms.moves),
        material.deforms.swell is not None,
        is_sprite,
        None if material.layer is None else _layer_variant_of(material, material.layer),
    )


def _layer_variant_of(material: Material, layer: Layer) -> LayerVariant:
    motion = layer.motion
    tells_more = motion.tc_mods != material.motion.tc_mods or layer.mirrors != material.mirrors
    return LayerVariant(
        layer.laid,
        layer.alpha_test,
        layer.fades,
        layer.by_vertex is not None,
        layer.color is not None or motion.pulses,
        tells_more,
        tells_more and bool(motion.tc_mods),
        tells_more and motion.is_turbulent,
        layer.mirrors,
    )


def veils(material: Material) -> bool:
    """Whether light from behind is held back, or let through, by how much of it a surface reflects.

    The light that it sends is another matter: it may be a hundred times as bright as white.
    """
    if material.blend is None or material.shade is Shade.FILTER:
        return False
    return material.blend == _SCREEN or material.blend[1] in _BY_REFLECTANCE


def alpha_test_vector(material: Material) -> tuple[float, float]:
    """surface.frag's ``alpha_test``: texels with ``a * x + y > 0`` are kept."""
    slope, shift = _ALPHA_TESTS[material.alpha_test]
    return slope * material.alpha_scale, shift


def set_uniforms(of: moderngl.Program, material: Material) -> None:
    """Tell a program of surface.frag what it asks of a material beside its images and motion."""
    if material.alpha_test is not None:
        program.set_uniform(of, "alpha_test", alpha_test_vector(material))
    if material.blend is not None:
        program.set_uniform(of, "fog_cover", fog_cover(material.blend))


def fog_cover(blend: Blend) -> tuple[float, float, float]:
    """surface.frag's ``fog_cover`` of a way of blending.

    The light from behind has come through the fog before the surface, too, and has brought its
    glow along. Of that glow a blended surface adds what it has held back: a share of its own,
    one by its reflectance and one by its alpha, all before GL weights them by the source's factor.
    Of what only multiplies, the first number is the one that leaves all as it is.
    """
    source, destination = blend
    if blend == _SCREEN:
        return _HELD_BACK[BlendFactor.ONE_MINUS_SRC_COLOR]
    if source is BlendFactor.DST_COLOR:
        neutral = {BlendFactor.ZERO: 1.0, BlendFactor.SRC_COLOR: 0.5}.get(destination, 0.0)
        return neutral, 0.0, 0.0
    if blend == (BlendFactor.ZERO, BlendFactor.SRC_COLOR):
        return 1.0, 0.0, 0.0
    if source is BlendFactor.SRC_ALPHA:
        return float(destination is BlendFactor.ONE_MINUS_SRC_ALPHA), 0.0, 0.0
    if source is not BlendFactor.ONE:
        return 0.0, 0.0, 0.0
    return _HELD_BACK.get(destination, (0.0, 0.0, 0.0))


def set_state(context: moderngl.Context, material: Material) -> None:
    """Set what GL needs to know of a material's state, but for tests and writes of depth."""
    if material.sides is Sides.BOTH:
        context.disable(moderngl.CULL_FACE)
    else:
        context.enable(moderngl.CULL_FACE)
        context.cull_face = _CULLED_SIDE[material.sides]
    # No part of it by the slope: seen edge-on, a decal would come through whatever is before it.
    context.polygon_offset = (0.0, -2.0) if material.polygon_offset else (0.0, 0.0)
    if material.blend is not None:
        source, destination = material.blend
        behind = _FACTORS[destination]
        if veils(material):
            if material.blend == _SCREEN:  # s (1 - d) + d = s + d (1 - s)
                source, destination = BlendFactor.ONE, BlendFactor.ONE_MINUS_SRC_COLOR
            behind = _BY_REFLECTANCE[destination]
        if material.blend == ADDS_BY_ALPHA:
            source = BlendFactor.ONE  # the shader weights by alpha: a layer's glow is not weighted
        # Alpha stays: it says whether there is a surface.
        factors = _FACTORS[source], behind, moderngl.ZERO, moderngl.ONE
        context.blend_func = factors  # type: ignore[assignment]  # four are taken, too


def set_caster_culling(context: moderngl.Context, material: Material, cull: CullFace) -> None:
    """Leave out the faces of a caster that a shadow map is to lack; none of two-sided ones."""
    if cull is CullFace.NONE or material.is_two_sided:
        context.disable(moderngl.CULL_FACE)
    else:
        context.enable(moderngl.CULL_FACE)
        context.cull_face = cull.value


_HALF = 128 / 255  # the game compares bytes with 128
_ALPHA_TESTS = {
    AlphaTest.GT0: (1.0, 0.0),
    AlphaTest.LT128: (-1.0, _HALF - 1e-4),
    AlphaTest.GE128: (1.0, 1e-4 - _HALF),
    None: (0.0, 1.0),
}
_CULLED_SIDE = {Sides.FRONT: "back", Sides.BACK: "front"}
_HELD_BACK = {
    BlendFactor.ZERO: (1.0, 0.0, 0.0),
    BlendFactor.SRC_COLOR: (1.0, -1.0, 0.0),
    BlendFactor.ONE_MINUS_SRC_COLOR: (0.0, 1.0, 0.0),
    BlendFactor.SRC_ALPHA: (1.0, 0.0, -1.0),
    BlendFactor.ONE_MINUS_SRC_ALPHA: (0.0, 0.0, 1.0),
}
_SCREEN = (BlendFactor.ONE_MINUS_DST_COLOR, BlendFactor.ONE)
_BY_REFLECTANCE = {
    BlendFactor.SRC_COLOR: gl.SRC1_COLOR,
    BlendFactor.ONE_MINUS_SRC_COLOR: gl.ONE_MINUS_SRC1_COLOR,
}
_FACTORS = {
    BlendFactor.ZERO: moderngl.ZERO,
    BlendFactor.ONE: moderngl.ONE,
    BlendFactor.SRC_COLOR: moderngl.SRC_COLOR,
    BlendFactor.ONE_MINUS_SRC_COLOR: moderngl.ONE_MINUS_SRC_COLOR,
    BlendFactor.DST_COLOR: moderngl.DST_COLOR,
    BlendFactor.ONE_MINUS_DST_COLOR: moderngl.ONE_MINUS_DST_COLOR,
    BlendFactor.SRC_ALPHA: moderngl.SRC_ALPHA,
    BlendFactor.ONE_MINUS_SRC_ALPHA: moderngl.ONE_MINUS_SRC_ALPHA,
    BlendFactor.DST_ALPHA: moderngl.DST_ALPHA,
    BlendFactor.ONE_MINUS_DST_ALPHA: moderngl.ONE_MINUS_DST_ALPHA,
    BlendFactor.SRC_ALPHA_SATURATE: gl.SRC_ALPHA_SATURATE,
}
