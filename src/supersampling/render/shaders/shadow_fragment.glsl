#ifdef ALPHA_TEST
layout(std140, binding = 0) uniform MaterialBlock {
    vec4 base_color;
    vec4 emission;
    vec4 factors;
} material;

uniform sampler2D albedo_map;

in vec2 uv;
in float opacity;

void main() {
    if (texture(albedo_map, uv).a * opacity < material.factors.z) discard;
}
#else
void main() {}
#endif
