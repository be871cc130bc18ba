#version 330 core
// A light's map as greys: distances along its axis, near ones dark, far ones light; white where
// there is nothing. From the near tile where that holds a texel's middle; lookups use all but
// its outermost texels.

uniform sampler2D shadow_depths;  // the atlas, as numbers
uniform ivec2 corner;             // of the light's wide tile, texels; its near one is beside it
uniform int size;                 // texels along a tile's edge
uniform vec4 near_from_wide;      // scale and shift, both tiles' edges at 0 and 1
uniform vec2 planes;              // near and far, units
uniform vec2 shown;               // distances that are darkest and lightest; or, where the first is
                                  // negative, the second is half-way there

out vec4 value;

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    texel.y = size - 1 - texel.y;  // the top row first, as pictures for a GUI have it
    vec2 near = (vec2(texel) + 0.5) / float(size) * near_from_wide.xy + near_from_wide.zw;
    bool is_near = all(greaterThanEqual(near, vec2(0.0))) && all(lessThan(near, vec2(1.0)));
    ivec2 place = is_near ? ivec2(near * float(size)) + ivec2(size, 0) : texel;
    float depth = texelFetch(shadow_depths, corner + place, 0).r;
    float ndc = 2.0 * depth - 1.0;
    float distance = 2.0 * planes.x * planes.y
        / (planes.x + planes.y - ndc * (planes.y - planes.x));
    float share = shown.x < 0.0 ? distance / (distance + shown.y)
                                : clamp((distance - shown.x) / (shown.y - shown.x), 0.0, 1.0);
    value = vec4(vec3(depth < 1.0 ? 0.05 + 0.85 * share : 1.0), 1.0);
}
