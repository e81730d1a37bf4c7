// Narkowicz 2015, "ACES Filmic Tone Mapping Curve", then the sRGB curve.
vec3 displayed(vec3 radiance) {
    vec3 x = max(radiance, 0.0);
    x = clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
    return mix(12.92 * x, 1.055 * pow(max(x, 1e-6), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}
