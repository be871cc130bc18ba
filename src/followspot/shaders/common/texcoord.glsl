// Where images are looked up at the frame's time: what a script's tcMods have made of a vertex'
// coordinates. scene/motion.py puts the matrices together.
in vec2 in_texcoord;
#ifdef MOVES
uniform mat3x2 base_moved;   // of s, t and 1
#endif
#ifdef SWAYS
uniform mat4x2 base_swayed;  // of `turbulence`
#endif
#ifdef LAYER_APART
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
    return base_moved * vec3(in_texcoord, 1.0) + base_swayed * turbulence();
#elif defined(MOVES)
    return base_moved * vec3(in_texcoord, 1.0);
#else
    return in_texcoord;
#endif
}

#ifdef LAYER_APART
vec2 layer_texcoord_of_its_own() {
#ifdef LAYER_SWAYS
    return layer_moved * vec3(in_texcoord, 1.0) + layer_swayed * turbulence();
#else
    return layer_moved * vec3(in_texcoord, 1.0);
#endif
}
#endif
