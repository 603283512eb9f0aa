// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/vulkan/context.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include "wavefront/vulkan/transfer.h"

namespace wavefront::vulkan {
namespace {

std::atomic<int64_t> liveBytes{0};  // of all devices

// A software device's memory is this process's own, in pages of 4 KB: incoherent rays wait for the translation of
// addresses. Asks for larger pages; only a wish, and nothing is touched that was not used before.
void AdviseHugePages([[maybe_unused]] void* mapped, [[maybe_unused]] uint64_t size) {
#if defined(MADV_HUGEPAGE)
  constexpr uintptr_t kHugePage = uintptr_t{2} << 20;
  const auto begin = reinterpret_cast<uintptr_t>(mapped);
  const uintptr_t first = (begin + kHugePage - 1) & ~(kHugePage - 1), end = (begin + size) & ~(kHugePage - 1);
  if (first < end) madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
#endif
}

const char* ResultName(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY: return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY: return "out of device memory";
    case VK_ERROR_INITIALIZATION_FAILED: return "initialization failed";
    case VK_ERROR_DEVICE_LOST: return "the device was lost";
    case VK_ERROR_MEMORY_MAP_FAILED: return "memory map failed";
    case VK_ERROR_LAYER_NOT_PRESENT: return "layer not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT: return "extension not present";
    case VK_ERROR_FEATURE_NOT_PRESENT: return "feature not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER: return "incompatible driver";
    case VK_ERROR_TOO_MANY_OBJECTS: return "too many objects";
    case VK_ERROR_FORMAT_NOT_SUPPORTED: return "format not supported";
    case VK_ERROR_FRAGMENTED_POOL: return "fragmented pool";
    case VK_ERROR_OUT_OF_POOL_MEMORY: return "out of pool memory";
    case VK_ERROR_INVALID_SHADER_NV: return "invalid shader";
    case VK_TIMEOUT: return "timeout";
    default: return nullptr;
  }
}

}  // namespace

std::string VersionText(uint32_t version) {
  return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) + "." +
         std::to_string(VK_API_VERSION_PATCH(version));
}

std::string BytesText(uint64_t bytes) {
  const char* units[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  double value = static_cast<double>(bytes);
  int unit = 0;
  while (value >= 1024 && unit < 4) value /= 1024, ++unit;
  char text[32];
  std::snprintf(text, sizeof text, unit == 0 || value >= 100 ? "%.0f %s" : "%.1f %s", value, units[unit]);
  return text;
}

Error VulkanError(const char* call, VkResult result) {
  const char* name = ResultName(result);
  return Error{std::string(call) + " failed: " + (name != nullptr ? name : ("VkResult " + std::to_string(result)).c_str())};
}

std::string_view MemoryKindName(MemoryKind kind) {
  constexpr std::string_view kNames[] = {"path state", "queues",    "film",    "geometry", "textures",
                                         "materials",  "staging",   "tables",  "other"};
  static_assert(std::size(kNames) == kMemoryKindCount);
  return kNames[static_cast<std::size_t>(kind)];
}

ContextRef::ContextRef(std::shared_ptr<Context> context) : context_(std::move(context)) { ++context_->liveObjects; }
ContextRef::~ContextRef() { --context_->liveObjects; }

Error Context::Fail(const char* call, VkResult result) {
  if (result == VK_ERROR_DEVICE_LOST) lost = true;
  return VulkanError(call, result);
}

void Context::Name(VkObjectType type, const void* handle, const std::string& name) const {
  if (instance->setObjectName == nullptr || name.empty()) return;
  auto info = Struct<VkDebugUtilsObjectNameInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT);
  info.objectType = type;
  info.objectHandle = reinterpret_cast<uint64_t>(handle);
  info.pObjectName = name.c_str();
  instance->setObjectName(device, &info);
}

Status Context::Charge(uint64_t bytes, MemoryKind kind, const std::string& name) {
  std::scoped_lock lock(memoryMutex_);
  if (bytes > budget || total_.current > budget - bytes) {
    std::string holders;
    for (std::size_t i = 0; i < kMemoryKindCount; ++i) {
      if (byKind_[i].current == 0) continue;
      holders += holders.empty() ? ": " : ", ";
      holders += std::string(MemoryKindName(static_cast<MemoryKind>(i))) + " " + BytesText(byKind_[i].current);
    }
    return Error{"'" + name + "' (" + std::string(MemoryKindName(kind)) + ") needs " + BytesText(bytes) +
                 " of device memory, which would pass the budget of " + BytesText(budget) + "; " +
                 BytesText(total_.current) + " are in use" + holders};
  }
  MemoryUse& use = byKind_[static_cast<std::size_t>(kind)];
  use.current += bytes;
  use.peak = std::max(use.peak, use.current);
  total_.current += bytes;
  liveBytes += static_cast<int64_t>(bytes);
  total_.peak = std::max(total_.peak, total_.current);
  return {};
}

