// Where surfaces are looked up in the shadow maps of point lights: one for each side of a cube around
// the light, +X, -X, +Y, -Y, +Z, -Z, one after the other in rows of three above those of spot lights.

// Place and depth in the atlas for point light i, as `visibility` takes them.
vec4 place_on_cube(int i, vec3 ray, vec3 n) {
    float cosine = dot(n, ray) * inversesqrt(dot(ray, ray));
#ifdef SHOWS_BACKS
    if (cosine < 0.0) n = -n;
    cosine = abs(cosine);
#endif
    vec3 way = n * SHADOW_BIAS - ray, size = abs(way);
    bool is_x = size.x >= max(size.y, size.z), is_y = size.y >= size.z;
    float along = is_x ? way.x : is_y ? way.y : way.z;
    float ahead = along < 0.0 ? -1.0 : 1.0;
    along = abs(along);

    // To the right and upwards on the side, of the place and of the normal.
    vec2 place = is_x ? vec2(-ahead * way.y, way.z)
               : is_y ? vec2(ahead * way.x, way.z)
               : vec2(-way.y, -ahead * way.x);
    vec2 across = is_x ? vec2(-ahead * n.y, n.z)
                : is_y ? vec2(ahead * n.x, n.z)
                : vec2(-n.y, -ahead * n.x);
    const float texel = 1.0 / TILE_SIZE;  // on the side, whose edges are at 0 and 1
    float nearer = moved_nearer(cosine, across) * NORMAL_OFFSET * texel / SIDE_SCALE;
    place = place / along * SIDE_SCALE + 0.5 + across * (NORMAL_OFFSET * texel);

    int side = 6 * (i - SHADOWS) + (is_x ? 0 : is_y ? 2 : 4) + int(ahead < 0.0);
    int row = side / 3;
    place += vec2(side - row * 3, row + SHADOWS);
    const float near = SIDE_NEAR, far = SIDE_FAR;
    float depth = (1.0 - near / along * (1.0 + nearer)) * (far / (far - near));
    return vec4(place / vec2(SHADOW_COLUMNS, SHADOW_ROWS), depth, 1.0);
}
