// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// wavefront-bench: how fast, against what, and where the time goes. Needs a Vulkan driver and nothing else.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "delegate/capture/compare_scenes.h"
#include "delegate/capture/scene_file.h"
#include "plugin/bench/options.h"
#include "plugin/bench/report.h"
#include "plugin/bench/session.h"
#include "plugin/bench/sweeps.h"

namespace {

using namespace bench;

int Fail(const std::string& message, int code = kFailed) {
  std::fprintf(stderr, "wavefront-bench: error: %s\n", message.c_str());
  return code;
}

int ListDevices() {
  for (const wavefront::DeviceDescription& d : wavefront::ListDevices())
    std::printf("%s, %s (%s), Vulkan %s, %.1f GiB%s%s\n", d.name.c_str(), d.driver.c_str(), d.type.c_str(), d.apiVersion.c_str(),
                static_cast<double>(d.heapBytes) / 1073741824.0, d.usable ? "" : "; not usable: ", d.whyNot.c_str());
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
  Session session(options, device.value());
  if (auto s = session.Begin(); !s) return Fail(s.error().message);
  for (std::size_t i = 0; i < scenes.size(); ++i) session.Run(std::move(scenes[i]), options.files[i]);
  if (!options.sweep.empty()) {
    const Sweep& sweep = *FindSweep(options.sweep);
    for (const SweepPoint& point : PointsOf(sweep, options.points, options.quick, cpu)) session.Run(sweep.make(point, cpu));
  }
  return session.Finish();
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
