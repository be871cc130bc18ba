"""GLSL programs from the package's shader files.

Includes are resolved here, since GLSL 3.30 has none; ``#line`` keeps the driver's messages
true, with the file told by its number in the list that a `ShaderError` prints.
"""

import re
from importlib.resources import files

import moderngl

SHADERS = files("followspot") / "shaders"
_INCLUDE = re.compile(r'^[ \t]*#include[ \t]+"([^"]+)"[ \t]*$', re.MULTILINE)


class ShaderError(RuntimeError):
    """A shader that does not compile: a bug of ours (or of somebody who edits shaders)."""


def expand(name: str, defines: dict[str, int | str]) -> tuple[str, list[str]]:
    """A shader's source with its includes and defines put in.

    Args:
        name: File below ``shaders/``.
        defines: Macros, set right after the ``#version`` line.

    Returns:
        The source, and the files in it by their number in ``#line`` directives.
    """
    sources: list[str] = []

    def put_in(file: str) -> str:
        number = len(sources)
        sources.append(file)
        text = (SHADERS / file).read_text(encoding="utf-8")

        def replace(match: re.Match[str]) -> str:
            line = text.count("\n", 0, match.start()) + 2
            if match[1] in sources:  # every common file is wanted once
                return f"#line {line} {number}"
            return f"#line 1 {len(sources)}\n{put_in(match[1])}\n#line {line} {number}"

        return _INCLUDE.sub(replace, text)

    version, _, rest = put_in(name).partition("\n")
    macros = "".join(f"#define {key} {value}\n" for key, value in defines.items())
    return f"{version}\n{macros}#line 2 0\n{rest}", sources


def uniform(program: moderngl.Program, name: str) -> moderngl.Uniform:
    """A program's uniform, to be set; it must be one that the shader uses."""
    found = program[name]
    assert isinstance(found, moderngl.Uniform), found
    return found


def build(
    context: moderngl.Context, name: str, defines: dict[str, int | str] | None = None
) -> moderngl.Program:
    """Compile and link ``name.vert`` with ``name.frag``.

    Raises:
        ShaderError: the driver's message, with the files by number.
    """
    vertex, vertex_files = expand(f"{name}.vert", defines or {})
    fragment, fragment_files = expand(f"{name}.frag", defines or {})
    try:
        return context.program(vertex_shader=vertex, fragment_shader=fragment)
    except moderngl.Error as error:
        listing = f"vertex files {vertex_files}, fragment files {fragment_files}"
        raise ShaderError(f"{name} with {defines}: {listing}\n{error}") from None
