// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The megakernel of a scene: which one, and its dispatches. Same stages as the wavefront loop, in one pipeline.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "wavefront/renderer.h"
#include "wavefront/scene/material_table.h"
#include "wavefront/scheduler/kernel_registry.h"
#include "wavefront/vulkan/command_stream.h"

namespace wavefront {

class Megakernel {
 public:
  explicit Megakernel(vulkan::Device& device) : device_(device) {}

  void SetLinker(MegakernelLinker linker) { linker_ = std::move(linker); }
  // Links the megakernel of the used buckets' kernels, unless the one at hand is it. False: this scene has
  // none, and `trouble` says why; an Error is the environment's.
  Result<bool> Prepare(const MaterialTable& materials, const std::vector<bool>& used, const KernelRegistry& registry,
                       Diagnostic* trouble);
  // Makes the driver compile it. `set` is as it will be used: what lavapipe compiles depends on the formats that it holds.
  Status WarmUp(KernelRegistry& registry, vulkan::CommandStream& stream, const vulkan::DescriptorSet& set);
  // mega_turn and the megakernel, once or several times; the turn closes the last dispatch.
  void Record(vulkan::CommandStream& stream, const KernelRegistry& registry, const vulkan::Buffer& counters,
              uint32_t dispatches, std::vector<uint32_t>* rows) const;

  // Profiler row of the megakernel's dispatches, beside the registry's.
  static constexpr uint32_t kRow = 0xffffffffu;
  KernelTimes& times() { return times_; }
  const KernelTimes& times() const { return times_; }

 private:
  vulkan::Device& device_;
  MegakernelLinker linker_;
  std::vector<std::string> keys_;  // of the pipeline, in the order of its constants
  uint32_t features_ = 0;  // SceneFeatures that it was made for
  std::unique_ptr<vulkan::ComputePipeline> pipeline_;
  bool isWarm_ = false;
  std::vector<std::string> tooSlow_;  // kernels whose megakernel was given up
  KernelTimes times_;
};

}  // namespace wavefront
