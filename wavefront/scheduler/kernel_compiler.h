// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Makes pipelines of material kernels in threads of its own, while the render goes on: SPIR-V is asked for, the pipeline
// is created, and where the driver compiles at the first dispatch (lavapipe), a second device dispatches it once with no
// work, so that the rendering device finds the machine code in the driver's disk cache.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "wavefront/scene/material_table.h"
#include "wavefront/vulkan/descriptors.h"
#include "wavefront/vulkan/driver_compile.h"
#include "wavefront/scheduler/state_traffic.h"
#include "wavefront/vulkan/pipeline.h"

namespace wavefront {

// What making one bucket's pipeline cost, and how large it is.
struct CompileCost {
  double codeMilliseconds = 0;  // GLSL to SPIR-V
  bool codeFromCache = false;
  double createSeconds = 0;     // the pipeline's creation, on all devices
  double firstDispatchSeconds = 0;
  uint64_t spirvBytes = 0, spirvInstructions = 0;
  StateTraffic state;
  std::vector<std::string> driverStatistics;  // where the driver gives them and they are asked for
};

class KernelCompiler {
 public:
  struct Job {
    uint32_t bucket = 0;
    std::string name;
    std::function<KernelCode()> code;
  };
  // A program that is only to be in the driver's cache. What it names outlives the job.
  struct CacheJob {
    uint32_t id = 0;
    const vulkan::PipelineDesc* desc = nullptr;
  };
  struct Done {
    uint32_t bucket = 0;
    std::unique_ptr<vulkan::ComputePipeline> pipeline;  // null: failed
    std::string error;
    std::string trouble;  // what made it slower than it should be
    CompileCost cost;
    std::chrono::steady_clock::time_point readyAt;  // not to be taken before: the driver's cache is still being written
  };

  // Device and layout outlive the compiler.
  KernelCompiler(vulkan::Device& device, const vulkan::PipelineLayout& layout, unsigned threads);
  // Forgets what has not begun, waits for what has.
  ~KernelCompiler();
  KernelCompiler(const KernelCompiler&) = delete;
  KernelCompiler& operator=(const KernelCompiler&) = delete;

  vulkan::DriverCompile driverCompile() const { return driverCompile_; }
  const std::string& whyNoCache() const { return whyNoCache_; }

  void Enqueue(std::vector<Job> jobs);
  // Before all that waits, and only where the driver compiles at dispatch into a cache.
  void EnqueueFirst(std::vector<CacheJob> jobs);
  // Takes such a job back; false where a thread has begun it.
  bool TakeBack(uint32_t id);
  // Until no thread works at such a job, and the cache has what they made.
  void WaitForCacheJobs();
  // What is finished since the last call, in order of finishing.
  std::vector<Done> Take();
  // Jobs that are over and not taken yet.
  std::size_t finished() const;
  // Until something can be taken, or the time is over.
  void Wait(double seconds);

 private:
  struct WarmDevice;
  void Run();
  WarmDevice* Warm(std::unique_ptr<WarmDevice>& warm, std::string* trouble);
  Done Compile(const Job& job, std::unique_ptr<WarmDevice>& warm);

  vulkan::Device& device_;
  const vulkan::PipelineLayout& layout_;
  std::string whyNoCache_;  // before what fills it
  vulkan::DriverCompile driverCompile_;
  unsigned threadCount_;

  mutable std::mutex mutex_;
  std::condition_variable work_, finished_;
  std::deque<Job> queue_;
  std::deque<CacheJob> cacheQueue_;
  unsigned cacheJobsInWork_ = 0;
  std::chrono::steady_clock::time_point cacheWritten_{};
  std::vector<Done> done_;
  bool stop_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace wavefront
