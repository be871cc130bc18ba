// Where a vertex is and which way it faces, in world space. The level's vertices are there already;
// with POSED, a figure's are between two of its key poses, placed by its instance.
#ifdef POSED
uniform sampler2D key_poses;   // two texels a vertex, frame after frame: position, unit normal
in mat3x4 in_world_from_part;  // its columns are the matrix's rows
in vec4 in_pose;               // first vertex of the pose before, of the one behind, blend

vec3 key_texel(float first_vertex, int which) {
    int k = 2 * (int(first_vertex) + gl_VertexID) + which;
    return texelFetch(key_poses, ivec2(k & ((1 << POSE_ROW_BITS) - 1), k >> POSE_ROW_BITS), 0).xyz;
}

vec3 between_keys(int which) {
    return mix(key_texel(in_pose.x, which), key_texel(in_pose.y, which), in_pose.z);
}

vec4 vertex_in_world() {
    return vec4(vec4(between_keys(0), 1.0) * in_world_from_part, 1.0);
}

vec3 normal_in_world() {
    vec3 n = vec4(between_keys(1), 0.0) * in_world_from_part;
    return n * inversesqrt(max(dot(n, n), 1e-12));  // none, where it turns round half-way
}
#else
in vec3 in_position;
in vec3 in_normal;

vec4 vertex_in_world() {
    return vec4(in_position, 1.0);
}

vec3 normal_in_world() {
    return in_normal;
}
#endif
