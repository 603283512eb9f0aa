// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Counts the Vulkan handles that are alive in this process, where the driver is called: what a class forgets to destroy
// shows, too. Always on: an atomic per creation and destruction. Private to wavefront/vulkan; device.h has LiveHandles.
#pragma once

#include <cstdint>
#include <volk.h>

namespace wavefront::vulkan {

// Kinds of objects that are created and destroyed one by one; command buffers and descriptor sets go with their pools.
#define WAVEFRONT_DEVICE_HANDLES(ROW)                                                                                 \
  ROW(Buffer) ROW(BufferView) ROW(Image) ROW(ImageView) ROW(Sampler) ROW(ShaderModule) ROW(PipelineCache)             \
  ROW(PipelineLayout) ROW(DescriptorSetLayout) ROW(DescriptorPool) ROW(CommandPool) ROW(QueryPool) ROW(Semaphore)

enum class HandleKind : uint8_t {
  Instance,
  Device,
  DeviceMemory,
  Pipeline,
#define ROW(Name) Name,
  WAVEFRONT_DEVICE_HANDLES(ROW)
#undef ROW
  kCount
};

// For what is made before there is a device table.
void CountHandle(HandleKind kind, int64_t change);
// Puts counting functions in the place of a device's own. `instance`: whose loader functions they call.
void CountDeviceHandles(VkInstance instance, VolkDeviceTable& table);

}  // namespace wavefront::vulkan
