// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The table of refracting GGX interfaces, as lib/bsdf/interface_table.glsl reads it (shared/interface_table.h).
#pragma once

#include <cstdint>
#include <vector>

namespace wavefront {

// Two words a texel.
std::vector<uint32_t> InterfaceTableTexels();

}  // namespace wavefront
