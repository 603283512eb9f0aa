// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/pool_size.h"

namespace wavefront {
namespace {

// Below 8K paths software Vulkan loses to dispatch costs; 32K to 256K is flat as long as the kernels are few.
constexpr uint32_t kSoftwarePool = 1u << 16, kSoftwarePoolLimit = 1u << 18;
// A kernel's code is cold at each dispatch where many kernels take turns: fetching it costs as much as shading some
// hundred paths (resources/BENCH.md, pools).
constexpr uint32_t kPathsOfBucket = 2048;
// The megakernel needs no more paths than keep the device busy; fewer make shorter dispatches and stay in the cache.
constexpr uint32_t kSoftwareMegakernelPool = 1u << 12, kMegakernelPool = 1u << 18;
constexpr uint32_t kGpuPool = 1u << 20;

}  // namespace

uint32_t DefaultPoolSize(vulkan::DeviceType device, ExecutionMode mode, std::size_t buckets, bool interactive) {
  const bool software = device == vulkan::DeviceType::Cpu;
  if (mode == ExecutionMode::Megakernel) return software ? kSoftwareMegakernelPool : kMegakernelPool;
  if (!software) return kGpuPool;
  uint32_t pool = kSoftwarePool;
  // An edit waits for the iteration that runs: short ones serve it better.
  if (interactive) return pool;
  while (pool < kSoftwarePoolLimit && pool / kPathsOfBucket < buckets) pool *= 2;
  return pool;
}

}  // namespace wavefront
