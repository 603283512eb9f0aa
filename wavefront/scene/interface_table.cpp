// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/interface_table.h"

#include "wavefront/shared/interface_table.h"

namespace wavefront {
namespace {

constexpr uint32_t kEntries[] = {
#include "interface_table.inc"  // made by resources/albedo/interface_table.cpp
};
static_assert(sizeof(kEntries) / sizeof(kEntries[0]) == layout::kInterfaceEntries);

}  // namespace

std::vector<uint32_t> InterfaceTableTexels() {
  std::vector<uint32_t> texels;
  texels.reserve(2 * layout::kInterfaceEntries);
  for (uint32_t i = 0; i < layout::kInterfaceEntries; ++i) {
    const bool isLast = i % layout::kInterfaceCosines == layout::kInterfaceCosines - 1;
    texels.push_back(kEntries[i]);
    texels.push_back(kEntries[isLast ? i : i + 1]);
  }
  return texels;
}

}  // namespace wavefront
