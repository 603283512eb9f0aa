// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/vulkan/live_handles.h"

#include <array>
#include <atomic>
#include <mutex>

#include "wavefront/vulkan/device.h"

namespace wavefront::vulkan {
namespace {

std::array<std::atomic<int64_t>, static_cast<std::size_t>(HandleKind::kCount)> live{};

constexpr const char* kNames[] = {"Instance",     "Device", "DeviceMemory", "Pipeline",
#define ROW(Name) #Name,
                                  WAVEFRONT_DEVICE_HANDLES(ROW)
#undef ROW
};
static_assert(std::size(kNames) == static_cast<std::size_t>(HandleKind::kCount));

// The loader's own functions: they find each device's driver by themselves, so one set serves all devices. A device's
// own would save them one jump, in calls that allocate.
struct Loader {
#define ROW(Name)                      \
  PFN_vkCreate##Name create##Name;     \
  PFN_vkDestroy##Name destroy##Name;
  WAVEFRONT_DEVICE_HANDLES(ROW)
#undef ROW
  PFN_vkCreateComputePipelines createComputePipelines;
  PFN_vkDestroyPipeline destroyPipeline;
  PFN_vkAllocateMemory allocateMemory;
  PFN_vkFreeMemory freeMemory;
} loader{};

#define ROW(Name)                                                                                                     \
  VKAPI_ATTR VkResult VKAPI_CALL Create##Name(VkDevice device, const Vk##Name##CreateInfo* info,                      \
                                              const VkAllocationCallbacks* allocator, Vk##Name* handle) {             \
    const VkResult result = loader.create##Name(device, info, allocator, handle);                                     \
    if (result == VK_SUCCESS) CountHandle(HandleKind::Name, 1);                                                       \
    return result;                                                                                                    \
  }                                                                                                                   \
  VKAPI_ATTR void VKAPI_CALL Destroy##Name(VkDevice device, Vk##Name handle, const VkAllocationCallbacks* allocator) { \
    loader.destroy##Name(device, handle, allocator);                                                                  \
    if (handle != VK_NULL_HANDLE) CountHandle(HandleKind::Name, -1);                                                  \
  }
WAVEFRONT_DEVICE_HANDLES(ROW)
#undef ROW

VKAPI_ATTR VkResult VKAPI_CALL CreateComputePipelines(VkDevice device, VkPipelineCache cache, uint32_t count,
                                                      const VkComputePipelineCreateInfo* infos,
                                                      const VkAllocationCallbacks* allocator, VkPipeline* handles) {
  const VkResult result = loader.createComputePipelines(device, cache, count, infos, allocator, handles);
  for (uint32_t i = 0; i < count; ++i)  // some may be there where others failed
    if (handles[i] != VK_NULL_HANDLE) CountHandle(HandleKind::Pipeline, 1);
  return result;
}
VKAPI_ATTR void VKAPI_CALL DestroyPipeline(VkDevice device, VkPipeline handle, const VkAllocationCallbacks* allocator) {
  loader.destroyPipeline(device, handle, allocator);
  if (handle != VK_NULL_HANDLE) CountHandle(HandleKind::Pipeline, -1);
}
VKAPI_ATTR VkResult VKAPI_CALL AllocateMemory(VkDevice device, const VkMemoryAllocateInfo* info,
                                              const VkAllocationCallbacks* allocator, VkDeviceMemory* memory) {
  const VkResult result = loader.allocateMemory(device, info, allocator, memory);
  if (result == VK_SUCCESS) CountHandle(HandleKind::DeviceMemory, 1);
  return result;
}
VKAPI_ATTR void VKAPI_CALL FreeMemory(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks* allocator) {
  loader.freeMemory(device, memory, allocator);
  if (memory != VK_NULL_HANDLE) CountHandle(HandleKind::DeviceMemory, -1);
}

void LoadOnce(VkInstance instance) {
  const auto load = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(vkGetInstanceProcAddr(instance, name));
  };
#define ROW(Name)                                  \
  load(loader.create##Name, "vkCreate" #Name);     \
  load(loader.destroy##Name, "vkDestroy" #Name);
  WAVEFRONT_DEVICE_HANDLES(ROW)
#undef ROW
  load(loader.createComputePipelines, "vkCreateComputePipelines");
  load(loader.destroyPipeline, "vkDestroyPipeline");
  load(loader.allocateMemory, "vkAllocateMemory");
  load(loader.freeMemory, "vkFreeMemory");
}

}  // namespace

void CountHandle(HandleKind kind, int64_t change) { live[static_cast<std::size_t>(kind)] += change; }

void CountDeviceHandles(VkInstance instance, VolkDeviceTable& table) {
  static std::once_flag loaded;
  std::call_once(loaded, LoadOnce, instance);
#define ROW(Name)                         \
  table.vkCreate##Name = Create##Name;    \
  table.vkDestroy##Name = Destroy##Name;
  WAVEFRONT_DEVICE_HANDLES(ROW)
#undef ROW
  table.vkCreateComputePipelines = CreateComputePipelines;
  table.vkDestroyPipeline = DestroyPipeline;
  table.vkAllocateMemory = AllocateMemory;
  table.vkFreeMemory = FreeMemory;
}

std::map<std::string, int64_t> LiveHandles() {
  std::map<std::string, int64_t> counts;
  for (std::size_t i = 0; i < live.size(); ++i) counts[kNames[i]] = live[i];
  return counts;
}

}  // namespace wavefront::vulkan
