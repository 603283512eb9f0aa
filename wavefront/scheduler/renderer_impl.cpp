// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/renderer_impl.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "wavefront/base/parallel.h"
#include "wavefront/scheduler/pipeline_cache_file.h"
#include "wavefront/scheduler/work_stats.h"
#include "wavefront/shared/counters_layout.h"
#include "wavefront/vulkan/driver_compile.h"

namespace wavefront {
namespace {

std::atomic<int64_t> liveRenderers{0};

// Equal values must not restart a render, so settings and cameras are compared field by field.
bool SameCamera(const CameraData& a, const CameraData& b) {
  if (a.transforms.size() != b.transforms.size()) return false;
  for (std::size_t i = 0; i < a.transforms.size(); ++i) {
    if (a.transforms[i].time != b.transforms[i].time || a.transforms[i].value.m != b.transforms[i].value.m) return false;
  }
  auto tie = [](const CameraData& c) {
    return std::tie(c.orthographic, c.left, c.right, c.bottom, c.top, c.nearClip, c.farClip, c.clipPlanes, c.lensRadius, c.focusDistance, c.exposureScale,
                    c.shutterOpen, c.shutterClose);
  };
  return tie(a) == tie(b);
}
bool SameSettings(const RenderSettings& a, const RenderSettings& b) {
  auto tie = [](const RenderSettings& s) {
    return std::tie(s.width, s.height, s.firstSample, s.samples, s.maxBounces, s.rouletteBounce, s.maxTransparency, s.seed, s.executionMode, s.poolSize,
                    s.samplesPerBatch, s.bandRows, s.frame, s.time, s.radianceClamp, s.cameraVisibleDome, s.shadows, s.lightSampling, s.aovs, s.primvarAovs);
  };
  return tie(a) == tie(b);
}

}  // namespace

Result<std::unique_ptr<Renderer>> Renderer::Create(const RendererOptions& options) { return RendererImpl::Make(options); }

Result<std::unique_ptr<Renderer>> RendererImpl::Make(const RendererOptions& options) {
  std::unique_ptr<RendererImpl> renderer(new RendererImpl(options));
  vulkan::DeviceOptions deviceOptions{options.device, options.validation, options.memoryBudget, false, {}};
  deviceOptions.pipelineCacheOf = [&](const vulkan::DeviceInfo& info) {
    std::string ignored;
    if (vulkan::DriverCompileOf(info, &ignored) == vulkan::DriverCompile::AtCreation)
      renderer->pipelineCacheFile_ = PipelineCacheFile(options.cacheFolder, info);
    return ReadPipelineCache(renderer->pipelineCacheFile_);
  };
  auto device = vulkan::Device::Create(deviceOptions);
  if (!device) return device.error();
  renderer->device_ = std::move(device).value();
  renderer->scene_ = std::make_unique<SceneStore>(*renderer->device_);
  auto tracer = PathTracer::Create(*renderer->device_);
  if (!tracer) return tracer.error();
  renderer->tracer_ = std::move(tracer).value();
  renderer->displacer_ = std::make_unique<Displacer>(*renderer->device_, renderer->tracer_->kernels().layout(), renderer->scene_->textures);
  return std::unique_ptr<Renderer>(std::move(renderer));
}

RendererImpl::RendererImpl(const RendererOptions& options) : options_(options) { ++liveRenderers; }
RendererImpl::~RendererImpl() {
  Stop();
  {
    std::lock_guard lock(deviceMutex_);
    displacer_.reset();
    tracer_.reset();
    scene_.reset();
    // Where it cannot be kept, the next run compiles once more.
    if (!pipelineCacheFile_.empty() && device_) {
      if (auto data = device_->PipelineCacheData()) (void)WritePipelineCache(pipelineCacheFile_, data.value());
    }
  }
  --liveRenderers;
}

LiveObjects CountLiveObjects() { return {liveRenderers, vulkan::LiveDeviceBytes(), vulkan::LiveHandles()}; }
int64_t LiveObjects::handleCount() const {
  int64_t count = 0;
  for (const auto& [kind, alive] : handles) count += alive;
  return count;
}

void RendererImpl::SetCamera(const CameraData& camera) {
  std::lock_guard lock(stagingMutex_);
  if (!cameraDirty_ && SameCamera(camera, stagedCamera_)) return;
  stagedCamera_ = camera;
  cameraDirty_ = true;
}
void RendererImpl::SetRenderSettings(const RenderSettings& settings) {
  std::lock_guard lock(stagingMutex_);
  stagedSettings_.interactive = settings.interactive;  // concerns the next Commit, but no image
  stagedSettings_.textureMemory = settings.textureMemory;  // so does this one, where no texture is reduced
  if (!settingsDirty_ && SameSettings(settings, stagedSettings_)) return;
  stagedSettings_ = settings;
  settingsDirty_ = true;
  scene_->SetPrimvarAovs(settings.primvarAovs);
  scene_->SetLightSampling(settings.lightSampling, settings.shadows);
}

Status RendererImpl::Commit() {
  const auto start = Clock::now();
  const bool wasRunning = progress().running;
  Stop();
  std::lock_guard device(deviceMutex_);
  if (Status s = tracer_->Drain(); !s) return s;
  const unsigned threads = options_.threads != 0 ? options_.threads : DefaultThreadCount();
  bool changed = false;
  ExecutionMode staged;
  bool interactive = false;
  {
    std::lock_guard lock(stagingMutex_);
    staged = stagedSettings_.executionMode;
    interactive = stagedSettings_.interactive;
    scene_->textures.SetLimit(stagedSettings_.textureMemory);
  }
  const auto displace = [this](MeshData& mesh) { return displacer_->Displace(mesh, options_.diagnostics); };
  const auto compile = [&] {
    if (staged == ExecutionMode::Wavefront) tracer_->OrderKernels(*scene_, threads);
  };
  if (Status s = scene_->Commit(threads, interactive, options_.diagnostics, displace, compile, &changed); !s) return s;
  {
    std::lock_guard lock(stagingMutex_);
    changed = changed || cameraDirty_ || settingsDirty_ || !configured_;
    settings_ = stagedSettings_;
    camera_ = stagedCamera_;
    cameraDirty_ = settingsDirty_ = false;
  }
  tracer_->SetInteractive(settings_.interactive);
  if (changed) {
    configured_ = false;  // until all of it is: after an error nothing of the old film fits the new settings
    if (settings_.width == 0 || settings_.height == 0) return Error{"the image has no pixels: " + std::to_string(settings_.width) + " x " + std::to_string(settings_.height)};
    for (uint32_t slot = 0; slot < kMaxPrimvarAovs; ++slot) {
      const bool held = std::find(settings_.aovs.begin(), settings_.aovs.end(), PrimvarAov(slot)) != settings_.aovs.end();
      if (held != (slot < settings_.primvarAovs.size())) return Error{"every primvar AOV needs a name, and every name its AOV: slot " + std::to_string(slot) + " has one of them"};
    }
    // The host holds the film of an image that renders in bands, and hands out copies.
    constexpr uint64_t kMaxPixels = 1ull << 29;
    if (static_cast<uint64_t>(settings_.width) * settings_.height > kMaxPixels) {
      return Error{"the image is too large: " + std::to_string(settings_.width) + " x " + std::to_string(settings_.height) + " is more than " +
                   std::to_string(kMaxPixels) + " pixels"};
    }
    if (static_cast<uint64_t>(settings_.firstSample) + settings_.samples > 0xffffffffull) return Error{"the sample range ends past 2^32"};
    if (Status s = tracer_->Configure(settings_, camera_, *scene_, threads, options_.diagnostics); !s) return s;
    configured_ = true;
    committed_ = start;
    firstPathSeconds_ = kernelsReadySeconds_ = 0;
    reportedFlags_ = 0;
    RestartFilm();
    std::lock_guard lock(stateMutex_);
    converged_ = false;
    secondsBefore_ = 0;
    error_ = {};
    progress_ = {};
    progress_.pathsTotal = static_cast<uint64_t>(settings_.width) * settings_.height * settings_.samples;
  }
  commitSeconds_ = std::chrono::duration<double>(Clock::now() - start).count();
  Publish();
  (void)wasRunning;  // the host starts again: Start belongs to the controlling thread
  return {};
}

void RendererImpl::RestartFilm() {
  ++version_;
  band_ = 0;
  bandBegun_ = false;
  film_ = {};
}

Status RendererImpl::Start() {
  std::unique_lock lock(stateMutex_);
  if (running_) return {};
  if (!configured_) return Error{"nothing was committed yet"};
  if (converged_) return {};
  lock.unlock();
  if (thread_.joinable()) thread_.join();
  lock.lock();
  error_ = {};
  stopRequested_ = false;
  paused_ = false;
  running_ = true;
  runStart_ = Clock::now();
  thread_ = std::thread([this] { Run(); });
  return {};
}

void RendererImpl::Pause() {
  std::lock_guard lock(stateMutex_);
  if (!running_ || paused_) return;
  secondsBefore_ = SecondsLocked();
  paused_ = true;
}
void RendererImpl::Resume() {
  std::lock_guard lock(stateMutex_);
  if (!paused_) return;
  paused_ = false;
  runStart_ = Clock::now();
  stateChanged_.notify_all();
}
void RendererImpl::Stop() {
  {
    std::lock_guard lock(stateMutex_);
    stopRequested_ = true;
    stateChanged_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
}
bool RendererImpl::WaitUntilDone(double timeoutSeconds) {
  std::unique_lock lock(stateMutex_);
  return stateChanged_.wait_for(lock, std::chrono::duration<double>(std::clamp(timeoutSeconds, 0.0, 1e9)), [this] { return !running_; });
}
Status RendererImpl::status() const {
  std::lock_guard lock(stateMutex_);
  return error_;
}
double RendererImpl::SecondsLocked() const {
  return running_ && !paused_ ? secondsBefore_ + std::chrono::duration<double>(Clock::now() - runStart_).count() : secondsBefore_;
}
Progress RendererImpl::progress() const {
  std::lock_guard lock(stateMutex_);
  Progress p = progress_;
  p.seconds = SecondsLocked();
  p.running = running_;
  p.paused = paused_;
  p.converged = converged_;
  return p;
}
bool RendererImpl::IsConverged() const {
  std::lock_guard lock(stateMutex_);
  return converged_;
}

void RendererImpl::Run() {
  Status result = RenderUntilStopped();
  std::lock_guard lock(stateMutex_);
  secondsBefore_ = SecondsLocked();
  if (!result) error_ = result;
  running_ = false;
  stateChanged_.notify_all();
}

Status RendererImpl::RenderUntilStopped() {
  // A stop or a map waits no longer than this for a render that waits for kernels.
  constexpr double kKernelPoll = 0.02;
  bool waiting = false;
  for (;;) {
    {
      std::unique_lock lock(stateMutex_);
      stateChanged_.wait(lock, [this] { return !paused_ || stopRequested_; });
      if (stopRequested_) break;
    }
    if (waiting) tracer_->kernels().WaitForKernels(kKernelPoll);
    std::lock_guard device(deviceMutex_);
    if (!bandBegun_) {
      if (settings_.samples == 0) {
        std::lock_guard lock(stateMutex_);
        converged_ = true;
        return {};
      }
      if (Status s = tracer_->BeginBand(band_); !s) return s;
      bandBegun_ = true;
    }
    PathTracer::Progress step;
    if (Status s = tracer_->Step(options_.diagnostics, &step); !s) return s;
    if (step == PathTracer::Progress::Restart) RestartFilm();
    waiting = step == PathTracer::Progress::Waiting;
    Publish();
    if (step != PathTracer::Progress::Done) continue;
    if (tracer_->bandCount() > 1) {
      if (film_.sums.empty()) {
        film_.sums.resize(static_cast<std::size_t>(settings_.width) * settings_.height * tracer_->film().sumChannels);
        film_.first.resize(static_cast<std::size_t>(settings_.width) * settings_.height * tracer_->film().firstChannels);
      }
      if (Status s = tracer_->ReadBand(&film_); !s) return s;
    }
    if (band_ + 1 < tracer_->bandCount()) {
      ++band_;
      bandBegun_ = false;
      continue;
    }
    ReportErrorFlags();
    std::lock_guard lock(stateMutex_);
    converged_ = true;
    progress_.samplesDone = settings_.samples;
    progress_.pathsDone = progress_.pathsTotal;
    return {};
  }
  std::lock_guard device(deviceMutex_);
  Status s = tracer_->Drain();
  Publish();
  ReportErrorFlags();
  return s;
}

void RendererImpl::ReportErrorFlags() {
  const uint32_t fresh = tracer_->status().errorFlags & ~reportedFlags_;
  reportedFlags_ |= fresh;
  if (!options_.diagnostics) return;
  auto report = [&](uint32_t flag, const char* code, const char* text) {
    if ((fresh & flag) != 0) options_.diagnostics({Severity::Warning, code, "render", text});
  };
  report(layout::kErrorTraversalBudget, "render-traversal-budget", "some rays gave up in the BVH; parts of the picture may be missing");
  report(layout::kErrorStackOverflow, "render-stack", "a ray needed more stack than there is; parts of the picture may be missing");
  report(layout::kErrorNonFinite, "render-non-finite", "some samples were not finite numbers and count as black");
  report(layout::kErrorTransparency, "render-transparency-limit", "some rays met more transparent surfaces than the limit; what lies behind them counts as black");
  report(layout::kErrorMediaStack, "render-media-stack", "more than four transmissive bodies lie inside each other; the innermost absorb nothing");
  report(layout::kErrorMediumSteps, "render-medium-steps", "some paths scattered too often inside of a body and were ended; it may be darker than it should be");
}

// Copies what the render thread knows to where any thread may read it. Device mutex held.
void RendererImpl::Publish() {
  const LoopStatus& loop = tracer_->status();
  RenderStats s;
  s.kernelsPending = tracer_->kernels().pending();
  auto row = [&](const KernelTimes& t) {
    const CompileCost& c = t.compile;
    s.kernels.push_back({t.name, t.seconds * 1e3, 0, t.dispatches, "ready", c.codeMilliseconds, c.codeFromCache, c.createSeconds * 1e3,
                         c.firstDispatchSeconds * 1e3, c.spirvBytes, c.spirvInstructions,
                         c.state.bytesRead, c.state.bytesWritten, c.driverStatistics});
  };
  for (const KernelTimes& t : tracer_->kernels().times()) row(t);
  for (std::size_t k = kKernelCount; k < s.kernels.size(); ++k) {
    constexpr const char* kStates[] = {"unused", "compiling", "ready", "failed"};
    s.kernels[k].state = kStates[static_cast<std::size_t>(tracer_->kernels().state(static_cast<uint32_t>(k - kKernelCount)))];
  }
  s.paths = loop.pathsStarted - std::min(loop.pathsStarted, loop.active);
  s.segments = s.extensionRays = loop.queueItems[static_cast<uint32_t>(Queue::ExtensionRay)];
  s.shadowRays = loop.queueItems[static_cast<uint32_t>(Queue::ShadowRay)];
  s.iterations = loop.iterations;
  s.submits = tracer_->submits();
  s.commitSeconds = commitSeconds_;
  s.bvhSeconds = scene_->geometry.bvhSeconds();
  const bvh::TreeCounts& trees = scene_->geometry.treeCounts();
  s.trees = {trees.built, trees.builtFast, trees.refitted, scene_->instanceTreesBuilt(), scene_->instanceTreesRefitted()};
  s.triangles = scene_->geometry.triangleCount();
  s.instances = scene_->facts().instances;
  s.lights = scene_->facts().lightCount;
  s.lightItems = scene_->facts().lightItemCount;
  s.materials = scene_->materials.count();
  s.textures = scene_->textures.count();
  s.uploadedBytes = device_->uploadedBytes();
  s.validationMessages = vulkan::ValidationMessageCount();
  s.errorFlags = loop.errorFlags;
  s.poolSize = tracer_->poolSize();
  s.executionMode = tracer_->executionMode();
  if (s.executionMode == ExecutionMode::Megakernel) row(tracer_->megakernel().times());
  AddWork(loop, s.poolSize, s.executionMode, &s);
  for (const auto& [key, t] : displacer_->times())
    s.kernels.push_back({"displacement:" + key, t.seconds * 1e3, t.corners, t.dispatches, "ready", 0, false, t.createSeconds * 1e3, t.firstDispatchSeconds * 1e3, t.spirvBytes});
  const vulkan::MemoryByKind memory = device_->memoryByKind();
  for (std::size_t k = 0; k < vulkan::kMemoryKindCount; ++k) {
    const std::string name(vulkan::MemoryKindName(static_cast<vulkan::MemoryKind>(k)));
    s.memoryBytes[name] = memory[k].current;
    s.memoryPeakBytes[name] = memory[k].peak;
  }
  const double sinceCommit = std::chrono::duration<double>(Clock::now() - committed_).count();
  if (firstPathSeconds_ == 0 && s.paths != 0) firstPathSeconds_ = sinceCommit;
  if (kernelsReadySeconds_ == 0 && s.kernelsPending == 0) kernelsReadySeconds_ = sinceCommit;
  s.firstPathSeconds = firstPathSeconds_;
  s.kernelsReadySeconds = kernelsReadySeconds_;
  std::lock_guard lock(stateMutex_);
  stats_ = std::move(s);
  progress_.pathsDone = stats_.paths;
  const uint64_t pixels = static_cast<uint64_t>(settings_.width) * settings_.height;
  if (pixels != 0 && !converged_) progress_.samplesDone = static_cast<uint32_t>(stats_.paths / pixels);
}

RenderStats RendererImpl::stats() const {
  std::lock_guard lock(stateMutex_);
  RenderStats s = stats_;
  s.renderSeconds = SecondsLocked();
  return s;
}

Result<AovImage> RendererImpl::Map(Aov aov) {
  std::lock_guard turn(deviceMutex_);
  return MapLocked(aov);
}
Result<std::vector<AovImage>> RendererImpl::Map(std::span<const Aov> aovs) {
  std::lock_guard turn(deviceMutex_);
  std::vector<AovImage> images;
  for (Aov aov : aovs) {
    auto image = MapLocked(aov);
    if (!image) return image.error();
    images.push_back(std::move(image).value());
  }
  return images;
}
Result<AovImage> RendererImpl::MapLocked(Aov aov) {
  if (!configured_) return Error{"nothing was committed yet"};
  if (tracer_->film().of(aov) == layout::kNoChannel) return Error{"the AOV " + std::string(Aovs()[static_cast<uint32_t>(aov)].token) + " was not asked for"};
  // Bands not rendered yet show the clear value; finished ones come from their sums.
  RawFilm shape;
  shape.width = settings_.width;
  shape.height = settings_.height;
  shape.aovs = settings_.aovs;
  AovImage image;
  if (tracer_->bandCount() > 1 && !film_.sums.empty()) {
    film_.width = shape.width; film_.height = shape.height; film_.aovs = shape.aovs;
    image = ResolveFilm(film_, aov);
  } else {
    const AovInfo& info = Aovs()[static_cast<uint32_t>(aov)];
    uint32_t clear;
    const int32_t clearInt = static_cast<int32_t>(info.clear);
    if (info.format == AovFormat::Float32) std::memcpy(&clear, &info.clear, 4); else std::memcpy(&clear, &clearInt, 4);
    image = {aov, shape.width, shape.height, info.components, {}};
    image.bits.assign(static_cast<std::size_t>(shape.width) * shape.height * info.components, clear);
  }
  if (!bandBegun_) return image;
  std::vector<uint32_t> bits;
  if (Status s = tracer_->ResolveBand(aov, &bits); !s) return s.error();
  std::copy(bits.begin(), bits.end(), image.bits.begin() + static_cast<std::ptrdiff_t>(tracer_->bandY()) * image.width * image.components);
  return image;
}

Result<RawFilm> RendererImpl::ReadFilm() {
  std::lock_guard turn(deviceMutex_);
  if (!configured_) return Error{"nothing was committed yet"};
  RawFilm film = film_;
  film.width = settings_.width;
  film.height = settings_.height;
  film.firstSample = settings_.firstSample;
  film.samples = settings_.samples;
  film.aovs = settings_.aovs;
  film.primvarAovs = settings_.primvarAovs;
  film.complete = IsConverged();
  const std::size_t pixels = static_cast<std::size_t>(film.width) * film.height;
  film.sums.resize(pixels * tracer_->film().sumChannels);
  film.first.resize(pixels * tracer_->film().firstChannels);
  if (bandBegun_) if (Status s = tracer_->ReadBand(&film); !s) return s.error();
  return film;
}

Status RendererImpl::RunColorKernel(std::span<const uint32_t> spirv, const std::vector<ColorLut>& luts, std::span<float> rgba, uint32_t width, uint32_t height) {
  std::lock_guard turn(deviceMutex_);
  return colorKernel_.Run(*device_, spirv, luts, rgba, width, height);
}

std::vector<DeviceDescription> ListDevices() {
  std::vector<DeviceDescription> out;
  auto devices = vulkan::ListDevices();
  if (!devices) return out;
  for (const vulkan::DeviceInfo& info : devices.value()) {
    DeviceDescription d;
    d.name = info.name;
    d.driver = info.driverName + " " + info.driverVersion;
    d.type = vulkan::DeviceTypeName(info.type);
    d.apiVersion = info.apiVersion;
    for (const vulkan::HeapInfo& heap : info.heaps) if (heap.deviceLocal) d.heapBytes = std::max(d.heapBytes, heap.size);
    d.subgroupSize = info.limits.subgroupSize;
    d.usable = info.missing.empty();
    for (const std::string& m : info.missing) d.whyNot += (d.whyNot.empty() ? "" : ", ") + m;
    auto detail = [&](const char* name, auto value) { d.details.emplace_back(name, std::to_string(value)); };
    detail("maxStorageBufferRange", info.limits.maxStorageBufferRange);
    detail("maxTexelBufferElements", info.limits.maxTexelBufferElements);
    detail("maxStorageBuffersPerStage", info.limits.maxStorageBuffersPerStage);
    detail("maxWorkGroupInvocations", info.limits.maxWorkGroupInvocations);
    detail("hostThreads", info.hostThreads);
    for (const vulkan::FeatureInfo& f : info.features) d.details.emplace_back(f.name, f.present ? "yes" : f.required ? "MISSING" : "no");
    out.push_back(std::move(d));
  }
  return out;
}

}  // namespace wavefront
