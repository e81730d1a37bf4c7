// Metallic-roughness reflectance: GGX distribution, height-correlated Smith visibility, Schlick's Fresnel
// (Walter et al. 2007; Heitz 2014; Schlick 1994), times pi, because light colours are irradiance / pi.
const float PI = 3.14159265;
const float MIN_ROUGHNESS = 0.08;  // a mirror of a point-like light has no finite highlight

struct Surface {
    vec3 diffuse;
    vec3 f0;
    float roughness;
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
    float a = s.roughness * s.roughness;
    float a2 = a * a;
    float d = n_dot_h * n_dot_h * (a2 - 1.0) + 1.0;
    float distribution = a2 / max(d * d, 1e-8);
    float visibility = 0.5 / max(n_dot_l * sqrt(s.n_dot_v * s.n_dot_v * (1.0 - a2) + a2) +
                                 s.n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2), 1e-4);
    float m = 1.0 - v_dot_h;
    float m2 = m * m;
    vec3 fresnel = s.f0 + (1.0 - s.f0) * (m2 * m2 * m);
    return (s.diffuse * (1.0 - fresnel) + distribution * visibility * fresnel) * n_dot_l;
}

// Karis 2014, "Physically Based Shading on Mobile": the split-sum table as a polynomial.
vec3 environment_reflectance(Surface s) {
    vec4 r = s.roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a004 = min(r.x * r.x, exp2(-9.28 * s.n_dot_v)) * r.x + r.y;
    vec2 ab = vec2(-1.04, 1.04) * a004 + r.zw;
    return s.f0 * ab.x + ab.y;
}
