// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// GLSL to SPIR-V for tests, and the names of the bindings of a SPIR-V module.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace kernel_runner {

// Throws std::runtime_error with the compiler's log. `stage`: "comp" (others as glslangValidator -S names them).
std::vector<uint32_t> CompileGlsl(const std::string& source, const std::string& stage,
                                  const std::vector<std::string>& includeFolders);

// Variable name (block name where a block has no instance name) to binding number, set 0.
std::map<std::string, uint32_t> BindingNames(const std::vector<uint32_t>& spirv);

}  // namespace kernel_runner
