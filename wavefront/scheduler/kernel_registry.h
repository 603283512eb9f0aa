// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Pipelines of the fixed kernels and of every material bucket, and what making them cost. Material kernels are compiled in
// the background (kernel_compiler.h): a bucket is there before its pipeline is.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "wavefront/base/diagnostics.h"
#include "wavefront/scene/material_table.h"
#include "wavefront/scene/scene_commit.h"
#include "wavefront/scheduler/kernel_compiler.h"
#include "wavefront/vulkan/command_stream.h"
#include "wavefront/vulkan/descriptors.h"
#include "wavefront/vulkan/pipeline.h"

namespace wavefront {

// One bit per row of shared/features.def.
struct SceneFeatures {
  static constexpr uint32_t kFirstConstant = 1000;  // as lib/features.glsl has it
  uint32_t bits = 0;

  static SceneFeatures Of(const SceneFacts& facts);
  // (constant_id, bits), as PipelineDesc has it.
  std::vector<std::pair<uint32_t, uint32_t>> Specialization() const;
};

enum class Kernel : uint32_t {
#define WAVEFRONT_KERNEL(Name, file, doc) Name,
#include "wavefront/shared/kernels.def"
#undef WAVEFRONT_KERNEL
  kCount
};
constexpr uint32_t kKernelCount = static_cast<uint32_t>(Kernel::kCount);

struct KernelTimes {
  std::string name;
  CompileCost compile;
  double seconds = 0;       // on the device, for the image that is being rendered
  uint64_t dispatches = 0;
  double measuredSeconds = 0;     // of a bucket's own kernel, over all images
  uint64_t measuredItems = 0;
};

class KernelRegistry {
 public:
  static Result<std::unique_ptr<KernelRegistry>> Create(vulkan::Device& device);

  const vulkan::PipelineLayout& layout() const { return *layout_; }
  const vulkan::ComputePipeline& fixed(Kernel kernel) const { return *fixed_[static_cast<uint32_t>(kernel)]; }

  // Of a bucket's pipeline. Unused: no instance wears it, and nothing was compiled.
  enum class State : uint8_t { Unused, Compiling, Ready, Failed };
  State state(uint32_t bucket) const { return buckets_[bucket].state; }
  KernelEntry entry(uint32_t bucket) const { return buckets_[bucket].entry; }
  // The bucket's own; where that is not ready, the neutral one that stands in for its entry point, once it was asked for.
  const vulkan::ComputePipeline* bucket(uint32_t index) const { return buckets_[index].pipeline.get(); }
  Result<const vulkan::ComputePipeline*> StandIn(KernelEntry entry);

  // Orders pipelines for used buckets that have none yet from threads of their own: this returns at once.
  void Order(const std::vector<Bucket>& buckets, const std::vector<bool>& used, unsigned threads);
  // Makes the fixed kernels that go by features (shared/features.def) for a scene. What once was there counts as there from
  // then on, so that lights that come and go compile nothing. Nothing that uses the kernels may be in flight.
  Status Specialize(SceneFeatures features);
  SceneFeatures features() const { return features_; }
  // Dispatches the fixed kernels once with no work: that is where lavapipe compiles.
  // Those of media wait for a scene with some. The threads that compile materials help; nothing is seen without these.
  Status WarmUpFixed(bool media, unsigned threads, vulkan::CommandStream& stream, const vulkan::DescriptorSet& set);
  // Buckets whose pipeline has come, or failed, since the last call. What went wrong is said.
  std::vector<uint32_t> Adopt(const DiagnosticSink& sink);
  // Buckets that Adopt has not handed out yet, and those of them whose compiling is over.
  uint32_t pending() const { return pending_; }
  uint32_t finished() const { return compiler_ ? static_cast<uint32_t>(compiler_->finished()) : 0u; }
  // What one path of a bucket takes, measured so far, over all renders; 0: not known.
  float NanosecondsPerPath(uint32_t bucket) const {
    const KernelTimes& times = times_[kKernelCount + bucket];
    return times.measuredItems == 0 ? 0.0f : static_cast<float>(times.measuredSeconds * 1e9 / static_cast<double>(times.measuredItems));
  }
  // The driver compiles, or reads its cache, at a pipeline's first dispatch.
  bool compilesAtDispatch() const { return compiler_ && compiler_->driverCompile() != vulkan::DriverCompile::AtCreation; }
  // Until Adopt has something, or the time is over. Any thread, while no Order runs.
  void WaitForKernels(double seconds) { if (compiler_) compiler_->Wait(seconds); }

  // The dispatch without work that makes a driver compile what it put off.
  static Status WarmUp(const vulkan::ComputePipeline& pipeline, KernelTimes& times, vulkan::CommandStream& stream, const vulkan::DescriptorSet& set);

  // Times by profiler row: fixed kernels, then buckets.
  std::vector<KernelTimes>& times() { return times_; }
  const std::vector<KernelTimes>& times() const { return times_; }

 private:
  explicit KernelRegistry(vulkan::Device& device) : device_(device) {}

  struct BucketKernel {
    State state = State::Unused;
    KernelEntry entry = KernelEntry::Surface;
    std::string user;
    std::unique_ptr<vulkan::ComputePipeline> pipeline;
  };
  vulkan::PipelineDesc DescOf(Kernel kernel) const;
  Result<std::unique_ptr<vulkan::ComputePipeline>> CreateFixed(Kernel kernel);

  vulkan::Device& device_;
  std::unique_ptr<vulkan::PipelineLayout> layout_;
  std::vector<std::unique_ptr<vulkan::ComputePipeline>> fixed_;
  std::vector<BucketKernel> buckets_;
  std::vector<KernelTimes> times_;
  uint32_t pending_ = 0;
  std::array<bool, kKernelCount> fixedWarm_{};
  SceneFeatures features_;
  bool specialized_ = false;
  bool saidNoCache_ = false, saidTrouble_ = false;
  std::unique_ptr<KernelCompiler> compiler_;  // its threads use what stands above
};

}  // namespace wavefront
