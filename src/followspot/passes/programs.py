"""Programs with the vertex arrays that go with them, compiled anew when their files change.

A program of surface.vert and surface.frag is compiled for each view, kind of target, variant of
material, number of lights and sky, so that no pixel pays for a choice that is the same in the whole
frame.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import product

import moderngl

from followspot.gpu import program
from followspot.gpu.program import ShaderError, ShaderFolder
from followspot.passes.materials import Variant
from followspot.passes.view import SURFACE_VIEWS, View
from followspot.scene.clouds import MAX_LAYERS

BASE_IMAGE, SHADOW_ATLAS, KEY_POSES, LAYER_IMAGE, LIGHTMAPS, CLOUDS = 0, 1, 2, 3, 4, 5
"""Texture units; of clouds the first one."""

MAX_PROGRAMS = 128
"""Programs kept for views and settings that come back; more than one frame needs at once."""

_VIEWS: dict[str, int | str] = {f"VIEW_{v.name}": n for n, v in enumerate(SURFACE_VIEWS)}
_SAMPLERS = {
    "base_image": BASE_IMAGE,
    "layer_image": LAYER_IMAGE,
    "kept": BASE_IMAGE,
    "shadow_atlas": SHADOW_ATLAS,
    "key_poses": KEY_POSES,
    "lightmaps": LIGHTMAPS,
} | {f"cloud_{n}": CLOUDS + n for n in range(MAX_LAYERS)}

Arrays = list[moderngl.VertexArray]
MakeArrays = Callable[[moderngl.Program], Arrays]
Compiled = tuple[moderngl.Program, Arrays]


class Shader:
    """A program and its vertex arrays.

    Args:
        context: Where they live.
        folder: Has the files.
        name: Of ``name.vert`` and ``name.frag``.
        make_arrays: A program to the vertex arrays that are drawn with it.
        defines: Macros.
        vertex: Takes the vertex shader from another pair of files.

    Attributes:
        program: The one that compiled last.
        arrays: Those that go with it.

    Raises:
        ShaderError: it does not compile.
    """

    def __init__(
        self,
        context: moderngl.Context,
        folder: ShaderFolder,
        name: str,
        make_arrays: MakeArrays,
        defines: Mapping[str, int | str] | None = None,
        vertex: str | None = None,
    ) -> None:
        self._context = context
        self._name, self._vertex = name, vertex
        self._defines = dict(defines or {})
        self._make_arrays = make_arrays
        self.program, self.arrays = self.compiled(folder.texts)

    def compiled(self, texts: Mapping[str, str]) -> Compiled:
        """The same from other texts of the files, for `use` or `drop`.

        Raises:
            ShaderError: it does not compile.
        """
        made = program.build(self._context, self._name, self._defines, texts, self._vertex)
        for name, unit in _SAMPLERS.items():
            program.set_uniform(made, name, unit)
        return made, self._make_arrays(made)

    def use(self, compiled: Compiled) -> None:
        """Draw with this from now on."""
        self.release()
        self.program, self.arrays = compiled

    def release(self) -> None:
        """Give the GL objects back."""
        drop((self.program, self.arrays))


def over_picture(
    context: moderngl.Context,
    folder: ShaderFolder,
    name: str,
    defines: Mapping[str, int | str] | None = None,
    vertex: str = "whole",
) -> Shader:
    """A fragment shader for the whole picture: its array is one triangle, made by `vertex` alone.

    Draw it by ``arrays[0].render(vertices=3)``.
    """
    return Shader(
        context,
        folder,
        name,
        lambda triangle: [context.vertex_array(triangle, [])],
        defines,
        vertex,
    )


def drop(compiled: Compiled) -> None:
    """Give the GL objects of what `Shader.compiled` returned back."""
    for array in compiled[1]:
        array.release()
    compiled[0].release()


def reload(folder: ShaderFolder, shaders: Iterable[Shader]) -> ShaderError | None:
    """Compile shaders from their files as they are now: all of them, or none where one fails.

    Returns:
        What is wrong; then everything is as it was before.
    """
    made: list[tuple[Shader, Compiled]] = []
    try:
        texts = folder.read()
        for shader in shaders:
            made.append((shader, shader.compiled(texts)))
    except ShaderError as error:
        for _, compiled in made:
            drop(compiled)
        return error
    for shader, compiled in made:
        shader.use(compiled)
    folder.texts = texts
    return None


class SurfacePrograms:
    """Shaders for the views that have been asked for, for what one pass draws.

    Args:
        context: Where they live.
        folder: Has the files.
        variants: Of the materials that are drawn.
        make_arrays: A program to the vertex arrays that are drawn with it.
        defines: Macros that all of them have.

    Attributes:
        chosen: By number of volumes of fog and variant, those of the frames that are prepared.
    """

    def __init__(
        self,
        context: moderngl.Context,
        folder: ShaderFolder,
        variants: Iterable[Variant],
        make_arrays: MakeArrays,
        defines: Mapping[str, int | str] | None = None,
    ) -> None:
        self._context = context
        self._folder = folder
        self._variants = set(variants)
        self._make_arrays = make_arrays
        self._defines = dict(defines or {})
        self._made: dict[object, Shader] = {}
        self._wanted: object = None
        self.chosen: dict[int, dict[Variant, Shader]] = {}

    @property
    def shaders(self) -> list[Shader]:
        """All that have been compiled and kept."""
        return list(self._made.values())

    def prepare(
        self,
        view: View,
        macros: Mapping[str, int | str],
        fogs: Sequence[int],
        *,
        encoded: bool,
        has_grain: bool,
    ) -> None:
        """Choose the shaders for the next frames, compiling what is new. Not inside a frame.

        Args:
            view: The stage that is written.
            macros: Of surface.frag; see `lighting.constants` and `lighting.counts`.
            fogs: Numbers of volumes of fog that surfaces are drawn through.
            encoded: Whether the picture is sRGB; what is not blended writes that itself.
            has_grain: Whether layers are drawn that only make the base image rougher.

        Raises:
            ShaderError: a new one does not compile; those chosen before stay.
        """
        wanted = view, encoded, has_grain, macros, fogs
        if wanted == self._wanted:
            return
        common: dict[str, int | str] = {**_VIEWS, **macros, "VIEW": f"VIEW_{view.name}"}
        if encoded:
            common["ENCODED"] = 1
        chosen: dict[int, dict[Variant, Shader]] = {count: {} for count in fogs}
        for count, variant in product(chosen, self._variants):
            drawn = variant if has_grain else variant.without_grain
            macros_here = common | {"FOGS": count}
            key = (*macros_here.items(), drawn)
            if key not in self._made:
                defines = macros_here | drawn.defines | self._defines
                self._made[key] = Shader(
                    self._context, self._folder, "surface", self._make_arrays, defines
                )
            # The last used is the last.
            chosen[count][variant] = self._made[key] = self._made.pop(key)
        self._wanted, self.chosen = wanted, chosen
        most = max(MAX_PROGRAMS, len(chosen) * len(self._variants))  # all of those are in use
        while len(self._made) > most:
            self._made.pop(next(iter(self._made))).release()

    def release(self) -> None:
        """Give the GL objects back."""
        for shader in self._made.values():
            shader.release()
