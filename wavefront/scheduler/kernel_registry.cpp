// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/kernel_registry.h"

#include <chrono>

#include "wavefront/base/check.h"
#include "wavefront/base/parallel.h"
#include "wavefront/scheduler/kernel_spirv.h"

namespace wavefront {
namespace {

struct FixedKernel { const char* file; };
constexpr FixedKernel kFixed[] = {
#define WAVEFRONT_KERNEL(Name, file, doc) {file},
#include "wavefront/shared/kernels.def"
#undef WAVEFRONT_KERNEL
};

std::vector<vulkan::Binding> Bindings() {
  using vulkan::DescriptorKind;
  // Texel bindings by the type that lib/bindings.glsl declares; a test compares the two.
  auto texelKind = [](uint32_t number) {
    switch (number) {
      case 9: case 13: case 15: case 16: case 18: return DescriptorKind::TexelBufferFloat;
      default: return DescriptorKind::TexelBufferUint;
    }
  };
  std::vector<vulkan::Binding> bindings;
  enum { Storage, Texel, Uniform };
  auto add = [&](uint32_t number, int kind) {
    bindings.push_back({number, kind == Storage ? DescriptorKind::StorageBuffer : kind == Uniform ? DescriptorKind::UniformBuffer : texelKind(number), 1});
  };
#define WAVEFRONT_BINDING(Name, number, kind) add(number, kind);
#include "wavefront/shared/bindings.def"
#undef WAVEFRONT_BINDING
  return bindings;
}

const char* EntryName(KernelEntry entry) {
  return entry == KernelEntry::Surface ? "surface" : entry == KernelEntry::Opacity ? "opacity" : "emission";
}

}  // namespace

Result<std::unique_ptr<KernelRegistry>> KernelRegistry::Create(vulkan::Device& device) {
  std::unique_ptr<KernelRegistry> registry(new KernelRegistry(device));
  auto layout = vulkan::PipelineLayout::Create(device, Bindings(), "kernels");
  if (!layout) return layout.error();
  registry->layout_ = std::move(layout).value();
  for (const FixedKernel& kernel : kFixed) {
    auto pipeline = vulkan::ComputePipeline::Create(device, *registry->layout_, {KernelSpirv(kernel.file), "main", {}, kernel.file});
    if (!pipeline) return pipeline.error();
    KernelTimes times;
    times.name = kernel.file;
    times.createSeconds = pipeline.value()->creationSeconds();
    registry->times_.push_back(times);
    registry->fixed_.push_back(std::move(pipeline).value());
  }
  return registry;
}

Status KernelRegistry::WarmUp(const vulkan::ComputePipeline& pipeline, KernelTimes& times, vulkan::CommandStream& stream, const vulkan::DescriptorSet& set) {
  const auto start = std::chrono::steady_clock::now();
  if (auto free = stream.Wait(stream.nextFreeAt()); !free) return free.error();
  if (Status s = stream.Begin(); !s) return s;
  stream.BindSet(set);
  stream.BindPipeline(pipeline);
  const uint32_t push[4] = {};
  stream.PushConstants(std::as_bytes(std::span(push)));
  stream.Dispatch(0, 1, 1);
  auto value = stream.Submit();
  if (!value) return value.error();
  if (auto done = stream.Wait(value.value()); !done) return done.error();
  times.firstDispatchSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return {};
}

Status KernelRegistry::AddBuckets(const std::vector<Bucket>& buckets, const std::vector<bool>& used, unsigned threads,
                                  vulkan::CommandStream& stream, const vulkan::DescriptorSet& set) {
  if (!fixedWarm_) {
    for (uint32_t k = 0; k < kKernelCount; ++k) {
      if (Status s = WarmUp(*fixed_[k], times_[k], stream, set); !s) return s;
    }
    fixedWarm_ = true;
  }
  for (std::size_t b = buckets_.size(); b < buckets.size(); ++b) {
    KernelTimes times;
    times.name = "material:" + buckets[b].kernelKey + ":" + EntryName(buckets[b].entry);
    times_.push_back(times);
  }
  buckets_.resize(buckets.size());
  std::vector<std::size_t> wanted;
  for (std::size_t b = 0; b < buckets.size(); ++b) if (b < used.size() && used[b] && !buckets_[b]) wanted.push_back(b);
  std::vector<Error> errors(wanted.size());
  ParallelFor(wanted.size(), threads, [&](std::size_t i) {
    const std::size_t b = wanted[i];
    auto pipeline = vulkan::ComputePipeline::Create(device_, *layout_, {buckets[b].spirv, "main", {}, times_[kKernelCount + b].name});
    if (pipeline.ok()) buckets_[b] = std::move(pipeline).value();
    else errors[i] = pipeline.error();
  });
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const std::size_t b = wanted[i];
    KernelTimes& times = times_[kKernelCount + b];
    if (!buckets_[b]) return Error{times.name + ": " + errors[i].message};
    times.createSeconds = buckets_[b]->creationSeconds();
    if (Status s = WarmUp(*buckets_[b], times, stream, set); !s) return s;
  }
  return {};
}

}  // namespace wavefront
