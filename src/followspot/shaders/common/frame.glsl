// What a whole frame shares; gpu/blocks.py is the other half.
#define MAX_LIGHTS 8
#define MAX_SHADOWS 4
#define MAX_FOGS 8

layout(std140) uniform Frame {
    mat4 clip_from_world;
    mat4 direction_from_clip;             // clip x, y to the world direction of a pixel
    mat4 shadow_from_world[MAX_SHADOWS];  // world units to a light's wide tile in [0,1]^3
    vec4 near_from_wide[MAX_SHADOWS];     // from there to its near tile: scale, shift by w
    vec4 offset_right[MAX_SHADOWS];       // the light's right; w: atlas units that a receiver is
                                          // moved along it, by its normal, at a distance of one
    vec4 offset_up[MAX_SHADOWS];          // likewise upwards
    vec4 light_position[MAX_LIGHTS];      // world units; w: depth that a receiver is moved by
    vec4 light_axis[MAX_LIGHTS];          // towards the light over the rim's width; w: its offset
    vec4 light_radiance[MAX_LIGHTS];      // rgb: W/(m^2 sr) of a white surface at one unit
    vec4 output_scale;                    // x: what outputs are multiplied by: exposure, if displayed;
                                          // y: what self-lit texels are
    vec4 sky_scale;                       // x: radiance of a sky texel of value 1
    vec4 eye_position;                    // world units
    vec4 fog_mins[MAX_FOGS];              // corners of boxes of fog, from the eye, world units
    vec4 fog_maxs[MAX_FOGS];
    vec4 fog_glow[MAX_FOGS];              // a: extinction per unit; rgb: the same times the radiance
                                          // of what is nothing but fog, times the output scale
};
