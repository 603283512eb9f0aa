// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// IEEE half <-> float without special instructions; round to nearest even, denormals and infinities kept.
#pragma once

#include <bit>
#include <cstdint>

namespace wavefront {

inline float HalfToFloat(uint16_t h) {
  // Shift the payload up and rescale by a power of two: exact also for denormals.
  uint32_t bits = static_cast<uint32_t>(h & 0x7fffu) << 13;
  float magnitude = std::bit_cast<float>(bits) * 0x1p112f;
  if ((h & 0x7c00u) == 0x7c00u) magnitude = std::bit_cast<float>(bits | 0x7f800000u);
  return std::bit_cast<float>(std::bit_cast<uint32_t>(magnitude) | (static_cast<uint32_t>(h & 0x8000u) << 16));
}

inline uint16_t FloatToHalf(float f) {
  uint32_t bits = std::bit_cast<uint32_t>(f);
  uint32_t sign = (bits >> 16) & 0x8000u;
  bits &= 0x7fffffffu;
  if (bits > 0x7f800000u) return static_cast<uint16_t>(sign | 0x7e00u);              // NaN
  if (bits >= 0x477ff000u) return static_cast<uint16_t>(sign | 0x7c00u);             // rounds to infinity
  if (bits < 0x38800000u) {                                                           // denormal: let the adder round
    float shifted = std::bit_cast<float>(bits) + 0.5f;
    return static_cast<uint16_t>(sign | (std::bit_cast<uint32_t>(shifted) - 0x3f000000u));
  }
  uint32_t odd = (bits >> 13) & 1u;
  return static_cast<uint16_t>(sign | ((bits - 0x38000000u + 0xfffu + odd) >> 13));
}

}  // namespace wavefront
