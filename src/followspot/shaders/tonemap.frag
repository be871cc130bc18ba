#version 330 core
// Linear values to the display: exposure, then (for light, not for data) the sRGB curve of
// IEC 61966-2-1. This is the only place where anything is encoded.
uniform sampler2D values;
uniform float exposure;
uniform bool encode;

out vec4 display;

void main() {
    vec3 v = clamp(texelFetch(values, ivec2(gl_FragCoord.xy), 0).rgb * exposure, 0.0, 1.0);
    if (encode)
        v = mix(1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, v * 12.92, lessThanEqual(v, vec3(0.0031308)));
    display = vec4(v, 1.0);
}
