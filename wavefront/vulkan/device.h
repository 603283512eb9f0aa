// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The device: which one is taken, what it can do, and what its memory is used for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "wavefront/base/result.h"
#include "wavefront/vulkan/handles.h"
#include "wavefront/vulkan/memory_kind.h"

namespace wavefront::vulkan {

enum class DeviceType : uint8_t { Discrete, Integrated, Virtual, Cpu, Other };
std::string_view DeviceTypeName(DeviceType type);

struct DeviceLimits {
  uint64_t maxStorageBufferRange = 0;  // bytes of one storage-buffer binding
  uint64_t maxBufferSize = 0;          // bytes
  uint64_t maxTexelBufferElements = 0;
  uint64_t texelBufferOffsetAlignment = 1;    // bytes
  uint64_t storageBufferOffsetAlignment = 1;  // bytes
  uint32_t maxWorkGroupInvocations = 0;
  uint32_t maxWorkGroupCountX = 0;
  uint32_t maxSharedMemory = 0;  // bytes
  uint32_t maxPushConstants = 0;  // bytes
  uint32_t maxStorageBuffersPerStage = 0;
  uint32_t maxSampledImagesPerStage = 0;  // texel buffers count as sampled images
  uint32_t maxResourcesPerStage = 0;
  uint32_t maxImageDimension2D = 0;
  uint32_t maxImageDimension3D = 0;
  uint32_t maxImageArrayLayers = 0;
  uint32_t subgroupSize = 0;
  double timestampPeriod = 1;  // nanoseconds per tick
};

struct FeatureInfo {
  std::string name;
  bool required = false;
  bool present = false;  // present features of this list are enabled
};

struct HeapInfo {
  uint64_t size = 0;  // bytes
  bool deviceLocal = false;
};

// What `hdwavefront doctor` prints.
struct DeviceInfo {
  uint32_t index = 0;  // as DeviceOptions::selector takes it
  std::string name, driverName, driverVersion, apiVersion;
  DeviceType type = DeviceType::Other;
  DeviceLimits limits;
  std::vector<FeatureInfo> features;
  std::vector<HeapInfo> heaps;
  bool unifiedMemory = false;        // the host writes device memory directly
  uint32_t hostThreads = 0;          // CPU devices: threads that run kernels; else 0
  std::vector<std::string> missing;  // what hdWavefront needs and this device lacks; empty: usable
};

// Every Vulkan device of the machine, usable or not. An error when there is no Vulkan loader.
Result<std::vector<DeviceInfo>> ListDevices();

struct DeviceOptions {
  // Index, or part of the name (case does not count). Empty: $HDWAVEFRONT_DEVICE; that empty too: a discrete
  // GPU, else an integrated one, else a virtual one, else the CPU.
  std::string selector;
  bool validation = false;          // $HDWAVEFRONT_VALIDATION=1 turns it on too
  uint64_t memoryBudgetBytes = 0;   // 0: the size of the largest device-local heap
  bool forceStaging = false;        // treat memory as a discrete GPU's even where it is unified (tests)
  std::span<const std::byte> pipelineCache;  // from PipelineCacheData() of an earlier run; foreign data is ignored
  // Hazards between commands as well ($HDWAVEFRONT_VALIDATION=sync). It sees whole bindings only: kernels that run side
  // by side on different paths of one buffer are a hazard to it, so it is for looking at one place at a time.
  bool synchronizationValidation = false;
  // In place of `pipelineCache`, when the device is chosen.
  std::function<std::vector<std::byte>(const DeviceInfo&)> pipelineCacheOf;
  // Whatever stands above and in the environment. For devices that come and go while others work: the validation layer
  // looks devices up in a table that it does not lock (KhronosGroup/Vulkan-ValidationLayers issue 4391), so that one made
  // in a thread of its own crashes a call of any other.
  bool neverValidate = false;
};

// Messages of the validation layer since the process started: warnings and errors, all devices.
uint64_t ValidationMessageCount();
std::vector<std::string> ValidationMessages();  // the first hundred

// One logical device with one compute queue. Thread-safe, and so is the creation of objects on it.
// Objects may outlive their Device: the last one out destroys the VkDevice.
class Device {
 public:
  // An error names what is missing on which device.
  static Result<std::unique_ptr<Device>> Create(const DeviceOptions& options = {});
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceInfo& info() const;
  bool validation() const;
  bool lost() const;  // true after the driver said so; every later call returns an error

  uint64_t memoryBudget() const;
  MemoryUse memoryUse() const;  // all kinds together
  MemoryByKind memoryByKind() const;

  // Buffers, images, views, layouts, sets, pipelines and streams alive on this device.
  int64_t liveObjects() const;

  // By Buffer::Upload and Image::Upload since the device was made.
  uint64_t uploadedBytes() const;

  // To be kept on disk and given back in DeviceOptions. Useful where pipeline creation compiles (NVIDIA).
  Result<std::vector<std::byte>> PipelineCacheData() const;

  // Blocks until the queue is idle. For shutdown and tests; frames use CommandStream::Wait.
  Status WaitIdle();

  const std::shared_ptr<Context>& context() const { return context_; }  // for wavefront/vulkan only

 private:
  explicit Device(std::shared_ptr<Context> context);
  std::shared_ptr<Context> context_;
};

// Vulkan handles alive in this process, by kind ("Buffer", "DeviceMemory", "Instance" ...), counted where the driver is
// called. All kinds are there, also those with none.
std::map<std::string, int64_t> LiveHandles();
// VkDevices alive in this process.
int64_t LiveDevices();
// Bytes of device memory allocated in this process, as they are charged to the budgets.
int64_t LiveDeviceBytes();

}  // namespace wavefront::vulkan
