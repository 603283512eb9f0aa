// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/path_tracer.h"

#include <algorithm>
#include <cstring>

#include "wavefront/base/check.h"
#include "wavefront/scene/transforms.h"
#include "wavefront/scheduler/pool_size.h"
#include "wavefront/shared/counters_layout.h"

namespace wavefront {
namespace {

using vulkan::MemoryKind;
using vulkan::MemoryLocation;
using namespace layout;

constexpr std::size_t kSlots = 3;  // submits in flight
constexpr uint32_t kTimestamps = 4096;
constexpr double kTargetSubmitSeconds = 0.05;
constexpr uint32_t kMaxIterationsPerSubmit = 32;
constexpr std::chrono::milliseconds kRestartInterval{400};
// Submits after which most kernels have been measured, and a film with materialCost starts anew.
constexpr uint32_t kCostSubmits = 6;

constexpr uint32_t kPathChunks = 0
#define WAVEFRONT_PATH_CHUNK(Name, index, doc) +1
#include "wavefront/shared/path_state.def"
#undef WAVEFRONT_PATH_CHUNK
    ;
static_assert(kQueueBase + kQueueKinds * kQueueStride <= kPathsDoneLo, "queue counters run into what follows");
static_assert(kPathChunks <= 16, "512K paths must fit one storage-buffer binding of 128 MiB");
#define WAVEFRONT_PATH_CHUNK(Name, index, doc) constexpr uint32_t kChunk##Name [[maybe_unused]] = index;
#include "wavefront/shared/path_state.def"
#undef WAVEFRONT_PATH_CHUNK

}  // namespace

Result<std::unique_ptr<PathTracer>> PathTracer::Create(vulkan::Device& device) {
  std::unique_ptr<PathTracer> tracer(new PathTracer(device));
  auto kernels = KernelRegistry::Create(device);
  if (!kernels) return kernels.error();
  tracer->kernels_ = std::move(kernels).value();
  auto stream = vulkan::CommandStream::Create(device, {static_cast<uint32_t>(kSlots), kTimestamps, "wavefront"});
  if (!stream) return stream.error();
  tracer->stream_ = std::move(stream).value();
  auto set = vulkan::DescriptorSet::Create(device, tracer->kernels_->layout(), "wavefront");
  if (!set) return set.error();
  tracer->set_ = std::move(set).value();
  tracer->inFlight_.resize(kSlots);
  return tracer;
}
PathTracer::~PathTracer() { (void)Drain(); }

uint32_t PathTracer::bandHeight() const { return std::min(bandRows_, settings_.height - bandY()); }

Status PathTracer::Allocate(std::unique_ptr<vulkan::Buffer>& buffer, uint64_t bytes, MemoryKind kind, MemoryLocation location, const char* name) {
  bytes = std::max<uint64_t>(16, bytes);
  if (buffer && buffer->size() >= bytes && buffer->size() <= 2 * bytes + 4096) return {};
  buffer.reset();
  auto created = vulkan::Buffer::Create(device_, {bytes, kind, location, name, kind == MemoryKind::PathState});
  if (!created) return created.error();
  buffer = std::move(created).value();
  return {};
}

Status PathTracer::Configure(const RenderSettings& settings, const CameraData& camera, SceneStore& scene, unsigned threads, const DiagnosticSink& sink) {
  if (Status s = Drain(); !s) return s;
  settings_ = settings;
  camera_ = camera;
  status_ = before_ = {};  // a paused host may ask before the first step
  facts_ = scene.facts();
  film_ = MakeFilmLayout(settings.aovs);
  if (Status s = kernels_->Specialize(SceneFeatures::Of(facts_)); !s) return s;
  if (Status s = ChooseMode(scene, sink); !s) return s;

  const uint64_t range = device_.info().limits.maxStorageBufferRange;
  const uint64_t poolLimit = std::min<uint64_t>(range / (16 * kPathChunks), device_.info().limits.maxTexelBufferElements / kPathChunks);
  const uint64_t wanted = settings.poolSize != 0 ? settings.poolSize
                                                 : DefaultPoolSize(device_.info().type, mode_, scene.materials.buckets().size(), settings.interactive);
  poolSize_ = static_cast<uint32_t>(std::clamp<uint64_t>(wanted, 64, poolLimit));
  // No more paths than there is work: a small image needs no big pool.
  const uint64_t work = static_cast<uint64_t>(settings.width) * settings.height * settings.samples;
  if (settings.poolSize == 0) poolSize_ = static_cast<uint32_t>(std::min<uint64_t>(poolSize_, std::max<uint64_t>(4096, (work + 63) / 64 * 64)));

  // Rows that a film binding holds; a larger image renders in bands.
  const uint64_t rowBytes = static_cast<uint64_t>(settings.width) * std::max<uint64_t>({film_.sumChannels * 8ull, film_.firstChannels * 4ull, 16ull});
  const uint64_t rows = range / rowBytes;
  if (rows == 0) return Error{"the image is too wide for this device's buffers: " + std::to_string(settings.width) + " pixels"};
  bandRows_ = static_cast<uint32_t>(std::min<uint64_t>(rows, settings.height));
  if (settings.bandRows != 0) bandRows_ = std::min(bandRows_, settings.bandRows);
  band_ = 0;
  const uint64_t pixels = static_cast<uint64_t>(settings.width) * bandRows_;
  if (pixels > 0x3fffffffu) return Error{"the image is too large"};

  const uint64_t pool = poolSize_;
  bucketCount_ = kFirstMaterialBucket + static_cast<uint32_t>(scene.materials.buckets().size());
  const uint64_t statusBytes = 4ull * (kBucketBase + static_cast<uint64_t>(kBucketStride) * bucketCount_);
  const uint64_t counterBytes = 4ull * (PartCounts(bucketCount_) + static_cast<uint64_t>(kPoolParts) * PartStride(bucketCount_));
  struct Row { std::unique_ptr<vulkan::Buffer>* buffer; uint64_t bytes; MemoryKind kind; MemoryLocation location; const char* name; };
  for (const Row& row : {Row{&pathState_, pool * 16 * kPathChunks, MemoryKind::PathState, MemoryLocation::DeviceLocal, "path state"},
                         {&queues_, pool * 4 * (kItemsQueues + kQueueKinds), MemoryKind::Queues, MemoryLocation::DeviceLocal, "queue items"},
                         {&counters_, counterBytes, MemoryKind::Queues, MemoryLocation::DeviceLocal, "counters"},
                         {&readback_, statusBytes * kSlots, MemoryKind::Queues, MemoryLocation::HostVisible, "status"},
                         {&filmSums_, pixels * film_.sumChannels * 8, MemoryKind::Film, MemoryLocation::DeviceLocal, "film sums"},
                         {&filmFirst_, pixels * film_.firstChannels * 4, MemoryKind::Film, MemoryLocation::DeviceLocal, "film first samples"},
                         {&resolved_, pixels * 16, MemoryKind::Film, MemoryLocation::DeviceLocal, "resolved AOV"},
                         {&frame_, sizeof(FrameConstants), MemoryKind::Tables, MemoryLocation::HostVisible, "frame constants"}}) {
    if (Status s = Allocate(*row.buffer, row.bytes, row.kind, row.location, row.name); !s) return s;
  }
  for (Status s : {set_->Write(0, *frame_), set_->Write(1, *pathState_), set_->WriteTexels(2, *pathState_),
                   set_->Write(3, *counters_), set_->Write(4, *queues_), set_->Write(5, *filmSums_), set_->Write(6, *filmFirst_),
                   set_->Write(7, *resolved_), scene.Bind(*set_)}) {
    if (!s) return s;
  }
  if (Status s = WriteFrameConstants(); !s) return s;
  if (mode_ == ExecutionMode::Megakernel) {
    runs_.clear();
    return megakernel_.WarmUp(*kernels_, *stream_, *set_);
  }
  OrderKernels(scene, threads);  // they compile while the fixed ones are warmed up
  runs_.assign(scene.materials.buckets().size(), {});
  costsMeasured_ = false;
  return kernels_->WarmUpFixed(facts_.hasMedia, threads, *stream_, *set_);
}

void PathTracer::OrderKernels(const SceneStore& scene, unsigned threads) { kernels_->Order(scene.materials.buckets(), scene.usedBuckets(), threads); }

// The megakernel where it is asked for and can be had; else the wavefront loop.
Status PathTracer::ChooseMode(SceneStore& scene, const DiagnosticSink& sink) {
  mode_ = ExecutionMode::Wavefront;
  if (settings_.executionMode == ExecutionMode::Wavefront) return {};
  Diagnostic trouble;
  auto prepared = megakernel_.Prepare(scene.materials, scene.usedBuckets(), *kernels_, &trouble);
  if (!prepared) return prepared.error();
  if (prepared.value()) mode_ = ExecutionMode::Megakernel;
  else if (sink && !trouble.code.empty()) sink(trouble);
  if (sink && mode_ == ExecutionMode::Megakernel && film_.of(Aov::MaterialCost) != kNoChannel) {
    sink({Severity::Warning, "megakernel-no-costs", "render", "the megakernel has no times of single materials; materialCost stays empty"});
  }
  return {};
}

Status PathTracer::WriteFrameConstants() {
  FrameConstants f{};
  const Matrix4d transform = camera_.transforms.empty() ? Matrix4d{} : camera_.transforms.front().value;
  const Rows rows = ToRows(transform, facts_.origin);
  auto row = [](const Float4& r) { return vec4{r.x, r.y, r.z, r.w}; };
  f.cameraToWorld0 = row(rows[0]); f.cameraToWorld1 = row(rows[1]); f.cameraToWorld2 = row(rows[2]);
  f.window = {camera_.left, camera_.right, camera_.bottom, camera_.top};
  f.nearClip = camera_.nearClip; f.farClip = camera_.farClip;
  layout::vec4* const planes[] = {&f.clipPlane0, &f.clipPlane1, &f.clipPlane2, &f.clipPlane3, &f.clipPlane4, &f.clipPlane5};
  static_assert(std::size(planes) == CameraData::kMaxClipPlanes);
  f.clipPlaneCount = static_cast<uint32_t>(std::min(camera_.clipPlanes.size(), CameraData::kMaxClipPlanes));
  for (uint32_t i = 0; i < f.clipPlaneCount; ++i) *planes[i] = row(camera_.clipPlanes[i]);
  f.lensRadius = camera_.focusDistance > 0 ? camera_.lensRadius : 0; f.focusDistance = camera_.focusDistance;
  f.exposureScale = camera_.exposureScale;
  const float pixelWidth = std::abs(camera_.right - camera_.left) / static_cast<float>(settings_.width);
  f.pixelSpread = camera_.orthographic ? 0.0f : pixelWidth;
  f.pixelWidth = camera_.orthographic ? pixelWidth : 0.0f;
  f.orthographic = camera_.orthographic ? 1u : 0u;
  f.width = settings_.width; f.height = settings_.height;
  f.bandY = bandY(); f.bandHeight = bandHeight();
  f.rangeFirstSample = settings_.firstSample;
  f.seed = settings_.seed;
  f.maxBounces = std::min(settings_.maxBounces, 254u);
  f.rouletteBounce = settings_.rouletteBounce;
  f.maxTransparency = std::min(settings_.maxTransparency, 254u);
  f.flags = (settings_.cameraVisibleDome ? kFrameDomeVisible : 0u) | (settings_.shadows ? kFrameShadows : 0u);
  f.radianceClamp = settings_.radianceClamp;
  f.shutterOpen = camera_.shutterOpen; f.shutterClose = camera_.shutterClose;
  f.frameNumber = settings_.frame; f.timeSeconds = settings_.time;
  const auto& o = facts_.origin;
  f.sceneOrigin = {static_cast<float>(o.x), static_cast<float>(o.y), static_cast<float>(o.z), 0};
  f.poolSize = poolSize_;
  f.bucketCount = bucketCount_;
  f.lightItemCount = facts_.lightItemCount; f.lightTree = facts_.lightTree; f.infiniteLightCount = facts_.infiniteLightCount; f.lightCount = facts_.lightCount;
  f.hasGeometry = facts_.hasGeometry; f.sceneRadius = facts_.sceneRadius; f.tlasRoot = facts_.tlasRoot;
  f.sumChannels = film_.sumChannels; f.firstChannels = film_.firstChannels;
  f.colorChannel = film_.of(Aov::Color); f.countChannel = film_.of(Aov::SampleCount);
  f.albedoChannel = film_.of(Aov::Albedo); f.normalChannel = film_.of(Aov::Normal);
  f.depthChannel = film_.of(Aov::Depth); f.cameraDepthChannel = film_.of(Aov::CameraDepth);
  f.primIdChannel = film_.of(Aov::PrimId); f.instanceIdChannel = film_.of(Aov::InstanceId); f.elementIdChannel = film_.of(Aov::ElementId);
  f.neyeChannel = film_.of(Aov::Neye); f.costChannel = film_.of(Aov::MaterialCost);
  f.primvarChannel = film_.of(Aov::Primvar0);
  f.primvarAovCount = f.primvarChannel == kNoChannel ? 0u : static_cast<uint32_t>(settings_.primvarAovs.size());
  return frame_->Upload(0, std::as_bytes(std::span(&f, 1)));
}

Status PathTracer::BeginRecording() {
  if (auto waited = stream_->Wait(stream_->nextFreeAt()); !waited) return waited.error();
  return stream_->Begin();
}

Status PathTracer::BeginBand(uint32_t band) {
  if (Status s = Drain(); !s) return s;
  band_ = band;
  if (band == 0) {
    before_ = {};
    status_ = {};
    for (BucketRun& run : runs_) run.standInRan = false;
    for (KernelTimes& times : kernels_->times()) times.seconds = 0, times.dispatches = 0;
    megakernel_.times().seconds = 0;
    megakernel_.times().dispatches = 0;
  }
  else before_ = status_;
  status_.drained = false;
  if (Status s = WriteFrameConstants(); !s) return s;
  batchEnd_ = settings_.samplesPerBatch == 0 ? settings_.firstSample + settings_.samples
                                             : settings_.firstSample + std::min(settings_.samples, settings_.samplesPerBatch);
  raiseBatch_ = false;
  // What was learnt at the end of another picture, when hardly a path was left, would make the first submits last for seconds.
  iterationsPerSubmit_ = 1;
  stalled_ = false;
  ++kernelEpoch_;
  holds_.assign(runs_.size(), 0);
  costs_.assign(runs_.size(), 0.0f);
  costSubmits_ = 0;
  bandItems_.assign(bucketCount_, 0);
  if (Status s = BeginRecording(); !s) return s;
  stream_->Fill(*filmSums_, 0, 0, 0);
  // FirstSample channels start at their AOV's clear value.
  if (film_.firstChannels != 0) {
    std::vector<uint32_t> clear(static_cast<std::size_t>(settings_.width) * bandHeight() * film_.firstChannels);
    for (std::size_t i = 0; i < clear.size(); ++i) clear[i] = film_.firstClear[i % film_.firstChannels];
    if (Status s = filmFirst_->Upload<uint32_t>(0, clear); !s) return s;
  }
  // No path; and no medium: where light enters no body, nothing else writes that chunk, and materials read it.
  for (uint32_t chunk : {kChunkIds, kChunkMedium})
    stream_->Fill(*pathState_, static_cast<uint64_t>(chunk) * poolSize_ * 16, static_cast<uint64_t>(poolSize_) * 16, 0);
  stream_->Fill(*counters_, 0, 0, 0);
  stream_->Barrier();
  const uint32_t work[3] = {settings_.firstSample, 0, batchEnd_};
  stream_->Update(*counters_, 4 * kWorkSample, std::as_bytes(std::span(work)));
  RecordWakeUp();
  auto value = stream_->Submit();
  if (!value) return value.error();
  auto done = stream_->Wait(value.value());
  return done ? Status() : Status(done.error());
}

// The kernels over the whole pool run again (scan_buckets puts them to sleep when nothing is left).
void PathTracer::RecordWakeUp() {
  const uint32_t arguments[6] = {(poolSize_ + 63) / 64, 1, 1, 1, 1, 1};
  stream_->Update(*counters_, 4 * kPoolArgs, std::as_bytes(std::span(arguments)));
}

void PathTracer::RecordIteration(std::vector<uint32_t>* rows) {
  auto stamp = [&](uint32_t row) {
    if (stream_->Timestamp() != vulkan::CommandStream::kNoTimestamp) rows->push_back(row);
  };
  auto row = [](Kernel k) { return static_cast<uint32_t>(k); };
  auto indirect = [&](Kernel k, uint32_t arguments) {
    stream_->BindPipeline(kernels_->fixed(k));
    stream_->DispatchIndirect(*counters_, 4ull * arguments);
    stream_->Barrier();
    stamp(row(k));
  };
  indirect(Kernel::Logic, kPoolArgs);
  indirect(Kernel::ScanBuckets, kScanArgs);
  auto queue = [&](Kernel k, Queue q) {
    stream_->BindPipeline(kernels_->fixed(k));
    stream_->DispatchIndirect(*counters_, 4ull * (kQueueBase + static_cast<uint32_t>(q) * kQueueStride + kQueueArgs));
    stamp(row(k));
  };
  // Side by side: they touch different paths, and the sort touches none.
  queue(Kernel::LightSample, Queue::LightSample);
  queue(Kernel::Escape, Queue::Escape);
  if (facts_.hasMedia) {
    queue(Kernel::MediumScatter, Queue::MediumScatter);
    queue(Kernel::SubsurfaceWalk, Queue::SubsurfaceWalk);
  }
  indirect(Kernel::Scatter, kPoolArgs);
  if (film_.of(Aov::MaterialCost) != kNoChannel) indirect(Kernel::MaterialCost, kPoolArgs);
  // New paths and all materials between two barriers.
  stream_->BindPipeline(kernels_->fixed(Kernel::NewPath));
  stream_->DispatchIndirect(*counters_, 4ull * (kBucketBase + kBucketNewPath * kBucketStride + kBucketArgs));
  stamp(row(Kernel::NewPath));
  for (uint32_t b = 0; b + kFirstMaterialBucket < bucketCount_; ++b) {
    const uint32_t bucket = b + kFirstMaterialBucket;
    if (runs_[b].pipeline == nullptr) continue;
    const uint32_t push[4] = {bucket, runs_[b].failed ? 1u : 0u, 0, 0};
    stream_->BindPipeline(*runs_[b].pipeline);
    stream_->PushConstants(std::as_bytes(std::span(push)));
    stream_->DispatchIndirect(*counters_, 4ull * (kBucketBase + static_cast<uint64_t>(bucket) * kBucketStride + kBucketArgs));
    stamp(kKernelCount + b);
  }
  if (facts_.hasMedia) queue(Kernel::SubsurfaceExit, Queue::SubsurfaceExit);
  stream_->Barrier();
  stream_->BindPipeline(kernels_->fixed(Kernel::ResetBuckets));
  stream_->Dispatch((std::max(bucketCount_, 2u) + 63) / 64);
  stream_->Barrier();
  stamp(row(Kernel::ResetBuckets));
  queue(Kernel::ExtensionRay, Queue::ExtensionRay);
  // The shadow kernel changes Ids, which the extension kernel reads: not side by side.
  stream_->Barrier();
  queue(Kernel::ShadowRay, Queue::ShadowRay);
  stream_->Barrier();
}

// What each bucket runs, now that kernels may have come. A bucket that no instance uses has no paths.
Status PathTracer::ChooseKernels() {
  for (std::size_t b = 0; b < runs_.size(); ++b) {
    BucketRun& run = runs_[b];
    const KernelRegistry::State state = kernels_->state(static_cast<uint32_t>(b));
    const bool compiling = state == KernelRegistry::State::Compiling;
    run.failed = state == KernelRegistry::State::Failed;
    run.held = compiling && !interactive_;
    run.standIn = compiling && interactive_;
    run.pipeline = kernels_->bucket(static_cast<uint32_t>(b));
    if (run.standIn || run.failed) {
      auto standIn = kernels_->StandIn(kernels_->entry(static_cast<uint32_t>(b)));
      if (!standIn) return standIn.error();
      run.pipeline = standIn.value();
    }
    run.standInRan = run.standInRan || run.standIn;
  }
  return {};
}

// `restart`: a kernel came whose paths a stand-in has shaded.
Status PathTracer::AdoptKernels(const DiagnosticSink& sink, bool* restart) {
  // Each restart throws the picture away, so kernels that come one after the other are taken together.
  const auto now = std::chrono::steady_clock::now();
  const bool more = kernels_->pending() > kernels_->finished();
  if (interactive_ && more && !stalled_ && now - lastRestart_ < kRestartInterval) return {};
  const std::vector<uint32_t> adopted = kernels_->Adopt(sink);
  if (adopted.empty()) return {};
  ++kernelEpoch_;
  stalled_ = false;
  costSubmits_ = 0;
  for (uint32_t b : adopted) {
    KernelTimes& times = kernels_->times()[kKernelCount + b];
    times.measuredSeconds = 0, times.measuredItems = 0;  // a stand-in's
    if (kernels_->bucket(b) != nullptr && kernels_->compilesAtDispatch()) fresh_.push_back(kernels_->bucket(b));
    // The megakernel runs no buckets; what comes was ordered before.
    if (b >= runs_.size() || !runs_[b].standInRan) continue;
    if (Status s = Drain(); !s) return s;
    if (status_.bucketItems.size() > b + kFirstMaterialBucket && status_.bucketItems[b + kFirstMaterialBucket] != 0) *restart = true;
    else runs_[b].standInRan = false;
  }
  if (*restart) lastRestart_ = now;
  return {};
}

bool PathTracer::StandInsInFilm() const {
  for (std::size_t b = 0; b < runs_.size(); ++b) {
    const std::size_t bucket = b + kFirstMaterialBucket;
    if (runs_[b].standInRan && kernels_->state(static_cast<uint32_t>(b)) == KernelRegistry::State::Compiling &&
        bucket < status_.bucketItems.size() && status_.bucketItems[bucket] != 0) return true;
  }
  return false;
}

// Tells the device which buckets hold their paths, and compiles what came (on lavapipe: takes it from the driver's cache).
void PathTracer::RecordHolds() {
  for (const vulkan::ComputePipeline* pipeline : fresh_) {
    stream_->BindPipeline(*pipeline);
    stream_->Dispatch(0, 1, 1);
  }
  fresh_.clear();
  bool changed = false;
  for (std::size_t b = 0; b < runs_.size(); ++b) {
    const uint32_t hold = runs_[b].held ? 1 : 0;
    if (holds_[b] == hold) continue;
    holds_[b] = static_cast<uint8_t>(hold);
    stream_->Update(*counters_, 4ull * (kBucketBase + (b + kFirstMaterialBucket) * kBucketStride + kBucketHold), std::as_bytes(std::span(&hold, 1)));
    changed = true;
  }
  for (std::size_t b = 0; b < runs_.size() && film_.of(Aov::MaterialCost) != kNoChannel; ++b) {
    const float cost = kernels_->NanosecondsPerPath(static_cast<uint32_t>(b));
    if (cost == costs_[b]) continue;
    costs_[b] = cost;
    stream_->Update(*counters_, 4ull * (kBucketBase + (b + kFirstMaterialBucket) * kBucketStride + kBucketCost), std::as_bytes(std::span(&cost, 1)));
    changed = true;
  }
  if (changed) stream_->Barrier();
}

// materialCost: the first paths meet kernels that nothing is known of, so the film starts anew, once, after some submits.
bool PathTracer::MeasureCosts() {
  if (film_.of(Aov::MaterialCost) == kNoChannel || costsMeasured_ || mode_ == ExecutionMode::Megakernel) return false;
  costsMeasured_ = status_.drained || (kernels_->pending() == 0 && costSubmits_ > kCostSubmits);
  return costsMeasured_;
}

Status PathTracer::Step(const DiagnosticSink& sink, Progress* progress) {
  *progress = Progress::Going;
  bool restart = MeasureCosts();
  if (Status s = AdoptKernels(sink, &restart); !s) return s;
  if (restart) {
    *progress = Progress::Restart;
    return Drain();
  }
  if (stalled_) {
    *progress = Progress::Waiting;
    return {};
  }
  InFlight& slot = inFlight_[nextSlot_];
  if (Status s = Collect(nextSlot_); !s) return s;
  if (status_.drained) {
    if (batchEnd_ >= settings_.firstSample + settings_.samples) {
      if (Status s = Drain(); !s) return s;
      if (MeasureCosts()) {
        *progress = Progress::Restart;
        return {};
      }
      // A picture with stand-ins in it is never done.
      stalled_ = StandInsInFilm();
      *progress = stalled_ ? Progress::Waiting : Progress::Done;
      return {};
    }
    if (Status s = Drain(); !s) return s;
    if (status_.drained) {
      batchEnd_ = std::min(batchEnd_ + settings_.samplesPerBatch, settings_.firstSample + settings_.samples);
      raiseBatch_ = true;
    }
  }
  if (Status s = ChooseKernels(); !s) return s;
  if (Status s = BeginRecording(); !s) return s;
  if (raiseBatch_) {
    stream_->Update(*counters_, 4 * kWorkEndSample, std::as_bytes(std::span(&batchEnd_, 1)));
    RecordWakeUp();
    stream_->Barrier();
    raiseBatch_ = false;
    iterationsPerSubmit_ = 1;  // as in BeginBand
    status_.drained = false;
  }
  const uint32_t nothing[4] = {};
  stream_->BindSet(*set_);
  stream_->PushConstants(std::as_bytes(std::span(nothing)));
  RecordHolds();
  slot.rows.clear();
  slot.kernelEpoch = kernelEpoch_;
  stream_->Timestamp();
  const uint32_t perIteration = kKernelCount + bucketCount_;
  const uint32_t fit = std::max(1u, kTimestamps / (perIteration + 1));
  slot.iterations = interactive_ ? 1 : std::min(iterationsPerSubmit_, fit);
  if (mode_ == ExecutionMode::Megakernel) megakernel_.Record(*stream_, *kernels_, *counters_, slot.iterations, &slot.rows);
  else for (uint32_t i = 0; i < slot.iterations; ++i) RecordIteration(&slot.rows);
  const uint64_t bytes = 4ull * (kBucketBase + static_cast<uint64_t>(kBucketStride) * bucketCount_);
  stream_->Copy(*counters_, 0, *readback_, nextSlot_ * bytes, bytes);
  auto value = stream_->Submit();
  if (!value) return value.error();
  slot.value = value.value();
  ++submits_;
  ++costSubmits_;
  const std::size_t submitted = nextSlot_;
  nextSlot_ = (nextSlot_ + 1) % kSlots;
  // Nothing is queued ahead of an edit: it waits for this iteration and for no other.
  return interactive_ ? Collect(submitted) : Status();
}

Status PathTracer::Collect(std::size_t index) {
  InFlight& slot = inFlight_[index];
  if (slot.value == 0) return {};
  auto waited = stream_->Wait(slot.value);
  if (!waited) return waited.error();
  timestamps_.resize(slot.rows.size() + 1);
  auto count = stream_->ReadTimestamps(slot.value, timestamps_);
  if (count.ok() && count.value() > 1) {
    for (uint32_t i = 1; i < count.value(); ++i) {
      const uint32_t row = slot.rows[i - 1];
      KernelTimes& times = row == Megakernel::kRow ? megakernel_.times() : kernels_->times()[row];
      const double passed = std::max(0.0, timestamps_[i] - timestamps_[i - 1]) * 1e-9;
      times.seconds += passed;
      times.measuredSeconds += passed;
      ++times.dispatches;
    }
    // Aim at a submit that is long enough to hide its cost and short enough to answer the host.
    const double seconds = (timestamps_[count.value() - 1] - timestamps_[0]) * 1e-9;
    const double each = std::max(1e-6, seconds / slot.iterations);
    const uint32_t most = std::min(kMaxIterationsPerSubmit, 2 * slot.iterations);
    iterationsPerSubmit_ = std::clamp(static_cast<uint32_t>(kTargetSubmitSeconds / each), 1u, most);
  }
  const uint64_t bytes = 4ull * (kBucketBase + static_cast<uint64_t>(kBucketStride) * bucketCount_);
  const std::span<std::byte> mapped = readback_->Map();
  statusWords_.resize(bytes / 4);
  std::memcpy(statusWords_.data(), mapped.data() + index * bytes, bytes);
  ReadStatus(statusWords_.data());
  // Where a whole submit with today's kernels moved nothing, all that is left is held. Counts that only grow: paths that
  // started, paths that ended, items. (One that can fall might hide another that rises.)
  uint64_t moved = status_.pathsStarted + (status_.pathsStarted - status_.active);
  for (uint64_t items : status_.queueItems) moved += items;
  for (uint64_t items : status_.bucketItems) moved += items;
  stalled_ = stalled_ || (kernels_->pending() != 0 && !status_.drained && slot.kernelEpoch == kernelEpoch_ &&
                          lastEpoch_ == kernelEpoch_ && moved == lastProgress_);
  lastProgress_ = moved;
  lastEpoch_ = slot.kernelEpoch;
  slot.value = 0;
  return {};
}

void PathTracer::ReadStatus(const uint32_t* c) {
  auto u64 = [&](uint32_t at) { return c[at] | static_cast<uint64_t>(c[at + 1]) << 32; };
  status_.errorFlags = before_.errorFlags | c[kErrorFlags];
  status_.active = c[kActivePaths];
  status_.pathsStarted = before_.pathsStarted + u64(kPathsDoneLo);
  status_.iterations = before_.iterations + c[kIterations];
  status_.drained = c[kActivePaths] == 0 && c[kWorkSample] >= c[kWorkEndSample] && c[kWorkEndSample] == batchEnd_ && c[kIterations] != 0;
  for (uint32_t q = 0; q < kQueueKinds; ++q) {
    status_.queueItems[q] = before_.queueItems[q] + u64(kQueueBase + q * kQueueStride + kQueueItemsLo);
    status_.queuePeak[q] = std::max(before_.queuePeak[q], c[kQueueBase + q * kQueueStride + kQueuePeak]);
  }
  status_.bucketItems.resize(bucketCount_);
  status_.bucketPeak.resize(bucketCount_);
  for (uint32_t b = 0; b < bucketCount_; ++b) {
    const uint64_t earlier = b < before_.bucketItems.size() ? before_.bucketItems[b] : 0;
    const uint64_t items = u64(kBucketBase + b * kBucketStride + kBucketItemsLo);
    status_.bucketItems[b] = earlier + items;
    if (b >= kFirstMaterialBucket) kernels_->times()[kKernelCount + b - kFirstMaterialBucket].measuredItems += items - bandItems_[b];
    bandItems_[b] = items;
    status_.bucketPeak[b] = std::max(b < before_.bucketPeak.size() ? before_.bucketPeak[b] : 0u, c[kBucketBase + b * kBucketStride + kBucketPeak]);
  }
}

Status PathTracer::Drain() {
  for (std::size_t i = 0; i < kSlots; ++i) {
    if (Status s = Collect((nextSlot_ + i) % kSlots); !s) return s;
  }
  return {};
}

Status PathTracer::ReadBand(RawFilm* film) {
  if (Status s = Drain(); !s) return s;
  const std::size_t pixels = static_cast<std::size_t>(settings_.width) * bandHeight();
  const std::size_t start = static_cast<std::size_t>(settings_.width) * bandY();
  if (Status s = filmSums_->Download(0, std::as_writable_bytes(std::span(film->sums).subspan(start * film_.sumChannels, pixels * film_.sumChannels))); !s) return s;
  if (film_.firstChannels == 0) return {};
  return filmFirst_->Download(0, std::as_writable_bytes(std::span(film->first).subspan(start * film_.firstChannels, pixels * film_.firstChannels)));
}

Status PathTracer::ResolveBand(Aov aov, std::vector<uint32_t>* bits) {
  const AovInfo& info = Aovs()[static_cast<uint32_t>(aov)];
  const uint32_t pixels = settings_.width * bandHeight();
  const uint32_t push[4] = {film_.of(aov), info.components, info.rule == AovRule::FirstSample ? 0u : aov == Aov::SampleCount ? 2u : 1u, 0};
  if (Status s = Drain(); !s) return s;
  if (Status s = BeginRecording(); !s) return s;
  stream_->BindSet(*set_);
  stream_->BindPipeline(kernels_->fixed(Kernel::Resolve));
  stream_->PushConstants(std::as_bytes(std::span(push)));
  stream_->Dispatch((pixels + 63) / 64);
  auto value = stream_->Submit();
  if (!value) return value.error();
  if (auto waited = stream_->Wait(value.value()); !waited) return waited.error();
  bits->resize(static_cast<std::size_t>(pixels) * info.components);
  return resolved_->Download(0, std::as_writable_bytes(std::span(*bits)));
}

}  // namespace wavefront
