// Where spot lights' near tiles are in the atlas, whose corners are at 0 and 1: second in their rows.

const vec2 tiles = vec2(SHADOW_COLUMNS, SHADOW_ROWS);
const vec2 near_reach = vec2(NEAR_REACH) / tiles;  // from its middle, of what is used

vec2 near_middle(int light) {
    return vec2(1.5, float(light) + 0.5) / tiles;
}
