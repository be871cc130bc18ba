// Where a vertex is and which way it faces, in world space. The level's vertices are there already;
// with POSED, a figure's are between two of its key poses, placed by its instance.
#ifdef POSED
uniform sampler2D key_poses;  // two texels a vertex, part after part, of each frame after frame:
                              // position, unit normal

// Of the instance, by part. Matrices' columns are their rows. A pose has the first vertex of the key
// pose before, that of the one behind, and their blend.
in mat3x4 in_world_from_lower, in_world_from_upper, in_world_from_head;
in vec4 in_lower_pose, in_upper_pose, in_head_pose;
in ivec2 in_vertex;  // part: 0 lower, 1 upper, 2 head; number as in that part's first key pose

mat3x4 world_from_part() {
    return in_vertex.x == 0 ? in_world_from_lower
         : in_vertex.x == 1 ? in_world_from_upper
         : in_world_from_head;
}

vec3 key_texel(float first_vertex, int which) {
    int k = 2 * (int(first_vertex) + in_vertex.y) + which;
    return texelFetch(key_poses, ivec2(k & ((1 << POSE_ROW_BITS) - 1), k >> POSE_ROW_BITS), 0).xyz;
}

vec3 between_keys(int which) {
    vec4 pose = in_vertex.x == 0 ? in_lower_pose : in_vertex.x == 1 ? in_upper_pose : in_head_pose;
    return mix(key_texel(pose.x, which), key_texel(pose.y, which), pose.z);
}

vec3 vertex_in_object() {
    return between_keys(0);
}

vec4 vertex_in_world() {
    return vec4(vec4(vertex_in_object(), 1.0) * world_from_part(), 1.0);
}

vec3 normal_in_world() {
    vec3 n = vec4(between_keys(1), 0.0) * world_from_part();
    return n * inversesqrt(max(dot(n, n), 1e-12));  // none, where it turns round half-way
}

// A unit vector in the axes of its part, which is turned and scaled alike in all directions.
vec3 in_axes_of_object(vec3 world) {
    return normalize((world_from_part() * world).xyz);
}
#else
in vec3 in_position;
in vec3 in_normal;

vec3 vertex_in_object() {
    return in_position;
}

vec4 vertex_in_world() {
    return vec4(in_position, 1.0);
}

vec3 normal_in_world() {
    return in_normal;
}

vec3 in_axes_of_object(vec3 world) {
    return world;
}
#endif
