// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The wavefront loop: the path pool, the queues and the film of one band of the image, and submits of K iterations.
// Nothing here waits inside the loop: the host reads one status block per submit, two submits behind.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <vector>

#include "wavefront/renderer.h"
#include "wavefront/scene/scene_commit.h"
#include "wavefront/scheduler/kernel_registry.h"
#include "wavefront/scheduler/megakernel.h"
#include "wavefront/shared/film_layout.h"
#include "wavefront/vulkan/command_stream.h"

namespace wavefront {

enum class Queue : uint32_t {
#define WAVEFRONT_QUEUE(Name, index, doc) Name = index,
#include "wavefront/shared/queues.def"
#undef WAVEFRONT_QUEUE
};
constexpr uint32_t kQueueKinds = 0
#define WAVEFRONT_QUEUE(Name, index, doc) +1
#include "wavefront/shared/queues.def"
#undef WAVEFRONT_QUEUE
    ;

struct LoopStatus {
  uint32_t errorFlags = 0;
  bool drained = false;           // nothing in flight and no work left for the current limit
  uint64_t pathsStarted = 0, active = 0;
  uint64_t iterations = 0;
  std::array<uint64_t, kQueueKinds> queueItems{};  // by row of queues.def
  std::array<uint32_t, kQueueKinds> queuePeak{};
  std::vector<uint64_t> bucketItems;  // new paths, then material buckets
  std::vector<uint32_t> bucketPeak;
};

// One thread at a time.
class PathTracer {
 public:
  static Result<std::unique_ptr<PathTracer>> Create(vulkan::Device& device);
  ~PathTracer();

  // Kernels that the scene's used buckets lack are compiled from now on. Nothing may run; before Configure, or by it.
  void OrderKernels(const SceneStore& scene, unsigned threads);
  KernelRegistry& kernels() { return *kernels_; }
  Megakernel& megakernel() { return megakernel_; }
  ExecutionMode executionMode() const { return mode_; }  // as the last Configure could have it
  uint32_t poolSize() const { return poolSize_; }
  uint32_t bandRows() const { return bandRows_; }    // rows of the image that one band holds
  uint32_t bandCount() const { return bandRows_ == 0 ? 0 : (settings_.height + bandRows_ - 1) / bandRows_; }
  const FilmLayout& film() const { return film_; }

  // Sizes pool and film for the settings, binds the scene, orders missing pipelines. Nothing may be in flight.
  Status Configure(const RenderSettings& settings, const CameraData& camera, SceneStore& scene, unsigned threads, const DiagnosticSink& sink);
  // Interactive: one iteration per submit and one submit in flight, so that an edit waits for little; what meets a
  // material whose kernel is still being compiled is shaded by a neutral one. Else as many iterations as hide the cost of
  // a submit, and such paths are held.
  void SetInteractive(bool interactive) { interactive_ = interactive; }
  // Clears the film and the pool, and starts at the first sample of the band.
  Status BeginBand(uint32_t band);
  enum class Progress : uint8_t {
    Going,
    Waiting,  // nothing can go on before a kernel comes: WaitForKernels, then Step again
    Restart,  // a kernel came for paths that a stand-in has shaded: the film starts anew, at the first band
    Done      // all samples of the band are in the film
  };
  // Takes kernels that have come, submits some iterations and reads the status of an older submit.
  Status Step(const DiagnosticSink& sink, Progress* progress);
  // Waits until nothing is in flight on the device (paths stay in the pool).
  Status Drain();
  // The band's sums into the film of the whole image; drains.
  Status ReadBand(RawFilm* film);
  // Resolved values of the band: rows x width x components words; drains.
  Status ResolveBand(Aov aov, std::vector<uint32_t>* bits);

  // Of all bands so far.
  const LoopStatus& status() const { return status_; }
  uint64_t submits() const { return submits_; }
  uint32_t bandY() const { return band_ * bandRows_; }
  uint32_t bandHeight() const;

 private:
  explicit PathTracer(vulkan::Device& device) : device_(device), megakernel_(device) {}
  Status ChooseMode(SceneStore& scene, const DiagnosticSink& sink);
  Status Allocate(std::unique_ptr<vulkan::Buffer>& buffer, uint64_t bytes, vulkan::MemoryKind kind, vulkan::MemoryLocation location, const char* name);
  Status WriteFrameConstants();
  Status BeginRecording();
  void RecordWakeUp();
  void RecordIteration(std::vector<uint32_t>* rows);
  Status Collect(std::size_t slot);
  void ReadStatus(const uint32_t* counters);
  Status AdoptKernels(const DiagnosticSink& sink, bool* restart);
  Status ChooseKernels();
  bool StandInsInFilm() const;
  bool MeasureCosts();
  void RecordHolds();

  struct InFlight {
    uint64_t value = 0;
    std::vector<uint32_t> rows;  // profiler row of each timestamp interval
    uint32_t iterations = 0;
    uint64_t kernelEpoch = 0;
  };
  // What a bucket's dispatch runs in this band.
  struct BucketRun {
    const vulkan::ComputePipeline* pipeline = nullptr;  // null: its paths are held, or it has none
    bool held = false, failed = false;
    bool standIn = false;   // of a kernel that is still to come
    bool standInRan = false;  // since the film was cleared
  };

  vulkan::Device& device_;
  std::unique_ptr<KernelRegistry> kernels_;
  Megakernel megakernel_;
  ExecutionMode mode_ = ExecutionMode::Wavefront;
  std::unique_ptr<vulkan::CommandStream> stream_;
  std::unique_ptr<vulkan::DescriptorSet> set_;
  std::unique_ptr<vulkan::Buffer> pathState_, queues_, counters_, filmSums_, filmFirst_, resolved_, frame_, readback_;
  RenderSettings settings_;
  CameraData camera_;
  SceneFacts facts_;
  FilmLayout film_;
  uint32_t poolSize_ = 0, bandRows_ = 0, band_ = 0, bucketCount_ = 0;
  uint32_t batchEnd_ = 0;
  bool raiseBatch_ = false, interactive_ = false;
  uint32_t iterationsPerSubmit_ = 1;
  std::vector<InFlight> inFlight_;
  std::size_t nextSlot_ = 0;
  LoopStatus status_, before_;       // before_: sums of earlier bands
  std::vector<BucketRun> runs_;      // by material bucket
  std::vector<uint8_t> holds_;       // as the device has them
  std::vector<float> costs_;         // likewise, nanoseconds a path; kept only where the AOV is asked for
  std::vector<uint64_t> bandItems_;  // by bucket, as the last status had them
  uint32_t costSubmits_ = 0;         // since the film was cleared
  bool costsMeasured_ = false;       // the film was cleared after they were
  std::vector<const vulkan::ComputePipeline*> fresh_;  // to be dispatched once with no work
  uint64_t kernelEpoch_ = 0;         // grows with what the device may run
  uint64_t lastProgress_ = 0, lastEpoch_ = 0;
  bool stalled_ = false;
  std::chrono::steady_clock::time_point lastRestart_{};
  uint64_t submits_ = 0;
  std::vector<double> timestamps_;
  std::vector<uint32_t> statusWords_;
};

}  // namespace wavefront
