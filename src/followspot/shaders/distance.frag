#version 330 core
// A light's map as greys: distances along its axis, near ones dark, far ones light; white where
// there is nothing.

uniform sampler2D shadow_depths;  // the atlas, as numbers
uniform ivec2 corner;             // of the light's tile, in texels
uniform int size;                 // texels along its edge
uniform vec2 planes;              // near and far, units
uniform vec2 shown;               // distances that are darkest and lightest

out vec4 value;

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    texel.y = size - 1 - texel.y;  // the top row first, as pictures for a GUI have it
    float depth = texelFetch(shadow_depths, corner + texel, 0).r;
    float ndc = 2.0 * depth - 1.0;
    float distance = 2.0 * planes.x * planes.y
        / (planes.x + planes.y - ndc * (planes.y - planes.x));
    float share = clamp((distance - shown.x) / (shown.y - shown.x), 0.0, 1.0);
    value = vec4(vec3(depth < 1.0 ? 0.05 + 0.85 * share : 1.0), 1.0);
}
