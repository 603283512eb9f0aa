// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/kernel_registry.h"

#include <chrono>

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
  using enum vulkan::Format;
  struct Of {
    static vulkan::Binding Make(uint32_t number, vulkan::DescriptorKind kind) { return {number, kind}; }
    static vulkan::Binding Make(uint32_t number, vulkan::Format format) {
      using vulkan::DescriptorKind;
      return {number, vulkan::IsUint(format) ? DescriptorKind::TexelBufferUint : DescriptorKind::TexelBufferFloat, 1, format};
    }
  };
  constexpr auto Storage = vulkan::DescriptorKind::StorageBuffer, Uniform = vulkan::DescriptorKind::UniformBuffer;
  return {
#define WAVEFRONT_BINDING(Name, number, kind) Of::Make(number, kind),
#include "wavefront/shared/bindings.def"
#undef WAVEFRONT_BINDING
  };
}

enum FeatureBit : uint32_t {
#define WAVEFRONT_FEATURE(Name, index, doc) k##Name = 1u << index,
#include "wavefront/shared/features.def"
#undef WAVEFRONT_FEATURE
};

// They take the place of material kernels, and most renders need none.
bool IsStandIn(Kernel kernel) { return kernel == Kernel::StandInSurface || kernel == Kernel::StandInShadow; }
bool IsForMedia(Kernel kernel) {
  return kernel == Kernel::MediumScatter || kernel == Kernel::SubsurfaceWalk || kernel == Kernel::SubsurfaceExit;
}

bool GoesByFeatures(Kernel kernel) {
  switch (kernel) {
    case Kernel::Logic: case Kernel::LightSample: case Kernel::Escape: case Kernel::MediumScatter: case Kernel::NewPath:
    case Kernel::ExtensionRay: return true;
    default: return false;
  }
}

const char* EntryName(KernelEntry entry) {
  return entry == KernelEntry::Surface ? "surface" : entry == KernelEntry::Opacity ? "opacity" : "emission";
}

}  // namespace

SceneFeatures SceneFeatures::Of(const SceneFacts& facts) {
  const bool LightShapes = facts.lightCount > facts.infiniteLightCount;
  const bool EmissiveMeshes = facts.lightItemCount > facts.lightCount;
  const bool LightTree = facts.lightTree != 0;
  const bool InfiniteLights = facts.infiniteLightCount != 0;
  const bool ScatteringMedia = facts.hasMedia;
  const bool Bodies = facts.hasBodies;
  const auto has = [&facts](LightType type) { return (facts.lightTraits & LightTraitOf(type)) != 0; };
  const bool RectLights = has(LightType::Rect), DiskLights = has(LightType::Disk);
  const bool SphereLights = has(LightType::Sphere), CylinderLights = has(LightType::Cylinder);
  const bool DistantLights = has(LightType::Distant), DomeLights = has(LightType::Dome);
  const bool ShapedLights = (facts.lightTraits & kLightTraitShaped) != 0;
  const bool TexturedLights = (facts.lightTraits & kLightTraitTextured) != 0;
  SceneFeatures features;
#define WAVEFRONT_FEATURE(Name, index, doc) features.bits |= Name ? 1u << index : 0u;
#include "wavefront/shared/features.def"
#undef WAVEFRONT_FEATURE
  return features;
}

std::vector<std::pair<uint32_t, uint32_t>> SceneFeatures::Specialization() const {
  return {
#define WAVEFRONT_FEATURE(Name, index, doc) {kFirstConstant + index, bits >> index & 1u},
#include "wavefront/shared/features.def"
#undef WAVEFRONT_FEATURE
  };
}

