// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/bench/report.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "plugin/bench/json_writer.h"
#include "plugin/bench/sample_count.h"

namespace bench {
namespace {

using namespace wavefront;

const char* NameOf(ExecutionMode mode) { return mode == ExecutionMode::Wavefront ? "wavefront" : "megakernel"; }

const Measurement* First(const SceneResult& scene, ExecutionMode mode) {
  for (const Measurement& m : scene.measurements)
    if (m.variant.mode == mode && m.rendered) return &m;
  return nullptr;
}

bool Rendered(const SceneResult& scene) { return First(scene, ExecutionMode::Wavefront) || First(scene, ExecutionMode::Megakernel); }

// How much faster the wavefront loop is than the megakernel of the same pool, as the paper counts: 0.36 is 36 %. NaN: no pair.
double Gain(const SceneResult& scene) {
  const Measurement *wave = First(scene, ExecutionMode::Wavefront), *mega = First(scene, ExecutionMode::Megakernel);
  return wave && mega ? wave->mpaths() / mega->mpaths() - 1 : std::nan("");
}

double KernelMilliseconds(const RenderStats& stats) {
  double sum = 0;
  for (const KernelStats& k : stats.kernels) sum += k.milliseconds;
  return sum;
}

// What path state moves, of what the device copies at best.
double CopyShare(const Measurement& m, const DeviceBandwidth& device) {
  if (device.bytesPerSecond == 0 || m.median() == 0) return 0;
  return m.stateBytesPerSegment * static_cast<double>(m.stats.segments) / m.median() / device.bytesPerSecond;
}

std::pair<double, double> Spread(const Measurement& m) {
  const auto [low, high] = std::minmax_element(m.seconds.begin(), m.seconds.end());
  return {*low, *high};
}

void PrintKernels(const Measurement& m) {
  std::vector<KernelStats> kernels = m.stats.kernels;
  std::sort(kernels.begin(), kernels.end(), [](const auto& a, const auto& b) { return a.milliseconds > b.milliseconds; });
  const double total = std::max(KernelMilliseconds(m.stats), 1e-9);
  std::printf("    %-52s %10s %7s %13s %9s\n", "kernel", "ms", "share", "items", "ns/item");
  for (const KernelStats& k : kernels) {
    if (k.milliseconds <= 0) continue;  // in a megakernel the stages have items, and no time of their own
    std::printf("    %-52.52s %10.2f %6.1f%% %13llu", k.name.c_str(), k.milliseconds, 100 * k.milliseconds / total, static_cast<unsigned long long>(k.items));
    if (k.items > 0) std::printf(" %9.1f", k.milliseconds * 1e6 / static_cast<double>(k.items));
    std::printf("\n");
  }
  std::printf("    kernels %.2f ms of %.2f ms: %.1f %% between and around them\n", total, m.median() * 1e3,
              100 * (1 - std::min(1.0, total / (m.median() * 1e3))));
}

void PrintMeasurement(const Measurement& m, const DeviceBandwidth& device) {
  if (!m.rendered) {
    std::printf("  %-11s not rendered: %s\n", NameOf(m.variant.mode), m.why.c_str());
    return;
  }
  const auto [low, high] = Spread(m);
  std::printf("  %-11s %9.3f Mpaths/s  %9.3f Mrays/s  %.4f s (%.4f to %.4f in %zu)  film %s\n", NameOf(m.variant.mode), m.mpaths(), m.mrays(),
              m.median(), low, high, m.seconds.size(), m.film.c_str());
  std::printf("    pool %u, filled %.1f times", m.stats.poolSize, m.refills());
  if (m.poolCut()) std::printf("; CUT: %u were asked for", m.variant.poolSize);
  std::printf("%s\n", m.refills() < 0.5 * kRefills ? " (start and end count)" : "");
  std::printf("    %.2f segments and %.2f shadow rays a path; making kernels took %.2f s\n",
              static_cast<double>(m.stats.segments) / static_cast<double>(std::max<uint64_t>(m.stats.paths, 1)),
              static_cast<double>(m.stats.shadowRays) / static_cast<double>(std::max<uint64_t>(m.stats.paths, 1)), m.compileSeconds);
  if (m.stateBytesPerSegment > 0)
    std::printf("    state: at most %.0f bytes a segment, %.1f %% of the copy bandwidth\n", m.stateBytesPerSegment, 100 * CopyShare(m, device));
  PrintKernels(m);
}

void WriteKernels(JsonWriter& json, const RenderStats& stats) {
  const double total = std::max(KernelMilliseconds(stats), 1e-9);
  json.Key("kernels").Begin('[');
  for (const KernelStats& k : stats.kernels) {
    if (k.milliseconds <= 0 && k.items == 0) continue;
    json.Begin('{').Pair("name", k.name).Pair("milliseconds", k.milliseconds).Pair("share", k.milliseconds / total);
    json.Pair("items", k.items).Pair("peak", k.peak).Pair("occupancy", k.occupancy).Pair("dispatches", k.dispatches);
    json.Pair("nanosecondsPerItem", k.items == 0 ? 0.0 : k.milliseconds * 1e6 / static_cast<double>(k.items));
    json.Pair("compileMilliseconds", k.codeMilliseconds + k.createMilliseconds + k.firstDispatchMilliseconds).End('}');
  }
  json.End(']');
  json.Key("queues").Begin('[');
  for (const QueueStats& q : stats.queues)
    if (q.items > 0)
      json.Begin('{').Pair("name", q.name).Pair("items", q.items).Pair("peak", q.peak).Pair("occupancy", q.occupancy)
          .Pair("milliseconds", q.milliseconds).End('}');
  json.End(']');
}

void WriteMeasurement(JsonWriter& json, const Measurement& m, const DeviceBandwidth& device) {
  json.Begin('{').Pair("mode", NameOf(m.variant.mode)).Pair("rendered", m.rendered);
  if (!m.rendered) {
    json.Pair("why", m.why).End('}');
    return;
  }
  const auto [low, high] = Spread(m);
  json.Pair("mpathsPerSecond", m.mpaths()).Pair("mraysPerSecond", m.mrays()).Pair("seconds", m.median());
  json.Pair("secondsLow", low).Pair("secondsHigh", high).Pair("runs", m.seconds.size());
  json.Pair("poolSize", m.stats.poolSize).Pair("poolAsked", m.variant.poolSize).Pair("poolCut", m.poolCut()).Pair("refills", m.refills());
  json.Pair("paths", m.stats.paths).Pair("segments", m.stats.segments).Pair("shadowRays", m.stats.shadowRays);
  json.Pair("iterations", m.stats.iterations).Pair("submits", m.stats.submits).Pair("errorFlags", m.stats.errorFlags);
  json.Pair("film", m.film).Pair("compileSeconds", m.compileSeconds).Pair("kernelMilliseconds", KernelMilliseconds(m.stats));
  if (m.stateBytesPerSegment > 0) json.Pair("stateBytesPerSegment", m.stateBytesPerSegment).Pair("copyShare", CopyShare(m, device));
  WriteKernels(json, m.stats);
  json.End('}');
}

// Mrays/s if all that a ray reads came over the bus at the speed of copies: caches do better.
double BusMrays(const RayMeasurement& m, const DeviceBandwidth& device) { return device.bytesPerSecond / std::max(m.bytesPerRay(), 1e-9) * 1e-6; }

void WriteRays(JsonWriter& json, const SceneResult& s, const DeviceBandwidth& device) {
  json.Key("rays").Begin('[');
  for (const RayMeasurement& m : s.rays) {
    const auto [fast, slow] = std::minmax_element(m.seconds.begin(), m.seconds.end());
    json.Begin('{').Pair("kind", m.kind).Pair("triangles", m.triangles).Pair("rays", m.rays).Pair("hits", m.hits).Pair("overflows", m.overflows);
    json.Pair("mraysPerSecond", m.mrays()).Pair("secondsLow", *fast).Pair("secondsHigh", *slow).Pair("runs", m.seconds.size());
    json.Pair("nodeBytesPerRay", m.bytes.nodes).Pair("triangleBytesPerRay", m.bytes.triangles);
    json.Pair("busMraysPerSecond", BusMrays(m, device)).Pair("shareOfBus", m.mrays() / BusMrays(m, device)).End('}');
  }
  json.End(']');
}

}  // namespace

void PrintDevice(const DeviceBandwidth& device) {
  std::printf("%s, %s (%s); copies read and write %.1f GB/s\n", device.name.c_str(), device.driver.c_str(), device.type.c_str(),
              device.bytesPerSecond * 1e-9);
}

void PrintScene(const SceneResult& s, const DeviceBandwidth& device) {
  std::printf("\n%s: %u x %u, %u samples; %llu triangles, %llu instances, %llu lights, %llu materials on %llu kernels, %llu textures\n", s.name.c_str(), s.width,
              s.height, s.samples, static_cast<unsigned long long>(s.triangles), static_cast<unsigned long long>(s.instances),
              static_cast<unsigned long long>(s.lights), static_cast<unsigned long long>(s.materials), static_cast<unsigned long long>(s.kernels),
              static_cast<unsigned long long>(s.textures));
  if (s.firstSeconds > 0)
    std::printf("  first picture after %.2f s, BVHs %.2f s of it; at most %.0f MiB of device memory\n", s.firstSeconds, s.bvhSeconds, s.peakDeviceBytes / 1048576);
  for (const Measurement& m : s.measurements) PrintMeasurement(m, device);
  if (const double gain = Gain(s); !std::isnan(gain)) std::printf("  wavefront is %+.0f %% faster\n", 100 * gain);
  if (Rendered(s)) std::printf("  identical: %s\n", s.identical ? "yes" : "NO");
  if (!s.error.empty()) std::printf("  FAILED: %s\n", s.error.c_str());
  for (const std::string& line : s.diagnostics) std::printf("  %s\n", line.c_str());
  if (s.validationMessages > 0) std::printf("  VALIDATION: %llu messages\n", static_cast<unsigned long long>(s.validationMessages));
  std::fflush(stdout);
}

void PrintRays(const SceneResult& s, const DeviceBandwidth& device) {
  if (!s.error.empty()) {
    std::printf("\n%s: rays FAILED: %s\n", s.name.c_str(), s.error.c_str());
    return;
  }
  std::printf("\n%s: rays through %llu triangles as one mesh\n", s.name.c_str(), static_cast<unsigned long long>(s.triangles));
  for (const std::string& line : s.diagnostics) std::printf("  %s\n", line.c_str());
  std::printf("  %-10s %10s %6s %10s %21s %9s %9s %12s %8s\n", "rays", "count", "hit", "Mrays/s", "(lowest to highest)", "node B", "triangle B", "bus Mrays/s", "of bus");
  for (const RayMeasurement& m : s.rays) {
    const auto [fast, slow] = std::minmax_element(m.seconds.begin(), m.seconds.end());
    const auto rate = [&](double seconds) { return static_cast<double>(m.rays) / seconds * 1e-6; };
    std::printf("  %-10s %10llu %5.1f%% %10.3f (%8.3f to %8.3f) %9.0f %9.0f %12.3f %7.1f%%\n", m.kind.c_str(), static_cast<unsigned long long>(m.rays),
                100.0 * static_cast<double>(m.hits) / static_cast<double>(m.rays), m.mrays(), rate(*slow), rate(*fast), m.bytes.nodes, m.bytes.triangles,
                BusMrays(m, device), 100 * m.mrays() / BusMrays(m, device));
    if (m.overflows > 0) std::printf("  %llu rays took more steps than they may\n", static_cast<unsigned long long>(m.overflows));
  }
  std::fflush(stdout);
}

void PrintSweep(const std::vector<SceneResult>& scenes) {
  std::printf("\n%-40s %10s %6s %10s %10s %7s %9s %9s %9s %8s %s\n", "scene", "pool", "filled", "wavefront", "megakernel", "gain", "Mrays/s", "compile s", "BVH s", "MiB",
              "identical");
  bool cut = false;
  for (const SceneResult& s : scenes) {
    const Measurement *wave = First(s, ExecutionMode::Wavefront), *mega = First(s, ExecutionMode::Megakernel);
    const Measurement* any = wave ? wave : mega;
    if (!any) {
      if (!s.error.empty()) std::printf("%-40.40s FAILED: %s\n", s.name.c_str(), s.error.c_str());
      continue;
    }
    const auto rate = [](const Measurement* m) {
      char text[32] = "-";
      if (m) std::snprintf(text, sizeof text, "%.3f", m->mpaths());
      return std::string(text);
    };
    const std::string pool = std::to_string(any->stats.poolSize) + (any->poolCut() ? "!" : "");
    char gain[32] = "-";
    if (wave && mega) std::snprintf(gain, sizeof gain, "%+.0f%%", 100 * Gain(s));
    std::printf("%-40.40s %10s %6.1f %10s %10s %7s %9.3f %9.2f %9.2f %8.0f %s%s\n", s.name.c_str(), pool.c_str(), any->refills(), rate(wave).c_str(), rate(mega).c_str(), gain,
                any->mrays(), any->compileSeconds, s.bvhSeconds, s.peakDeviceBytes / 1048576, s.identical ? "yes" : "NO", s.error.empty() ? "" : ", FAILED");
    cut = cut || any->poolCut();
  }
  if (cut) std::printf("! a pool that the device cannot have: cut to what it can\n");
}

std::string Json(const DeviceBandwidth& device, const std::vector<SceneResult>& scenes) {
  JsonWriter json;
  json.Begin('{');
  json.Key("device").Begin('{').Pair("name", device.name).Pair("driver", device.driver).Pair("type", device.type);
  json.Pair("copyBytesPerSecond", device.bytesPerSecond).End('}');
  json.Key("scenes").Begin('[');
  for (const SceneResult& s : scenes) {
    json.Begin('{').Pair("name", s.name).Pair("version", s.version).Pair("width", s.width).Pair("height", s.height).Pair("samples", s.samples);
    json.Pair("triangles", s.triangles).Pair("instances", s.instances).Pair("lights", s.lights).Pair("materials", s.materials);
    json.Pair("kernels", s.kernels).Pair("textures", s.textures).Pair("firstSeconds", s.firstSeconds).Pair("bvhSeconds", s.bvhSeconds);
    json.Pair("peakDeviceBytes", s.peakDeviceBytes).Pair("validationMessages", s.validationMessages);
    if (Rendered(s)) json.Pair("identical", s.identical);
    if (!s.error.empty()) json.Pair("error", s.error);
    if (const double gain = Gain(s); !std::isnan(gain)) json.Pair("gain", gain);
    for (const ExecutionMode mode : {ExecutionMode::Wavefront, ExecutionMode::Megakernel})
      if (const Measurement* m = First(s, mode)) WriteMeasurement(json.Key(NameOf(mode)), *m, device);
    if (!s.rays.empty()) WriteRays(json, s, device);
    json.Key("variants").Begin('[');
    for (const Measurement& m : s.measurements) WriteMeasurement(json, m, device);
    json.End(']').Key("diagnostics").Begin('[');
    for (const std::string& line : s.diagnostics) json.Value(line);
    json.End(']').End('}');
  }
  json.End(']').End('}');
  return json.text() + "\n";
}

Status WriteText(const std::string& text, const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  const bool written = file && std::fwrite(text.data(), 1, text.size(), file) == text.size();
  const int reason = errno;
  if ((file && std::fclose(file) != 0) || !written) return Error{path + " cannot be written: " + std::strerror(reason) + "."};
  return {};
}

Status WritePfm(const AovImage& color, const std::string& path) {
  std::string text = "PF\n" + std::to_string(color.width) + " " + std::to_string(color.height) + "\n-1.0\n";
  for (uint32_t y = color.height; y-- > 0;)
    for (uint32_t x = 0; x < color.width; ++x) {
      const std::size_t pixel = (std::size_t{y} * color.width + x) * color.components;
      text.append(reinterpret_cast<const char*>(&color.bits[pixel]), 3 * sizeof(uint32_t));
    }
  return WriteText(text, path);
}

}  // namespace bench
