// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// How many paths are on their way at a time where the host does not say.
#pragma once

#include <cstddef>
#include <cstdint>

#include "wavefront/renderer.h"
#include "wavefront/vulkan/device.h"

namespace wavefront {

// Paths, before the limits of the device's buffers and of the picture's work. `buckets`: queues of material kernels.
// The picture is the same to the bit whatever the size.
uint32_t DefaultPoolSize(vulkan::DeviceType device, ExecutionMode mode, std::size_t buckets, bool interactive);

}  // namespace wavefront
