// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/megakernel.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>

#include "wavefront/shared/counters_layout.h"

namespace wavefront {
namespace {

using namespace layout;

// Compile time grows with every material, and all is compiled again when one is added.
constexpr std::size_t kMaxKernels = 16;
// $HDWAVEFRONT_MEGAKERNEL_SECONDS says otherwise: comparisons may want one whatever it takes.
double MaxCompileSeconds() {
  const char* wish = std::getenv("HDWAVEFRONT_MEGAKERNEL_SECONDS");
  const double seconds = wish == nullptr ? 0.0 : std::strtod(wish, nullptr);
  return seconds > 0 ? seconds : 60.0;
}
// Where the driver compiles at the first dispatch, that takes about twice as long as what came before it (measured on
// lavapipe: 2 to 3 times), and cannot be stopped: the end is foreseen.
double ForeseenSeconds(const vulkan::DeviceInfo& info, double soFar) { return info.type == vulkan::DeviceType::Cpu ? 3 * soFar : soFar; }

// Work of this thread where the device is a processor, which may have other work to do; else time on the wall, since
// drivers compile in threads of their own.
double CompileClock(const vulkan::DeviceInfo& info) {
  timespec now{};
  clock_gettime(info.type == vulkan::DeviceType::Cpu ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// What ends a dispatch, see kernels/megakernel/tail.glsl. On a GPU only the number of turns, so that the host is answered.
struct DispatchLimits { uint32_t turns, loops; };
DispatchLimits LimitsOf(const vulkan::DeviceInfo& info) {
  return info.type == vulkan::DeviceType::Cpu ? DispatchLimits{64, 4096} : DispatchLimits{64, 0xffffffffu};
}

}  // namespace

Result<bool> Megakernel::Prepare(const MaterialTable& materials, const std::vector<bool>& used, const KernelRegistry& registry,
                                 Diagnostic* trouble) {
  std::vector<std::string> keys;
  for (std::size_t b = 0; b < materials.buckets().size(); ++b) {
    if (b < used.size() && used[b]) keys.push_back(materials.buckets()[b].kernelKey);
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  if (pipeline_ && keys == keys_ && features_ == registry.features().bits) return true;
  if (!tooSlow_.empty() && keys == tooSlow_) return false;  // said once
  auto decline = [&](const char* code, const std::string& text) {
    *trouble = {Severity::Warning, code, "render", text + " The picture is rendered in wavefront mode."};
    return false;
  };
  if (!linker_) return decline("megakernel-unavailable", "This host links no megakernels.");
  if (keys.size() > kMaxKernels) {
    return decline("megakernel-too-many-materials", "The scene's materials have " + std::to_string(keys.size()) +
                                                        " topologies; a megakernel takes at most " + std::to_string(kMaxKernels) + ".");
  }
  const double begin = CompileClock(device_.info());
  const auto start = std::chrono::steady_clock::now();
  auto spirv = linker_(keys);
  const double linkSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!spirv) return decline("megakernel-failed", "The megakernel does not compile: " + spirv.error().message);
  vulkan::PipelineDesc desc;
  desc.spirv = spirv.value();
  desc.name = "megakernel";
  desc.specialization = registry.features().Specialization();
  for (uint32_t k = 0; k < keys.size(); ++k) {
    const KernelInfo* info = materials.Kernel(keys[k]);
    desc.specialization.insert(desc.specialization.end(), {{3 * k, info->surface}, {3 * k + 1, info->opacity}, {3 * k + 2, info->emission}});
  }
  pipeline_.reset();
  auto pipeline = vulkan::ComputePipeline::Create(device_, registry.layout(), desc);
  if (!pipeline) return pipeline.error();
  const double foreseen = ForeseenSeconds(device_.info(), CompileClock(device_.info()) - begin);
  const double limit = MaxCompileSeconds();
  if (foreseen > limit) {
    tooSlow_ = std::move(keys);
    return decline("megakernel-compile-time", "Compiling the megakernel of " + std::to_string(tooSlow_.size()) + " topologies would take about " +
                                                  std::to_string(static_cast<int>(foreseen)) + " s, more than " + std::to_string(static_cast<int>(limit)) + ".");
  }
  times_ = {};
  times_.name = desc.name;
  times_.compile.codeMilliseconds = linkSeconds * 1e3;
  times_.compile.createSeconds = pipeline.value()->creationSeconds();
  times_.compile.spirvBytes = spirv.value().size() * 4;
  pipeline_ = std::move(pipeline).value();
  keys_ = std::move(keys);
  features_ = registry.features().bits;
  isWarm_ = false;
  return true;
}

Status Megakernel::WarmUp(KernelRegistry& registry, vulkan::CommandStream& stream, const vulkan::DescriptorSet& set) {
  if (isWarm_) return {};
  Status s = registry.WarmUp(*pipeline_, times_, stream, set);
  isWarm_ = s.ok();
  return s;
}

void Megakernel::Record(vulkan::CommandStream& stream, const KernelRegistry& registry, const vulkan::Buffer& counters,
                        uint32_t dispatches, std::vector<uint32_t>* rows) const {
  const DispatchLimits limits = LimitsOf(device_.info());
  const uint32_t push[4] = {0, limits.turns, limits.loops, 0};
  stream.PushConstants(std::as_bytes(std::span(push)));
  auto run = [&](const vulkan::ComputePipeline& pipeline, uint32_t arguments, uint32_t row) {
    stream.BindPipeline(pipeline);
    stream.DispatchIndirect(counters, 4ull * arguments);
    stream.Barrier();
    if (stream.Timestamp() != vulkan::CommandStream::kNoTimestamp) rows->push_back(row);
  };
  const uint32_t turn = static_cast<uint32_t>(Kernel::MegaTurn);
  run(registry.fixed(Kernel::MegaTurn), kScanArgs, turn);
  for (uint32_t i = 0; i < dispatches; ++i) {
    run(*pipeline_, kPoolArgs, kRow);
    run(registry.fixed(Kernel::MegaTurn), kScanArgs, turn);
  }
}

}  // namespace wavefront
