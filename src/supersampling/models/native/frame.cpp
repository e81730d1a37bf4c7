// The steps of a DLCTUS frame (Swensen 2021, 4.1) before and after its network, one pass over rows of blocks each.
//
// A block is 4x4 target pixels, the stride of the network's first convolution. Layouts, all float32:
//   state   (H, W, 4)          the history, channels last: a pixel is one vector, four neighbours one cache line
//   blocks  (H/4, W/4, K)      reprojected history by position in the block and channel (64), then the block's samples
//   x       (H/4, W/4, 32)     the network's features
// Low-resolution buffers are planes.

#include <cmath>
#ifdef __linux__
#include <sys/mman.h>
#endif
#include <vector>

#include "vectors.h"

namespace {

const int SIDE = 4, WIDTH = 32;
enum { MOVED, STILL, ALIGNED };  // source of a pixel's history

// Two neighbours on one axis and the weight of the second, for every target position.
struct Axis {
    std::vector<int> low, high;
    std::vector<float> weight;
    // Target position j reads the low-resolution axis at (j + 0.5) / scale - shift; borders are repeated.
    Axis(int size, int scale, double shift) : low(size * scale), high(size * scale), weight(size * scale) {
        for (int j = 0; j < size * scale; ++j) {
            double position = (j + 0.5) / scale - shift - 0.5;
            position = position > 0.0 ? std::min(position, size - 1.0) : 0.0;  // NaN becomes 0
            low[j] = int(position);
            high[j] = std::min(low[j] + 1, size - 1);
            weight[j] = float(position - low[j]);
        }
    }
};

// Not a + weight * (b - a), which is NaN between two infinite motions.
inline float mix(float a, float b, float weight) {
    return weight == 0.0f ? a : (1.0f - weight) * a + weight * b;
}

struct Planes {
    const float* data;
    int count, height, width;
    // Interpolates between two rows: value c of position x goes to x * stride + c * step.
    void row(int y0, int y1, float weight, float* out, int stride, int step = 1) const {
        for (int c = 0; c < count; ++c) {
            const float *a = data + (size_t(c) * height + y0) * width, *b = data + (size_t(c) * height + y1) * width;
            for (int x = 0; x < width; ++x) out[x * stride + c * step] = mix(a[x], b[x], weight);
        }
    }
};

inline v4 interpolate(const float* row, const Axis& axis, int j) {
    v4 l = load4(row + 4 * axis.low[j]), r = load4(row + 4 * axis.high[j]);
    return l + axis.weight[j] * (r - l);
}

// Cubic convolution's four weights as polynomials of the fraction t: exactly 0, 1, 0, 0 where it is 0.
struct Cubic {
    v4 c3, c2, c1;
    v16 d3, d2, d1;
    explicit Cubic(float a) : c3{a, a + 2, -a - 2, -a}, c2{-2 * a, -a - 3, 2 * a + 3, a}, c1{a, 0, -a, 0} {
        d3 = spread(c3), d2 = spread(c2), d1 = spread(c1);
    }
    static v16 spread(v4 w) { return __builtin_shufflevector(w, w, 0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3); }
    v4 weights(float t) const { return ((c3 * t + c2) * t + c1) * t + v4{0, 1, 0, 0}; }
    // Every weight four times.
    v16 lanes(float t) const {
        return ((d3 * t + d2) * t + d1) * t + v16{0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0};
    }
};

// The sum of the four quarters.
inline v4 sum_quarters(v16 x) {
    typedef float v8 __attribute__((vector_size(32)));
    v8 low = __builtin_shufflevector(x, x, 0, 1, 2, 3, 4, 5, 6, 7);
    v8 half = low + __builtin_shufflevector(x, x, 8, 9, 10, 11, 12, 13, 14, 15);
    return __builtin_shufflevector(half, half, 0, 1, 2, 3) + __builtin_shufflevector(half, half, 4, 5, 6, 7);
}

inline v4 bicubic(const float* image, int height, int width, float px, float py, const Cubic& cubic) {
    float fx = std::floor(px), fy = std::floor(py);
    v4 wy = cubic.weights(py - fy);
    // Clamp so that no position overflows; for NaN, which the weights contain, any pixel may be read.
    int x = fx > -4.0f ? int(std::min(fx, width + 3.0f)) : -4, y = fy > -4.0f ? int(std::min(fy, height + 3.0f)) : -4;
    v16 rows[4];
    if (x >= 1 && x + 2 < width && y >= 1 && y + 2 < height) {
        const float* p = image + (size_t(y - 1) * width + x - 1) * 4;
        for (int k = 0; k < 4; ++k) rows[k] = load(p + size_t(k) * width * 4);
    } else {
        for (int k = 0; k < 4; ++k) {
            float row[16];
            const float* p = image + size_t(clamp(y - 1 + k, height)) * width * 4;
            for (int i = 0; i < 4; ++i) store4(row + 4 * i, load4(p + clamp(x - 1 + i, width) * 4));
            rows[k] = load(row);
        }
    }
    return sum_quarters((wy[0] * rows[0] + wy[1] * rows[1] + wy[2] * rows[2] + wy[3] * rows[3]) * cubic.lanes(px - fx));
}

}  // namespace

