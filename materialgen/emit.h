// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Expressions and weighted lobes -> GLSL of the three entries, and the parameter block.
#pragma once

#include <set>
#include <string>

#include "materialgen/builder.h"

namespace materialgen {

// `functions`: text of the library functions that the material calls, includes resolved.
CompiledMaterial Emit(Expressions* expressions, const Material& material, const std::string& functions);

}  // namespace materialgen
