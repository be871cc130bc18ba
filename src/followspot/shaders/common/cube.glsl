// Where surfaces are looked up in the shadow maps of point lights: one for each side of a cube around
// the light that has anything in it that is seen.

// Place and depth in the atlas for point light i, as `visibility` takes them. Sides come in the order
// +X, -X, +Y, -Y, +Z, -Z; passes/shadow_tiles.py has what the block says of them.
vec4 place_on_cube(int i, vec3 ray, vec3 n) {
    float cosine = dot(n, ray) * inversesqrt(dot(ray, ray));
#ifdef SIDES_BOTH
    if (cosine < 0.0) n = -n;
    cosine = abs(cosine);
#endif
    vec3 way = n * SHADOW_BIAS - ray, size = abs(way);
    bool is_x = size.x >= max(size.y, size.z), is_y = size.y >= size.z;
    vec3 turned = is_x ? way.yzx : is_y ? way.xzy : way.yxz;  // across, across, along the axis
    vec2 slope = is_x ? n.yz : is_y ? n.xz : n.yx;
    int side = (is_x ? 0 : is_y ? 2 : 4) + int(turned.z < 0.0);
    vec4 window = side_window[6 * (i - SHADOWS) + side];
    vec2 depth = side_depth[6 * (i - SHADOWS) + side].xy;

    float along = abs(turned.z);
    vec2 texel = 1.0 / vec2(textureSize(shadow_atlas, 0));
    vec2 across = slope * sign(window.xy);
    float nearer = moved_nearer(cosine, across) * NORMAL_OFFSET;
    vec2 widest = texel / abs(window.xy);  // a texel, in tangents
    nearer *= max(widest.x, widest.y);     // shares of the distance
    return vec4(turned.xy / along * window.xy + window.zw + across * texel * NORMAL_OFFSET,
                depth.x + depth.y / along * (1.0 + nearer), 1.0);
}
