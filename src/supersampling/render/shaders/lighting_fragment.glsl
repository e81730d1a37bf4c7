uniform vec3 eye;
uniform vec2 depth_range;  // near, far - near

uniform vec3 sun_direction;
uniform vec3 sun_radiance;
layout(std140, binding = 1) uniform LightBlock {
    vec4 place[MAX_LIGHTS];      // position, radius
    vec4 intensity[MAX_LIGHTS];  // rgb, row of the shadow atlas: -1 unshadowed, + 0.5 where moving objects are near
    vec4 spot[MAX_LIGHTS];       // (direction * scale, offset): clamp(cos * scale + offset)^2 of the full light
} lights;
uniform int light_count;

layout(location = 0) out vec4 out_color;
#ifdef RADIANCE
layout(location = 1) out vec4 out_radiance;
#endif

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
        float cone = clamp(lights.spot[i].w - dot(lights.spot[i].xyz, to_light) * inversesqrt(square), 0.0, 1.0);
        float light = fade * fade / square * cone * cone;
        for (int k = 0; k < (row >= 0.0 ? 1 : 0); k++) light *= cube_tap(cubes, floor(row), radius, from_light);
        for (int k = 0; k < (fract(row) > 0.25 ? 1 : 0); k++)
            light *= cube_tap(moving_cubes, floor(row), radius, from_light);
        sum = reflected(s, to_light * inversesqrt(square)) * lights.intensity[i].rgb * light;
    }
    return sum;
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depth_map, pixel, 0).r;
    vec4 emission = texelFetch(emission_map, pixel, 0);
    vec3 ray = pixel_ray();
    float ray_length = length(ray);
    vec3 direction = ray / ray_length;
    vec3 radiance = sky(direction);
    for (int once = 0; once < (depth < 1.0 && emission.a < 0.5 ? 1 : 0); once++) {
        float view_depth = depth_range.x + depth * depth_range.y;
        vec3 position = eye + view_depth * ray;
        Surface s = surface_at(pixel, direction);

        vec3 mirror = reflect(direction, s.normal);
        vec3 glossy = mix(sky(mirror), ambient(mirror.y), s.roughness);
        radiance = (s.diffuse * ambient(s.normal.y) + specular_integral(s) * glossy) * sky_zenith.a;
        radiance += emission.rgb;
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
    radiance = (emission.a > 0.5 ? emission.rgb : radiance) * exposure;
    out_color = vec4(displayed(radiance), 1.0);
#ifdef RADIANCE
    out_radiance = vec4(radiance, 1.0);
#endif
}
