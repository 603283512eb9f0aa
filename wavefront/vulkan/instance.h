// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The VkInstance, shared by all devices of the process that agree about validation. Private to wavefront/vulkan.
#pragma once

#include <volk.h>

#include <cstdint>
#include <memory>
#include <mutex>

#include "wavefront/base/result.h"

namespace wavefront::vulkan {

enum class Validation : uint8_t { Off, On, Synchronization };

struct Instance {
  VkInstance handle = VK_NULL_HANDLE;
  Validation validation = Validation::Off;
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
  // Not core, so loaded per instance; null where VK_EXT_debug_utils is absent.
  PFN_vkDestroyDebugUtilsMessengerEXT destroyMessenger = nullptr;
  PFN_vkSetDebugUtilsObjectNameEXT setObjectName = nullptr;
  PFN_vkCmdBeginDebugUtilsLabelEXT beginLabel = nullptr;
  PFN_vkCmdEndDebugUtilsLabelEXT endLabel = nullptr;

  Instance() = default;
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  // The living instance with this setting, or a new one. Thread-safe.
  static Result<std::shared_ptr<Instance>> Acquire(Validation validation);
};

// Held while devices and instances come and go and while their functions are looked up: the loader walks its list of
// devices with a lock and changes it without one (KhronosGroup/Vulkan-Loader issue 2018).
std::mutex& LoaderMutex();

}  // namespace wavefront::vulkan
