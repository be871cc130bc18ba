"""Records the OpenGL calls that a program makes through moderngl, as C that makes them again.

moderngl asks its context object for every GL function by name. Here such an object gives it
functions that note the call with its arguments and data, then make it. What comes out is plain
C: one function per section, one line per call, the data in one file beside it.

The prototypes are read from ``GL/glcorearb.h`` (Khronos), so every call is noted in the same way;
only how many bytes lie behind a pointer has to be known here.
"""

import ctypes
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import glcontext  # type: ignore[import-untyped]
import moderngl
from common import BenchmarkError, need_file

HEADER = "/usr/include/GL/glcorearb.h"
_PROTOTYPE = re.compile(r"^GLAPI (.+?) ?APIENTRY (gl\w+) \((.*)\);$", re.MULTILINE)
_TYPES: dict[str, Any] = {
    "GLenum": ctypes.c_uint, "GLuint": ctypes.c_uint, "GLbitfield": ctypes.c_uint,
    "GLint": ctypes.c_int, "GLsizei": ctypes.c_int, "GLboolean": ctypes.c_ubyte,
    "GLfloat": ctypes.c_float, "GLdouble": ctypes.c_double, "GLintptr": ctypes.c_ssize_t,
    "GLsizeiptr": ctypes.c_ssize_t, "void": None, "GLubyte": ctypes.c_ubyte,
    "GLbyte": ctypes.c_byte, "GLshort": ctypes.c_short, "GLushort": ctypes.c_ushort,
    "GLuint64": ctypes.c_uint64, "GLint64": ctypes.c_int64,
}  # fmt: skip

_READS_ONLY = ("glGet", "glIs", "glCheck", "glReadPixels", "glFinish", "glFlush", "glCopyImage")
"""Calls that change nothing, which the C program leaves out."""

_CHANNELS = {0x1903: 1, 0x8227: 2, 0x1907: 3, 0x1908: 4, 0x1902: 1, 0x80E1: 4, 0x80E0: 3}
_CHANNEL_BYTES = {0x1401: 1, 0x1400: 1, 0x1403: 2, 0x140B: 2, 0x1405: 4, 0x1406: 4}
_UNPACK_ALIGNMENT = 0x0CF5
_MATRIX = re.compile(r"glUniformMatrix(\d)(?:x(\d))?fv")
_VECTOR = re.compile(r"glUniform(\d)(?:f|i|ui)v")

Prototype = tuple[str, list[str]]


def prototypes() -> dict[str, Prototype]:
    """Result type and argument types of every function of the core profile."""
    text = Path(need_file(HEADER, "libgl-dev")).read_text()
    found: dict[str, Prototype] = {}
    for result, name, arguments in _PROTOTYPE.findall(text):
        kinds = [] if arguments == "void" else [_kind(a) for a in arguments.split(",")]
        found[name] = _kind(result + " result"), kinds
    return found


def _kind(declaration: str) -> str:
    """An argument's type without its name: ``GLenum`` or, for any pointer, ``*``."""
    if "*" in declaration or "GLsync" in declaration or "GLDEBUGPROC" in declaration:
        return "*"
    return declaration.replace("const", "").split()[0]


def _ctype(kind: str) -> Any:
    return ctypes.c_void_p if kind == "*" else _TYPES[kind]


