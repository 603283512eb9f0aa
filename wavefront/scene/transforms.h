// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// From USD's double matrices to the records' rows, relative to the scene's origin.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "wavefront/types.h"

namespace wavefront {

struct Double3 { double x = 0, y = 0, z = 0; };
using Rows = std::array<Float4, 3>;  // p'.x = dot(rows[0], (p, 1))

inline double Determinant3(const Matrix4d& a) {
  const auto& m = a.m;
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

// Scales the unit shape before the transform (row vectors: the rows of the linear part).
inline Matrix4d Prescale(Matrix4d a, double x, double y, double z) {
  for (int c = 0; c < 4; ++c) { a.m[0][c] *= x; a.m[1][c] *= y; a.m[2][c] *= z; }
  return a;
}

inline Rows ToRows(const Matrix4d& a, const Double3& origin) {
  const double shift[3] = {origin.x, origin.y, origin.z};
  Rows rows;
  for (int j = 0; j < 3; ++j) {
    rows[j] = {static_cast<float>(a.m[0][j]), static_cast<float>(a.m[1][j]), static_cast<float>(a.m[2][j]),
               static_cast<float>(a.m[3][j] - shift[j])};
  }
  return rows;
}

// Inverse of the affine part, taking origin-relative world points; none where the transform is singular or not finite.
inline std::optional<Rows> InverseRows(const Matrix4d& a, const Double3& origin) {
  double det = Determinant3(a);
  double scale = 0;
  for (int i = 0; i < 3; ++i) for (int j = 0; j < 3; ++j) scale = std::max(scale, std::abs(a.m[i][j]));
  if (!std::isfinite(det) || !std::isfinite(scale) || std::abs(det) <= 1e-15 * scale * scale * scale) return std::nullopt;
  const auto& m = a.m;
  const double t[3] = {m[3][0] - origin.x, m[3][1] - origin.y, m[3][2] - origin.z};
  // Column-vector matrix C[j][i] = m[i][j]; rows of its inverse.
  double c[3][3];
  for (int i = 0; i < 3; ++i) for (int j = 0; j < 3; ++j) c[j][i] = m[i][j];
  double inv[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      int a1 = (j + 1) % 3, a2 = (j + 2) % 3, b1 = (i + 1) % 3, b2 = (i + 2) % 3;
      inv[i][j] = (c[a1][b1] * c[a2][b2] - c[a1][b2] * c[a2][b1]) / det;
    }
  }
  Rows rows;
  for (int i = 0; i < 3; ++i) {
    double shift = -(inv[i][0] * t[0] + inv[i][1] * t[1] + inv[i][2] * t[2]);
    rows[i] = {static_cast<float>(inv[i][0]), static_cast<float>(inv[i][1]), static_cast<float>(inv[i][2]), static_cast<float>(shift)};
    if (!std::isfinite(rows[i].x) || !std::isfinite(rows[i].y) || !std::isfinite(rows[i].z) || !std::isfinite(rows[i].w)) return std::nullopt;
  }
  return rows;
}

inline float Luminance(const Float3& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

}  // namespace wavefront
