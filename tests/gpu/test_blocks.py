"""The uniform block of a frame as Python writes it against the one that GLSL reads."""

import ctypes

import moderngl
import pytest
from gl_calls import gl_function

from followspot.gpu import blocks, program
from followspot.present.renderer import Renderer
from synthetic import floor, make_scene

pytestmark = pytest.mark.gl

_OFFSET = 0x8A3B  # GL_UNIFORM_OFFSET
_NAME, _NUMBERS = ctypes.c_uint, ctypes.c_void_p


def test_the_frame_block_is_laid_out_as_in_glsl(renderer: Renderer) -> None:
    context = renderer.open(make_scene([floor()])).context
    source, _ = program.expand("surface.vert", {"LIGHTS": 1, "SHADOWS": 0})
    nothing = "#version 330 core\nvoid main() {}"
    made = context.program(vertex_shader=source, fragment_shader=nothing)
    block = made["Frame"]
    assert isinstance(block, moderngl.UniformBlock)
    assert block.size == blocks.FRAME.itemsize
    index_of = gl_function("glGetUniformIndices", None, _NAME, ctypes.c_int, _NUMBERS, _NUMBERS)
    property_of = gl_function(
        "glGetActiveUniformsiv", None, _NAME, ctypes.c_int, _NUMBERS, _NAME, _NUMBERS
    )
    assert blocks.FRAME.fields
    for name, (_, offset, *_) in blocks.FRAME.fields.items():
        text, index, found = ctypes.c_char_p(name.encode()), _NAME(), ctypes.c_int(-1)
        index_of(made.glo, 1, ctypes.byref(text), ctypes.byref(index))
        property_of(made.glo, 1, ctypes.byref(index), _OFFSET, ctypes.byref(found))
        assert found.value == offset, name
    made.release()
