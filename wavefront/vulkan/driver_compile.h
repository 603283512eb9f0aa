// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// When a driver turns SPIR-V into machine code, and whether what one device compiled is there for another.
#pragma once

#include <cstdint>
#include <string>

#include "wavefront/vulkan/device.h"

namespace wavefront::vulkan {

enum class DriverCompile : uint8_t {
  AtCreation,        // in the creation of the pipeline, on any thread: GPUs
  AtDispatchCached,  // at a device's first dispatch, and a second device's dispatch finds it in Mesa's disk cache: lavapipe
  AtDispatch         // at a device's first dispatch, each time anew: lavapipe without that cache
};

// `why`: where the cache cannot be used, the reason in words.
DriverCompile DriverCompileOf(const DeviceInfo& info, std::string* why);

}  // namespace wavefront::vulkan
