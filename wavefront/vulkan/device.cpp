// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/vulkan/device.h"

#include <algorithm>
#include <cstdlib>

#include "wavefront/vulkan/context.h"
#include "wavefront/vulkan/live_handles.h"
#include "wavefront/vulkan/transfer.h"

namespace wavefront::vulkan {
namespace {

std::string Environment(const char* name) {
  const char* text = std::getenv(name);
  return text != nullptr ? text : "";
}

Validation WantedValidation(const DeviceOptions& options) {
  if (options.neverValidate) return Validation::Off;
  const std::string environment = Environment("HDWAVEFRONT_VALIDATION");
  if (options.synchronizationValidation || environment == "sync") return Validation::Synchronization;
  return options.validation || (!environment.empty() && environment != "0") ? Validation::On : Validation::Off;
}

// VK_KHR_pipeline_executable_properties is there, and asked for: it may cost pipeline creation its caches.
bool CapturesStatistics(VkPhysicalDevice physical) {
  const std::string wish = Environment("HDWAVEFRONT_DRIVER_STATISTICS");
  if (wish.empty() || wish == "0") return false;
  uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, extensions.data());
  const bool isThere = std::any_of(extensions.begin(), extensions.end(), [](const VkExtensionProperties& e) {
    return std::string_view(e.extensionName) == VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;
  });
  if (!isThere) return false;
  auto wanted = Struct<VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR>(
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR);
  auto features = Struct<VkPhysicalDeviceFeatures2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &wanted);
  vkGetPhysicalDeviceFeatures2(physical, &features);
  return wanted.pipelineExecutableInfo == VK_TRUE;
}

Status CreateLogicalDevice(Context& context) {
  const float priority = 1;
  auto queue = Struct<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
  queue.queueFamilyIndex = context.queueFamily;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  Features features;
  EnableFeatures(context.physical, features);
  auto info = Struct<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features.core);
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  context.capturesStatistics = CapturesStatistics(context.physical);
  auto statistics = Struct<VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR>(
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR);
  statistics.pipelineExecutableInfo = VK_TRUE;
  const char* extension = VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;
  if (context.capturesStatistics) {
    statistics.pNext = features.core.pNext;
    features.core.pNext = &statistics;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
  }
  std::scoped_lock loader(LoaderMutex());
  const VkResult result = vkCreateDevice(context.physical, &info, nullptr, &context.device);
  if (result != VK_SUCCESS) {
    context.device = VK_NULL_HANDLE;
    return Error{VulkanError("vkCreateDevice", result).message + " on " + context.info.name};
  }
  CountHandle(HandleKind::Device, 1);
  volkLoadDeviceTable(&context.vk, context.device);
  CountDeviceHandles(context.instance->handle, context.vk);
  context.vk.vkGetDeviceQueue(context.device, context.queueFamily, 0, &context.queue);
  vkGetPhysicalDeviceMemoryProperties(context.physical, &context.memoryProperties);
  return {};
}

uint64_t LargestLocalHeap(const DeviceInfo& info) {
  uint64_t size = 0;
  for (const HeapInfo& heap : info.heaps) {
    if (heap.deviceLocal) size = std::max(size, heap.size);
  }
  return size;
}

}  // namespace

Context::~Context() {
  if (device == VK_NULL_HANDLE) return;
  vk.vkDeviceWaitIdle(device);
  transfer_.reset();
  if (pipelineCache != VK_NULL_HANDLE) vk.vkDestroyPipelineCache(device, pipelineCache, nullptr);
  {
    std::scoped_lock loader(LoaderMutex());
    vk.vkDestroyDevice(device, nullptr);
  }
  CountHandle(HandleKind::Device, -1);
}

int64_t LiveDevices() { return LiveHandles()["Device"]; }

Result<std::vector<DeviceInfo>> ListDevices() {
  auto instance = Instance::Acquire(Validation::Off);
  if (!instance) return instance.error();
  auto devices = EnumerateDevices(**instance);
  if (!devices) return devices.error();
  std::vector<DeviceInfo> infos;
  for (Selection& device : *devices) infos.push_back(std::move(device.info));
  return infos;
}

Result<std::unique_ptr<Device>> Device::Create(const DeviceOptions& options) {
  auto instance = Instance::Acquire(WantedValidation(options));
  if (!instance) return instance.error();
  auto selection = SelectDevice(**instance, options.selector.empty() ? Environment("HDWAVEFRONT_DEVICE") : options.selector);
  if (!selection) return selection.error();

  auto context = std::make_shared<Context>();
  context->instance = *instance;
  context->physical = selection->physical;
  context->queueFamily = selection->queueFamily;
  context->info = std::move(selection->info);
  context->directWrites = context->info.unifiedMemory && !options.forceStaging;
  context->budget = options.memoryBudgetBytes != 0 ? options.memoryBudgetBytes : LargestLocalHeap(context->info);
  if (Status created = CreateLogicalDevice(*context); !created) return created.error();

  std::vector<std::byte> kept(options.pipelineCache.begin(), options.pipelineCache.end());
  if (options.pipelineCacheOf) kept = options.pipelineCacheOf(context->info);
  auto cache = Struct<VkPipelineCacheCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO);
  cache.initialDataSize = kept.size();
  cache.pInitialData = kept.data();
  VkResult result = context->vk.vkCreatePipelineCache(context->device, &cache, nullptr, &context->pipelineCache);
  if (result != VK_SUCCESS) return context->Fail("vkCreatePipelineCache", result);
  context->CreateTransfer();
  return std::unique_ptr<Device>(new Device(std::move(context)));
}

Device::Device(std::shared_ptr<Context> context) : context_(std::move(context)) {}
Device::~Device() = default;

const DeviceInfo& Device::info() const { return context_->info; }
bool Device::validation() const { return context_->instance->validation != Validation::Off; }
bool Device::lost() const { return context_->lost; }
uint64_t Device::memoryBudget() const { return context_->budget; }
MemoryUse Device::memoryUse() const { return context_->MemoryTotal(); }
MemoryByKind Device::memoryByKind() const { return context_->MemoryKinds(); }
int64_t Device::liveObjects() const { return context_->liveObjects; }
uint64_t Device::uploadedBytes() const { return context_->uploadedBytes; }
Status Device::WaitIdle() { return context_->WaitIdle(); }

Result<std::vector<std::byte>> Device::PipelineCacheData() const {
  Context& context = *context_;
  std::size_t size = 0;
  VkResult result = context.vk.vkGetPipelineCacheData(context.device, context.pipelineCache, &size, nullptr);
  std::vector<std::byte> data(size);
  if (result == VK_SUCCESS) {
    result = context.vk.vkGetPipelineCacheData(context.device, context.pipelineCache, &size, data.data());
  }
  if (result < 0) return context.Fail("vkGetPipelineCacheData", result);
  data.resize(size);
  return data;
}

}  // namespace wavefront::vulkan
