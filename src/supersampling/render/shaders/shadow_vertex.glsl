in vec3 in_position;
in vec2 in_uv;
in vec4 in_color;
in vec4 in_model_0;
in vec4 in_model_1;
in vec4 in_model_2;

uniform mat4 light;

#ifdef ALPHA_TEST
out vec2 uv;
out float opacity;
#endif

void main() {
    vec4 p = vec4(in_position, 1.0);
#ifdef ALPHA_TEST
    uv = in_uv;
    opacity = in_color.a;
#endif
    gl_Position = light * vec4(dot(in_model_0, p), dot(in_model_1, p), dot(in_model_2, p), 1.0);
}
