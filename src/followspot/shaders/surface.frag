#version 330 core
// A Lambertian surface under the frame's lights and sky: L = rho/pi E. VIEW chooses which stage
// of that is written, ENCODED as sRGB, but where GL blends, which does that itself; LIGHTS are the
// frame's: first SHADOWS spot lights with a map, then POINT_SHADOWS point lights with some, then those
// without any.
#include "common/frame.glsl"
#include "common/light.glsl"
#include "common/srgb.glsl"
#if FOGS > 0
#include "common/fog.glsl"
#endif

#define MAPPED (SHADOWS + POINT_SHADOWS)
#define MIDDLE_GREY 0.2140411  // linear light of what is displayed as one half
#define DISPLAY_GAMMA 2.2
#if defined(LAYERED) && !defined(ALBEDO)
#define SHOWS_LAYER
#endif
#if defined(LAID_GLOW) && defined(EMISSIVE) && !defined(BLENDED)
#define PAINTED_GLOW  // lava of several images: as bright as the game displays their sum
#endif

uniform sampler2D base_image;          // linear light; a is coverage
uniform sampler2D layer_image;         // likewise, laid on that
uniform sampler2DShadow shadow_atlas;  // depth from the lights, compared by the fetch
#if defined(BAKED) && !defined(POSED)
uniform sampler2D lightmaps;           // linear light
#endif
uniform vec2 alpha_test;               // keep where a * x + y > 0
#if FOGS > 0 && defined(BLENDED)
uniform vec3 fog_cover;                // share of fog before it that it stands for: of all, by its
                                       // reflectance, by its alpha; x: what multiplies nothing
#endif
#ifdef PULSES
uniform vec2 pulse;                    // that texels are multiplied by: rgb, a
#endif
#ifdef LAYER_COLORED
uniform vec3 layer_color;              // that those of the layer are multiplied by
#endif

in vec3 world_normal;
in vec2 texcoord;
#ifdef LAYER_APART
in vec2 layer_texcoord;
#else
#define layer_texcoord texcoord
#endif
#if defined(TINTED) || defined(FADES) || defined(LAYER_TINTED)
in vec4 tint;  // linear, that texels or the layer's are multiplied by; or how far that covers, its a
#endif
#ifdef BAKED
in vec3 baked;  // light; where there are lightmaps, what they are multiplied by
#ifndef POSED
in vec2 luxel;
#endif
#endif
flat in float scale;
#if defined(EMISSIVE) || defined(LAID_GLOW)
flat in float own_scale;
#endif
#if LIGHTS > MAPPED
in vec3 world_position;
#endif
#if FOGS > 0 || defined(SMOOTHED)
in vec3 eye_ray;
#endif
#if MAPPED > 0
in vec4 shadowed_ray[MAPPED];
flat in vec4 shadowed_glow[MAPPED];
#endif
#if SHADOWS > 0
in vec4 shadow_wide[SHADOWS];
#ifdef SHADOW_FIT
in vec3 shadow_near[SHADOWS];
#endif
#endif

layout(location = 0, index = 0) out vec4 value;
#ifdef VEILS
layout(location = 0, index = 1) out vec4 reflected;  // what GL weights the light from behind by
#endif

#if SHADOWS > 0
#ifdef SHADOW_FIT
#include "common/atlas.glsl"

// Where a light's map is looked at, moved off the surface: in the near tile if that holds the
// place and all that the filter takes, else in the wide one.
vec4 place_in_atlas(int i) {
    vec4 wide = shadow_wide[i];
    vec3 near = shadow_near[i];
    bool is_near = max(abs(near.x), abs(near.y)) < wide.w;
    near.xy = near.xy * near_reach + wide.w * near_middle(i);
    return vec4(is_near ? near : wide.xyz, wide.w);
}
#else
vec4 place_in_atlas(int i) {
    return shadow_wide[i];
}
#endif
#endif

