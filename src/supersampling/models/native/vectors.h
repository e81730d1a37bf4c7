// Vectors of 4 and 16 floats as GCC and Clang have them on every machine; where registers are narrower, they make several of one.

#pragma once

#include <algorithm>
#include <cstddef>

typedef float v4 __attribute__((vector_size(16)));
typedef float v16 __attribute__((vector_size(64)));
typedef v4 u4 __attribute__((aligned(4)));    // where memory need not be aligned
typedef v16 u16 __attribute__((aligned(4)));

static inline v4 load4(const float* p) { return *(const u4*)p; }
static inline void store4(float* p, v4 x) { *(u4*)p = x; }
static inline v16 load(const float* p) { return *(const u16*)p; }
static inline void store(float* p, v16 x) { *(u16*)p = x; }
static inline int held(int i, int size) { return std::min(std::max(i, 0), size - 1); }
// A NaN stays one.
static inline v16 unit(v16 x) {
    x = x < 0.0f ? v16{} : x;
    return x > 1.0f ? v16{} + 1.0f : x;
}