Result<std::unique_ptr<KernelRegistry>> KernelRegistry::Create(vulkan::Device& device) {
  std::unique_ptr<KernelRegistry> registry(new KernelRegistry(device));
  auto layout = vulkan::PipelineLayout::Create(device, Bindings(), "kernels");
  if (!layout) return layout.error();
  registry->layout_ = std::move(layout).value();
  registry->fixed_.resize(kKernelCount);
  for (uint32_t k = 0; k < kKernelCount; ++k) {
    KernelTimes times;
    times.name = kFixed[k].file;
    registry->times_.push_back(times);
    // Made when a kernel is waited for, or when the scene is known.
    if (IsStandIn(static_cast<Kernel>(k)) || GoesByFeatures(static_cast<Kernel>(k))) continue;
    auto pipeline = registry->CreateFixed(static_cast<Kernel>(k));
    if (!pipeline) return pipeline.error();
    registry->fixed_[k] = std::move(pipeline).value();
  }
  return registry;
}

vulkan::PipelineDesc KernelRegistry::DescOf(Kernel kernel) const {
  const char* file = kFixed[static_cast<uint32_t>(kernel)].file;
  vulkan::PipelineDesc desc{KernelSpirv(file), "main", {}, file};
  if (GoesByFeatures(kernel)) desc.specialization = features_.Specialization();
  return desc;
}

Result<std::unique_ptr<vulkan::ComputePipeline>> KernelRegistry::CreateFixed(Kernel kernel) {
  const auto k = static_cast<uint32_t>(kernel);
  const auto spirv = KernelSpirv(kFixed[k].file);
  const vulkan::PipelineDesc desc = DescOf(kernel);
  auto pipeline = vulkan::ComputePipeline::Create(device_, *layout_, desc);
  if (!pipeline) return pipeline;
  times_[k].compile.createSeconds = pipeline.value()->creationSeconds();
  times_[k].compile.spirvBytes = spirv.size_bytes();
  times_[k].compile.state = StateTrafficOf(spirv, desc.specialization);
  return pipeline;
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
  times.compile.firstDispatchSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return {};
}

Status KernelRegistry::Specialize(SceneFeatures features) {
  features.bits |= features_.bits;
  if (specialized_ && features.bits == features_.bits) return {};
  features_ = features;
  specialized_ = true;
  for (uint32_t k = 0; k < kKernelCount; ++k) {
    if (!GoesByFeatures(static_cast<Kernel>(k))) continue;
    if (IsForMedia(static_cast<Kernel>(k)) && (features_.bits & kScatteringMedia) == 0) continue;  // nothing dispatches it
    auto pipeline = CreateFixed(static_cast<Kernel>(k));
    if (!pipeline) return pipeline.error();
    fixed_[k] = std::move(pipeline).value();
    fixedWarm_[k] = false;
  }
  return {};
}

Status KernelRegistry::WarmUpFixed(bool media, unsigned threads, vulkan::CommandStream& stream, const vulkan::DescriptorSet& set) {
  std::vector<uint32_t> cold;
  for (uint32_t k = 0; k < kKernelCount; ++k) {
    const Kernel kernel = static_cast<Kernel>(k);
    if (!fixed_[k] || fixedWarm_[k]) continue;
    if (kernel == Kernel::MaterialCost || kernel == Kernel::MegaTurn) continue;  // few renders ask for costs, or for the megakernel
    if (!media && IsForMedia(kernel)) continue;
    cold.push_back(k);
  }
  if (cold.empty()) return {};
  if (!compiler_) compiler_ = std::make_unique<KernelCompiler>(device_, *layout_, threads);
  // The compiler's threads come from one end, this one from the other.
  std::vector<vulkan::PipelineDesc> descs;
  for (uint32_t k : cold) descs.push_back(DescOf(static_cast<Kernel>(k)));
  std::vector<KernelCompiler::CacheJob> jobs;
  for (std::size_t i = 0; i < cold.size(); ++i) jobs.push_back({cold[i], &descs[i]});
  compiler_->EnqueueFirst(jobs);
  const bool shared = compiler_->driverCompile() == vulkan::DriverCompile::AtDispatchCached;
  Status status;
  std::vector<uint32_t> others;
  for (std::size_t i = cold.size(); i-- > 0;) {
    if (shared && !compiler_->TakeBack(cold[i])) {
      others.push_back(cold[i]);
      continue;
    }
    if (status) status = WarmUp(*fixed_[cold[i]], times_[cold[i]], stream, set);
  }
  compiler_->WaitForCacheJobs();  // `descs` are in use until then
  for (uint32_t k : others) {
    if (status) status = WarmUp(*fixed_[k], times_[k], stream, set);
  }
  if (!status) return status;
  for (uint32_t k : cold) fixedWarm_[k] = true;
  return {};
}

