// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Which device is taken, and what a device must have.
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <thread>

#include "wavefront/vulkan/context.h"

namespace wavefront::vulkan {
namespace {

// The one list of features: (struct of the chain, Vulkan's name).
#define WAVEFRONT_REQUIRED_FEATURES(X)                                                             \
  X(core.features, shaderInt64)                                                                    \
  X(v12, shaderBufferInt64Atomics)                                                                 \
  X(v12, scalarBlockLayout)                                                                        \
  X(v12, timelineSemaphore)                                                                        \
  X(v12, hostQueryReset)                                                                           \
  X(v13, synchronization2)                                                                         \
  X(v13, maintenance4)
#define WAVEFRONT_OPTIONAL_FEATURES(X)                                                             \
  X(core.features, shaderInt16)                                                                    \
  X(v12, shaderInt8)                                                                               \
  X(v12, shaderFloat16)                                                                            \
  X(v11, storageBuffer16BitAccess)                                                                 \
  X(v12, storageBuffer8BitAccess)                                                                  \
  X(v12, vulkanMemoryModel)                                                                        \
  X(v12, vulkanMemoryModelDeviceScope)                                                             \
  X(v13, shaderDemoteToHelperInvocation)

struct LimitCheck {
  const char* name;
  uint64_t value, needed;
};

DeviceType TypeOf(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return DeviceType::Discrete;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return DeviceType::Integrated;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return DeviceType::Virtual;
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return DeviceType::Cpu;
    default: return DeviceType::Other;
  }
}

uint32_t KernelThreads() {
  if (const char* text = std::getenv("LP_NUM_THREADS"); text != nullptr && std::atoi(text) > 0) {
    return static_cast<uint32_t>(std::atoi(text));
  }
  return std::max(1u, std::thread::hardware_concurrency());
}

void FillLimits(VkPhysicalDevice physical, const VkPhysicalDeviceProperties& properties,
                const VkPhysicalDeviceVulkan11Properties& v11, const VkPhysicalDeviceVulkan13Properties& v13,
                DeviceLimits& limits) {
  (void)physical;
  const VkPhysicalDeviceLimits& l = properties.limits;
  limits.maxStorageBufferRange = l.maxStorageBufferRange;
  limits.maxBufferSize = std::min<uint64_t>(v13.maxBufferSize, v11.maxMemoryAllocationSize);
  limits.maxTexelBufferElements = l.maxTexelBufferElements;
  limits.texelBufferOffsetAlignment = std::max<VkDeviceSize>(1, l.minTexelBufferOffsetAlignment);
  limits.storageBufferOffsetAlignment = std::max<VkDeviceSize>(1, l.minStorageBufferOffsetAlignment);
  limits.maxWorkGroupInvocations = l.maxComputeWorkGroupInvocations;
  limits.maxWorkGroupCountX = l.maxComputeWorkGroupCount[0];
  limits.maxSharedMemory = l.maxComputeSharedMemorySize;
  limits.maxPushConstants = l.maxPushConstantsSize;
  limits.maxStorageBuffersPerStage = l.maxPerStageDescriptorStorageBuffers;
  limits.maxSampledImagesPerStage = l.maxPerStageDescriptorSampledImages;
  limits.maxResourcesPerStage = l.maxPerStageResources;
  limits.maxImageDimension2D = l.maxImageDimension2D;
  limits.maxImageDimension3D = l.maxImageDimension3D;
  limits.maxImageArrayLayers = l.maxImageArrayLayers;
  limits.subgroupSize = v11.subgroupSize;
  limits.timestampPeriod = l.timestampPeriod;
}

// The first compute family whose timestamps work, graphics families first: they are the universal ones.
bool FindQueueFamily(VkPhysicalDevice physical, uint32_t& family, bool& timestamps) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
  int best = -1, bestScore = -1;
  for (uint32_t i = 0; i < count; ++i) {
    if (!(families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) || families[i].queueCount == 0) continue;
    const int score = (families[i].timestampValidBits > 0 ? 2 : 0) + ((families[i].queueFlags & VK_QUEUE_GRAPHICS_BIT) ? 1 : 0);
    if (score > bestScore) bestScore = score, best = static_cast<int>(i);
  }
  if (best < 0) return false;
  family = static_cast<uint32_t>(best);
  timestamps = families[family].timestampValidBits > 0;
  return true;
}

