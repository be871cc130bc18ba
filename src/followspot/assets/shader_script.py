"""Entries of Quake 3's .shader scripts as records: how a surface is drawn, told in words.

An entry is a name, general directives, and stages, which are the layers that are drawn one
upon the other. Records keep every directive as written, with its line; what its arguments
mean is worked out only when a property asks, by the readers in `shader_values`. `shader_parser`
makes the records. Their semantics are those of ioquake3's ``code/renderergl1/tr_shader.c``.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from followspot.assets.shader_deform import DEFORM_READERS, Deform, read_deform
from followspot.assets.shader_motion import (
    MAX_TC_MODS,
    MOTION_READERS,
    TcMod,
    Wave,
    read_alpha_wave,
    read_color,
    read_color_wave,
    read_frame_rate,
    read_tc_mod,
)
from followspot.assets.shader_values import (
    GENERAL_READERS,
    STAGE_READERS,
    AlphaTest,
    BlendFactor,
    Directive,
    FogParms,
    Reader,
    Sides,
    SkyParms,
    Sun,
    read_alpha_test,
    read_blend,
    read_cull,
    read_fog_parms,
    read_images,
    read_sky_parms,
    read_sun,
    read_tc_gen,
)
from followspot.errors import AssetError

MAX_QUOTED = 100
"""Characters of a script that a problem repeats, so that it stays one readable line."""


@dataclass(frozen=True, slots=True)
class Stage:
    """One layer of a surface.

    Args:
        directives: In the order of the file.
        line: Line of the opening brace.
    """

    directives: tuple[Directive, ...]
    line: int

    def get(self, *names: str) -> Directive | None:
        """Find the last directive with one of these (lower-case) names, or None.

        The last wins, as each directive sets one variable of the engine's.
        """
        return _last(self.directives, names)

    @property
    def image(self) -> str | None:
        """The image, of an ``animMap`` the first; None for a stage without (``videoMap``)."""
        return next(iter(self.images), None)

    @property
    def images(self) -> tuple[str, ...]:
        """The image names of the last ``map``, ``clampMap`` or ``animMap``; see `read_images`."""
        image = self.get("map", "clampmap", "animmap")
        return read_images(image, []) if image else ()

    @property
    def frame_rate(self) -> float:
        """How many of the images are shown in a second, one after the other."""
        image = self.get("map", "clampmap", "animmap")
        is_animated = image is not None and image.name == "animmap"
        return read_frame_rate(image, []) if is_animated and image else 0.0

    @property
    def clamps(self) -> bool:
        """Whether the image's edge goes on for ever (``clampMap``), instead of its repeating."""
        image = self.get("map", "clampmap", "animmap")
        return image is not None and image.name == "clampmap"

    @property
    def blend(self) -> tuple[BlendFactor, BlendFactor] | None:
        """Source and target factor, or None for a stage that covers what is below it.

        ``GL_ONE GL_ZERO`` covers, so the engine takes it as no blending at all.
        """
        blend = self.get("blendfunc")
        factors = read_blend(blend, []) if blend else None
        return None if factors == (BlendFactor.ONE, BlendFactor.ZERO) else factors

    @property
    def alpha_test(self) -> AlphaTest | None:
        """Which texels are drawn; None for all."""
        test = self.get("alphafunc")
        return read_alpha_test(test, []) if test else None

    @property
    def alpha_gen(self) -> str:
        """Where alpha comes from beside the image, in lower case; empty where nowhere else."""
        alpha_gen = self.get("alphagen")
        return alpha_gen.word if alpha_gen else ""

    @property
    def tc_gen(self) -> tuple[str, ...]:
        """Where texture coordinates come from, with its arguments, in lower case.

        Without (a known) ``tcGen`` it is ``lightmap`` for the image ``$lightmap``, else
        ``texture``. ``texGen`` is the same directive.
        """
        tc_gen = self.get("tcgen", "texgen")
        words = read_tc_gen(tc_gen, []) if tc_gen else ()
        return words or (("lightmap",) if self.image == "$lightmap" else ("texture",))

    @property
    def tc_mods(self) -> tuple[TcMod, ...]:
        """What moves the texture coordinates, in this order; what moves nothing is left out."""
        mods = [item for item in self.directives if item.name == "tcmod"][:MAX_TC_MODS]
        return tuple(mod for mod in (read_tc_mod(each, []) for each in mods) if mod is not None)

    @property
    def rgb_gen(self) -> str:
        """What colours are multiplied by, in lower case; empty where the script does not say."""
        rgb_gen = self.get("rgbgen")
        return rgb_gen.word if rgb_gen else ""

    @property
    def color_wave(self) -> Wave | None:
        """What colours are multiplied by, if that changes with time."""
        rgb_gen = self.get("rgbgen")
        return read_color_wave(rgb_gen, []) if rgb_gen else None

    @property
    def color(self) -> tuple[float, float, float] | None:
        """What colours are multiplied by as displayed, if that is always the same."""
        rgb_gen = self.get("rgbgen")
        return read_color(rgb_gen, []) if rgb_gen else None

    @property
    def alpha_wave(self) -> Wave | None:
        """What alpha is multiplied by, likewise."""
        alpha_gen = self.get("alphagen")
        return read_alpha_wave(alpha_gen, []) if alpha_gen else None


