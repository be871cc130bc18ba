#version 330 core
// The mean of a square of pixels, times a share: what several pictures add up to is their mean.
#include "common/srgb.glsl"

uniform sampler2D picture;
uniform int edge;     // of the square, in pixels
uniform float share;  // of one pixel in the sum
uniform bool decoded; // the picture holds plain values, which the fetch has taken for sRGB

out vec4 value;

void main() {
    ivec2 corner = ivec2(gl_FragCoord.xy) * edge;
    vec3 sum = vec3(0.0);
    for (int y = 0; y < edge; y++) {
        for (int x = 0; x < edge; x++) {
            vec3 v = texelFetch(picture, corner + ivec2(x, y), 0).rgb;
            sum += decoded ? srgb_from_linear(v) : v;
        }
    }
    value = vec4(sum * share, 1.0);
}
