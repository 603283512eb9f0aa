// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// How much path state a kernel moves, read off its SPIR-V.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

namespace wavefront {

// Bytes of path state that an item reads and writes at most: those of the way through the code on which there are most,
// also if few paths take it. A chunk has 16; where only a word of it is read or written, that word counts. A place in a loop counts
// once.
struct StateTraffic { uint32_t bytesRead = 0, bytesWritten = 0; };

// Of the module's entry point; zeros for what is no SPIR-V. The two bindings of path state: shared/bindings.def. Branches
// on constants are decided, on specialization constants by their ids (constant_id, value), else by their defaults.
StateTraffic StateTrafficOf(std::span<const uint32_t> spirv,
                            std::span<const std::pair<uint32_t, uint32_t>> specialization = {});

}  // namespace wavefront
