// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/work_stats.h"

#include <cctype>
#include <string>

#include "wavefront/scheduler/kernel_registry.h"
#include "wavefront/scheduler/path_tracer.h"
#include "wavefront/shared/counters_layout.h"

namespace wavefront {
namespace {

// As statistics name the queues: the row's name, first letter small.
std::string QueueName(std::string name) {
  name[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(name[0])));
  return name;
}

}  // namespace

void AddWork(const LoopStatus& loop, uint32_t poolSize, ExecutionMode mode, RenderStats* stats) {
  const uint64_t visits = loop.iterations * poolSize;
  const auto occupancy = [&](uint64_t items) { return visits == 0 ? 0.0 : static_cast<double>(items) / static_cast<double>(visits); };
  const auto kernel = [&](std::size_t row, uint64_t items, uint64_t peak) -> const KernelStats& {
    KernelStats& k = stats->kernels[row];
    k.items = items;
    k.peak = peak;
    k.occupancy = occupancy(items);
    return k;
  };
  // A queue and the kernel that empties it.
  const auto queue = [&](const std::string& name, std::size_t row, uint64_t items, uint64_t peak) {
    const KernelStats& k = kernel(row, items, peak);
    stats->queues.push_back({name, items, peak, k.occupancy, k.milliseconds});
  };
  const auto row = [](Kernel k) { return static_cast<std::size_t>(k); };

  stats->queues.clear();
  if (mode == ExecutionMode::Wavefront) {
    for (Kernel k : {Kernel::Logic, Kernel::Scatter}) kernel(row(k), visits, loop.iterations == 0 ? 0 : poolSize);
  }
  queue("newPath", row(Kernel::NewPath), loop.pathsStarted, loop.bucketPeak.empty() ? 0 : loop.bucketPeak[layout::kBucketNewPath]);
#define WAVEFRONT_QUEUE(Name, index, doc) queue(QueueName(#Name), row(Kernel::Name), loop.queueItems[index], loop.queuePeak[index]);
#include "wavefront/shared/queues.def"
#undef WAVEFRONT_QUEUE
  for (std::size_t b = layout::kFirstMaterialBucket; b < loop.bucketItems.size(); ++b) {
    const std::size_t at = kKernelCount + b - layout::kFirstMaterialBucket;
    if (at < stats->kernels.size()) queue(stats->kernels[at].name, at, loop.bucketItems[b], loop.bucketPeak[b]);
  }
  if (mode != ExecutionMode::Megakernel) return;
  KernelStats& mega = stats->kernels.back();
  mega.items = stats->segments;
  mega.occupancy = occupancy(mega.items);
}

}  // namespace wavefront
