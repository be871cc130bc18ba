// Where a vertex is drawn that rests somewhere else; scene/deform.py has its numbers.
#ifdef DISPLACED
uniform vec3 displaced;  // units
#endif
#ifdef SWELLS
uniform vec4 swell;      // base and amplitude in units, phase in periods, periods a unit
#endif
#ifdef SPRITE
in vec4 in_pivot;        // the place that it turns about; w: units from there, 0 for what does not
in vec3 in_axis;         // none: it keeps to the picture's plane

// A camera axis, told by a row of the matrix.
vec3 camera_axis(int row) {
    return normalize(vec3(clip_from_world[0][row], clip_from_world[1][row], clip_from_world[2][row]));
}

vec3 turned(vec3 rest) {
    if (in_pivot.w == 0.0) return rest;
    vec2 corner = vec2(2.0, -2.0) * in_texcoord + vec2(-1.0, 1.0);
    vec3 away = dot(in_axis, in_axis) == 0.0
              ? camera_axis(0) * corner.x + camera_axis(1) * corner.y
              : normalize(cross(camera_axis(3), in_axis));
    return in_pivot.xyz + in_pivot.w * away;
}
#endif

vec3 drawn_at(vec3 rest) {
    vec3 p = rest;
#ifdef SPRITE
    p = turned(p);
#endif
#ifdef SWELLS
    float periods = swell.z + swell.w * (rest.x + rest.y + rest.z);
    p += normal_in_world() * (swell.x + swell.y * sin(6.283185307 * periods));
#endif
#ifdef DISPLACED
    p += displaced;
#endif
    return p;
}
