// One buffer of the G-buffer as stored in data sets; EXTRACT is an expression of the surface.
uniform mat3 image_axes;  // world to the camera's axes: x right, y down, z towards the camera

layout(location = 0) out vec4 out_value;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec3 direction = normalize(pixel_ray());
    vec4 albedo = texelFetch(albedo_map, pixel, 0);
    vec4 emission = texelFetch(emission_map, pixel, 0);
    float solid = texelFetch(depth_map, pixel, 0).r < 1.0 ? 1.0 : 0.0;
    float lit = emission.a > 0.5 ? 0.0 : solid;  // receives light: neither sky nor interface
    Surface s = surface_at(pixel, direction);
    vec3 unlit = (emission.a > 0.5 || solid > 0.5 ? emission.rgb : sky(direction)) * exposure;
    vec3 value = EXTRACT;
    out_value = vec4(value, 1.0);
}
