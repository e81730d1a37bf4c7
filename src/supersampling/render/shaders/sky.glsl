uniform vec4 sky_zenith;  // a: ambient
uniform vec3 sky_horizon;
uniform vec3 sky_ground;

vec3 sky(vec3 d) {
    float up = 1.0 - clamp(d.y, 0.0, 1.0), down = 1.0 - clamp(-d.y, 0.0, 1.0);
    float up2 = up * up, down4 = down * down * down * down;
    vec3 above = mix(sky_zenith.rgb, sky_horizon, up2 * up2);
    return mix(sky_ground, above, d.y >= 0.0 ? 1.0 : down4 * down4 * down4 * down4);
}

// Mean radiance of the hemisphere around a normal.
vec3 ambient(float up) { return mix(sky_ground, 0.5 * (sky_zenith.rgb + sky_horizon), 0.5 + 0.5 * up); }
