// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// How much path state a kernel moves, read off its SPIR-V.
#pragma once

#include <cstdint>
#include <span>

namespace wavefront {

// Chunks of path state (16 bytes) that an item reads and writes at most: those of the way through the code on which there are
// most, also if few paths take it. A place in a loop counts once.
struct StateTraffic { uint32_t chunksRead = 0, chunksWritten = 0; };

// Of the module's entry point; zeros for what is no SPIR-V. The two bindings of path state: shared/bindings.def.
StateTraffic StateTrafficOf(std::span<const uint32_t> spirv);

}  // namespace wavefront
