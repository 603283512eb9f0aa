// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What the objects of one device share: its handles, functions, memory accounts. Private to wavefront/vulkan.
#pragma once

#include <volk.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "wavefront/base/result.h"
#include "wavefront/vulkan/device.h"
#include "wavefront/vulkan/instance.h"

namespace wavefront::vulkan {

class Transfer;

// A Vulkan struct with its type, its chain, and zeros.
template <typename T>
T Struct(VkStructureType type, const void* next = nullptr) {
  T value{};
  value.sType = type;
  value.pNext = const_cast<void*>(next);
  return value;
}

std::string VersionText(uint32_t version);            // "1.3.230"
std::string BytesText(uint64_t bytes);                // "1.5 GiB"
Error VulkanError(const char* call, VkResult result); // names the call and the result

enum class MemoryLocation : uint8_t;  // buffer.h

struct Allocation {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize size = 0;
  void* mapped = nullptr;  // null: not host-visible
};

struct Context : std::enable_shared_from_this<Context> {
  std::shared_ptr<Instance> instance;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  uint32_t queueFamily = 0;
  VolkDeviceTable vk{};
  VkPhysicalDeviceMemoryProperties memoryProperties{};
  DeviceInfo info;
  bool capturesStatistics = false;  // pipelines are made so that the driver can tell of them
  bool directWrites = false;  // device memory is written by the host without staging
  VkPipelineCache pipelineCache = VK_NULL_HANDLE;
  std::atomic<int64_t> liveObjects{0};
  std::atomic<uint64_t> uploadedBytes{0};  // so far, to buffers and images
  std::atomic<bool> lost{false};

  Context() = default;
  ~Context();

  // Turns a result into an error and remembers a lost device.
  Error Fail(const char* call, VkResult result);
  void Name(VkObjectType type, const void* handle, const std::string& name) const;

  // One vkAllocateMemory, charged to `kind`. Over budget or out of memory: an error that says who holds what.
  Result<Allocation> Allocate(const VkMemoryRequirements& needs, bool hostVisible, MemoryKind kind, const std::string& name);
  void Free(const Allocation& allocation, MemoryKind kind);

  Status Submit(const VkSubmitInfo2& submit);
  Status WaitIdle();
  Transfer& transfer() { return *transfer_; }
  void CreateTransfer();

  uint64_t budget = 0;
  MemoryUse MemoryTotal() const;
  MemoryByKind MemoryKinds() const;

 private:
  Status Charge(uint64_t bytes, MemoryKind kind, const std::string& name);
  void Refund(uint64_t bytes, MemoryKind kind);

  std::mutex queueMutex_;
  mutable std::mutex memoryMutex_;
  MemoryByKind byKind_{};
  MemoryUse total_{};
  std::unique_ptr<Transfer> transfer_;
};

// selection.cpp: the device to take and the features to enable.
struct Selection {
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  uint32_t queueFamily = 0;
  DeviceInfo info;
};
Result<std::vector<Selection>> EnumerateDevices(const Instance& instance);
Result<Selection> SelectDevice(const Instance& instance, const std::string& selector);

// The feature chain of vkCreateDevice: required features, and optional ones where present.
struct Features {
  VkPhysicalDeviceFeatures2 core = Struct<VkPhysicalDeviceFeatures2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2);
  VkPhysicalDeviceVulkan11Features v11 = Struct<VkPhysicalDeviceVulkan11Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES);
  VkPhysicalDeviceVulkan12Features v12 = Struct<VkPhysicalDeviceVulkan12Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
  VkPhysicalDeviceVulkan13Features v13 = Struct<VkPhysicalDeviceVulkan13Features>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
  Features() {
    core.pNext = &v11;
    v11.pNext = &v12;
    v12.pNext = &v13;
  }
  Features(const Features&) = delete;
  Features& operator=(const Features&) = delete;
};
void EnableFeatures(VkPhysicalDevice physical, Features& enabled);

}  // namespace wavefront::vulkan
