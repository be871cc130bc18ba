// Where images are looked up at the frame's time: what a script's tcMods have made of a vertex'
// coordinates. scene/motion.py puts the matrices together.
in vec2 in_texcoord;

#if defined(MIRRORS) || defined(LAYER_MIRRORS)
// `tcGen environment`: by the way that a ray from the eye leaves a mirror, in the model's axes.
vec2 mirrored() {
    vec3 n = normal_in_world();
    vec3 to_eye = normalize(eye_position.xyz - vertex_in_world().xyz);
    vec3 away = in_axes_of_object(2.0 * dot(n, to_eye) * n - to_eye);
    return vec2(0.5, 0.5) + vec2(0.5, -0.5) * away.yz;
}
#endif

// Where images are looked up before anything moves them.
vec2 base_rest() {
#ifdef MIRRORS
    return mirrored();
#else
    return in_texcoord;
#endif
}

#ifdef LAYER_APART
vec2 layer_rest() {
#ifdef LAYER_MIRRORS
    return mirrored();
#else
    return in_texcoord;
#endif
}
#endif

#ifdef MOVES
uniform mat3x2 base_moved;   // of s, t and 1
#endif
#ifdef SWAYS
uniform mat4x2 base_swayed;  // of `turbulence`
#endif
#ifdef LAYER_MOVES
uniform mat3x2 layer_moved;
#endif
#ifdef LAYER_SWAYS
uniform mat4x2 layer_swayed;
#endif

#if defined(SWAYS) || defined(LAYER_SWAYS)
// Waves of 1024 units along x + z and y.
vec4 turbulence() {
    vec3 p = vertex_in_object();
    vec2 angle = vec2(p.x + p.z, p.y) * (6.283185307 / 1024.0);
    return vec4(sin(angle), cos(angle));
}
#endif

vec2 base_texcoord() {
#ifdef SWAYS
    return base_moved * vec3(base_rest(), 1.0) + base_swayed * turbulence();
#elif defined(MOVES)
    return base_moved * vec3(base_rest(), 1.0);
#else
    return base_rest();
#endif
}

#ifdef LAYER_APART
vec2 layer_texcoord_of_its_own() {
#ifdef LAYER_SWAYS
    return layer_moved * vec3(layer_rest(), 1.0) + layer_swayed * turbulence();
#elif defined(LAYER_MOVES)
    return layer_moved * vec3(layer_rest(), 1.0);
#else
    return layer_rest();
#endif
}
#endif
