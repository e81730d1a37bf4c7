// Metallic-roughness reflectance of NSRD (supplement, equations 1 to 10), times pi, because light colours are
// irradiance / pi: GGX distribution, Schlick's Fresnel and shadowing-masking, a Lambertian diffuse term.
const float MIN_ROUGHNESS = 0.08;  // a perfect mirror has no finite highlight of a point light

struct Surface {
    vec3 diffuse;  // (1 - m) c
    vec3 f0;
    float roughness;
    float metallic;
    vec3 normal;
    vec3 view;
    float n_dot_v;
};

vec3 reflected(Surface s, vec3 l) {
    float n_dot_l = dot(s.normal, l);
    if (n_dot_l <= 0.0) return vec3(0.0);
    vec3 sum = s.view + l;
    vec3 h = sum * inversesqrt(max(dot(sum, sum), 1e-8));  // view = -light: no half vector
    float n_dot_h = clamp(dot(s.normal, h), 0.0, 1.0);
    float v_dot_h = clamp(dot(s.view, h), 0.0, 1.0);
    float alpha = s.roughness * s.roughness;
    float alpha2 = alpha * alpha;
    float d = n_dot_h * n_dot_h * (alpha2 - 1.0) + 1.0;
    float distribution = alpha2 / max(d * d, 1e-10);  // equation 5; d is at least alpha2
    float k = (alpha + 1.0) * (alpha + 1.0) / 8.0;   // equation 10
    // G / (4 (n.l) (n.v)), equations 4, 8 and 9; k is at least 1/8.
    float visibility = 0.25 / ((n_dot_l * (1.0 - k) + k) * (s.n_dot_v * (1.0 - k) + k));
    float m = 1.0 - v_dot_h;
    float m2 = m * m;
    vec3 fresnel = s.f0 + (1.0 - s.f0) * (m2 * m2 * m);  // equation 6
    return (s.diffuse + distribution * visibility * fresnel) * n_dot_l;
}

uniform sampler2D brdf_table;  // A and B of equations 16 and 17 over n.v and roughness

// The specular term's integral over the hemisphere, equation 15.
vec3 specular_integral(Surface s) {
    vec2 ab = texture(brdf_table, vec2(s.n_dot_v, s.roughness)).rg;
    return s.f0 * ab.x + ab.y;
}
