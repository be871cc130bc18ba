#version 330 core
#include "common/frame.glsl"

uniform samplerCube sky;  // sRGB, decoded by the fetch

in vec3 direction;
out vec4 value;

void main() {
    value = vec4(texture(sky, direction).rgb * (sky_scale.x * output_scale.x), 0.0);  // a: no surface
}
