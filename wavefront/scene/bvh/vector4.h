// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Four floats at once for the BVH builder: SSE2 where the target has it, plain loops elsewhere, same results.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace wavefront::bvh {

#if defined(__SSE2__)
using Vec4 = __m128;
inline Vec4 Load(const float* p) { return _mm_load_ps(p); }
inline Vec4 Splat(float x) { return _mm_set1_ps(x); }
inline Vec4 Add(Vec4 a, Vec4 b) { return _mm_add_ps(a, b); }
inline Vec4 Sub(Vec4 a, Vec4 b) { return _mm_sub_ps(a, b); }
inline Vec4 Mul(Vec4 a, Vec4 b) { return _mm_mul_ps(a, b); }
inline Vec4 Min(Vec4 a, Vec4 b) { return _mm_min_ps(a, b); }
inline Vec4 Max(Vec4 a, Vec4 b) { return _mm_max_ps(a, b); }
inline std::array<float, 4> Store(Vec4 a) {
  alignas(16) std::array<float, 4> r;
  _mm_store_ps(r.data(), a);
  return r;
}
inline std::array<int32_t, 4> TruncateToInt(Vec4 a) {
  alignas(16) std::array<int32_t, 4> r;
  _mm_store_si128(reinterpret_cast<__m128i*>(r.data()), _mm_cvttps_epi32(a));
  return r;
}
#else
struct Vec4 {
  std::array<float, 4> v;
};
template <typename F>
inline Vec4 PerLane(Vec4 a, Vec4 b, F f) {
  Vec4 r;
  for (int i = 0; i < 4; ++i) r.v[i] = f(a.v[i], b.v[i]);
  return r;
}
inline Vec4 Load(const float* p) { return {{p[0], p[1], p[2], p[3]}}; }
inline Vec4 Splat(float x) { return {{x, x, x, x}}; }
inline Vec4 Add(Vec4 a, Vec4 b) { return PerLane(a, b, [](float x, float y) { return x + y; }); }
inline Vec4 Sub(Vec4 a, Vec4 b) { return PerLane(a, b, [](float x, float y) { return x - y; }); }
inline Vec4 Mul(Vec4 a, Vec4 b) { return PerLane(a, b, [](float x, float y) { return x * y; }); }
inline Vec4 Min(Vec4 a, Vec4 b) { return PerLane(a, b, [](float x, float y) { return x < y ? x : y; }); }
inline Vec4 Max(Vec4 a, Vec4 b) { return PerLane(a, b, [](float x, float y) { return x > y ? x : y; }); }
inline std::array<float, 4> Store(Vec4 a) { return a.v; }
inline std::array<int32_t, 4> TruncateToInt(Vec4 a) {
  // Lane 3 carries no coordinate and may lie outside an int.
  return {static_cast<int32_t>(a.v[0]), static_cast<int32_t>(a.v[1]), static_cast<int32_t>(a.v[2]), 0};
}
#endif

// A box in lanes 0..2, empty at first.
struct Box4 {
  Vec4 lo = Splat(std::numeric_limits<float>::max());
  Vec4 hi = Splat(std::numeric_limits<float>::lowest());

  void Extend(const Box4& other) {
    lo = Min(lo, other.lo);
    hi = Max(hi, other.hi);
  }
  // Half the surface; 0 if empty. Double: coordinates reach 1e18 and are multiplied by counts.
  double HalfArea() const {
    const auto e = Store(Sub(hi, lo));
    if (e[0] < 0) return 0;
    return double(e[0]) * e[1] + double(e[1]) * e[2] + double(e[2]) * e[0];
  }
};

}  // namespace wavefront::bvh
