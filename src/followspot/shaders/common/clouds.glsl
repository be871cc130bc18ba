// A sky's clouds as they are at a time, scene/clouds.py: images on a sphere about a point far below
// the eye, which cover, add to or tint each other and the box behind them, all as displayed.
const float GROUND_RADIUS = 4096.0;  // units
const float CLOUD_RADIUS = GROUND_RADIUS + CLOUD_HEIGHT;

uniform sampler2D cloud_0, cloud_1, cloud_2, cloud_3;  // as displayed; a is coverage
uniform mat3x2 cloud_from_place[CLOUDS];               // texture coordinates from (place, 1)
uniform vec3 cloud_color[CLOUDS];                      // that texels are multiplied by

// Angles in radians between the X and Y axes and the place, from the sphere's middle, that is seen
// along a unit direction.
vec2 place_in_clouds(vec3 direction) {
    const float more = CLOUD_RADIUS * CLOUD_RADIUS - GROUND_RADIUS * GROUND_RADIUS;
    float up = direction.z * GROUND_RADIUS;
    float away = sqrt(up * up + more) - up;
    return acos(clamp(direction.xy * (away / CLOUD_RADIUS), -1.0, 1.0));
}

// Of a layer's image, at a place.
vec4 cloud_texel(sampler2D image, int i, vec2 place) {
    vec4 texel = texture(image, cloud_from_place[i] * vec3(place, 1.0));
    return vec4(texel.rgb * cloud_color[i], texel.a);
}

// Linear light, 1 at most, of clouds before a box; straight below there are none. How a layer blends
// is a formula of `texel` and `shown`.
vec3 with_clouds(vec3 direction, vec3 box) {
    vec2 place = place_in_clouds(normalize(direction));
#ifdef NO_BOX
    vec3 shown = vec3(0.0);
#else
    vec3 shown = srgb_from_linear(box);
#endif
    vec4 texel = cloud_texel(cloud_0, 0, place);
    shown = min(CLOUD_BLEND_0, 1.0);
#if CLOUDS > 1
    texel = cloud_texel(cloud_1, 1, place);
    shown = min(CLOUD_BLEND_1, 1.0);
#endif
#if CLOUDS > 2
    texel = cloud_texel(cloud_2, 2, place);
    shown = min(CLOUD_BLEND_2, 1.0);
#endif
#if CLOUDS > 3
    texel = cloud_texel(cloud_3, 3, place);
    shown = min(CLOUD_BLEND_3, 1.0);
#endif
    bool is_below = -direction.z > max(abs(direction.x), abs(direction.y));
    return is_below ? box : linear_from_srgb(shown);
}
