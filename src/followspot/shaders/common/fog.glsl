// Fog between the eye and what is seen, scene/fog.py: boxes of one density each.

//
// A loop of a length known to the compiler: software rasterisers take ten times as long to look
// into a uniform block by a number that is not.

// How much fog there is along a ray from the eye, up to `reach` times its length: a: optical depth;
// rgb: the same weighted by the radiance of what is nothing but fog, times the output scale. The way
// through a box is found by its slabs (Kay and Kajiya 1986).
vec4 fog_along(vec3 ray, float reach) {
    vec3 per_ray = 1.0 / ray;
    vec4 depth = vec4(0.0);
    for (int i = 0; i < FOGS; ++i) {
        vec3 to_mins = fog_mins[i].xyz * per_ray, to_maxs = fog_maxs[i].xyz * per_ray;
        vec3 enters = min(to_mins, to_maxs), leaves = max(to_mins, to_maxs);
        float start = max(max(enters.x, enters.y), max(enters.z, 0.0));
        float end = min(min(leaves.x, leaves.y), min(leaves.z, reach));
        depth += fog_glow[i] * max(end - start, 0.0);
    }
    return depth * length(ray);
}

// Share of the light from behind that comes through, by Beer and Lambert.
float through_fog(vec4 depth) {
    return exp(-depth.a);
}

// Radiance where nothing is seen but fog: that of the boxes on the way by how much they hold back,
// in whatever order. Boxes of two colours seldom lie behind each other.
vec3 glow_of_fog(vec4 depth) {
    return depth.rgb / max(depth.a, 1e-6);
}
