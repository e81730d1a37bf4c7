in vec3 in_position;
in vec3 in_normal;
in vec2 in_uv;
in vec4 in_tangent;
in vec4 in_color;
in mat4 in_current;   // unjittered object-to-clip, this instant
in vec4 in_previous_x;  // rows of the unjittered object-to-clip matrix of the previous instant
in vec4 in_previous_y;
in vec4 in_previous_w;
in vec4 in_model_0;
in vec4 in_model_1;
in vec4 in_model_2;
in float in_object;

uniform vec2 jitter;  // of the sample, clip space

out vec2 uv;
#if defined(ALPHA_TEST) || defined(SHADE)
out vec4 color;
#endif
#ifdef SHADE
out vec3 normal;
#ifdef NORMAL_MAP
out vec4 tangent;
#endif
#endif
#ifdef MOTION
out vec3 current;
out vec3 previous;
#endif
#ifdef OBJECT
flat out float object;
#endif

void main() {
    vec4 clip = in_current * vec4(in_position, 1.0);
    uv = in_uv;
#if defined(ALPHA_TEST) || defined(SHADE)
    color = in_color;
#endif
#ifdef MOTION
    current = clip.xyw;
    vec4 p = vec4(in_position, 1.0);
    previous = vec3(dot(in_previous_x, p), dot(in_previous_y, p), dot(in_previous_w, p));
#endif
#ifdef OBJECT
    object = in_object;
#endif
#ifdef SHADE
    vec3 x = in_model_0.xyz, y = in_model_1.xyz, z = in_model_2.xyz;  // rows
    // Cofactors: correct under non-uniform scale; their sign is that of the determinant.
    mat3 cofactors = mat3(cross(y, z), cross(z, x), cross(x, y));  // columns are the cofactor matrix's rows
    float winding = sign(dot(x, cross(y, z)));
    normal = winding * (in_normal * cofactors);
#ifdef NORMAL_MAP
    tangent = vec4(dot(x, in_tangent.xyz), dot(y, in_tangent.xyz), dot(z, in_tangent.xyz), winding * in_tangent.w);
#endif
#endif
    gl_Position = vec4(clip.xy - jitter * clip.w, clip.zw);
}
