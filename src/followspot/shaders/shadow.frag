#version 330 core
// Nothing but depth; leaves and grates are cut out as in the picture.
#ifdef ALPHA_TEST
uniform sampler2D base_image;
uniform vec2 alpha_test;  // as in surface.frag
in vec2 texcoord;
#endif

void main() {
#ifdef ALPHA_TEST
    // At full size: averaged alpha would thin small leaves out, or fill the gaps between them.
    if (textureLod(base_image, texcoord, 0.0).a * alpha_test.x + alpha_test.y <= 0.0) discard;
#endif
}
