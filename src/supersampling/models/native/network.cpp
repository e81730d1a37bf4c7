// The network of DLCTUS (Swensen 2021, figure 5) on features x (rows, columns, 32), float32: a matrix product, and 3x3
// convolutions by Winograd's F(4x4, 3x3) (Lavin and Gray 2016), which needs a quarter of the multiplications. A strip of
// tiles is processed at a time so that transforms and products stay in a core's cache.

#include <vector>

#include "vectors.h"

namespace {

const int WIDTH = 32;

// R rows of (R, K) times (K, 32), in registers.
template <int R>
inline void product(const float* in, int step, const float* weights, int k, const float* start, float* out) {
    v16 sum[R][2];
    for (int r = 0; r < R; ++r)
        for (int h = 0; h < 2; ++h) sum[r][h] = start ? load(start + 16 * h) : v16{};
    for (int i = 0; i < k; ++i) {
        v16 w0 = load(weights + i * WIDTH), w1 = load(weights + i * WIDTH + 16);
        for (int r = 0; r < R; ++r) {
            float x = in[r * step + i];
            sum[r][0] += x * w0;
            sum[r][1] += x * w1;
        }
    }
    for (int r = 0; r < R; ++r)
        for (int h = 0; h < 2; ++h) store(out + r * WIDTH + 16 * h, sum[r][h]);
}

const int TILES = 12;  // 24 sums, two weights and a value fit in 32 registers

// Winograd's F(4x4, 3x3), Lavin and Gray 2016: one axis of the input transform, and of the output transform.
inline void to_points(const v16* d, int step, v16* out, int out_step) {
    v16 a = d[0], b = d[step], c = d[2 * step], e = d[3 * step], f = d[4 * step], g = d[5 * step];
    v16 even = f - 4.0f * c, odd = e - 4.0f * b, half = f - c, twice = 2.0f * (e - b);
    out[0] = 4.0f * a - 5.0f * c + f;
    out[out_step] = even + odd;
    out[2 * out_step] = even - odd;
    out[3 * out_step] = half + twice;
    out[4 * out_step] = half - twice;
    out[5 * out_step] = 4.0f * b - 5.0f * e + g;
}

inline void from_points(const v16* m, int step, v16* out, int out_step) {
    v16 s1 = m[step] + m[2 * step], d1 = m[step] - m[2 * step];
    v16 s2 = m[3 * step] + m[4 * step], d2 = m[3 * step] - m[4 * step];
    out[0] = m[0] + s1 + s2;
    out[out_step] = d1 + 2.0f * d2;
    out[2 * out_step] = s1 + 4.0f * s2;
    out[3 * out_step] = d1 + 8.0f * d2 + m[5 * step];
}

struct Image { const float* x; int height, width; };

void input_tile(Image in, int y, int x, float* points) {
    bool inner = y >= 1 && x >= 1 && y + 5 <= in.height && x + 5 <= in.width;
    for (int h = 0; h < 2; ++h) {
        v16 d[36], t[36];
        for (int i = 0; i < 6; ++i)
            for (int j = 0; j < 6; ++j) {
                int r = y - 1 + i, c = x - 1 + j;
                if (!inner) r = clamp(r, in.height), c = clamp(c, in.width);
                d[6 * i + j] = load(in.x + (size_t(r) * in.width + c) * WIDTH + 16 * h);
            }
        for (int j = 0; j < 6; ++j) to_points(d + j, 6, t + j, 6);
        for (int i = 0; i < 6; ++i) to_points(t + 6 * i, 1, d + 6 * i, 1);
        for (int p = 0; p < 36; ++p) store(points + size_t(p) * TILES * WIDTH + 16 * h, d[p]);
    }
}

void output_tile(const float* points, const float* bias, const float* residual, int y, int x, int height, int width,
                 float* out) {
    for (int h = 0; h < 2; ++h) {
        v16 m[36], t[24], r[16];
        for (int p = 0; p < 36; ++p) m[p] = load(points + size_t(p) * TILES * WIDTH + 16 * h);
        for (int j = 0; j < 6; ++j) from_points(m + j, 6, t + j, 6);
        for (int i = 0; i < 4; ++i) from_points(t + 6 * i, 1, r + 4 * i, 1);
        for (int i = 0; i < 4 && y + i < height; ++i)
            for (int j = 0; j < 4 && x + j < width; ++j) {
                size_t index = (size_t(y + i) * width + x + j) * WIDTH + 16 * h;
                v16 value = r[4 * i + j] + load(bias + 16 * h);
                if (residual) value += load(residual + index);
                else value = value < 0.0f ? v16{} : value;  // ReLU
                store(out + index, value);
            }
    }
}

}  // namespace

extern "C" {

// x (count, 32) <- blocks (count, k) times weights (k, 32), plus bias.
void ss_linear(const float* blocks, const float* weights, const float* bias, float* x, int count, int k, int threads) {
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads)
    for (int n = 0; n < (count + TILES - 1) / TILES; ++n) {
        int first = n * TILES, rows = std::min(TILES, count - first);
        const float* in = blocks + size_t(first) * k;
        float* out = x + size_t(first) * WIDTH;
        if (rows == TILES) product<TILES>(in, k, weights, k, bias, out);
        else for (int r = 0; r < rows; ++r) product<1>(in + size_t(r) * k, k, weights, k, bias, out + r * WIDTH);
    }
}

// out <- 3x3 convolution of x (height, width, 32), borders repeated; plus residual, or ReLU if that is null.
// points (36, 32, 32) is the transformed kernel. out may be residual, never x.
void ss_convolve(const float* x, const float* points, const float* bias, const float* residual, float* out, int height,
                 int width, int threads) {
    Image in{x, height, width};
    int down = (height + 3) / 4, across = (width + 3) / 4, groups = (across + TILES - 1) / TILES;
#pragma omp parallel num_threads(threads)
    {
        std::vector<float> before(36 * TILES * WIDTH), after(36 * TILES * WIDTH);
#pragma omp for schedule(dynamic, 4)
        for (int n = 0; n < down * groups; ++n) {
            int y = n / groups * 4, first = n % groups * TILES, tiles = std::min(TILES, across - first);
            for (int t = 0; t < tiles; ++t) input_tile(in, y, (first + t) * 4, &before[t * WIDTH]);
            for (int p = 0; p < 36; ++p)
                product<TILES>(&before[p * TILES * WIDTH], WIDTH, points + p * WIDTH * WIDTH, WIDTH, nullptr,
                               &after[p * TILES * WIDTH]);
            for (int t = 0; t < tiles; ++t)
                output_tile(&after[t * WIDTH], bias, residual, y, (first + t) * 4, height, width, out);
        }
    }
}

}  // extern "C"
