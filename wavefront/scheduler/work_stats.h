// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What the loop counted on the device, as RenderStats tells it: items, peak and occupancy of kernels and queues.
#pragma once

#include <cstdint>

#include "wavefront/renderer.h"

namespace wavefront {

struct LoopStatus;

// `stats->kernels` begins with the fixed kernels and the material buckets, in the registry's order, with their times.
// Fills their work, and `stats->queues`.
void AddWork(const LoopStatus& loop, uint32_t poolSize, ExecutionMode mode, RenderStats* stats);

}  // namespace wavefront
