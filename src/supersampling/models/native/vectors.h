// Vectors of 4 and 16 floats: GCC and Clang support them on every machine and split them where registers are narrower.

#pragma once

#include <algorithm>
#include <cstddef>

typedef float v4 __attribute__((vector_size(16)));
typedef float v16 __attribute__((vector_size(64)));
typedef v4 u4 __attribute__((aligned(4)));    // for unaligned memory
typedef v16 u16 __attribute__((aligned(4)));

static inline v4 load4(const float* p) { return *(const u4*)p; }
static inline void store4(float* p, v4 x) { *(u4*)p = x; }
static inline v16 load(const float* p) { return *(const u16*)p; }
static inline void store(float* p, v16 x) { *(u16*)p = x; }
static inline int clamp(int i, int size) { return std::min(std::max(i, 0), size - 1); }
// Clamps to [0, 1]; NaN stays NaN.
static inline v16 unit(v16 x) {
    x = x < 0.0f ? v16{} : x;
    return x > 1.0f ? v16{} + 1.0f : x;
}
