// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Pipelines of the fixed kernels and of every material bucket, and what making them cost.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "wavefront/scene/material_table.h"
#include "wavefront/vulkan/command_stream.h"
#include "wavefront/vulkan/descriptors.h"
#include "wavefront/vulkan/pipeline.h"

namespace wavefront {

enum class Kernel : uint32_t {
#define WAVEFRONT_KERNEL(Name, file, doc) Name,
#include "wavefront/shared/kernels.def"
#undef WAVEFRONT_KERNEL
  kCount
};
constexpr uint32_t kKernelCount = static_cast<uint32_t>(Kernel::kCount);

struct KernelTimes {
  std::string name;
  double createSeconds = 0, firstDispatchSeconds = 0;
  double seconds = 0;       // on the device
  uint64_t dispatches = 0;
};

class KernelRegistry {
 public:
  static Result<std::unique_ptr<KernelRegistry>> Create(vulkan::Device& device);

  const vulkan::PipelineLayout& layout() const { return *layout_; }
  const vulkan::ComputePipeline& fixed(Kernel kernel) const { return *fixed_[static_cast<uint32_t>(kernel)]; }
  // Null: nothing has used that bucket yet.
  const vulkan::ComputePipeline* bucket(uint32_t index) const { return buckets_[index].get(); }

  // Pipelines for used buckets that have none yet, created on `threads` threads, then dispatched once with no work:
  // that is where lavapipe compiles. A bucket that no instance uses costs nothing.
  Status AddBuckets(const std::vector<Bucket>& buckets, const std::vector<bool>& used, unsigned threads,
                    vulkan::CommandStream& stream, const vulkan::DescriptorSet& set);

  // Times by profiler row: fixed kernels, then buckets.
  std::vector<KernelTimes>& times() { return times_; }
  const std::vector<KernelTimes>& times() const { return times_; }

 private:
  explicit KernelRegistry(vulkan::Device& device) : device_(device) {}
  Status WarmUp(const vulkan::ComputePipeline& pipeline, KernelTimes& times, vulkan::CommandStream& stream, const vulkan::DescriptorSet& set);

  vulkan::Device& device_;
  std::unique_ptr<vulkan::PipelineLayout> layout_;
  std::vector<std::unique_ptr<vulkan::ComputePipeline>> fixed_, buckets_;
  std::vector<KernelTimes> times_;
  bool fixedWarm_ = false;
};

}  // namespace wavefront
