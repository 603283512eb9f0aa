// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace wavefront {

/// SPIR-V of a fixed kernel, compiled from `wavefront/kernels/<name>.comp` at build time.
/// `name` is the file's stem ("logic", "extension_ray"). Empty when there is no such kernel.
/// The words live as long as the program. Any thread.
std::span<const uint32_t> KernelSpirv(std::string_view name);

}  // namespace wavefront
