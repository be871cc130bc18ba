#version 330 core
// One triangle over the whole picture, at the far plane.
#include "common/frame.glsl"

out vec3 direction;  // world space; linear over the picture, so interpolation is exact

void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    direction = (direction_from_clip * vec4(corner, 0.0, 1.0)).xyz;
    gl_Position = vec4(corner, 1.0, 1.0);
}
