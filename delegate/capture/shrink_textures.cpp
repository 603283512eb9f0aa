// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include <algorithm>
#include <cmath>
#include <cstring>

#include "delegate/capture/captured_scene.h"
#include "wavefront/base/half.h"

namespace delegate {
namespace {

using namespace wavefront;

// The mean of each four texels; at odd sizes the last row and column are left out, as in the core's mip chain.
template <typename T, typename ToFloat, typename FromFloat>
void Halve(TextureData& texture, ToFloat toFloat, FromFloat fromFloat) {
  const uint32_t width = std::max(1u, texture.width / 2), height = std::max(1u, texture.height / 2);
  const auto at = [&](uint32_t x, uint32_t y, uint32_t c) {
    T value;
    const std::size_t texel = std::size_t{std::min(y, texture.height - 1)} * texture.width + std::min(x, texture.width - 1);
    std::memcpy(&value, texture.texels.data() + (4 * texel + c) * sizeof(T), sizeof(T));
    return toFloat(value);
  };
  std::vector<uint8_t> texels(std::size_t{width} * height * 4 * sizeof(T));
  std::size_t out = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      for (uint32_t c = 0; c < 4; ++c) {
        const float sum = at(2 * x, 2 * y, c) + at(2 * x + 1, 2 * y, c) + at(2 * x, 2 * y + 1, c) + at(2 * x + 1, 2 * y + 1, c);
        const T value = fromFloat(0.25f * sum);
        std::memcpy(texels.data() + out, &value, sizeof(T));
        out += sizeof(T);
      }
  texture.texels = std::move(texels);
  texture.width = width;
  texture.height = height;
}

template <typename T>
void HalveUnorm(TextureData& texture) {
  Halve<T>(texture, [](T v) { return static_cast<float>(v); }, [](float v) { return static_cast<T>(std::lround(v)); });
}

}  // namespace

std::size_t ShrinkTextures(CapturedScene& scene, uint32_t maxSide) {
  std::size_t count = 0;
  for (auto& [id, texture] : scene.textures) {
    if (std::max(texture.width, texture.height) > maxSide) ++count;
    while (std::max(texture.width, texture.height) > std::max(1u, maxSide)) {
      switch (texture.format) {
        case TexelFormat::Rgba8Unorm: HalveUnorm<uint8_t>(texture); break;
        case TexelFormat::Rgba16Unorm: HalveUnorm<uint16_t>(texture); break;
        case TexelFormat::Rgba16Float: Halve<uint16_t>(texture, HalfToFloat, FloatToHalf); break;
        case TexelFormat::Rgba32Float: Halve<float>(texture, [](float v) { return v; }, [](float v) { return v; }); break;
      }
    }
  }
  return count;
}

}  // namespace delegate
