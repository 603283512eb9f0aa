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

}  // namespace

wavefront::Status Session::KeepJson() const {
  return options_.json.empty() ? wavefront::Status{} : WriteText(Json(device_, results_), options_.json);
}

void Session::Run(delegate::CapturedScene scene, const std::string& origin) {
  ApplyWishes(options_, scene.settings);
  const auto progress = [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); };
  const MeasureOptions measure{options_.device, options_.validate, options_.runs, options_.seconds, progress};
  const auto variants = VariantsOf(options_, scene.settings.poolSize);
  SceneResult result = Measure(std::move(scene), variants, measure);
  if (!result.error.empty()) {
    failed_ = true;
    Say((origin.empty() ? result.name : origin) + ": " + result.error);
  }
  PrintScene(result, device_);
  results_.push_back(std::move(result));
  if (wavefront::Status s = KeepJson(); !s) {
    failed_ = true;
    Say(s.error().message);
  }
}

ExitCode Session::Finish() const {
  if (!options_.sweep.empty()) PrintSweep(results_);
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
