#version 330 core
// The sky's six faces, unfolded as they are seen from inside: +Y +X -Y -X around the horizon, +Z
// above and -Z below +X. As displayed: sRGB that GL need not encode.
#include "common/srgb.glsl"

uniform samplerCube sky;
uniform float level;  // MIP
uniform float edge;   // of a face, in pixels

out vec4 value;

void main() {
    vec2 place = gl_FragCoord.xy / edge;  // the top row first, as pictures for a GUI have it
    ivec2 cell = ivec2(place);
    if (cell.y != 1 && cell.x != 1) {
        value = vec4(0.0);
        return;
    }
    const vec3 around[4] = vec3[](
        vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, -1.0, 0.0), vec3(-1.0, 0.0, 0.0)
    );
    vec3 ahead = around[cell.x], up = vec3(0.0, 0.0, 1.0);
    vec3 right = cross(ahead, up);
    if (cell.y == 0) {  // the head thrown back
        up = -ahead;
        ahead = vec3(0.0, 0.0, 1.0);
    } else if (cell.y == 2) {
        up = ahead;
        ahead = vec3(0.0, 0.0, -1.0);
    }
    vec2 across = (fract(place) * 2.0 - 1.0) * vec2(1.0, -1.0);  // right and up
    vec3 direction = ahead + across.x * right + across.y * up;
    value = vec4(srgb_from_linear(textureLod(sky, direction, level).rgb), 1.0);
}
