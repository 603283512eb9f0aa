// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#define VOLK_IMPLEMENTATION
#include "wavefront/vulkan/instance.h"

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <vector>

#include "wavefront/vulkan/context.h"
#include "wavefront/vulkan/device.h"
#include "wavefront/vulkan/live_handles.h"

namespace wavefront::vulkan {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";
constexpr std::size_t kKeptMessages = 100;
constexpr uint64_t kPrintedMessages = 20;

std::atomic<uint64_t> validationCount{0};
std::mutex messagesMutex;
std::vector<std::string>& KeptMessages() {
  static std::vector<std::string> messages;
  return messages;
}

VKAPI_ATTR VkBool32 VKAPI_CALL OnMessage(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                         VkDebugUtilsMessageTypeFlagsEXT, const VkDebugUtilsMessengerCallbackDataEXT* data,
                                         void*) {
  const char* level = severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT ? "error" : "warning";
  const char* text = data != nullptr && data->pMessage != nullptr ? data->pMessage : "(no text)";
  // One fault repeats every frame: the first few tell it all.
  if (validationCount++ < kPrintedMessages) std::fprintf(stderr, "vulkan validation %s: %s\n", level, text);
  std::scoped_lock lock(messagesMutex);
  if (KeptMessages().size() < kKeptMessages) KeptMessages().push_back(std::string(level) + ": " + text);
  return VK_FALSE;
}

bool HasLayer(const char* name) {
  uint32_t count = 0;
  if (vkEnumerateInstanceLayerProperties(&count, nullptr) != VK_SUCCESS) return false;
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  layers.resize(count);
  for (const auto& layer : layers) {
    if (std::strcmp(layer.layerName, name) == 0) return true;
  }
  return false;
}

bool HasExtension(const char* layer, const char* name) {
  uint32_t count = 0;
  if (vkEnumerateInstanceExtensionProperties(layer, &count, nullptr) != VK_SUCCESS) return false;
  std::vector<VkExtensionProperties> extensions(count);
  vkEnumerateInstanceExtensionProperties(layer, &count, extensions.data());
  extensions.resize(count);
  for (const auto& extension : extensions) {
    if (std::strcmp(extension.extensionName, name) == 0) return true;
  }
  return false;
}

template <typename Function>
Function Load(VkInstance instance, const char* name) {
  return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

Result<std::shared_ptr<Instance>> CreateInstance(Validation validation) {
  const bool listening = validation != Validation::Off;
  if (vkEnumerateInstanceVersion == nullptr) {
    return Error{"the Vulkan loader is too old: Vulkan 1.3 is needed"};
  }
  uint32_t version = 0;
  vkEnumerateInstanceVersion(&version);
  if (version < VK_API_VERSION_1_3) {
    return Error{"the Vulkan loader is of version " + VersionText(version) + ": 1.3 is needed"};
  }
  if (listening && !HasLayer(kValidationLayer)) {
    return Error{"Vulkan validation was asked for, but the validation layer is not installed "
                 "(Debian and Ubuntu: vulkan-validationlayers)"};
  }

  const bool debugUtils = HasExtension(nullptr, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  const bool validationFeatures = validation == Validation::Synchronization;
  if (validationFeatures && !HasExtension(kValidationLayer, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME)) {
    return Error{"synchronization validation was asked for, but the validation layer has no VK_EXT_validation_features"};
  }
  std::vector<const char*> extensions;
  if (debugUtils) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  if (validationFeatures) extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);

  auto messenger = Struct<VkDebugUtilsMessengerCreateInfoEXT>(VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT);
  messenger.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = OnMessage;

  const VkValidationFeatureEnableEXT enables[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  auto features = Struct<VkValidationFeaturesEXT>(VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT);
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = enables;

  auto application = Struct<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.pApplicationName = "hdWavefront";
  application.pEngineName = "hdWavefront";
  application.apiVersion = VK_API_VERSION_1_3;
  auto info = Struct<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  info.pNext = validationFeatures ? &features : nullptr;
  info.pApplicationInfo = &application;
  info.enabledLayerCount = listening ? 1 : 0;
  info.ppEnabledLayerNames = &kValidationLayer;
  info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();

  auto instance = std::make_shared<Instance>();
  instance->validation = validation;
  std::scoped_lock loader(LoaderMutex());
  if (const VkResult result = vkCreateInstance(&info, nullptr, &instance->handle); result != VK_SUCCESS) {
    instance->handle = VK_NULL_HANDLE;
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER) {
      return Error{"there is no Vulkan driver on this machine, or VK_DRIVER_FILES names none that works (Debian and "
                   "Ubuntu: mesa-vulkan-drivers has one that runs on the CPU)"};
    }
    return VulkanError("vkCreateInstance", result);
  }
  CountHandle(HandleKind::Instance, 1);
  // Core functions got here are the loader's own and serve every instance: loading them once is enough,
  // and never writes them while another thread calls through them.
  static std::once_flag loaded;
  std::call_once(loaded, [&] { volkLoadInstanceOnly(instance->handle); });

  if (debugUtils) {
    instance->destroyMessenger =
        Load<PFN_vkDestroyDebugUtilsMessengerEXT>(instance->handle, "vkDestroyDebugUtilsMessengerEXT");
    instance->setObjectName = Load<PFN_vkSetDebugUtilsObjectNameEXT>(instance->handle, "vkSetDebugUtilsObjectNameEXT");
    instance->beginLabel = Load<PFN_vkCmdBeginDebugUtilsLabelEXT>(instance->handle, "vkCmdBeginDebugUtilsLabelEXT");
    instance->endLabel = Load<PFN_vkCmdEndDebugUtilsLabelEXT>(instance->handle, "vkCmdEndDebugUtilsLabelEXT");
    auto create = Load<PFN_vkCreateDebugUtilsMessengerEXT>(instance->handle, "vkCreateDebugUtilsMessengerEXT");
    if (listening && create != nullptr) {
      const VkResult result = create(instance->handle, &messenger, nullptr, &instance->messenger);
      if (result != VK_SUCCESS) return VulkanError("vkCreateDebugUtilsMessengerEXT", result);
    }
  }
  if (listening && instance->messenger == VK_NULL_HANDLE) {
    return Error{"Vulkan validation was asked for, but its messages cannot be received (no VK_EXT_debug_utils)"};
  }
  return instance;
}

}  // namespace

std::mutex& LoaderMutex() {
  static std::mutex mutex;
  return mutex;
}

Instance::~Instance() {
  if (messenger != VK_NULL_HANDLE) destroyMessenger(handle, messenger, nullptr);
  if (handle == VK_NULL_HANDLE) return;
  {
    std::scoped_lock loader(LoaderMutex());
    vkDestroyInstance(handle, nullptr);
  }
  CountHandle(HandleKind::Instance, -1);
}

Result<std::shared_ptr<Instance>> Instance::Acquire(Validation validation) {
  static std::mutex mutex;
  static std::weak_ptr<Instance> living[3];
  const auto level = static_cast<std::size_t>(validation);
  std::scoped_lock lock(mutex);
  if (auto instance = living[level].lock()) return instance;
  static const VkResult initialized = volkInitialize();
  if (initialized != VK_SUCCESS) {
    return Error{"there is no Vulkan loader on this machine (libvulkan.so.1; Debian and Ubuntu: libvulkan1, and "
                 "mesa-vulkan-drivers for a device)"};
  }
  auto created = CreateInstance(validation);
  if (created) living[level] = *created;
  return created;
}

uint64_t ValidationMessageCount() { return validationCount; }

std::vector<std::string> ValidationMessages() {
  std::scoped_lock lock(messagesMutex);
  return KeptMessages();
}

}  // namespace wavefront::vulkan
