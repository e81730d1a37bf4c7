uniform sampler2D depth_map;
uniform sampler2D albedo_map;    // linear albedo, roughness
uniform sampler2D normal_map;    // world normal, metallic
uniform sampler2D emission_map;

uniform mat3 rays;       // (x, y, 1) of clip space to the ray of unit view depth
uniform vec3 eye;
uniform vec2 size;
uniform vec2 jitter;
uniform vec2 depth_range;  // near, far - near
uniform float exposure;

uniform vec3 sun_direction;
uniform vec3 sun_radiance;
uniform vec4 sky_zenith;  // a: ambient
uniform vec3 sky_horizon;
uniform vec3 sky_ground;

layout(std140, binding = 1) uniform LightBlock {
    vec4 place[MAX_LIGHTS];      // position, radius
    vec4 intensity[MAX_LIGHTS];  // rgb, row of the shadow atlas: -1 unshadowed, + 0.5 where moving objects are near
} lights;
uniform int light_count;

layout(location = 0) out vec4 out_color;

vec3 sky(vec3 d) {
    float up = 1.0 - clamp(d.y, 0.0, 1.0), down = 1.0 - clamp(-d.y, 0.0, 1.0);
    float up2 = up * up, down4 = down * down * down * down;
    vec3 above = mix(sky_zenith.rgb, sky_horizon, up2 * up2);
    return mix(sky_ground, above, d.y >= 0.0 ? 1.0 : down4 * down4 * down4 * down4);
}

// Mean radiance of the hemisphere around a normal.
vec3 ambient(float up) { return mix(sky_ground, 0.5 * (sky_zenith.rgb + sky_horizon), 0.5 + 0.5 * up); }

vec3 point_light(int i, Surface s, vec3 position, vec3 offset) {
    vec3 to_light = lights.place[i].xyz - position;
    float radius = lights.place[i].w;
    float square = max(dot(to_light, to_light), 1e-4);  // a point on the light itself
    float ratio = square / (radius * radius);
    float fade = clamp(1.0 - ratio * ratio, 0.0, 1.0);
    vec3 sum = vec3(0.0);
    for (int once = 0; once < (fade > 0.0 && dot(to_light, s.normal) > 0.0 ? 1 : 0); once++) {
        float row = lights.intensity[i].w;
        vec3 from_light = offset * sqrt(square) - to_light;
        float light = fade * fade / square;
        for (int k = 0; k < (row >= 0.0 ? 1 : 0); k++) light *= cube_tap(cubes, floor(row), radius, from_light);
        for (int k = 0; k < (fract(row) > 0.25 ? 1 : 0); k++) light *= cube_tap(moving_cubes, floor(row), radius, from_light);
        sum = reflected(s, to_light * inversesqrt(square)) * lights.intensity[i].rgb * light;
    }
    return sum;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depth_map, pixel, 0).r;
    vec3 ray = rays * vec3(2.0 * gl_FragCoord.xy / size - 1.0 + jitter, 1.0);
    float ray_length = length(ray);
    vec3 direction = ray / ray_length;
    vec3 radiance = sky(direction);
    for (int once = 0; once < (depth < 1.0 ? 1 : 0); once++) {
        float view_depth = depth_range.x + depth * depth_range.y;
        vec3 position = eye + view_depth * ray;
        vec4 albedo = texelFetch(albedo_map, pixel, 0);
        vec4 normal = texelFetch(normal_map, pixel, 0);
        Surface s;
        s.normal = normalize(normal.xyz);
        s.view = -direction;
        s.n_dot_v = clamp(dot(s.normal, s.view), 1e-3, 1.0);
        s.roughness = max(albedo.a, MIN_ROUGHNESS);
        s.diffuse = albedo.rgb * (1.0 - normal.w);
        s.f0 = mix(vec3(0.04), albedo.rgb, normal.w);

        vec3 mirror = reflect(direction, s.normal);
        vec3 glossy = mix(sky(mirror), ambient(mirror.y), s.roughness);
        radiance = (s.diffuse * ambient(s.normal.y) + environment_reflectance(s) * glossy) * sky_zenith.a;
        radiance += texelFetch(emission_map, pixel, 0).rgb;
#ifdef SUN
        vec3 sun = vec3(0.0);
        for (int k = 0; k < (dot(s.normal, sun_direction) > 0.0 ? 1 : 0); k++)
            sun = reflected(s, sun_direction) * sun_light(position, s.normal, view_depth * ray_length);
        radiance += sun * sun_radiance;
#endif
        // Metres that a texel of a cube's face spans, per metre from the light.
        vec3 offset = s.normal * CUBE_OFFSET;
        for (int i = 0; i < light_count; i++) radiance += point_light(i, s, position, offset);
    }
    out_color = vec4(displayed(radiance * exposure), 1.0);
}
