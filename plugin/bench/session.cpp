// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/bench/session.h"

#include <algorithm>
#include <cstdio>

#include "plugin/bench/report.h"

namespace bench {
namespace {

void Say(const std::string& message) { std::fprintf(stderr, "wavefront-bench: error: %s\n", message.c_str()); }

std::vector<Variant> VariantsOf(const Options& options, uint32_t scenePool) {
  std::vector<Variant> variants;
  for (const uint32_t pool : options.pools) {
    const uint32_t size = pool != 0 ? pool : scenePool;
    if (options.wavefront) variants.push_back({wavefront::ExecutionMode::Wavefront, size});
    if (options.megakernel) variants.push_back({wavefront::ExecutionMode::Megakernel, size});
  }
  return variants;
}

void ApplyWishes(const Options& options, wavefront::RenderSettings& settings) {
  const double aspect = static_cast<double>(settings.height) / settings.width;
  if (options.samples != 0) settings.samples = options.samples;
  if (options.width != 0) {
    settings.width = options.width;
    settings.height = std::max(1u, static_cast<uint32_t>(options.width * aspect + 0.5));
  }
  if (options.height != 0) settings.height = options.height;
}

// Enough to fill the device many times over, within 65,535 groups of a dispatch.
constexpr uint32_t kRaysOnCpu = 1u << 17, kRaysOnGpu = 4'000'000;

SceneResult CastRays(const delegate::CapturedScene& scene, const RayOptions& options) {
  SceneResult result;
  result.name = scene.info.name;
  result.version = scene.info.version;
  result.width = scene.settings.width;
  result.height = scene.settings.height;
  const bool moved = std::any_of(scene.meshes.begin(), scene.meshes.end(), [](const auto& mesh) { return !mesh.second.displacements.empty(); });
  if (moved) result.diagnostics.push_back("Rays are cast through meshes without their displacements.");
  auto rays = MeasureRays(scene, options);
  if (rays) result.rays = std::move(rays).value();
  else result.error = rays.error().message;
  if (!result.rays.empty()) result.triangles = result.rays[0].triangles;
  return result;
}

}  // namespace

wavefront::Status Session::KeepJson() const {
  return options_.json.empty() ? wavefront::Status{} : WriteText(Json(device_, results_), options_.json);
}

SceneResult Session::Measured(delegate::CapturedScene scene) const {
  const auto progress = [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); };
  if (options_.rays) {
    progress(scene.info.name + ": casting rays");
    return CastRays(scene, {options_.device, options_.runs, device_.type == "CPU" ? kRaysOnCpu : kRaysOnGpu});
  }
  const MeasureOptions measure{options_.device, options_.validate, options_.runs, options_.seconds, progress};
  const auto variants = VariantsOf(options_, scene.settings.poolSize);
  return Measure(std::move(scene), variants, measure);
}

void Session::Run(delegate::CapturedScene scene, const std::string& origin) {
  ApplyWishes(options_, scene.settings);
  SceneResult result = Measured(std::move(scene));
  if (!result.error.empty()) {
    failed_ = true;
    Say((origin.empty() ? result.name : origin) + ": " + result.error);
  }
  if (options_.rays) PrintRays(result, device_);
  else PrintScene(result, device_);
  results_.push_back(std::move(result));
  if (wavefront::Status s = KeepJson(); !s) {
    failed_ = true;
    Say(s.error().message);
  }
}

ExitCode Session::Finish() const {
  if (!options_.sweep.empty() && !options_.rays) PrintSweep(results_);
  const auto seen = std::find_if(results_.rbegin(), results_.rend(), [](const SceneResult& r) { return !r.color.bits.empty(); });
  if (!options_.image.empty() && seen != results_.rend())
    if (wavefront::Status s = WritePfm(seen->color, options_.image); !s) {
      Say(s.error().message);
      return kFailed;
    }
  if (failed_) return kFailed;
  const bool differs = std::any_of(results_.begin(), results_.end(), [](const SceneResult& r) { return !r.identical || r.validationMessages > 0; });
  return differs ? kDifferent : kDone;
}

}  // namespace bench
