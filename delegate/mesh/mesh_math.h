// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Double-precision vectors for mesh processing: products of float coordinates neither overflow nor cancel early.
// Internal to delegate/mesh.
#pragma once

#include <cmath>

#include "wavefront/types.h"

namespace delegate {

struct Vec3 {
  double x = 0, y = 0, z = 0;
  Vec3() = default;
  Vec3(double px, double py, double pz) : x(px), y(py), z(pz) {}
  explicit Vec3(const wavefront::Float3& p) : x(p.x), y(p.y), z(p.z) {}
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3 operator-(const Vec3& a, const Vec3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
inline Vec3 operator*(const Vec3& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec3& operator+=(Vec3& a, const Vec3& b) { return a = a + b; }
inline double Dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3 Cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double Length(const Vec3& a) { return std::sqrt(Dot(a, a)); }

// The unit vector, or zero if the length is zero.
inline Vec3 Normalized(const Vec3& a) {
  const double length = Length(a);
  return length > 0 ? a * (1 / length) : Vec3();
}

// Angle between two directions in [0, pi], 0 if one is zero. atan2 keeps small angles exact.
inline double AngleBetween(const Vec3& a, const Vec3& b) { return std::atan2(Length(Cross(a, b)), Dot(a, b)); }

inline wavefront::Float3 ToFloat3(const Vec3& a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}

}  // namespace delegate
