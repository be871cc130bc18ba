#version 330 core
// Depth as a light sees it (Williams 1978).
uniform mat4 clip_from_world;  // of the light
uniform mat4 world_from_object;

in vec3 in_position;
#ifdef ALPHA_TEST
in vec2 in_texcoord;
out vec2 texcoord;
#endif

void main() {
#ifdef ALPHA_TEST
    texcoord = in_texcoord;
#endif
    gl_Position = clip_from_world * (world_from_object * vec4(in_position, 1.0));
}
