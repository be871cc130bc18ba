// Light that reaches a surface point, from the frame's lights and from the environment.
//
// A light is told to the shading in two vectors. The first, interpolated where it can be, holds
// what is linear in the surface's position p; the second is the same for the whole frame:
//   ray:  xyz: light - p, world units; w: distance along the axis over the width of the rim
//   glow: rgb: radiance of a white surface that faces the light at distance 1, times the output
//         scale; w: offset of the rim, so that (ray.w / r + glow.w) is 0 at the rim and 1 where
//         the light is full

vec4 light_ray(int i, vec3 p) {
    vec3 l = light_position[i].xyz - p;
    return vec4(l, dot(light_axis[i].xyz, l));
}

vec4 light_glow(int i) {
    return vec4(light_radiance[i].rgb * output_scale.x, light_axis[i].w);
}

// Radiance of a white Lambertian surface with unit normal n under one light: L = E/pi with
// E = I cos(theta) / r^2 (Pharr, Jakob, Humphreys: PBR, 4th ed., 12.1-12.2) and a smoothstep over
// the cosine in the rim. A point light's axis is 0 and its rim 1 everywhere.
vec3 radiance_from_light(vec4 ray, vec4 glow, vec3 n) {
    float per_r = inversesqrt(dot(ray.xyz, ray.xyz));
    float cos_theta = max(dot(n, ray.xyz) * per_r, 0.0);
    float rim = clamp(ray.w * per_r + glow.w, 0.0, 1.0);
    return glow.rgb * (cos_theta * per_r * per_r * (rim * rim * (3.0 - 2.0 * rim)));
}

// Radiance of a white surface under the environment: the mean of six sky radiances weighted by
// max(0, +-n.axis). Each max leaves out the axis that faces away from the surface. Dividing by
// the weights' sum makes a uniform sky light every direction alike.
//
// The radiances are constants of the program: software rasterisers read a uniform block anew for
// every pixel, which took longer than the sum itself.
vec3 radiance_from_environment(vec3 n) {
#ifdef SKY_LIGHT
    vec3 towards = max(n, 0.0), away = max(-n, 0.0);
    vec3 sum = towards.x * SKY_POS_X + away.x * SKY_NEG_X
             + towards.y * SKY_POS_Y + away.y * SKY_NEG_Y
             + towards.z * SKY_POS_Z + away.z * SKY_NEG_Z;
    return sum / (abs(n.x) + abs(n.y) + abs(n.z));
#else
    return vec3(0.0);
#endif
}
