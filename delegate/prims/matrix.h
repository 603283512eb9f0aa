// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Double-precision 4x4 matrices, row-vector convention (p' = p * M). Internal to delegate.
#pragma once

#include <cmath>

#include "wavefront/types.h"

namespace delegate {

using wavefront::Matrix4d;

// First a, then b. Sums run in a fixed order, so results do not depend on who calls.
inline Matrix4d Multiply(const Matrix4d& a, const Matrix4d& b) {
  Matrix4d c;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      c.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j] + a.m[i][3] * b.m[3][j];
  return c;
}

inline bool IsFinite(const Matrix4d& a) {
  for (const auto& row : a.m)
    for (double v : row)
      if (!std::isfinite(v)) return false;
  return true;
}

// Of the upper left 3x3.
inline double Determinant3(const Matrix4d& a) {
  const auto& m = a.m;
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

// True where the 3x3 part has no inverse worth the name: its determinant is lost in the rounding of its rows' lengths.
inline bool IsSingular3(const Matrix4d& a) {
  double lengths = 1;
  for (int i = 0; i < 3; ++i)
    lengths *= std::sqrt(a.m[i][0] * a.m[i][0] + a.m[i][1] * a.m[i][1] + a.m[i][2] * a.m[i][2]);
  const double determinant = std::abs(Determinant3(a));
  return !(determinant > lengths * 1e-12) || !(determinant > 0);
}

// Gauss-Jordan with row pivots. The identity where there is no inverse: ask IsSingular3 first.
Matrix4d Inverse(const Matrix4d& a);

inline Matrix4d Lerp(const Matrix4d& a, const Matrix4d& b, double t) {
  Matrix4d c;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) c.m[i][j] = a.m[i][j] + (b.m[i][j] - a.m[i][j]) * t;
  return c;
}

}  // namespace delegate
