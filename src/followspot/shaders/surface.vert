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
    for (int i = 0; i < SHADOWS; ++i) shadow_position[i] = shadow_from_world[i] * world;
#endif
    gl_Position = clip_from_world * world;
}
