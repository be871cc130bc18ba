#version 330 core
// A Lambertian surface under the frame's lights and sky: L = rho/pi E. VIEW chooses which stage
// of that is written; LIGHTS and SHADOWS are the frame's counts, shadowed lights first.
#include "common/frame.glsl"
#include "common/light.glsl"

uniform sampler2D base_image;          // sRGB, decoded by the fetch; a is coverage
uniform sampler2DShadow shadow_atlas;  // depth from the lights, compared by the fetch
uniform vec3 alpha_test;               // keep where a * x + y > 0; z unused

in vec3 world_position;
in vec3 world_normal;
in vec2 texcoord;
#if SHADOWS > 0
in vec4 shadow_position[SHADOWS];
#endif

out vec4 value;

float visibility(int i) {
#if SHADOWS > 0
    return textureProj(shadow_atlas, shadow_position[i]);
#else
    return 1.0;
#endif
}

vec3 direct_irradiance(vec3 n) {
    vec3 e = vec3(0.0);
#if SHADOWS > 0
    for (int i = 0; i < SHADOWS; ++i)
        e += irradiance_from_light(i, world_position, n) * visibility(i);
#endif
    for (int i = SHADOWS; i < LIGHTS; ++i) e += irradiance_from_light(i, world_position, n);
    return e;
}

// 1 where the key light arrives: inside its cone, on a side that faces it, behind nothing.
float key_light_visibility(vec3 n) {
#if LIGHTS > 0
    vec3 e = irradiance_from_light(0, world_position, n);
    return max(e.r, max(e.g, e.b)) > 0.0 ? visibility(0) : 0.0;
#else
    return 0.0;
#endif
}

void main() {
#if defined(ALPHA_TEST) || !defined(CONSTANT_ALBEDO)
    vec4 texel = texture(base_image, texcoord);
#else
    vec4 texel = vec4(1.0);
#endif
#ifdef ALPHA_TEST
    if (texel.a * alpha_test.x + alpha_test.y <= 0.0) discard;
#endif
#ifdef CONSTANT_ALBEDO
    texel.rgb = vec3(1.0);
#endif
    vec3 rho = texel.rgb * tint.rgb;
    vec3 n = normalize(world_normal);
#ifdef SIDES_BOTH
    if (!gl_FrontFacing) n = -n;
#endif

#if defined(EMISSIVE) && VIEW == VIEW_FINAL
    value.rgb = rho * tint.a;
#elif defined(FILTER)
    value.rgb = rho;
#elif VIEW == VIEW_FINAL
    value.rgb = rho * (direct_irradiance(n) / PI + environment_radiance(n));
#elif VIEW == VIEW_NORMALS
    value.rgb = n * 0.5 + 0.5;
#elif VIEW == VIEW_LAMBERTIAN
    value.rgb = rho;
#elif VIEW == VIEW_SHADING
    value.rgb = direct_irradiance(n) / PI + environment_radiance(n);
#elif VIEW == VIEW_DIRECT
    value.rgb = rho / PI * direct_irradiance(n);
#elif VIEW == VIEW_ENVIRONMENT
    value.rgb = rho * environment_radiance(n);
#elif VIEW == VIEW_SHADOW
    value.rgb = vec3(key_light_visibility(n));
#elif VIEW == VIEW_DEPTH
    value.rgb = vec3(1.0 / gl_FragCoord.w);  // clip w is the distance along the view axis
#endif
#ifndef FILTER
    value.rgb *= output_scale.x;
#endif
#ifdef BLENDED
    value.a = texel.a;
#else
    value.a = 1.0;
#endif
}