void FillFeatures(VkPhysicalDevice physical, DeviceInfo& info) {
  Features have;
  vkGetPhysicalDeviceFeatures2(physical, &have.core);
#define X(group, name) info.features.push_back({#name, true, have.group.name == VK_TRUE});
  WAVEFRONT_REQUIRED_FEATURES(X)
#undef X
#define X(group, name) info.features.push_back({#name, false, have.group.name == VK_TRUE});
  WAVEFRONT_OPTIONAL_FEATURES(X)
#undef X
  for (const FeatureInfo& feature : info.features) {
    if (feature.required && !feature.present) info.missing.push_back("feature " + feature.name);
  }
}

void FillMemory(VkPhysicalDevice physical, DeviceInfo& info) {
  VkPhysicalDeviceMemoryProperties memory{};
  vkGetPhysicalDeviceMemoryProperties(physical, &memory);
  for (uint32_t i = 0; i < memory.memoryHeapCount; ++i) {
    info.heaps.push_back({memory.memoryHeaps[i].size, (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0});
  }
  // A discrete GPU may show its memory to the host through the bus; staging is still the better way there.
  constexpr VkMemoryPropertyFlags kDirect = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                            VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  if (info.type != DeviceType::Discrete) {
    for (uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
      info.unifiedMemory |= (memory.memoryTypes[i].propertyFlags & kDirect) == kDirect;
    }
  }
}

Selection Describe(VkPhysicalDevice physical, uint32_t index) {
  Selection selection;
  selection.physical = physical;
  DeviceInfo& info = selection.info;
  VkPhysicalDeviceProperties properties{};
  vkGetPhysicalDeviceProperties(physical, &properties);
  info.index = index;
  info.name = properties.deviceName;
  info.apiVersion = VersionText(properties.apiVersion);
  info.type = TypeOf(properties.deviceType);
  if (info.type == DeviceType::Cpu) info.hostThreads = KernelThreads();
  if (properties.apiVersion < VK_API_VERSION_1_3) {
    info.missing.push_back("Vulkan 1.3 (it has " + info.apiVersion + ")");
    return selection;  // the queries below are of 1.3
  }

  auto v13 = Struct<VkPhysicalDeviceVulkan13Properties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES);
  auto v12 = Struct<VkPhysicalDeviceVulkan12Properties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES, &v13);
  auto v11 = Struct<VkPhysicalDeviceVulkan11Properties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES, &v12);
  auto properties2 = Struct<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &v11);
  vkGetPhysicalDeviceProperties2(physical, &properties2);
  info.driverName = v12.driverName;
  info.driverVersion = v12.driverInfo;
  FillLimits(physical, properties, v11, v13, info.limits);
  FillFeatures(physical, info);
  FillMemory(physical, info);

  const LimitCheck checks[] = {
      {"maxPushConstantsSize", info.limits.maxPushConstants, 128},
      {"maxComputeWorkGroupInvocations", info.limits.maxWorkGroupInvocations, 256},
      {"maxPerStageDescriptorStorageBuffers", info.limits.maxStorageBuffersPerStage, 32},
      {"maxPerStageDescriptorSampledImages", info.limits.maxSampledImagesPerStage, 64},
      {"maxTexelBufferElements", info.limits.maxTexelBufferElements, 1ull << 24},
      {"maxStorageBufferRange", info.limits.maxStorageBufferRange, 1ull << 27},
  };
  for (const LimitCheck& check : checks) {
    if (check.value < check.needed) {
      info.missing.push_back(std::string(check.name) + " of " + std::to_string(check.needed) + " (it has " +
                             std::to_string(check.value) + ")");
    }
  }
  constexpr VkSubgroupFeatureFlags kSubgroup = VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT;
  if ((v11.subgroupSupportedOperations & kSubgroup) != kSubgroup ||
      !(v11.subgroupSupportedStages & VK_SHADER_STAGE_COMPUTE_BIT)) {
    info.missing.push_back("subgroup operations in compute");
  }
  bool timestamps = false;
  if (!FindQueueFamily(physical, selection.queueFamily, timestamps)) {
    info.missing.push_back("a compute queue");
  } else if (!timestamps) {
    info.missing.push_back("timestamps on the compute queue");
  }
  return selection;
}

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