Result<const vulkan::ComputePipeline*> KernelRegistry::StandIn(KernelEntry entry) {
  const Kernel kernel = entry == KernelEntry::Surface ? Kernel::StandInSurface : Kernel::StandInShadow;
  auto& pipeline = fixed_[static_cast<uint32_t>(kernel)];
  if (!pipeline) {
    auto created = CreateFixed(kernel);
    if (!created) return created.error();
    pipeline = std::move(created).value();
  }
  return pipeline.get();
}

void KernelRegistry::Order(const std::vector<Bucket>& buckets, const std::vector<bool>& used, unsigned threads) {
  for (std::size_t b = buckets_.size(); b < buckets.size(); ++b) {
    KernelTimes times;
    times.name = "material:" + buckets[b].kernelKey + ":" + EntryName(buckets[b].entry);
    times_.push_back(times);
    buckets_.push_back({State::Unused, buckets[b].entry, buckets[b].user, nullptr});
  }
  std::vector<KernelCompiler::Job> jobs;
  // Surfaces first: nothing is seen without them.
  for (const bool surfaces : {true, false}) {
    for (std::size_t b = 0; b < buckets.size(); ++b) {
      if (b >= used.size() || !used[b] || buckets_[b].state != State::Unused) continue;
      if ((buckets[b].entry == KernelEntry::Surface) != surfaces) continue;
      buckets_[b].state = State::Compiling;
      ++pending_;
      jobs.push_back({static_cast<uint32_t>(b), times_[kKernelCount + b].name, buckets[b].code});
    }
  }
  if (jobs.empty()) return;
  if (!compiler_) compiler_ = std::make_unique<KernelCompiler>(device_, *layout_, threads);
  compiler_->Enqueue(std::move(jobs));
}

std::vector<uint32_t> KernelRegistry::Adopt(const DiagnosticSink& sink) {
  if (!compiler_ || pending_ == 0) return {};
  const auto say = [&](Severity severity, const char* code, const std::string& location, const std::string& text) {
    if (sink) sink({severity, code, location, text});
  };
  std::vector<uint32_t> adopted;
  for (KernelCompiler::Done& done : compiler_->Take()) {
    BucketKernel& bucket = buckets_[done.bucket];
    KernelTimes& times = times_[kKernelCount + done.bucket];
    times.compile = done.cost;
    bucket.pipeline = std::move(done.pipeline);
    bucket.state = bucket.pipeline ? State::Ready : State::Failed;
    --pending_;
    adopted.push_back(done.bucket);
    if (bucket.state == State::Failed) {
      say(Severity::Error, "material-kernel-failed", bucket.user.empty() ? times.name : bucket.user,
          "A generated material kernel (" + times.name + ") does not compile; its materials show magenta. " + done.error);
    }
    if (!done.trouble.empty() && !saidTrouble_) {
      saidTrouble_ = true;
      say(Severity::Warning, "kernel-compile-slow", "render", "material kernels are compiled by the rendering device, which waits meanwhile: " + done.trouble);
    }
  }
  if (compiler_->driverCompile() == vulkan::DriverCompile::AtDispatch && !saidNoCache_) {
    saidNoCache_ = true;
    say(Severity::Info, "kernel-compile-slow", "render", "material kernels are compiled by the rendering device, which waits meanwhile: " + compiler_->whyNoCache());
  }
  return adopted;
}

}  // namespace wavefront
