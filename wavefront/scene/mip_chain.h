// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Box-filtered halving of a texture level, in the format's own precision. Odd sizes: the last row or column is
// weighted with the others it falls on (three-tap box), so that nothing shifts.
#pragma once

#include <cstdint>
#include <vector>

#include "wavefront/scene.h"

namespace wavefront {

constexpr uint32_t TexelBytes(TexelFormat format) {
  return format == TexelFormat::Rgba8Unorm ? 4 : format == TexelFormat::Rgba32Float ? 16 : 8;
}

// `texels`: width * height texels. The result is max(1, width / 2) x max(1, height / 2).
std::vector<uint8_t> HalveLevel(const std::vector<uint8_t>& texels, uint32_t width, uint32_t height, TexelFormat format);

Float4 ReadTexel(const uint8_t* texel, TexelFormat format);

}  // namespace wavefront