int Rank(DeviceType type) {
  switch (type) {
    case DeviceType::Discrete: return 0;
    case DeviceType::Integrated: return 1;
    case DeviceType::Virtual: return 2;
    case DeviceType::Cpu: return 3;
    default: return 4;
  }
}

bool Matches(const DeviceInfo& info, const std::string& selector) {
  if (selector.empty()) return true;
  if (selector.find_first_not_of("0123456789") == std::string::npos) {
    return selector.size() < 10 && std::stoul(selector) == info.index;
  }
  return Lower(info.name).find(Lower(selector)) != std::string::npos;
}

std::string Join(const std::vector<std::string>& parts, const char* separator) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : separator) + part;
  return text;
}

}  // namespace

std::string_view DeviceTypeName(DeviceType type) {
  switch (type) {
    case DeviceType::Discrete: return "discrete GPU";
    case DeviceType::Integrated: return "integrated GPU";
    case DeviceType::Virtual: return "virtual GPU";
    case DeviceType::Cpu: return "CPU";
    default: return "other";
  }
}

void EnableFeatures(VkPhysicalDevice physical, Features& enabled) {
  Features have;
  vkGetPhysicalDeviceFeatures2(physical, &have.core);
#define X(group, name) enabled.group.name = have.group.name;
  WAVEFRONT_REQUIRED_FEATURES(X)
  WAVEFRONT_OPTIONAL_FEATURES(X)
#undef X
}

Result<std::vector<Selection>> EnumerateDevices(const Instance& instance) {
  uint32_t count = 0;
  VkResult result = vkEnumeratePhysicalDevices(instance.handle, &count, nullptr);
  std::vector<VkPhysicalDevice> handles(count);
  if (result == VK_SUCCESS) result = vkEnumeratePhysicalDevices(instance.handle, &count, handles.data());
  if (result < 0) return VulkanError("vkEnumeratePhysicalDevices", result);
  handles.resize(count);
  std::vector<Selection> devices;
  for (uint32_t i = 0; i < handles.size(); ++i) devices.push_back(Describe(handles[i], i));
  return devices;
}

Result<Selection> SelectDevice(const Instance& instance, const std::string& selector) {
  auto devices = EnumerateDevices(instance);
  if (!devices) return devices.error();
  if (devices->empty()) {
    return Error{"there is no Vulkan device on this machine (Debian and Ubuntu: mesa-vulkan-drivers has one that "
                 "runs on the CPU)"};
  }
  const Selection* best = nullptr;
  std::vector<std::string> names, unfit;
  for (const Selection& device : *devices) {
    names.push_back(std::to_string(device.info.index) + ": " + device.info.name);
    if (!Matches(device.info, selector)) continue;
    if (!device.info.missing.empty()) {
      unfit.push_back(device.info.name + " lacks " + Join(device.info.missing, ", "));
    } else if (best == nullptr || Rank(device.info.type) < Rank(best->info.type)) {
      best = &device;
    }
  }
  if (best != nullptr) return *best;
  if (!unfit.empty()) return Error{"no Vulkan device fits: " + Join(unfit, "; ")};
  return Error{"no Vulkan device matches '" + selector + "'; the devices by index: " + Join(names, ", ")};
}

}  // namespace wavefront::vulkan
