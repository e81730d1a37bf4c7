layout(std140, binding = 0) uniform MaterialBlock {
    vec4 base_color;  // a: the colours of a mesh multiply the emission
    vec4 emission;    // a: double sided
    vec4 factors;     // roughness, metallic, alpha cutoff, interface
} material;

uniform sampler2D albedo_map;
uniform sampler2D normal_map;
uniform sampler2D surface_map;
uniform sampler2D glow_map;
uniform float mip_bias;
uniform vec2 depth_range;  // near, 1 / (far - near)

in vec2 uv;
#if defined(ALPHA_TEST) || defined(SHADE)
in vec4 color;
#endif
#ifdef SHADE
in vec3 normal;
#ifdef NORMAL_MAP
in vec4 tangent;
#endif
#endif
#ifdef MOTION
in vec3 current;
in vec3 previous;
#endif
#ifdef OBJECT
flat in float object;
#endif

layout(location = 0) out float out_depth;
#ifdef SHADE
layout(location = AT_ALBEDO) out vec4 out_albedo;      // linear albedo, roughness
layout(location = AT_NORMAL) out vec4 out_normal;      // world normal, metallic
layout(location = AT_EMISSION) out vec4 out_emission;  // linear radiance; a = 1: an element of the interface
#endif
#ifdef MOTION
layout(location = AT_MOTION) out vec4 out_motion;  // motion, the previous view depth in metres
#endif
#ifdef OBJECT
layout(location = AT_OBJECT) out float out_object;
#endif

void main() {
#if defined(ALPHA_TEST) || defined(SHADE)
    vec4 albedo = texture(albedo_map, uv, mip_bias);
#endif
#ifdef ALPHA_TEST
    if (albedo.a * color.a < material.factors.z) discard;
#endif
    out_depth = (1.0 / gl_FragCoord.w - depth_range.x) * depth_range.y;
#ifdef MOTION
    // A point behind the previous camera has no position in its image: use a far-away position.
    vec2 moved = 0.5 * (previous.xy / max(previous.z, 1e-4) - current.xy / current.z);
    out_motion = vec4(moved, previous.z, 1.0);
#endif
#ifdef OBJECT
    out_object = object;
#endif
#ifdef SHADE
    vec3 surface = vec3(1.0);
#ifdef SURFACE_MAP
    surface = texture(surface_map, uv, mip_bias).rgb;
#endif
    vec3 n = normalize(normal);
#ifdef NORMAL_MAP
    vec3 t = tangent.xyz - n * dot(n, tangent.xyz);
    float length_t = length(t);
    if (length_t > 1e-6) {
        t /= length_t;
        vec3 texel = texture(normal_map, uv, mip_bias).xyz * 2.0 - 1.0;
        vec3 mapped = texel.x * t + texel.y * tangent.w * cross(n, t) + texel.z * n;
        n = dot(mapped, mapped) > 1e-8 ? normalize(mapped) : n;
    }
#endif
    if (material.emission.a > 0.5 && !gl_FrontFacing) n = -n;
    vec3 base = albedo.rgb * color.rgb * material.base_color.rgb;
    out_albedo = vec4(base, clamp(surface.r * material.factors.x, 0.0, 1.0));
    out_normal = vec4(n, clamp(surface.g * material.factors.y, 0.0, 1.0));
#ifdef GLOW_MAP
    vec3 emission = material.emission.rgb * texture(glow_map, uv, mip_bias).rgb;
#else
    vec3 emission = material.emission.rgb * albedo.rgb * surface.b;
#endif
    emission *= mix(vec3(1.0), color.rgb, material.base_color.a);
    out_emission = vec4(emission, material.factors.w);
#endif
}