#if MAPPED > 0
// Share of a light that arrives, by percentage-closer filtering (Reeves, Salesin and Cook 1987):
// the mean of comparisons, of which the hardware makes four for each fetch.
float visibility(vec4 homogeneous) {
#if SHADOW_TAPS == 1
    return textureProj(shadow_atlas, homogeneous);
#else
    vec3 s = homogeneous.xyz / homogeneous.w;
    vec2 texel = 1.0 / vec2(textureSize(shadow_atlas, 0));
    float sum = 0.0;
    for (int y = 0; y < SHADOW_TAPS; ++y)
        for (int x = 0; x < SHADOW_TAPS; ++x) {
            vec2 offset = vec2(x, y) - 0.5 * float(SHADOW_TAPS - 1);
            sum += texture(shadow_atlas, s + vec3(offset * texel, 0.0));
        }
    return sum / float(SHADOW_TAPS * SHADOW_TAPS);
#endif
}

#if POINT_SHADOWS > 0
#include "common/offset.glsl"
#include "common/cube.glsl"
#endif

// Share of a light that arrives at the side of a triangle that is seen; `place` is where its map tells.
float arrives(vec3 ray, vec4 place) {
#ifdef SMOOTHED
    // Normals that are smoothed over edges face some lights from which the triangle itself is turned
    // away. It is in its own shadow there. The map cannot tell that, since what it holds there is the
    // triangle itself.
    // A sun's ray is too long for its own changes from pixel to pixel.
    vec3 seen_side = cross(dFdx(eye_ray), dFdy(eye_ray));
    if (dot(seen_side, ray) <= 0.0) return 0.0;
#endif
    return visibility(place);
}
#endif

vec3 radiance_from_lights(vec3 n) {
    vec3 sum = vec3(0.0);
#if SHADOWS > 0
    for (int i = 0; i < SHADOWS; ++i)
        sum += radiance_from_light(shadowed_ray[i], shadowed_glow[i], n)
             * arrives(shadowed_ray[i].xyz, place_in_atlas(i));
#endif
#if POINT_SHADOWS > 0
    for (int i = SHADOWS; i < MAPPED; ++i)
        sum += radiance_from_light(shadowed_ray[i], shadowed_glow[i], n)
             * arrives(shadowed_ray[i].xyz, place_on_cube(i, shadowed_ray[i].xyz, n));
#endif
#if LIGHTS > MAPPED
    for (int i = MAPPED; i < LIGHTS; ++i)
        sum += radiance_from_light(light_ray(i, world_position), light_glow(i), n);
#endif
    return sum;
}

// Radiance of a white surface under what was baked for its place, or under the environment.
vec3 radiance_from_around(vec3 n) {
#if defined(BAKED) && defined(POSED)
    return BAKED * baked;
#elif defined(BAKED)
    return BAKED * baked * texture(lightmaps, luxel).rgb;
#else
    return radiance_from_environment(n);
#endif
}

// 1 where the key light arrives: inside its cone, on a side that faces it, behind nothing.
float key_light_visibility(vec3 n) {
    const vec3 white = vec3(1.0);
#if MAPPED > 0
    bool faces = radiance_from_light(shadowed_ray[0], vec4(white, shadowed_glow[0].w), n).r > 0.0;
#if SHADOWS > 0
    float share = arrives(shadowed_ray[0].xyz, place_in_atlas(0));
#else
    float share = arrives(shadowed_ray[0].xyz, place_on_cube(0, shadowed_ray[0].xyz, n));
#endif
    return faces ? share : 0.0;  // chosen last: derivatives are for what all pixels do
#elif LIGHTS > 0
    vec4 ray = light_ray(0, world_position);
    return radiance_from_light(ray, vec4(white, light_glow(0).w), n).r > 0.0 ? 1.0 : 0.0;
#else
    return 0.0;
#endif
}

