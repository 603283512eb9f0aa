// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Runs a colour library's GPU shader as a compute kernel over an image.
#pragma once

#include <span>
#include <vector>

#include "wavefront/renderer.h"
#include "wavefront/vulkan/device.h"

namespace wavefront {

// Binding 0: storage buffer of RGBA floats (in place); LUTs at their own bindings. Push constants: pixel count.
// Workgroup: 64 pixels. Waits for the result.
Status RunColor(vulkan::Device& device, std::span<const uint32_t> spirv, const std::vector<Renderer::ColorLut>& luts,
                std::span<float> rgba, uint32_t width, uint32_t height);

}  // namespace wavefront
