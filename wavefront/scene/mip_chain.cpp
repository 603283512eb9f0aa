// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/mip_chain.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "wavefront/base/half.h"
#include "wavefront/base/parallel.h"

namespace wavefront {
namespace {

// Source columns (or rows) of a destination one and their weights: two taps, or three where the source size is odd.
struct Taps {
  uint32_t first = 0, count = 0;
  float weight[3] = {0, 0, 0};
};
Taps TapsOf(uint32_t target, uint32_t sourceSize, uint32_t targetSize) {
  Taps taps;
  if (sourceSize == targetSize) return {target, 1, {1, 0, 0}};
  float lo = static_cast<float>(target) * sourceSize / targetSize, hi = static_cast<float>(target + 1) * sourceSize / targetSize;
  taps.first = static_cast<uint32_t>(lo);
  for (uint32_t s = taps.first; s < sourceSize && static_cast<float>(s) < hi && taps.count < 3; ++s) {
    float overlap = std::min(hi, static_cast<float>(s + 1)) - std::max(lo, static_cast<float>(s));
    taps.weight[taps.count++] = overlap / (hi - lo);
  }
  return taps;
}

void WriteTexel(uint8_t* out, const Float4& v, TexelFormat format) {
  const float c[4] = {v.x, v.y, v.z, v.w};
  uint16_t words[4];
  switch (format) {
    case TexelFormat::Rgba8Unorm:
      for (int i = 0; i < 4; ++i) out[i] = static_cast<uint8_t>(std::lround(std::clamp(c[i], 0.0f, 1.0f) * 255.0f));
      return;
    case TexelFormat::Rgba32Float: std::memcpy(out, c, 16); return;
    case TexelFormat::Rgba16Unorm:
      for (int i = 0; i < 4; ++i) words[i] = static_cast<uint16_t>(std::lround(std::clamp(c[i], 0.0f, 1.0f) * 65535.0f));
      break;
    case TexelFormat::Rgba16Float:
      for (int i = 0; i < 4; ++i) words[i] = FloatToHalf(c[i]);
      break;
  }
  std::memcpy(out, words, 8);
}

}  // namespace

Float4 ReadTexel(const uint8_t* texel, TexelFormat format) {
  if (format == TexelFormat::Rgba8Unorm) {
    constexpr float k = 1.0f / 255.0f;
    return {texel[0] * k, texel[1] * k, texel[2] * k, texel[3] * k};
  }
  if (format == TexelFormat::Rgba32Float) {
    float c[4];
    std::memcpy(c, texel, 16);
    return {c[0], c[1], c[2], c[3]};
  }
  uint16_t h[4];
  std::memcpy(h, texel, 8);
  if (format == TexelFormat::Rgba16Unorm) {
    constexpr float k = 1.0f / 65535.0f;
    return {h[0] * k, h[1] * k, h[2] * k, h[3] * k};
  }
  return {HalfToFloat(h[0]), HalfToFloat(h[1]), HalfToFloat(h[2]), HalfToFloat(h[3])};
}

std::vector<uint8_t> HalveLevel(const std::vector<uint8_t>& texels, uint32_t width, uint32_t height, TexelFormat format) {
  const uint32_t w = std::max(1u, width / 2), h = std::max(1u, height / 2), bytes = TexelBytes(format);
  std::vector<uint8_t> out(static_cast<std::size_t>(w) * h * bytes);
  std::vector<Taps> columns(w);
  for (uint32_t x = 0; x < w; ++x) columns[x] = TapsOf(x, width, w);
  ParallelFor(h, DefaultThreadCount(), [&](std::size_t y) {
    Taps rows = TapsOf(static_cast<uint32_t>(y), height, h);
    for (uint32_t x = 0; x < w; ++x) {
      Float4 sum;
      for (uint32_t r = 0; r < rows.count; ++r) {
        const uint8_t* line = &texels[(static_cast<std::size_t>(rows.first + r) * width + columns[x].first) * bytes];
        for (uint32_t c = 0; c < columns[x].count; ++c) {
          Float4 t = ReadTexel(line + c * bytes, format);
          float weight = rows.weight[r] * columns[x].weight[c];
          sum.x += weight * t.x; sum.y += weight * t.y; sum.z += weight * t.z; sum.w += weight * t.w;
        }
      }
      WriteTexel(&out[(y * w + x) * bytes], sum, format);
    }
  });
  return out;
}

}  // namespace wavefront
