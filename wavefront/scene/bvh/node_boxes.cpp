// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/bvh/node_boxes.h"

#include <algorithm>
#include <bit>

namespace wavefront::bvh {
namespace {

// 2^k for -1022 <= k <= 1023: std::ldexp and std::frexp took a good part of a refit.
double PowerOfTwo(int k) { return std::bit_cast<double>(static_cast<uint64_t>(1023 + k) << 52); }

// Steps of 2^(exponent - 127) from `origin` that cover up to `hi` in at most 255 steps.
int StepExponent(double origin, double hi) {
  const double extent = hi - origin;
  if (!(extent > 0)) return 1;
  // extent / 255 < 2^k. The difference of two floats is far from a double's denormals.
  const int k = static_cast<int>(std::bit_cast<uint64_t>(extent / 255) >> 52) - 1022;
  int exponent = std::max(k + 127, 1);
  while (exponent > 1 && 255 * PowerOfTwo(exponent - 1 - 127) >= extent) --exponent;
  return exponent;
}

}  // namespace

void QuantiseBoxes(BvhNode4& node, std::span<const Box4> boxes) {
  uint8_t* const lows[3] = {node.loX, node.loY, node.loZ};
  uint8_t* const highs[3] = {node.hiX, node.hiY, node.hiZ};
  Box4 whole;
  std::array<std::array<float, 4>, 4> lo, hi;
  for (size_t i = 0; i < boxes.size(); ++i) {
    whole.Extend(boxes[i]);
    lo[i] = Store(boxes[i].lo);
    hi[i] = Store(boxes[i].hi);
  }
  const auto wholeLo = Store(whole.lo), wholeHi = Store(whole.hi);
  for (int axis = 0; axis < 3; ++axis) {
    if (boxes.empty()) {
      node.exponents[axis] = 1;
      continue;
    }
    const double origin = wholeLo[axis];
    node.origin[axis] = wholeLo[axis];
    const int exponent = StepExponent(origin, wholeHi[axis]);
    node.exponents[axis] = static_cast<uint8_t>(exponent);
    const double step = PowerOfTwo(exponent - 127), perUnit = PowerOfTwo(127 - exponent);
    for (size_t i = 0; i < boxes.size(); ++i) {
      const double stepsToLo = (lo[i][axis] - origin) * perUnit, stepsToHi = (hi[i][axis] - origin) * perUnit;
      int low = static_cast<int>(std::min(stepsToLo, 255.0)), high = static_cast<int>(std::min(stepsToHi, 255.0));
      while (low > 0 && origin + low * step > lo[i][axis]) --low;  // the difference was rounded
      while (high < 255 && origin + high * step < hi[i][axis]) ++high;
      lows[axis][i] = static_cast<uint8_t>(low);
      highs[axis][i] = static_cast<uint8_t>(high);
    }
  }
}

double QuantisedHalfArea(const BvhNode4& node, uint32_t child) {
  const auto extent = [&](int axis, const uint8_t* lows, const uint8_t* highs) {
    const float step = std::bit_cast<float>(static_cast<uint32_t>(node.exponents[axis]) << 23);
    return double(step) * (highs[child] - lows[child]);
  };
  const double x = extent(0, node.loX, node.hiX), y = extent(1, node.loY, node.hiY), z = extent(2, node.loZ, node.hiZ);
  return x * y + y * z + z * x;
}

}  // namespace wavefront::bvh
