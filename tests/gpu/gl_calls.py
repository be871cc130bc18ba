"""GL functions that moderngl has no call for, looked up by hand in the context that is current."""

import ctypes
from typing import Any, Self

_ENABLE, _SYNCHRONOUS = 0x92E0, 0x8242  # GL_DEBUG_OUTPUT and its synchronous kind
_APPLICATION, _ERROR, _HIGH = 0x824A, 0x824C, 0x9146
_KINDS = (
    "Texture", "Buffer", "Framebuffer", "Renderbuffer", "Program", "VertexArray", "Sampler"
)  # fmt: skip


def gl_function(name: str, result: Any, *arguments: Any) -> Any:
    """A GL function by its name, through EGL."""
    egl = ctypes.CDLL("libEGL.so.1")
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    egl.eglGetProcAddress.argtypes = [ctypes.c_char_p]
    address = egl.eglGetProcAddress(name.encode())
    assert address, f"the GL has no {name}"
    return ctypes.CFUNCTYPE(result, *arguments)(address)


def live_objects() -> dict[str, int]:
    """How many objects of each kind exist in the context that is current."""
    found = {}
    for kind in _KINDS:
        exists = gl_function(f"glIs{kind}", ctypes.c_ubyte, ctypes.c_uint)
        found[kind] = sum(map(bool, map(exists, range(1, max(4096, _new_name(kind))))))
    return found


def _new_name(kind: str) -> int:
    """A name that nothing has: above all others where the GL, as Mesa's, does not reuse names."""
    if kind == "Program":
        name: int = gl_function("glCreateProgram", ctypes.c_uint)()
        gl_function("glDeleteProgram", None, ctypes.c_uint)(name)
        return name
    names = ctypes.c_uint()
    for verb in ("Gen", "Delete"):
        function = gl_function(f"gl{verb}{kind}s", None, ctypes.c_int, ctypes.c_void_p)
        function(1, ctypes.byref(names))
    return names.value


class DebugLog:
    """The GL's own messages (KHR_debug) while a block runs."""

    def __init__(self) -> None:
        number, pointer = ctypes.c_uint, ctypes.POINTER(ctypes.c_uint)
        self._enable = gl_function("glEnable", None, number)
        self._disable = gl_function("glDisable", None, number)
        self._insert = gl_function(
            "glDebugMessageInsert", None, *[number] * 4, ctypes.c_int, ctypes.c_char_p
        )
        self._read = gl_function(
            "glGetDebugMessageLog",
            *(number, number, ctypes.c_int, pointer, pointer, pointer, pointer, pointer),
            ctypes.c_char_p,
        )

    def __enter__(self) -> Self:
        self._enable(_ENABLE)
        self._enable(_SYNCHRONOUS)
        self.messages()
        return self

    def __exit__(self, *_: object) -> None:
        self._disable(_SYNCHRONOUS)
        self._disable(_ENABLE)

    def say(self, text: str) -> None:
        """Insert a message of our own."""
        self._insert(_APPLICATION, _ERROR, 1, _HIGH, len(text), text.encode())

    def messages(self) -> list[str]:
        """What has been said since the last call."""
        found = []
        buffer = ctypes.create_string_buffer(4096)
        while self._read(1, len(buffer), None, None, None, None, None, buffer):
            found.append(buffer.value.decode())
        return found
