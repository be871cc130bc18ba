// The sRGB curve (IEC 61966-2-1), where GL is not to apply it.

vec3 srgb_from_linear(vec3 v) {
    return mix(v * 12.92, 1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, greaterThan(v, vec3(0.0031308)));
}