class Trace:
    """Stands in for moderngl's context object and notes what is called through it.

    Attributes:
        sections: Lines of C by section, in the order in which they were begun.
        data: What the lines refer to as ``data + offset``.
        picture: Framebuffer and arguments of the last glReadPixels: what was looked at.
    """

    def __init__(self, context: Any) -> None:
        self._context = context
        self._prototypes = prototypes()
        self._keep: list[Any] = []
        self._lines: list[str] | None = None  # of the section that is being noted
        self._alignment = 4
        self._read_from = 0
        self.sections: dict[str, list[str]] = {}
        self.data = bytearray()
        self.picture: tuple[int, ...] = ()

    def load(self, name: str) -> int:
        """The address of a function that notes a call and makes it; moderngl calls this."""
        address: int = self._context.load(name)
        if not address or name not in self._prototypes:
            return address
        result, kinds = self._prototypes[name]
        form = ctypes.CFUNCTYPE(_ctype(result), *(_ctype(kind) for kind in kinds))
        real = form(address)

        def noted(*arguments: Any) -> Any:
            answer = real(*arguments)
            self._note(name, kinds, arguments, answer)
            return answer

        wrapped = form(noted)
        self._keep += [real, wrapped]
        return ctypes.cast(wrapped, ctypes.c_void_p).value or 0

    def __enter__(self) -> Self:
        self._context.__enter__()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._context.__exit__(kind, error, at)

    def release(self) -> None:
        """Give the context back."""
        self._context.release()

    def note_as(self, section: str | None) -> None:
        """From here on note what is called under this name, or not at all."""
        self._lines = None if section is None else self.sections.setdefault(section, [])

    def _note(self, name: str, kinds: list[str], arguments: tuple[Any, ...], answer: Any) -> None:
        if name == "glPixelStorei" and arguments[0] == _UNPACK_ALIGNMENT:
            self._alignment = arguments[1]
        if name == "glBindFramebuffer":
            self._read_from = arguments[1]
        if name == "glReadPixels":
            self.picture = (self._read_from, *arguments[:6])
        if self._lines is None or name.startswith(_READS_ONLY):
            return
        if name.startswith("glGen") and kinds[-1] == "*":
            names = ctypes.cast(arguments[1], ctypes.POINTER(ctypes.c_uint))[: arguments[0]]
            self._lines += [f"MAKE({name}, {number}u);" for number in names]
            return
        if name == "glShaderSource":
            self._lines.append(self._source(arguments))
            return
        size = self._bytes_behind(name, arguments)
        texts = [
            self._pointer(value, size) if kind == "*" else _literal(value)
            for kind, value in zip(kinds, arguments, strict=True)
        ]
        call = f"{name}({', '.join(texts)})"
        made = name in ("glCreateShader", "glCreateProgram")
        self._lines.append(f"SAME({call}, {answer}u);" if made else f"{call};")

    def _pointer(self, value: int | None, size: int) -> str:
        if not value or size == 0:
            return f"(void *){value or 0}"
        self.data += bytes(-len(self.data) % 8)
        offset = len(self.data)
        self.data += ctypes.string_at(value, size)
        return f"(void *)(data + {offset})"

    def _source(self, arguments: tuple[Any, ...]) -> str:
        shader, count, strings, lengths = arguments
        texts = ctypes.cast(strings, ctypes.POINTER(ctypes.c_char_p))[:count]
        whole = b"".join(texts)
        if lengths:
            sizes = ctypes.cast(lengths, ctypes.POINTER(ctypes.c_int))[:count]
            whole = b"".join(t[:n] if n >= 0 else t for t, n in zip(texts, sizes, strict=True))
        buffer = ctypes.create_string_buffer(whole)
        place = self._pointer(ctypes.addressof(buffer), len(whole) + 1)
        return f"source({shader}u, {place});"

    def _bytes_behind(self, name: str, a: tuple[Any, ...]) -> int:
        """How many bytes a call reads behind its pointer; 0 where the pointer is an offset.

        Raises:
            BenchmarkError: nobody has told this function how many.
        """
        if "*" not in self._prototypes[name][1]:
            return 0
        if matrix := _MATRIX.fullmatch(name):
            return 4 * int(matrix[1]) * int(matrix[2] or matrix[1]) * int(a[1])
        if vector := _VECTOR.fullmatch(name):
            return 4 * int(vector[1]) * int(a[1])
        if name.startswith("glDelete") or name == "glDrawBuffers":
            return 4 * int(a[0])
        sizes: dict[str, Callable[[], int]] = {
            "glBufferData": lambda: a[1],
            "glBufferSubData": lambda: a[2],
            "glTexImage2D": lambda: self._image(a[3], a[4], a[6], a[7]),
            "glTexSubImage2D": lambda: self._image(a[4], a[5], a[6], a[7]),
            "glTexParameterfv": lambda: 16,
            "glTexParameteriv": lambda: 16,
            "glClearBufferfv": lambda: 16 if a[0] == 0x1800 else 4,
            "glVertexAttribPointer": lambda: 0,
            "glVertexAttribIPointer": lambda: 0,
            "glDrawElements": lambda: 0,
            "glDrawElementsInstanced": lambda: 0,
            "glDrawElementsBaseVertex": lambda: 0,
        }
        if name not in sizes:
            raise BenchmarkError(f"gl_trace.py does not know what {name} reads")
        return int(sizes[name]())

    def _image(self, width: int, height: int, form: int, kind: int) -> int:
        row = width * _CHANNELS[form] * _CHANNEL_BYTES[kind]
        return (row + -row % self._alignment) * height


def _literal(value: Any) -> str:
    if isinstance(value, float):
        return value.hex() + "f" if value == value and abs(value) != float("inf") else "INFINITY"
    return f"{value}u" if value > 0x7FFFFFFF else str(value)


@contextmanager
def tracing() -> Iterator[list[Trace]]:
    """Contexts that moderngl makes in here are traced, from "setup" on; gives a list of them."""
    traces: list[Trace] = []
    create = moderngl.create_standalone_context

    def traced(require: int = 330, backend: str = "egl", **settings: Any) -> moderngl.Context:
        make = glcontext.get_backend_by_name(backend)
        trace = Trace(make(mode="standalone", glversion=require, **settings))
        trace.note_as("setup")
        traces.append(trace)
        return create(require=require, context=trace)  # type: ignore[arg-type]

    moderngl.create_standalone_context = traced  # type: ignore[assignment]
    try:
        yield traces
    finally:
        moderngl.create_standalone_context = create
