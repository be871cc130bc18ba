#version 330 core
#include "common/frame.glsl"
#include "common/srgb.glsl"

uniform samplerCube sky;  // linear light

in vec3 direction;
out vec4 value;

void main() {
    value.rgb = texture(sky, direction).rgb * (sky_scale.x * output_scale.x);
#ifdef ENCODED
    value.rgb = srgb_from_linear(value.rgb);
#endif
    value.a = 0.0;  // no surface
}
