// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Renders of one scene, timed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "delegate/capture/captured_scene.h"
#include "plugin/bench/rays.h"
#include "wavefront/renderer.h"

namespace bench {

// One way to render a scene.
struct Variant {
  wavefront::ExecutionMode mode = wavefront::ExecutionMode::Wavefront;
  uint32_t poolSize = 0;
};

// Renders of a variant, after one that is not counted: kernels are compiled, memory is touched.
struct Measurement {
  Variant variant;
  bool rendered = false;             // false: the scene has no megakernel, or something failed; `why` says what
  std::string why;
  std::vector<double> seconds;       // of each render, Start to the last sample, in the order they were made
  wavefront::RenderStats stats;      // of the render with the median time
  double compileSeconds = 0;         // CPU seconds that making kernels took, summed over them (driver and glslang)
  double stateBytesPerSegment = 0;   // at most (KernelStats); 0 for the megakernel
  std::string film;                  // hash of all sums and first-sample values; of the first render
  bool identical = true;             // every render of the variant made the same film

  double median() const;             // seconds
  double mpaths() const { return static_cast<double>(stats.paths) / median() * 1e-6; }
  // How often the render filled its pool; at a few, its start and its end count.
  double refills() const { return static_cast<double>(stats.paths) / std::max(stats.poolSize, 1u); }
  // A pool was asked for that the device cannot have, or that is too small to be one.
  bool poolCut() const { return rendered && variant.poolSize != 0 && variant.poolSize != stats.poolSize; }
  double mrays() const { return static_cast<double>(stats.extensionRays + stats.shadowRays) / median() * 1e-6; }
};

struct SceneResult {
  std::string name, version;         // version: of hdWavefront that captured it
  std::string error;                 // what ended it early; empty: nothing. What was measured before is here
  uint32_t width = 0, height = 0, samples = 0;
  std::vector<Measurement> measurements;
  std::vector<RayMeasurement> rays;  // with --rays, instead
  bool identical = true;             // all films of all variants are the same
  uint64_t triangles = 0, instances = 0, lights = 0, materials = 0, textures = 0, kernels = 0;
  double firstSeconds = 0;           // from the scene in memory to its first render with all kernels: start-up
  double bvhSeconds = 0, peakDeviceBytes = 0;
  uint64_t validationMessages = 0;
  std::vector<std::string> diagnostics;
  wavefront::AovImage color;         // of the last render
};

struct MeasureOptions {
  std::string device;
  bool validation = false;
  uint32_t runs = 3;
  double seconds = 0;                // that a render shall take (sample_count.h); 0: the scene's samples, whatever they take
  std::function<void(const std::string&)> progress;  // a line on what is being done
};

// Variants are rendered in turn, `runs` times round. `settings` are the scene's, with what the user asked for instead.
SceneResult Measure(delegate::CapturedScene scene, const std::vector<Variant>& variants, const MeasureOptions& options);

}  // namespace bench
