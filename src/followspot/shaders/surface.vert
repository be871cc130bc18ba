#version 330 core
// World to clip, and to every shadow map: what is linear in the position, so that
// interpolating it is exact. Divisions stay in the pixel stage.
#include "common/frame.glsl"
#include "common/light.glsl"
#include "common/object.glsl"

in vec2 in_texcoord;
#ifdef TINTED
in vec4 in_tint;
out vec4 tint;
#endif

out vec3 world_normal;
out vec2 texcoord;
flat out float scale;  // of the output; handed on, since pixels read uniform blocks slowly
#if LIGHTS > SHADOWS
out vec3 world_position;
#endif
#if SHADOWS > 0
out vec4 shadow_position[SHADOWS];
out vec4 shadowed_ray[SHADOWS];  // common/light.glsl
flat out vec4 shadowed_glow[SHADOWS];
#endif

void main() {
    vec4 world = vertex_in_world();
    world_normal = normal_in_world();
    texcoord = in_texcoord;
#ifdef TINTED
    tint = in_tint;
#endif
    scale = output_scale.x;
#if LIGHTS > SHADOWS
    world_position = world.xyz;
#endif
#if SHADOWS > 0
    for (int i = 0; i < SHADOWS; ++i) {
        shadowed_ray[i] = light_ray(i, world.xyz);
        shadowed_glow[i] = light_glow(i);
        vec3 n = world_normal;
#ifdef SIDES_BOTH
        if (dot(n, shadowed_ray[i].xyz) < 0.0) n = -n;
        n *= 4.0;  // its lit side is in the map itself, whichever faces that leaves out
#endif
        // A texel's footprint grows with w, the distance along the light's axis: the receiver is
        // moved off its surface by a part of it (Holbert, "Saying goodbye to shadow acne", 2011).
        // Along the normal, since along the axis it would go into surfaces that face away from it.
        vec4 s = shadow_from_world[i] * world;
        float offset = light_position[i].w * s.w + SHADOW_BIAS;
        shadow_position[i] = s + shadow_from_world[i] * vec4(n * offset, 0.0);
    }
#endif
    gl_Position = clip_from_world * world;
}
