// The G-buffer of the sky: directions at infinity move only with the camera's rotation.
uniform mat3 homography;  // current (x, y, 1) to previous (x, y, w)
uniform vec2 size;
uniform vec2 jitter;

layout(location = 0) out float out_depth;
#ifdef SHADE
layout(location = AT_ALBEDO) out vec4 out_albedo;
layout(location = AT_NORMAL) out vec4 out_normal;
layout(location = AT_EMISSION) out vec4 out_emission;
#endif
#ifdef MOTION
layout(location = AT_MOTION) out vec4 out_motion;
#endif
#ifdef OBJECT
layout(location = AT_OBJECT) out float out_object;
#endif

const float INFINITE = 1e30;  // metres

void main() {
    out_depth = 1.0;
#ifdef SHADE
    out_albedo = vec4(0.0);
    out_normal = vec4(0.0, 0.0, 1.0, 0.0);
    out_emission = vec4(0.0);
#endif
#ifdef MOTION
    vec2 here = 2.0 * gl_FragCoord.xy / size - 1.0 + jitter;
    vec3 there = homography * vec3(here, 1.0);
    out_motion = vec4(0.5 * (there.xy / max(there.z, 1e-4) - here), INFINITE, 1.0);
#endif
#ifdef OBJECT
    out_object = 0.0;
#endif
}
