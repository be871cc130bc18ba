"""Materials: what a surface is called, how large its texture is and what the engine shall know."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from followspot.assets.bsp import LUMPS
from followspot.assets.shader_parser import find_entries
from followspot.assets.shader_script import ShaderScript
from followspot.assets.surface_flags import Contents, Surface
from followspot.errors import UsageError

PLAIN = Surface(0)
"""No flags: an ordinary wall."""

_LONGEST_NAME = LUMPS["shaders"]["name"].itemsize - 1  # a NUL ends it


@dataclass(frozen=True)
class Material:
    """One entry of the shader lump, and the shader script that goes with it.

    Raises:
        UsageError: The name is too long for the file, or the script is none that the engine knows.

    Attributes:
        name: Shader name, as ``textures/yard/brick``; also the image path without a script.
        size: Texture width and height that ``units_per_texel`` counts, in texels.
        units_per_texel: World units that one texel covers under world-aligned projection.
        surface: Surface flags.
        contents: Content flags of brushes and patches made of it.
        opacity: Share of light that it stops, 0 to 1. Only at 1 does a brush hide what it covers.
        script: Body of the shader script entry between its braces, without ``surfaceparm``
            lines; empty where the image alone will do.
        image: The texture, (height, width, 3 or 4) uint8 sRGB, where the image has its name.
    """

    name: str
    size: tuple[int, int] = (256, 256)
    units_per_texel: float = 0.5
    surface: Surface = PLAIN
    contents: Contents = Contents.SOLID
    opacity: float = 1.0
    script: str = ""
    image: NDArray[np.uint8] | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if not self.name.isascii() or len(self.name) > _LONGEST_NAME:
            raise UsageError(
                f"a material's name has at most {_LONGEST_NAME} ASCII characters: {self.name!r}"
            )
        entries, problems = find_entries(self.script_entry(), self.name)
        problems += [problem for entry in entries for problem in entry.read().problems]
        if problems:
            raise UsageError(str(problems[0]))

    @property
    def shader(self) -> ShaderScript:
        """The shader script entry as the renderer reads it."""
        return find_entries(self.script_entry(), self.name)[0][0].read()

    @property
    def drawn(self) -> bool:
        """Whether faces of it are written at all."""
        return not self.surface & Surface.NODRAW

    @property
    def lightmapped(self) -> bool:
        """Whether its polygons and patches carry a lightmap."""
        return self.drawn and not self.surface & (Surface.NOLIGHTMAP | Surface.SKY)

    def script_entry(self) -> str:
        """Return the shader script entry: name, flags as ``surfaceparm`` words, then the body."""
        words = [str(flag.name).lower() for flag in Surface if self.surface & flag]
        words += ["trans"] if self.contents & Contents.TRANSLUCENT else []
        words += ["water"] if self.contents & Contents.WATER else []
        words += ["playerclip"] if self.contents & Contents.PLAYERCLIP else []
        lines = [f"surfaceparm {word}" for word in words] + self.script.strip().splitlines()
        body = "".join(f"\t{line.strip()}\n" for line in lines)
        return f"{self.name}\n{{\n{body}}}\n"


CAULK = Material(
    "textures/common/caulk", surface=Surface.NODRAW | Surface.NOLIGHTMAP | Surface.NOMARKS
)
"""Solid and never drawn: for the sides of brushes that nobody can see.

A shadow map does not see them either: where the sun might shine through, use a drawn material.
"""

CLIP = Material(
    "textures/common/clip",
    surface=Surface.NODRAW | Surface.NOLIGHTMAP | Surface.NOMARKS | Surface.NOIMPACT,
    contents=Contents.PLAYERCLIP,
    opacity=0.0,
)
"""Stops players and nothing else: over steps and round columns, for smooth walking."""
