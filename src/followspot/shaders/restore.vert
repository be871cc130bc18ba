#version 330 core
// Rectangles of a tile, one an instance, as a strip.

in vec4 in_corners;  // clip space: left, bottom, right, top

void main() {
    vec2 which = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(mix(in_corners.xy, in_corners.zw, which), 0.0, 1.0);
}
