#version 330 core
// World to clip, and to every shadow map: what is linear in the position, so that
// interpolating it is exact. Divisions stay in the pixel stage.
#include "common/frame.glsl"
#include "common/light.glsl"
#include "common/object.glsl"
#include "common/texcoord.glsl"
#include "common/deform.glsl"

#define MAPPED (SHADOWS + POINT_SHADOWS)

#if defined(TINTED) || defined(FADES) || defined(LAYER_TINTED)
in vec4 in_tint;
out vec4 tint;
#endif

#ifdef BAKED
in vec3 in_baked;  // light: of the instance; or of the vertex, which luxels are multiplied by
out vec3 baked;
#ifndef POSED
in vec2 in_luxel;  // place in the lightmaps
out vec2 luxel;
#endif
#endif

out vec3 world_normal;
out vec2 texcoord;
#ifdef LAYER_APART
out vec2 layer_texcoord;
#endif
flat out float scale;  // of the output; handed on, since pixels read uniform blocks slowly
#if defined(EMISSIVE) || defined(LAID_GLOW)
flat out float own_scale;  // of self-lit texels
#endif
#if LIGHTS > MAPPED
out vec3 world_position;
#endif
#if FOGS > 0 || defined(SMOOTHED)
out vec3 eye_ray;  // from the eye, world units
#endif
#if MAPPED > 0
out vec4 shadowed_ray[MAPPED];  // common/light.glsl
flat out vec4 shadowed_glow[MAPPED];
#endif
#if SHADOWS > 0
out vec4 shadow_wide[SHADOWS];  // place in the atlas, in the wide tile
#ifdef SHADOW_FIT
out vec3 shadow_near[SHADOWS];  // x, y in the near tile, used from -w to w; and z for it
#include "common/atlas.glsl"
#endif

#include "common/offset.glsl"

// Where a receiver is looked up in spot light i's tiles, moved as offset.glsl says.
void place_in_tiles(int i, vec3 position, vec3 n) {
    vec3 ray = shadowed_ray[i].xyz;
    float cosine = dot(n, ray) * inversesqrt(dot(ray, ray));
#ifdef SHOWS_BACKS
    if (cosine < 0.0) n = -n;
    cosine = abs(cosine);
#endif
    vec2 across = vec2(dot(offset_right[i].xyz, n), dot(offset_up[i].xyz, n));
    float nearer = moved_nearer(cosine, across);
    float depth = light_position[i].w * nearer;
    vec4 s = shadow_from_world[i] * vec4(position + n * SHADOW_BIAS, 1.0);
    vec2 moved = across * vec2(offset_right[i].w, offset_up[i].w) * s.w;
    shadow_wide[i] = vec4(s.xy + moved, s.z + depth, s.w);
#ifdef SHADOW_FIT
    vec2 scale = near_from_wide[i].xy;  // a texel is smaller by this, and with it its depth
    vec2 near = s.xy * scale + s.w * near_from_wide[i].zw + moved;
    near = (near - s.w * near_middle(i)) / near_reach;
    shadow_near[i] = vec3(near, s.z + depth / min(scale.x, scale.y));
#endif
}
#endif

void main() {
    vec4 world = vertex_in_world();
    world_normal = normal_in_world();
    texcoord = base_texcoord();
#ifdef LAYER_APART
    layer_texcoord = layer_texcoord_of_its_own();
#endif
#if defined(TINTED) || defined(FADES) || defined(LAYER_TINTED)
    tint = in_tint;
#endif
#ifdef BAKED
    baked = in_baked;
#ifndef POSED
    luxel = in_luxel;
#endif
#endif
    scale = output_scale.x;
#if defined(EMISSIVE) || defined(LAID_GLOW)
    own_scale = output_scale.y;
#endif
#if LIGHTS > MAPPED
    world_position = world.xyz;
#endif
#if FOGS > 0 || defined(SMOOTHED)
    eye_ray = world.xyz - eye_position.xyz;
#endif
#if MAPPED > 0
    for (int i = 0; i < MAPPED; ++i) {
        shadowed_ray[i] = light_ray(i, world.xyz);
        shadowed_glow[i] = light_glow(i);
    }
#endif
#if SHADOWS > 0
    for (int i = 0; i < SHADOWS; ++i) place_in_tiles(i, world.xyz, world_normal);
#endif
    gl_Position = clip_from_world * vec4(drawn_at(world.xyz), 1.0);
}
