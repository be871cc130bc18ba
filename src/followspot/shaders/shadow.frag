#version 330 core
// Nothing but depth; leaves and grates are cut out as in the picture.
#ifdef ALPHA_TEST
uniform sampler2D base_image;
uniform vec2 alpha_test;  // as in surface.frag
in vec2 texcoord;
#endif

void main() {
#ifdef ALPHA_TEST
    if (texture(base_image, texcoord).a * alpha_test.x + alpha_test.y <= 0.0) discard;
#endif
}