void main() {
#if defined(ALPHA_TEST) || !defined(ALBEDO)
    vec4 texel = texture(base_image, texcoord);
#else
    vec4 texel = vec4(1.0);
#endif
#ifdef ALPHA_TEST
    if (texel.a * alpha_test.x + alpha_test.y <= 0.0) discard;
#endif
#ifdef TINTED
    texel *= tint;
#endif
#ifdef PULSES
    texel *= pulse.xxxy;
#endif
#ifdef SHOWS_LAYER
    vec4 layer = texture(layer_image, layer_texcoord);
#ifdef FADES
    layer.a *= tint.a;
#endif
#ifdef LAYER_TEST
    if (layer.a * LAYER_TEST.x + LAYER_TEST.y <= 0.0) layer.a = 0.0;
#endif
#ifdef LAYER_TINTED
    layer.rgb *= tint.rgb;
#endif
#ifdef LAYER_COLORED
    layer.rgb *= layer_color;
#endif
#if defined(LAID_OVER)
    texel.rgb = mix(texel.rgb, layer.rgb, layer.a);
#elif defined(LAID_SHEEN)
    texel.rgb = min(texel.rgb + layer.rgb, 1.0);
#elif defined(PAINTED_GLOW)
    texel.rgb = linear_from_srgb(min(srgb_from_linear(texel.rgb) + srgb_from_linear(layer.rgb), 1.0));
#elif defined(LAID_FILTER) && !defined(BRIGHTENS)
    texel.rgb *= layer.rgb;
#elif defined(LAID_GRAIN)
    texel.rgb = min(texel.rgb * layer.rgb / MIDDLE_GREY, 1.0);
#endif
#endif
#ifdef WEIGHTED
    texel.rgb *= texel.a;
#endif
#ifdef BRIGHTENS  // what is behind, by 1 and the texel more; GL adds at most as much as is there
#if defined(SHOWS_LAYER) && defined(LAID_FILTER)
    texel.rgb = min((1.0 + texel.rgb) * (1.0 + layer.rgb) - 1.0, 1.0);
#else
    texel.rgb = min(pow(1.0 + srgb_from_linear(texel.rgb), vec3(DISPLAY_GAMMA)) - 1.0, 1.0);
#endif
#endif
#ifdef ALBEDO
    vec3 rho = vec3(ALBEDO);
#else
    vec3 rho = texel.rgb;
#endif
    vec3 n = normalize(world_normal);
#ifdef SHOWS_BACKS
    if (!gl_FrontFacing) n = -n;
#endif

#if defined(EMISSIVE) && VIEW == VIEW_FINAL && (defined(BLENDED) || !defined(ALBEDO))
    value.rgb = rho * own_scale;
#elif defined(FILTER)
    value.rgb = rho;
#elif VIEW == VIEW_FINAL
    value.rgb = rho * (radiance_from_lights(n) + radiance_from_around(n) * scale);
#elif VIEW == VIEW_NORMALS
    value.rgb = n * 0.5 + 0.5;
#elif VIEW == VIEW_LAMBERTIAN
    value.rgb = rho;
#elif VIEW == VIEW_SHADING
    value.rgb = radiance_from_lights(n) + radiance_from_around(n) * scale;
#elif VIEW == VIEW_DIRECT
    value.rgb = rho * radiance_from_lights(n);
#elif VIEW == VIEW_ENVIRONMENT
    value.rgb = rho * radiance_from_around(n) * scale;
#elif VIEW == VIEW_SHADOW
    value.rgb = vec3(key_light_visibility(n));
#elif VIEW == VIEW_DEPTH
    value.rgb = vec3(scale / gl_FragCoord.w);  // clip w is the distance along the view axis
#endif
#if defined(LAID_GLOW) && !defined(PAINTED_GLOW) && defined(SHOWS_LAYER) && VIEW == VIEW_FINAL
    value.rgb += layer.rgb * own_scale;
#endif
#if FOGS > 0 && VIEW == VIEW_FINAL
    vec4 fog = fog_along(eye_ray, 1.0);
    float through = through_fog(fog);
#if defined(FILTER)
    value.rgb = mix(fog_cover.xxx, value.rgb, through);
#elif defined(BLENDED)
    vec3 cover = fog_cover.x + fog_cover.y * rho + fog_cover.z * texel.a;
    value.rgb = mix(glow_of_fog(fog) * cover, value.rgb, through);
#else
    value.rgb = mix(glow_of_fog(fog), value.rgb, through);
#endif
#endif
#ifdef VEILS
    reflected = vec4(rho, texel.a);
#endif
#ifdef BLENDED
    value.a = texel.a;
#else
    value.a = 1.0;
#ifdef ENCODED
    value.rgb = srgb_from_linear(value.rgb);
#endif
#endif
}
