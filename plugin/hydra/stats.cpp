// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/stats.h"

#include <string>

#include "plugin/hydra/render_param.h"

namespace hydra {

VtDictionary ToStats(const RenderParam& param) {
  const delegate::RenderDelegate& core = param.core();
  const wavefront::Progress progress = core.progress();
  const wavefront::RenderStats stats = core.stats();
  const bool done = param.IsConverged();
  double fraction = progress.pathsTotal ? double(progress.pathsDone) / double(progress.pathsTotal) : 0;
  if (done) fraction = 1;
  const char* stage = param.HasFailed()  ? "failed"
                      : param.IsStopped() ? "stopped"
                      : param.IsPaused()  ? "paused"
                      : done              ? "done"
                                          : "rendering";
  VtDictionary d;
  // Blender reads percentDone without looking at its type: it must be a double.
  d["percentDone"] = VtValue(100 * fraction);
  d["fractionDone"] = VtValue(fraction);
  d["numCompletedSamples"] = VtValue(static_cast<int>(progress.samplesDone));
  d["totalClockTime"] = VtValue(progress.seconds);
  d["renderProgressAnnotation"] =
      VtValue(std::string(stage) + ", " + std::to_string(progress.samplesDone) + " samples");
  d["rendererName"] = VtValue(std::string("Wavefront"));
  d["rendererStage"] = VtValue(std::string(stage));
  uint64_t memory = 0, peak = 0;
  for (const auto& [kind, bytes] : stats.memoryBytes) memory += bytes;
  for (const auto& [kind, bytes] : stats.memoryPeakBytes) peak += bytes;
  d["totalMemory"] = VtValue(memory);
  d["peakMemory"] = VtValue(peak);
  d["gpuMemoryUsed"] = VtValue(memory);
  d["huskErrorStatus"] = VtValue(param.HasFailed() ? 1 : 0);
  for (const wavefront::KernelStats& kernel : stats.kernels) {
    d["kernel:" + kernel.name + ":ms"] = VtValue(kernel.milliseconds);
    d["kernel:" + kernel.name + ":items"] = VtValue(kernel.items);
    d["kernel:" + kernel.name + ":peak"] = VtValue(kernel.peak);
    d["kernel:" + kernel.name + ":occupancy"] = VtValue(kernel.occupancy);
  }
  // Materials of one topology share a kernel: its time is that of all of them together.
  for (const delegate::RenderDelegate::KernelUse& use : core.kernelUses())
    for (const std::string& path : use.materials) {
      const std::string name = "material:" + path + ":";
      d[name + "kernel"] = VtValue(use.key);
      d[name + "ms"] = VtValue(use.milliseconds);
      d[name + "paths"] = VtValue(use.paths);
      d[name + "nsPerPath"] = VtValue(use.nanosecondsPerPath);
      d[name + "share"] = VtValue(use.share);
    }
  for (const wavefront::QueueStats& queue : stats.queues) {
    d["queue:" + queue.name + ":peak"] = VtValue(queue.peak);
    d["queue:" + queue.name + ":items"] = VtValue(queue.items);
    d["queue:" + queue.name + ":occupancy"] = VtValue(queue.occupancy);
    d["queue:" + queue.name + ":ms"] = VtValue(queue.milliseconds);
  }
  return d;
}

}  // namespace hydra
