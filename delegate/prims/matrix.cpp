// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/prims/matrix.h"

#include <utility>

namespace delegate {

Matrix4d Inverse(const Matrix4d& a) {
  Matrix4d left = a, right;
  for (int column = 0; column < 4; ++column) {
    int pivot = column;
    for (int row = column + 1; row < 4; ++row)
      if (std::abs(left.m[row][column]) > std::abs(left.m[pivot][column])) pivot = row;
    if (!(std::abs(left.m[pivot][column]) > 0)) return {};
    std::swap(left.m[pivot], left.m[column]);
    std::swap(right.m[pivot], right.m[column]);
    const double scale = 1 / left.m[column][column];
    for (int j = 0; j < 4; ++j) {
      left.m[column][j] *= scale;
      right.m[column][j] *= scale;
    }
    for (int row = 0; row < 4; ++row) {
      const double factor = left.m[row][column];
      if (row == column || factor == 0) continue;
      for (int j = 0; j < 4; ++j) {
        left.m[row][j] -= factor * left.m[column][j];
        right.m[row][j] -= factor * right.m[column][j];
      }
    }
  }
  return right;
}

}  // namespace delegate