extern "C" {

// Requests large pages for memory before its first use: touching 33 MB in 4 KB pages takes as long as the pass.
void ss_large_pages(float* data, size_t count) {
#if defined(__linux__) && defined(MADV_HUGEPAGE)
    const size_t page = 4096;
    size_t first = (size_t(data) + page - 1) / page * page, last = size_t(data + count) / page * page;
    if (last > first) madvise((void*)first, last - first, MADV_HUGEPAGE);
#else
    (void)data, (void)count;
#endif
}

struct Frame {
    const float *color, *depth, *motion;   // (3, h, w), (1, h, w), (2, h, w)
    const float *centre_x, *centre_y;      // (W,), (H,): normalised pixel centres
    int height, width, scale;              // h, w, s
    float jitter_x, jitter_y, a;           // low-resolution pixels; the cubic kernel's parameter
};

// blocks <- history, reprojected and padded (the jitter-aligned input without a state), and samples.
void ss_prepare(const Frame* f, const float* state, float* blocks, int threads) {
    int h = f->height, w = f->width, s = f->scale, H = h * s, W = w * s, side = SIDE / s, K = 64 + 4 * side * side;
    Axis mx(w, s, 0.0), my(h, s, 0.0), ax(w, s, f->jitter_x), ay(h, s, f->jitter_y);
    Planes color{f->color, 3, h, w}, motion{f->motion, 2, h, w};
    const Cubic cubic(f->a);
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (int block = 0; block < H / SIDE; ++block) {
        std::vector<float> colors(4 * w, 1.0f), vectors(2 * w), xs(W), ys(W);
        std::vector<int> kind(W);
        for (int i = SIDE * block; i < SIDE * block + SIDE; ++i) {
            color.row(ay.low[i], ay.high[i], ay.weight[i], colors.data(), 4);
            motion.row(my.low[i], my.high[i], my.weight[i], vectors.data(), 1, w);
            const float *u = vectors.data(), *v = u + w;
            for (int j = 0; j < W; ++j) {
                int l = mx.low[j], r = mx.high[j];
                float x = mix(u[l], u[r], mx.weight[j]), y = mix(v[l], v[r], mx.weight[j]);
                float previous_x = f->centre_x[j] + 2.0f * x, previous_y = f->centre_y[i] + 2.0f * y;
                bool outside = std::fabs(previous_x) > 1.0f || std::fabs(previous_y) > 1.0f;
                kind[j] = !state || outside ? ALIGNED : x == 0.0f && y == 0.0f ? STILL : MOVED;
                xs[j] = j + x * W, ys[j] = i + y * H;
            }
            float* out = blocks + size_t(block) * (W / SIDE) * K + (i % SIDE) * SIDE * 4;
            for (int j = 0; j < W; ++j) {
                v4 value;
                if (kind[j] == MOVED) value = bicubic(state, H, W, xs[j], ys[j], cubic);
                else if (kind[j] == STILL) value = load4(state + (size_t(i) * W + j) * 4);
                else value = interpolate(colors.data(), ax, j);
                store4(out + size_t(j / SIDE) * K + j % SIDE * 4, value);
            }
        }
        for (int y = 0; y < side; ++y)
            for (int j = 0; j < w; ++j) {
                size_t index = size_t(block * side + y) * w + j;
                float* out = blocks + (size_t(block) * (W / SIDE) + j / side) * K + 64 + (y * side + j % side) * 4;
                for (int c = 0; c < 3; ++c) out[c] = f->color[size_t(c) * h * w + index];
                out[3] = f->depth[index];
            }
    }
}

// state <- the blend of blocks' history and the jitter-aligned input by the network's output x (H/4, W/4, 32).
void ss_construct(const Frame* f, const float* blocks, const float* x, float* state, int threads) {
    int h = f->height, w = f->width, s = f->scale, H = h * s, W = w * s, side = SIDE / s, K = 64 + 4 * side * side;
    Axis ax(w, s, f->jitter_x), ay(h, s, f->jitter_y);
    Planes color{f->color, 3, h, w};
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (int block = 0; block < H / SIDE; ++block) {
        std::vector<float> colors(4 * w, 1.0f);
        for (int i = SIDE * block; i < SIDE * block + SIDE; ++i) {
            color.row(ay.low[i], ay.high[i], ay.weight[i], colors.data(), 4);
            for (int j = 0; j < W; j += SIDE) {
                size_t n = size_t(block) * (W / SIDE) + j / SIDE;
                int offset = (i % SIDE) * SIDE;
                float aligned[16];
                for (int p = 0; p < SIDE; ++p) store4(aligned + 4 * p, interpolate(colors.data(), ax, j + p));
                v16 history = load(blocks + n * K + 4 * offset);
                v4 o1 = load4(x + n * WIDTH + offset), o2 = load4(x + n * WIDTH + 16 + offset);
                v16 value = history + unit(Cubic::spread(o1)) * (load(aligned) - history);
                // Every fourth channel times o2, the remaining ones times 1.
                v4 ones = {1, 1, 1, 1};
                value *= unit(__builtin_shufflevector(o2, ones, 4, 4, 4, 0, 4, 4, 4, 1, 4, 4, 4, 2, 4, 4, 4, 3));
                store(state + (size_t(i) * W + j) * 4, unit(value));
            }
        }
    }
}

}  // extern "C"
