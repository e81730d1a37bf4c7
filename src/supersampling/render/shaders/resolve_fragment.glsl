// Box filter of samples x samples displayed values.
uniform sampler2D image;
uniform int samples;

layout(location = 0) out vec4 out_color;

void main() {
    ivec2 corner = ivec2(gl_FragCoord.xy) * samples;
    vec3 sum = vec3(0.0);
    for (int y = 0; y < samples; y++)
        for (int x = 0; x < samples; x++) sum += texelFetch(image, corner + ivec2(x, y), 0).rgb;
    out_color = vec4(sum / float(samples * samples), 1.0);
}
