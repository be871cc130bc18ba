#version 330 core
// Lines and triangles over the picture.
#include "common/frame.glsl"

in vec3 in_position;
in vec4 in_colour;  // as displayed; a: coverage

uniform float nearer;  // added to clip z

out vec4 colour;

void main() {
    colour = in_colour;
    gl_Position = clip_from_world * vec4(in_position, 1.0);
    gl_Position.z += nearer;
}
