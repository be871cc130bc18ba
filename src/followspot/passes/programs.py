"""The programs of surface.vert and surface.frag, with the vertex arrays that go with them.

A program is compiled for each view, variant of material, number of lights and sky, so that no
pixel pays for a choice that is the same in the whole frame.
"""

from collections.abc import Callable, Iterable, Mapping

import moderngl

from followspot.gpu import program
from followspot.passes.materials import Variant
from followspot.passes.view import SURFACE_VIEWS, View

BASE_IMAGE, SHADOW_ATLAS, KEY_POSES = 0, 1, 2
"""Texture units."""

MAX_PROGRAMS = 128
"""Programs kept for views and settings that come back; more than one frame needs at once."""

_VIEWS: dict[str, int | str] = {f"VIEW_{v.name}": n for n, v in enumerate(SURFACE_VIEWS)}
_SAMPLERS = {"base_image": BASE_IMAGE, "shadow_atlas": SHADOW_ATLAS, "key_poses": KEY_POSES}

Arrays = list[moderngl.VertexArray]


class SurfacePrograms:
    """Programs for the views that have been asked for, for what one pass draws.

    Args:
        context: Where they live.
        variants: Of the materials that are drawn.
        make_arrays: A program to the vertex arrays that are drawn with it.
        defines: Macros that all of them have.

    Attributes:
        arrays: By variant, those of the frames that have been prepared.
    """

    def __init__(
        self,
        context: moderngl.Context,
        variants: Iterable[Variant],
        make_arrays: Callable[[moderngl.Program], Arrays],
        defines: Mapping[str, int | str] | None = None,
    ) -> None:
        self._context = context
        self._variants = set(variants)
        self._make_arrays = make_arrays
        self._defines = dict(defines or {})
        self._made: dict[object, tuple[moderngl.Program, Arrays]] = {}
        self._common: dict[str, int | str] = {}
        self.arrays: dict[Variant, Arrays] = {}

    def prepare(
        self, view: View, lights: int, shadows: int, constants: dict[str, int | str]
    ) -> None:
        """Choose the programs for the next frames, compiling what is new. Not inside a frame.

        Args:
            view: The stage that is written.
            lights: How many there are.
            shadows: How many of them have a shadow map; they come first.
            constants: Macros of surface.frag; see `lighting.constants`.
        """
        common = {
            **_VIEWS,
            **constants,
            "VIEW": f"VIEW_{view.name}",
            "LIGHTS": lights,
            "SHADOWS": shadows,
        }
        if common == self._common:
            return
        self._common = common
        for variant in self._variants:
            key = (*common.items(), variant)
            made = self._made.pop(key, None) or self._make(common | variant.defines)
            self._made[key] = made  # the last one used is the last
            self.arrays[variant] = made[1]
        while len(self._made) > MAX_PROGRAMS:
            _drop(*self._made.pop(next(iter(self._made))))

    def _make(self, defines: dict[str, int | str]) -> tuple[moderngl.Program, Arrays]:
        surface = program.build(self._context, "surface", defines | self._defines)
        for name, unit in _SAMPLERS.items():
            if name in surface:
                program.uniform(surface, name).value = unit
        return surface, self._make_arrays(surface)

    def release(self) -> None:
        """Give the GL objects back."""
        for made in self._made.values():
            _drop(*made)


def _drop(surface: moderngl.Program, arrays: Arrays) -> None:
    for array in arrays:
        array.release()
    surface.release()
