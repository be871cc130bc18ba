#version 330 core
// A material's image, small. As displayed: sRGB that GL need not encode.
#include "common/srgb.glsl"

uniform sampler2D base_image;
uniform vec2 corner;  // of its place, in pixels
uniform float edge;   // of that place
uniform float holes;  // 1: alpha is a hole's

out vec4 value;

void main() {
    vec4 texel = texture(base_image, (gl_FragCoord.xy - corner) / edge);
    value = vec4(srgb_from_linear(texel.rgb), mix(1.0, texel.a, holes));
}
