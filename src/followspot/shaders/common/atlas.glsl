// Where the near tiles are in the atlas, whose corners are at 0 and 1: in rows of two, a spot light's.

const vec2 near_reach = vec2(NEAR_REACH) / vec2(2.0, SHADOW_ROWS);  // from its middle, of what is used

vec2 near_middle(int light) {
    return vec2(1.5, float(light) + 0.5) / vec2(2.0, SHADOW_ROWS);
}