@dataclass(frozen=True, slots=True)
class ShaderScript:
    """One entry of a script.

    Args:
        name: Lower case, with forward slashes; see `lookup_name`.
        source: The file.
        line: Line of the name.
        directives: The general ones (outside stages), in the order of the file.
        stages: In the order of drawing.
    """

    name: str
    source: str
    line: int
    directives: tuple[Directive, ...]
    stages: tuple[Stage, ...]

    def get(self, *names: str) -> Directive | None:
        """Find the last general directive with one of these (lower-case) names, or None."""
        return _last(self.directives, names)

    def all(self, *names: str) -> tuple[Directive, ...]:
        """List the general directives with one of these (lower-case) names, in file order."""
        return tuple(item for item in self.directives if item.name in names)

    @property
    def problems(self) -> tuple[AssetError, ...]:
        """Directives whose arguments the engine does not know; the properties replace them."""
        problems = _wrong_arguments(self.directives, GENERAL_READERS | DEFORM_READERS, self.source)
        for stage in self.stages:
            problems += _wrong_arguments(
                stage.directives, STAGE_READERS | MOTION_READERS, self.source
            )
        return tuple(problems)

    @property
    def surfaceparms(self) -> frozenset[str]:
        """What ``surfaceparm`` says of the surface's nature, in lower case; they add up."""
        return frozenset(parm.word for parm in self.all("surfaceparm") if parm.args)

    @property
    def cull(self) -> Sides:
        """The sides that are drawn; the front unless the script says otherwise."""
        cull = self.get("cull")
        return read_cull(cull, []) if cull else Sides.FRONT

    @property
    def sky_box(self) -> SkyParms | None:
        """The sky's boxes and cloud height; None for what the engine does not draw as sky."""
        sky = self.get("skyparms")
        return read_sky_parms(sky, []) if sky else None

    @property
    def sun(self) -> Sun | None:
        """The last sun of the entry, as in the engine; q3map2 bakes the light of all of them."""
        sun = self.get("q3map_sun", "q3map_sunext", "sun")
        return read_sun(sun, []) if sun else None

    @property
    def fog(self) -> FogParms | None:
        """What fills the volume whose brush has this entry's name, if it is fog."""
        fog = self.get("fogparms")
        return read_fog_parms(fog, []) if fog else None

    @property
    def deforms(self) -> tuple[Deform, ...]:
        """How vertices move."""
        read = (read_deform(each, []) for each in self.all("deformvertexes"))
        return tuple(deform for deform in read if deform is not None)

    @property
    def is_polygonoffset(self) -> bool:
        """Whether the surface is drawn a little nearer, to win over one in the same plane."""
        return self.get("polygonoffset") is not None


def lookup_name(name: str) -> str:
    """Make the name under which the engine looks for a surface's entry.

    Case and slash direction do not matter, and whatever follows the last dot of the last
    part is taken off (``COM_StripExtension`` in ioquake3's ``code/qcommon/q_shared.c``). The
    names of entries keep theirs: an entry ``foo.tga`` is never found, in the game or here.
    """
    folder, slash, last = normalised_name(name).rpartition("/")
    stem, dot, _ = last.rpartition(".")
    return folder + slash + (stem if dot else last)


def normalised_name(name: str) -> str:
    """Put a name in lower case with forward slashes, as `ShaderScript.name` holds it."""
    return name.lower().replace("\\", "/")


def _last(directives: Sequence[Directive], names: Sequence[str]) -> Directive | None:
    return next((item for item in reversed(directives) if item.name in names), None)


def _wrong_arguments(
    directives: Sequence[Directive], readers: dict[str, Reader], source: str
) -> list[AssetError]:
    problems = []
    for directive in directives:
        if reader := readers.get(directive.name):
            wrong: list[str] = []
            reader(directive, wrong)
            problems += [
                AssetError(
                    source,
                    place=f"line {directive.line}",
                    expected=f"{expected} after {directive.name}",
                    found=repr(str(directive))[:MAX_QUOTED],
                )
                for expected in wrong
            ]
    return problems
