// The sRGB curve (IEC 61966-2-1), where GL is not to apply it. Above the straight piece, minimax
// polynomials, of its square root to encode: within a twelfth and a nineteenth of a byte's step, and
// several times faster than a power on a software rasteriser.

vec3 srgb_from_linear(vec3 v) {
    v = min(v, 1.0);
    vec3 r = sqrt(v);
    vec3 curve = 0.5170761 * r - 1.623031;
    curve = curve * r + 2.030938;
    curve = curve * r - 1.402449;
    curve = curve * r + 1.517895;
    curve = curve * r - 0.04010618;
    return mix(curve, v * 12.92, lessThan(v, vec3(0.0031308)));
}

vec3 linear_from_srgb(vec3 v) {
    vec3 curve = -0.116794 * v + 0.5265169;
    curve = curve * v + 0.5603688;
    curve = curve * v + 0.02840467;
    curve = curve * v + 0.001046252;
    return mix(curve, v / 12.92, lessThan(v, vec3(0.04045)));
}
