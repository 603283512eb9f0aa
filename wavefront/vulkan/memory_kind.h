// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Device memory is accounted by what it is for, against one budget.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace wavefront::vulkan {

enum class MemoryKind : uint8_t {
  PathState,
  Queues,
  Film,
  Geometry,
  Textures,
  Materials,
  Staging,
  Tables,
  Other,
  kCount
};
constexpr std::size_t kMemoryKindCount = static_cast<std::size_t>(MemoryKind::kCount);

std::string_view MemoryKindName(MemoryKind kind);

// Bytes allocated from the driver.
struct MemoryUse {
  uint64_t current = 0;
  uint64_t peak = 0;
};
using MemoryByKind = std::array<MemoryUse, kMemoryKindCount>;

}  // namespace wavefront::vulkan