void Context::Refund(uint64_t bytes, MemoryKind kind) {
  std::scoped_lock lock(memoryMutex_);
  byKind_[static_cast<std::size_t>(kind)].current -= bytes;
  total_.current -= bytes;
  liveBytes -= static_cast<int64_t>(bytes);
}

int64_t LiveDeviceBytes() { return liveBytes; }

MemoryUse Context::MemoryTotal() const {
  std::scoped_lock lock(memoryMutex_);
  return total_;
}

MemoryByKind Context::MemoryKinds() const {
  std::scoped_lock lock(memoryMutex_);
  return byKind_;
}

Result<Allocation> Context::Allocate(const VkMemoryRequirements& needs, bool hostVisible, MemoryKind kind,
                                     const std::string& name) {
  constexpr VkMemoryPropertyFlags kHost = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  constexpr VkMemoryPropertyFlags kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  // Best first. A host-visible buffer on a discrete GPU is for small counters and read-back: cached system memory.
  VkMemoryPropertyFlags wanted[3] = {kLocal, 0, 0};
  if (directWrites) {
    wanted[0] = kLocal | kHost, wanted[1] = kHost, wanted[2] = hostVisible ? kHost : 0;
  } else if (hostVisible) {
    wanted[0] = kHost | kCached, wanted[1] = kHost, wanted[2] = kHost;
  }
  uint32_t type = UINT32_MAX;
  for (const VkMemoryPropertyFlags flags : wanted) {
    for (uint32_t i = 0; i < memoryProperties.memoryTypeCount && type == UINT32_MAX; ++i) {
      const bool allowed = (needs.memoryTypeBits >> i) & 1;
      if (allowed && (memoryProperties.memoryTypes[i].propertyFlags & flags) == flags) type = i;
    }
    if (type != UINT32_MAX) break;
  }
  if (type == UINT32_MAX) return Error{"no memory type of the device fits '" + name + "'"};

  if (Status charged = Charge(needs.size, kind, name); !charged) return charged.error();
  auto info = Struct<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  info.allocationSize = needs.size;
  info.memoryTypeIndex = type;
  Allocation allocation;
  allocation.size = needs.size;
  VkResult result = vk.vkAllocateMemory(device, &info, nullptr, &allocation.memory);
  const bool map = (hostVisible || directWrites) &&
                   (memoryProperties.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) != 0;
  if (result == VK_SUCCESS && map) {
    result = vk.vkMapMemory(device, allocation.memory, 0, VK_WHOLE_SIZE, 0, &allocation.mapped);
  }
  if (result != VK_SUCCESS) {
    if (allocation.memory != VK_NULL_HANDLE) vk.vkFreeMemory(device, allocation.memory, nullptr);
    Refund(needs.size, kind);
    Error error = Fail("vkAllocateMemory", result);
    error.message += " ('" + name + "', " + BytesText(needs.size) + ")";
    return error;
  }
  if (allocation.mapped != nullptr && this->info.type == DeviceType::Cpu) AdviseHugePages(allocation.mapped, needs.size);
  return allocation;
}

void Context::Free(const Allocation& allocation, MemoryKind kind) {
  if (allocation.memory == VK_NULL_HANDLE) return;
  vk.vkFreeMemory(device, allocation.memory, nullptr);
  Refund(allocation.size, kind);
}

Status Context::Submit(const VkSubmitInfo2& submit) {
  std::scoped_lock lock(queueMutex_);
  const VkResult result = vk.vkQueueSubmit2(queue, 1, &submit, VK_NULL_HANDLE);
  if (result != VK_SUCCESS) return Fail("vkQueueSubmit2", result);
  return {};
}

Status Context::WaitIdle() {
  std::scoped_lock lock(queueMutex_);
  const VkResult result = vk.vkQueueWaitIdle(queue);
  if (result != VK_SUCCESS) return Fail("vkQueueWaitIdle", result);
  return {};
}

void Context::CreateTransfer() { transfer_ = std::make_unique<Transfer>(*this); }

}  // namespace wavefront::vulkan
