// Light that reaches a point, from shadow maps. Loops that run at most once replace `if`: a software rasteriser
// evaluates both sides of an `if`, but skips a loop that no pixel enters.
uniform sampler2DShadow sun_near;    // static geometry around the camera
uniform sampler2DShadow sun_far;     // static geometry of the whole scene
uniform sampler2DShadow sun_moving;  // moving objects, near region
uniform mat4 sun_near_matrix;
uniform mat4 sun_far_matrix;
uniform vec2 sun_texel;              // metres per texel: near, far
uniform vec3 sun_blend;              // eye distance where near begins to fade, 1 / width of the fade, moving casters

// Four bilinear taps: a tent about three texels wide.
float filtered(sampler2DShadow map, vec3 p) {
    vec2 t = 0.75 / vec2(textureSize(map, 0));
    return 0.25 * (texture(map, p + vec3(-t.x, -t.y, 0.0)) + texture(map, p + vec3(t.x, -t.y, 0.0)) +
                   texture(map, p + vec3(-t.x, t.y, 0.0)) + texture(map, p + vec3(t.x, t.y, 0.0)));
}

bool covered(vec3 p) { return all(greaterThan(p.xy, vec2(0.001))) && all(lessThan(p.xy, vec2(0.999))) && p.z < 1.0; }

float sun_light(vec3 position, vec3 normal, float eye_distance) {
    float far_weight = clamp((eye_distance - sun_blend.x) * sun_blend.y, 0.0, 1.0);
    float near_light = 1.0, far_light = 1.0;
    vec3 p = (sun_near_matrix * vec4(position + normal * sun_texel.x * 1.5, 1.0)).xyz;
    for (int once = 0; once < (far_weight < 1.0 && covered(p) ? 1 : 0); once++) near_light = filtered(sun_near, p);
    for (int once = 0; once < (far_weight < 1.0 && sun_blend.z > 0.5 && covered(p) ? 1 : 0); once++)
        near_light *= filtered(sun_moving, p);
    for (int once = 0; once < (far_weight > 0.0 ? 1 : 0); once++) {
        vec3 q = (sun_far_matrix * vec4(position + normal * sun_texel.y * 1.5, 1.0)).xyz;
        if (covered(q)) far_light = filtered(sun_far, q);
    }
    return mix(near_light, far_light, far_weight);
}

uniform sampler2DShadow cubes;         // six tiles per row, one row per light; static geometry
uniform sampler2DShadow moving_cubes;  // the same for moving objects
uniform mat3 cube_faces[6];            // world to face: right, up, forward
uniform vec2 cube_tile;                // half extent of a face on its tile (the rest is filter margin), near plane

float cube_tap(sampler2DShadow map, float row, float radius, vec3 from_light) {
    vec3 a = abs(from_light);
    int face = a.x >= a.y && a.x >= a.z ? (from_light.x > 0.0 ? 0 : 1)
             : a.y >= a.z               ? (from_light.y > 0.0 ? 2 : 3)
                                        : (from_light.z > 0.0 ? 4 : 5);
    vec3 local = cube_faces[face] * from_light;
    float depth = max(local.z, cube_tile.y);
    vec2 ndc = local.xy / depth * cube_tile.x;
    float z = 0.5 + 0.5 * (radius + cube_tile.y - 2.0 * radius * cube_tile.y / depth) / (radius - cube_tile.y);
    vec2 rows = vec2(6.0, float(textureSize(map, 0).y * 6 / textureSize(map, 0).x));
    return filtered(map, vec3((vec2(float(face), row) + 0.5 + 0.5 * ndc) / rows, z));
}
