"""GLSL programs from a folder of shader files.

Includes are resolved here, since GLSL 3.30 has none; ``#line`` keeps the driver's messages
true, with the file told by its number among those that were put together.
"""

import re
from collections.abc import Mapping
from pathlib import Path

import moderngl
import numpy as np
from numpy.typing import NDArray

SHADERS = Path(__file__).parent.parent / "shaders"
_SUFFIXES = (".vert", ".frag", ".glsl")
_LINES_CHANGE = re.compile(
    r'^[ \t]*#(?:include[ \t]+"([^"]+)"|(?:else|elif|endif)\b.*)[ \t]*$', re.MULTILINE
)
_PLACE = re.compile(r"(\d+)[:(](\d+)")
"""File's number and line in a driver's message: Mesa's ``0:12(3): error``, NVIDIA's ``0(12) :``,
and ``ERROR: 0:12:`` of others."""


class ShaderError(RuntimeError):
    """A shader that does not compile: a bug of ours (or of somebody who edits shaders).

    Attributes:
        file: Below the shaders' folder; a program's name where the fault is in no one file.
        line: In that file, where it is known.
        message: What the driver says.
    """

    def __init__(self, file: str, line: int | None, message: str) -> None:
        self.file = file
        self.line = line
        self.message = message
        where = file if line is None else f"{file}:{line}"
        super().__init__(f"{where}: {message}")


class ShaderFolder:
    """The shader files of a folder, as they were when all that is in use compiled.

    Attributes:
        path: The folder.
        texts: The files' texts by their names below the folder.
    """

    def __init__(self, path: Path = SHADERS) -> None:
        self.path = path
        self._times: dict[str, int] = {}
        self.texts = self.read()

    def read(self) -> dict[str, str]:
        """The files as they are now; `texts` stays as it is.

        Raises:
            ShaderError: one cannot be read, as when an editor is just putting it in place.
        """
        try:
            times = self._look()
            texts = {
                name: (self.path / name).read_text(encoding="utf-8", errors="replace")
                for name in times
            }
        except OSError as error:
            raise ShaderError(str(self.path), None, str(error)) from None
        self._times = times
        return texts

    @property
    def has_changed(self) -> bool:
        """Whether a file has been written, added or removed since the last `read`."""
        try:
            return self._look() != self._times
        except OSError:  # a file has gone meanwhile
            return True

    def _look(self) -> dict[str, int]:
        """The files' times of modification."""
        return {
            file.relative_to(self.path).as_posix(): file.stat().st_mtime_ns
            for file in sorted(self.path.rglob("*"))
            if file.suffix in _SUFFIXES
        }


def expand(
    name: str, defines: Mapping[str, int | str], texts: Mapping[str, str] | None = None
) -> tuple[str, list[str]]:
    """A shader's source with its includes and defines put in.

    Args:
        name: File below the shaders' folder.
        defines: Macros, set right after the ``#version`` line.
        texts: All files; by default the package's own.

    Returns:
        The source, and the files in it by their number in ``#line`` directives.

    Raises:
        ShaderError: there is no such file, or none of an included one's name.
    """
    given = ShaderFolder().texts if texts is None else texts
    if name not in given:
        raise ShaderError(name, None, "there is no such file")
    sources: list[str] = []

    def put_in(file: str) -> str:
        number = len(sources)
        sources.append(file)
        text = given[file]

        def replace(match: re.Match[str]) -> str:
            line = text.count("\n", 0, match.start()) + 2
            on = f"#line {line} {number}"
            if match[1] is None:  # what a branch that is left out includes has lines all the same
                return f"{match[0]}\n{on}"
            if match[1] in sources:  # every common file is wanted once
                return on
            if match[1] not in given:
                raise ShaderError(file, line - 1, f"there is no {match[1]} to include")
            return f"#line 1 {len(sources)}\n{put_in(match[1])}\n{on}"

        return _LINES_CHANGE.sub(replace, text)

    version, _, rest = put_in(name).partition("\n")
    macros = "".join(f"#define {key} {value}\n" for key, value in defines.items())
    return f"{version}\n{macros}#line 2 0\n{rest}", sources


def set_uniform(
    program: moderngl.Program,
    name: str,
    value: float | tuple[float, ...] | NDArray[np.float32] | bytes,
) -> None:
    """Set a uniform, unless the shader does not use it: it may be one that is being edited."""
    uniform: object = program.get(name, None)  # `in` would look through all of them
    if uniform is None:
        return
    assert isinstance(uniform, moderngl.Uniform), uniform
    if isinstance(value, np.ndarray | bytes):
        uniform.write(value)
    else:
        uniform.value = value


def build(
    context: moderngl.Context,
    name: str,
    defines: Mapping[str, int | str] | None = None,
    texts: Mapping[str, str] | None = None,
    vertex: str | None = None,
) -> moderngl.Program:
    """Compile and link ``name.vert`` with ``name.frag``.

    Args:
        context: Where the program lives.
        name: Of the files.
        defines: Macros.
        texts: All shader files; by default the package's own.
        vertex: Takes the vertex shader from another pair of files.

    Raises:
        ShaderError: the driver's message with the place that it names.
    """
    vertex_text, vertex_files = expand(f"{vertex or name}.vert", defines or {}, texts)
    fragment_text, fragment_files = expand(f"{name}.frag", defines or {}, texts)
    try:
        return context.program(vertex_shader=vertex_text, fragment_shader=fragment_text)
    except moderngl.Error as error:
        # A title, the stage with a line below it, then what the driver says.
        title, stage, *lines = [line for line in str(error).splitlines() if line.strip()]
        message = "\n".join(lines[1:]) or title
        files = vertex_files if stage.startswith("vertex") else fragment_files
        place = None if "Linker" in title else _PLACE.search(message)
        if place is None or int(place[1]) >= len(files):
            raise ShaderError(name, None, message) from None
        raise ShaderError(files[int(place[1])], int(place[2]), message) from None
