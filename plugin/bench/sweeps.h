// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Scenes that the bench makes by itself, each sweep in growing sizes. Deterministic: the same on every machine.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "delegate/capture/captured_scene.h"

namespace bench {

// One scene of a sweep.
struct SweepPoint {
  std::string name;
  uint32_t size = 0;         // what the sweep counts
  uint32_t operations = 0;   // of a material, where the sweep is about that
};

struct Sweep {
  const char* name;
  const char* doc;
  std::vector<uint32_t> quick, cpu, gpu;  // sizes: with --quick, on a CPU's Vulkan driver, on a GPU
  std::vector<uint32_t> operations;       // each size with each of these; empty: without
  delegate::CapturedScene (*make)(const SweepPoint& point, bool cpu);
  bool ownSamples = false;                // the samples a pixel are the sweep's matter: they are not raised
};

std::span<const Sweep> Sweeps();
const Sweep* FindSweep(const std::string& name);  // null: none of that name
// Sizes in place of the sweep's own where there are any.
std::vector<SweepPoint> PointsOf(const Sweep& sweep, const std::vector<uint32_t>& sizes, bool quick, bool cpu);

}  // namespace bench
