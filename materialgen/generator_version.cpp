// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "materialgen/spirv_cache.h"

namespace materialgen {

// Part of every key: raise it when the same network yields other source.
std::string_view GeneratorVersion() { return "14"; }

}  // namespace materialgen
