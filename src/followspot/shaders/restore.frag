#version 330 core
// A kept depth map back into the one that is drawn over.

uniform sampler2D kept;

void main() {
    gl_FragDepth = texelFetch(kept, ivec2(gl_FragCoord.xy), 0).r;
}
