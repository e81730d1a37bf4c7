// Motion and depth of the sky: directions at infinity move with the camera's rotation alone.
uniform mat3 homography;  // current (x, y, 1) to previous (x, y, w)
uniform vec2 size;
uniform vec2 jitter;

layout(location = 0) out float out_depth;
#ifdef SHADE
layout(location = 4) out vec2 out_motion;
#else
layout(location = 1) out vec2 out_motion;
#endif

void main() {
    vec2 here = 2.0 * gl_FragCoord.xy / size - 1.0 + jitter;
    vec3 there = homography * vec3(here, 1.0);
    out_depth = 1.0;
    out_motion = 0.5 * (there.xy / max(there.z, 1e-4) - here);
}
