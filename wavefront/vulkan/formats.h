// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Private to wavefront/vulkan.
#pragma once

#include <volk.h>

#include "wavefront/vulkan/buffer.h"

namespace wavefront::vulkan {

VkFormat ToVulkan(Format format);

}  // namespace wavefront::vulkan
