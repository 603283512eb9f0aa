// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/bench/measure.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>

#include "delegate/capture/scene_file.h"
#include "materialgen/spirv_cache.h"
#include "plugin/bench/sample_count.h"

namespace bench {
namespace {

using namespace wavefront;
using Clock = std::chrono::steady_clock;

double Since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::string HashOf(const RawFilm& film) {
  const uint64_t hash = delegate::Checksum(std::as_bytes(std::span(film.first)), delegate::Checksum(std::as_bytes(std::span(film.sums))));
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

struct Render {
  double seconds = 0;
  RenderStats stats;
  std::string film;
};

class Player {
 public:
  static Result<std::unique_ptr<Player>> Create(delegate::CapturedScene scene, const MeasureOptions& options) {
    auto player = std::unique_ptr<Player>(new Player);
    player->settings_ = scene.settings;
    RendererOptions rendererOptions;
    rendererOptions.device = options.device;
    rendererOptions.validation = options.validation;
    rendererOptions.cacheFolder = materialgen::CacheFolder();
    rendererOptions.diagnostics = [raw = player.get()](const Diagnostic& d) { raw->Say(d); };
    auto renderer = Renderer::Create(rendererOptions);
    if (!renderer) return renderer.error();
    player->renderer_ = std::move(renderer).value();
    if (Status s = delegate::SendScene(std::move(scene), *player->renderer_); !s) return s.error();
    return player;
  }

  Result<Render> Once(const Variant& variant, uint32_t samples) {
    RenderSettings settings = settings_;
    settings.executionMode = variant.mode;
    settings.poolSize = variant.poolSize;
    settings.samples = samples;
    const uint64_t before = renderer_->version();
    if (Status s = Commit(settings); !s) return s.error();
    if (renderer_->version() == before) {  // what is rendered already starts anew only for something else
      RenderSettings other = settings;
      ++other.samples;
      if (Status s = Commit(other); !s) return s.error();
      if (Status s = Commit(settings); !s) return s.error();
    }
    if (Status s = renderer_->Start(); !s) return s.error();
    while (!renderer_->WaitUntilDone(3600)) {}
    if (Status s = renderer_->status(); !s) return s.error();
    Render render;
    render.seconds = renderer_->progress().seconds;
    render.stats = renderer_->stats();
    auto film = renderer_->ReadFilm();
    if (!film) return film.error();
    if (!film->complete) return Error{"The render ended early."};
    render.film = HashOf(*film);
    return render;
  }

  Renderer& renderer() { return *renderer_; }
  const RenderSettings& settings() const { return settings_; }
  // Of the code, the last; empty: none.
  std::string Said(const std::string& code) const {
    std::lock_guard lock(mutex_);
    for (auto d = diagnostics_.rbegin(); d != diagnostics_.rend(); ++d)
      if (d->code.starts_with(code)) return d->message;
    return {};
  }
  std::vector<std::string> Diagnostics() const {
    std::lock_guard lock(mutex_);
    std::vector<std::string> lines;
    for (const Diagnostic& d : diagnostics_) {
      const std::string line = "[" + d.code + "] " + d.location + ": " + d.message;
      if (!d.code.starts_with("megakernel-") && std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
    }
    return lines;
  }

 private:
  Player() = default;
  Status Commit(const RenderSettings& settings) {
    renderer_->SetRenderSettings(settings);
    return renderer_->Commit();
  }
  void Say(const Diagnostic& d) {
    std::lock_guard lock(mutex_);
    diagnostics_.push_back(d);
  }

  RenderSettings settings_;
  mutable std::mutex mutex_;  // before the renderer, whose threads report to their last breath
  std::vector<Diagnostic> diagnostics_;
  std::unique_ptr<Renderer> renderer_;
};

// The AOV that differs from run to run by its nature is not rendered.
void LeaveOutCosts(RenderSettings& settings) { std::erase(settings.aovs, Aov::MaterialCost); }

double CompileSeconds(const RenderStats& stats) {
  double milliseconds = 0;
  for (const KernelStats& k : stats.kernels) milliseconds += k.codeMilliseconds + k.createMilliseconds + k.firstDispatchMilliseconds;
  return milliseconds * 1e-3;
}

double StateBytesPerSegment(const RenderStats& stats) {
  double bytes = 0;
  for (const KernelStats& k : stats.kernels) bytes += static_cast<double>(k.stateBytesRead + k.stateBytesWritten) * static_cast<double>(k.items);
  return stats.segments == 0 ? 0 : bytes / static_cast<double>(stats.segments);
}

// The render that is not counted; whether there is anything to measure.
Status Prepare(Player& player, Measurement& m) {
  // A kernel that no path has met may still be on its way.
  for (int i = 0; i < 64; ++i) {
    auto render = player.Once(m.variant, std::min(player.settings().samples, 2u));
    if (!render) return render.error();
    m.rendered = render->stats.executionMode == m.variant.mode;
    m.compileSeconds = CompileSeconds(render->stats);
    if (!m.rendered) m.why = player.Said("megakernel-");
    if (!m.rendered || render->stats.kernelsPending == 0) return {};
  }
  return {};
}

void DescribeScene(const RenderStats& stats, SceneResult& result) {
  result.bvhSeconds = stats.bvhSeconds;
  result.triangles = stats.triangles;
  result.instances = stats.instances;
  result.lights = stats.lights;
  result.materials = stats.materials;
  result.textures = stats.textures;
}

// The samples that every variant is measured with, from short renders that grow until they say enough.
Result<uint32_t> ChooseSamples(Player& player, const std::vector<Measurement>& measurements, double seconds) {
  const RenderSettings& settings = player.settings();
  const uint64_t pixels = uint64_t{settings.width} * settings.height;
  uint32_t chosen = settings.samples, tried = std::clamp(settings.samples, 1u, 2u);
  for (bool enough = seconds <= 0; !enough; tried = std::min(chosen, 8 * tried)) {
    std::vector<Probe> probes;
    for (const Measurement& m : measurements) {
      if (!m.rendered) continue;
      auto render = player.Once(m.variant, tried);
      if (!render) return render.error();
      probes.push_back({render->stats.poolSize, render->seconds / tried});
    }
    chosen = SamplesFor(settings.samples, pixels, seconds, probes);
    // Where nobody asked for a pool it grows with the work; a short time is mostly the host's.
    enough = chosen <= 2 * tried || std::all_of(probes.begin(), probes.end(), [&](const Probe& p) {
      return tried * p.secondsPerSample >= 0.1 * seconds && pixels * tried > p.poolSize;
    });
  }
  return chosen;
}

Status RenderAll(delegate::CapturedScene scene, const std::vector<Variant>& variants, const MeasureOptions& options, SceneResult& result,
                 std::vector<std::vector<Render>>& renders) {
  const auto start = Clock::now();
  auto made = Player::Create(std::move(scene), options);
  if (!made) return made.error();
  Player& player = **made;
  const auto say = [&](const std::string& what) { if (options.progress) options.progress(result.name + ": " + what); };
  const auto measureAll = [&]() -> Status {
    for (std::size_t v = 0; v < variants.size(); ++v) {
      Measurement& m = result.measurements[v];
      say(std::string("compiling, ") + (m.variant.mode == ExecutionMode::Wavefront ? "wavefront" : "megakernel"));
      if (Status s = Prepare(player, m); !s) return s;
      if (v != 0) continue;
      result.firstSeconds = Since(start);
      DescribeScene(player.renderer().stats(), result);
    }
    auto samples = ChooseSamples(player, result.measurements, options.seconds);
    if (!samples) return samples.error();
    result.samples = samples.value();
    for (uint32_t run = 0; run < options.runs; ++run)
      for (std::size_t v = 0; v < variants.size(); ++v) {
        if (!result.measurements[v].rendered) continue;
        say("run " + std::to_string(run + 1) + " of " + std::to_string(options.runs));
        auto render = player.Once(result.measurements[v].variant, result.samples);
        if (!render) return render.error();
        renders[v].push_back(std::move(render).value());
      }
    return {};
  };
  const Status status = measureAll();
  const RenderStats stats = player.renderer().stats();
  for (const auto& [kind, bytes] : stats.memoryPeakBytes) result.peakDeviceBytes += static_cast<double>(bytes);
  result.validationMessages = stats.validationMessages;
  result.diagnostics = player.Diagnostics();
  if (!status) return status;
  auto color = player.renderer().Map(Aov::Color);
  if (color) result.color = std::move(color).value();
  return {};
}

void Summarise(Measurement& m, std::vector<Render>& renders) {
  for (const Render& render : renders) m.seconds.push_back(render.seconds);
  const double median = m.median();
  for (Render& render : renders) {
    if (m.film.empty()) m.film = render.film;
    m.identical = m.identical && m.film == render.film;
    if (render.seconds == median) m.stats = std::move(render.stats);
  }
  if (m.variant.mode == ExecutionMode::Wavefront) m.stateBytesPerSegment = StateBytesPerSegment(m.stats);
}

}  // namespace

double Measurement::median() const {
  std::vector<double> sorted = seconds;
  std::sort(sorted.begin(), sorted.end());
  return sorted.empty() ? 0 : sorted[sorted.size() / 2];
}

SceneResult Measure(delegate::CapturedScene scene, const std::vector<Variant>& variants, const MeasureOptions& options) {
  SceneResult result;
  result.name = scene.info.name;
  result.version = scene.info.version;
  result.kernels = scene.kernels.size();
  LeaveOutCosts(scene.settings);
  result.width = scene.settings.width;
  result.height = scene.settings.height;
  result.samples = scene.settings.samples;
  for (const Variant& variant : variants) result.measurements.emplace_back().variant = variant;
  std::vector<std::vector<Render>> renders(variants.size());
  if (Status s = RenderAll(std::move(scene), variants, options, result, renders); !s) result.error = s.error().message;
  std::string film;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    Measurement& m = result.measurements[v];
    if (renders[v].empty()) {
      if (m.rendered || m.why.empty()) m.why = result.error;
      m.rendered = false;
      continue;
    }
    Summarise(m, renders[v]);
    if (film.empty()) film = m.film;
    result.identical = result.identical && m.identical && m.film == film;
  }
  return result;
}

}  // namespace bench
