// Contents of the G-buffer at a pixel.
uniform sampler2D depth_map;
uniform sampler2D albedo_map;    // linear albedo, roughness
uniform sampler2D normal_map;    // world normal, metallic
uniform sampler2D emission_map;  // linear radiance; a = 1: an element of the interface, which only emits

uniform mat3 rays;  // (x, y, 1) of clip space to the ray of unit view depth
uniform vec2 size;
uniform vec2 jitter;
uniform float exposure;

vec3 pixel_ray() { return rays * vec3(2.0 * gl_FragCoord.xy / size - 1.0 + jitter, 1.0); }

Surface surface_at(ivec2 pixel, vec3 direction) {
    vec4 albedo = texelFetch(albedo_map, pixel, 0);
    vec4 normal = texelFetch(normal_map, pixel, 0);
    Surface s;
    s.normal = normalize(normal.xyz);
    s.view = -direction;
    s.n_dot_v = clamp(dot(s.normal, s.view), 1e-3, 1.0);
    s.roughness = max(albedo.a, MIN_ROUGHNESS);
    s.metallic = normal.w;
    s.diffuse = albedo.rgb * (1.0 - normal.w);
    s.f0 = mix(vec3(0.04), albedo.rgb, normal.w);  // equation 7
    return s;
}
