#version 330 core
#include "common/frame.glsl"
#include "common/srgb.glsl"
#ifdef CLOUDS
#include "common/clouds.glsl"
#endif
#if FOGS > 0
#include "common/fog.glsl"
#endif

uniform samplerCube sky;  // linear light

const float FOREVER = 1e9;

in vec3 direction;
out vec4 value;

void main() {
#ifdef NO_BOX
    value.rgb = vec3(0.0);
#else
    value.rgb = texture(sky, direction).rgb;
#endif
#ifdef CLOUDS
    value.rgb = with_clouds(direction, value.rgb);
#endif
    value.rgb *= sky_scale.x * output_scale.x;
#if FOGS > 0
    vec4 fog = fog_along(direction, FOREVER);
    value.rgb = mix(glow_of_fog(fog), value.rgb, through_fog(fog));
#endif
#ifdef ENCODED
    value.rgb = srgb_from_linear(value.rgb);
#endif
    value.a = 0.0;  // no surface
}
