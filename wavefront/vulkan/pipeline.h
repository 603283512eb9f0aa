// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A compute kernel ready to be dispatched.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "wavefront/base/result.h"
#include "wavefront/vulkan/descriptors.h"
#include "wavefront/vulkan/device.h"

namespace wavefront::vulkan {

struct PipelineDesc {
  std::span<const uint32_t> spirv;
  std::string entryPoint = "main";
  // (constant_id, bits); a workgroup size is one too: layout(local_size_x_id = ...).
  std::vector<std::pair<uint32_t, uint32_t>> specialization;
  std::string name;  // for errors, debuggers and the profiler
};

// Immutable. Create may be called from several threads at once. On lavapipe the expensive part comes with the first
// dispatch: a dispatch of (0, 1, 1) groups compiles.
class ComputePipeline {
 public:
  static Result<std::unique_ptr<ComputePipeline>> Create(Device& device, const PipelineLayout& layout,
                                                         const PipelineDesc& desc);
  ~ComputePipeline();
  ComputePipeline(const ComputePipeline&) = delete;
  ComputePipeline& operator=(const ComputePipeline&) = delete;

  const std::string& name() const { return name_; }
  double creationSeconds() const { return creationSeconds_; }
  // "name: value" of what the driver tells of the machine code (VK_KHR_pipeline_executable_properties): registers, spills,
  // code size. Empty where it tells nothing or DeviceOptions did not ask.
  std::vector<std::string> DriverStatistics() const;
  VkPipeline handle() const { return pipeline_; }

 private:
  explicit ComputePipeline(Device& device);
  ContextRef context_;
  std::string name_;
  double creationSeconds_ = 0;
  VkPipeline pipeline_ = nullptr;
};

}  // namespace wavefront::vulkan
