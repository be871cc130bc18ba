// What a whole frame shares; gpu/blocks.py is the other half and names the units.
#define MAX_LIGHTS 8
#define MAX_SHADOWS 4

layout(std140) uniform Frame {
    mat4 clip_from_world;
    mat4 direction_from_clip;
    mat4 shadow_from_world[MAX_SHADOWS];  // world units to [0,1]^3 of the shadow atlas
    vec4 light_position[MAX_LIGHTS];      // world units; w: units per unit of distance that a
                                          // receiver is moved along its normal for the shadow map
    vec4 light_direction[MAX_LIGHTS];     // unit, away from the light; w: cosine of the rim
    vec4 light_intensity[MAX_LIGHTS];     // W/sr, per square metre in a square unit; w: cosine of
                                          // the angle up to which the intensity is full
    vec4 environment[6];                  // W/(m^2 sr) from +X -X +Y -Y +Z -Z
    vec4 tint;                            // rgb: albedo where there is no texture;
                                          // w: radiance of a self-lit texel of value 1
    vec4 output_scale;                    // x: what outputs are multiplied by: exposure, if displayed
    vec4 sky_scale;                       // x: radiance of a sky texel of value 1
};

const float PI = 3.14159265358979;
