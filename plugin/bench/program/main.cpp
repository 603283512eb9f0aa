// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// wavefront-bench: how fast, against what, and where the time goes. Needs a Vulkan driver and nothing else.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "delegate/capture/compare_scenes.h"
#include "delegate/capture/scene_file.h"
#include "plugin/bench/measure.h"
#include "plugin/bench/options.h"
#include "plugin/bench/report.h"
#include "plugin/bench/sweeps.h"

namespace {

using namespace bench;

constexpr int kDone = 0, kFailed = 1, kWrongUsage = 2, kDifferent = 3;

int Fail(const std::string& message, int code = kFailed) {
  std::fprintf(stderr, "wavefront-bench: error: %s\n", message.c_str());
  return code;
}

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

int ListDevices() {
  for (const wavefront::DeviceDescription& d : wavefront::ListDevices())
    std::printf("%s, %s (%s), Vulkan %s, %.1f GiB%s%s\n", d.name.c_str(), d.driver.c_str(), d.type.c_str(), d.apiVersion.c_str(),
                static_cast<double>(d.heapBytes) / 1073741824.0, d.usable ? "" : "; not usable: ", d.whyNot.c_str());
  return kDone;
}

struct Bench {
  const Options& options;
  const wavefront::DeviceBandwidth& device;
  std::vector<SceneResult> results;

  wavefront::Status Run(delegate::CapturedScene scene) {
    ApplyWishes(options, scene.settings);
    MeasureOptions measure{options.device, options.validate, options.runs, [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); }};
    const auto variants = VariantsOf(options, scene.settings.poolSize);
    auto result = Measure(std::move(scene), variants, measure);
    if (!result) return result.error();
    PrintScene(result.value(), device);
    results.push_back(std::move(result).value());
    return {};
  }
};

int Finish(const Bench& bench) {
  const Options& options = bench.options;
  if (!options.sweep.empty()) PrintSweep(bench.results);
  if (!options.json.empty())
    if (auto s = WriteText(Json(bench.device, bench.results), options.json); !s) return Fail(s.error().message);
  if (!options.image.empty() && !bench.results.empty())
    if (auto s = WritePfm(bench.results.back().color, options.image); !s) return Fail(s.error().message);
  for (const SceneResult& result : bench.results)
    if (!result.identical || result.validationMessages > 0) return kDifferent;
  return kDone;
}

int Compare(const delegate::CapturedScene& a, const delegate::CapturedScene& b) {
  const std::vector<std::string> lines = delegate::CompareScenes(a, b);
  for (const std::string& line : lines) std::printf("%s\n", line.c_str());
  if (lines.empty()) std::printf("The same to the bit.\n");
  return lines.empty() ? kDone : kDifferent;
}

int Main(const Options& options) {
  std::vector<delegate::CapturedScene> scenes;  // a bad file is said before anything is rendered
  for (const std::string& file : options.files) {
    auto scene = delegate::ReadSceneFile(file);
    if (!scene) return Fail(scene.error().message);
    scenes.push_back(std::move(scene).value());
  }
  if (options.compare) return Compare(scenes[0], scenes[1]);
  auto device = wavefront::MeasureCopyBandwidth(options.device);
  if (!device) return Fail(device.error().message);
  const bool cpu = device->type == "CPU";
  if (!options.write.empty()) {
    const auto points = PointsOf(*FindSweep(options.sweep), options.points, options.quick, cpu);
    if (auto s = delegate::WriteSceneFile(FindSweep(options.sweep)->make(points.back(), cpu), options.write); !s) return Fail(s.error().message);
    return kDone;
  }
  PrintDevice(device.value());
  Bench bench{options, device.value(), {}};
  for (std::size_t i = 0; i < scenes.size(); ++i)
    if (auto s = bench.Run(std::move(scenes[i])); !s) return Fail(options.files[i] + ": " + s.error().message);
  if (!options.sweep.empty()) {
    const Sweep& sweep = *FindSweep(options.sweep);
    for (const SweepPoint& point : PointsOf(sweep, options.points, options.quick, cpu))
      if (auto s = bench.Run(sweep.make(point, cpu)); !s) return Fail(point.name + ": " + s.error().message);
  }
  return Finish(bench);
}

}  // namespace

int main(int count, char** arguments) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  auto options = ParseOptions(std::span<const char* const>(arguments + 1, static_cast<std::size_t>(std::max(count, 1) - 1)));
  if (!options) return Fail(options.error().message + " --help tells more.", kWrongUsage);
  if (options->help) {
    std::fputs(Usage().c_str(), stdout);
    return kDone;
  }
  if (options->listDevices) return ListDevices();
  return Main(options.value());
}
