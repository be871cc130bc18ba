// Light that reaches a surface point, from the frame's lights and from the environment.

// Irradiance in W/m^2 of light i on a surface at p (world units) with unit normal n:
// E = I cos(theta) / r^2 inside the cone (Pharr, Jakob, Humphreys: PBR, 4th ed., 12.1-12.2),
// with a smoothstep over the cosine in the rim. A point light's cone is the whole sphere.
vec3 irradiance_from_light(int i, vec3 p, vec3 n) {
    vec3 l = light_position[i].xyz - p;
    float per_r = inversesqrt(dot(l, l));
    float cos_theta = max(dot(n, l) * per_r, 0.0);
    float cos_axis = -dot(light_direction[i].xyz, l) * per_r;
    float cos_rim = light_direction[i].w, cos_full = light_intensity[i].w;
    float rim = clamp((cos_axis - cos_rim) / (cos_full - cos_rim), 0.0, 1.0);
    return light_intensity[i].rgb * (cos_theta * per_r * per_r * (rim * rim * (3.0 - 2.0 * rim)));
}

// Irradiance over pi from the environment, the mean of six sky radiances weighted by
// max(0, +-n.axis). Each max leaves out the axis that faces away from the surface. Dividing by
// the weights' sum makes a uniform sky light every direction alike.
vec3 environment_radiance(vec3 n) {
    vec3 towards = max(n, 0.0), away = max(-n, 0.0);
    vec3 sum = towards.x * environment[0].rgb + away.x * environment[1].rgb
             + towards.y * environment[2].rgb + away.y * environment[3].rgb
             + towards.z * environment[4].rgb + away.z * environment[5].rgb;
    return sum / (abs(n.x) + abs(n.y) + abs(n.z));
}
