// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A device's VkPipelineCache on disk, for drivers that compile when a pipeline is created. One file per device and driver
// version, written beside and renamed, checked by its checksum: drivers trust what they are given.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "wavefront/vulkan/device.h"

namespace wavefront {

// In `folder`; empty: none.
std::string PipelineCacheFile(const std::string& folder, const vulkan::DeviceInfo& info);
// Empty: there is none, or it is damaged.
std::vector<std::byte> ReadPipelineCache(const std::string& file);
// False where it could not be written; what was there before then stays.
bool WritePipelineCache(const std::string& file, const std::vector<std::byte>& data);

}  // namespace wavefront
