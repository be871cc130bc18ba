#version 330 core
// Object to world to clip, and to every shadow map: the multiplications that are linear, so that
// interpolating their homogeneous results is exact. The divisions stay in the pixel stage.
#include "common/frame.glsl"

uniform mat4 world_from_object;

in vec3 in_position;
in vec3 in_normal;
in vec2 in_texcoord;

out vec3 world_position;
out vec3 world_normal;
out vec2 texcoord;
#if SHADOWS > 0
out vec4 shadow_position[SHADOWS];
#endif

void main() {
    vec4 world = world_from_object * vec4(in_position, 1.0);
    world_position = world.xyz;
    world_normal = mat3(world_from_object) * in_normal;  // rotations and even scales only
    texcoord = in_texcoord;
#if SHADOWS > 0
    for (int i = 0; i < SHADOWS; ++i) {
        vec3 n = world_normal;
#ifdef SIDES_BOTH
        if (dot(n, light_position[i].xyz - world_position) < 0.0) n = -n;
#endif
        // A texel's footprint grows with w, the distance along the light's axis (Holbert 2011,
        // "Normal offset shadows"): the receiver moves off its surface by a part of it.
        vec4 s = shadow_from_world[i] * world;
        shadow_position[i] = s + shadow_from_world[i] * vec4(n * (light_position[i].w * s.w), 0.0);
    }
#endif
    gl_Position = clip_from_world * world;
}
