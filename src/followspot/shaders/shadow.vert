#version 330 core
// Depth as a light sees it (Williams 1978).
#include "common/object.glsl"

uniform mat4 clip_from_world;  // of the light

#ifdef ALPHA_TEST
in vec2 in_texcoord;
out vec2 texcoord;
#endif

void main() {
#ifdef ALPHA_TEST
    texcoord = in_texcoord;
#endif
    gl_Position = clip_from_world * vertex_in_world();
}
