// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The facade: a scene that is edited, and a film that is rendered in the background.
//
// Threads: scene edits (Set*, Create*, Destroy*) may come from several threads at once and are only staged; Commit,
// Start, Pause, Resume and Stop belong to one controlling thread; Map, progress, IsConverged and stats may be called from
// any thread at any time. Commit stops a running render (the one edit gate); Start goes on where it may.
// Errors: environment and input give Result/Status; scene content gives Diagnostics through the sink, and renders on.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "wavefront/base/diagnostics.h"
#include "wavefront/base/result.h"
#include "wavefront/film.h"
#include "wavefront/scene.h"

namespace wavefront {

struct DeviceDescription {
  std::string name, driver, type;  // type: "discrete GPU", "CPU", ...
  std::string apiVersion;
  uint64_t heapBytes = 0;
  uint32_t subgroupSize = 0;
  bool usable = false;
  std::string whyNot;                                        // what is missing, where not usable
  std::vector<std::pair<std::string, std::string>> details;  // limits and features used, for `doctor`
};
std::vector<DeviceDescription> ListDevices();

// What copying memory on the device reaches: bytes read and written, the best of several tries, in seconds of a device
// that does nothing else. `device` as in RendererOptions.
struct DeviceBandwidth {
  std::string name, driver, type;  // of the device that was chosen
  double bytesPerSecond = 0;
};
Result<DeviceBandwidth> MeasureCopyBandwidth(const std::string& device);

// What is alive in this process; all zero where no Renderer is. Any thread.
struct LiveObjects {
  int64_t renderers = 0;
  int64_t deviceBytes = 0;
  std::map<std::string, int64_t> handles;  // Vulkan handles by kind
  int64_t handleCount() const;
};
LiveObjects CountLiveObjects();

struct RendererOptions {
  std::string device;          // index or part of the name; empty: HDWAVEFRONT_DEVICE, else the best one
  bool validation = false;     // also HDWAVEFRONT_VALIDATION=1
  uint64_t memoryBudget = 0;   // bytes; 0: what the device offers
  uint32_t threads = 0;        // host threads for BVH builds and for compiling kernels; 0: all
  std::string cacheFolder;     // where drivers' pipeline caches are kept; empty: nowhere
  DiagnosticSink diagnostics;  // may be called from any thread
};

// How the paths get through the kernels; the image is the same to the bit.
enum class ExecutionMode : uint8_t {
  Wavefront,   // queues and a kernel per operation and material (Laine et al. 2013)
  Megakernel,  // everything in one kernel with path regeneration; scenes that cannot have one render as Wavefront
};
// SPIR-V of the megakernel of these kernels (keys of RegisterKernel): materialgen::LinkMegakernel says which
// specialization constants it has. Called by Commit.
using MegakernelLinker = std::function<Result<std::vector<uint32_t>>(std::span<const std::string> kernelKeys)>;

// What one render is made of. The image is a pure function of (scene, camera, these but executionMode, poolSize,
// samplesPerBatch, bandRows, interactive).
struct RenderSettings {
  uint32_t width = 0, height = 0;
  uint32_t firstSample = 0, samples = 64;  // the range [firstSample, firstSample + samples)
  uint32_t maxBounces = 8;                 // scattering events after the camera ray's hit
  uint32_t rouletteBounce = 3;             // Russian roulette from this bounce on
  uint32_t maxTransparency = 64;           // surfaces passed through per ray by opacity
  uint32_t seed = 0;
  ExecutionMode executionMode = ExecutionMode::Wavefront;
  uint32_t poolSize = 0;                   // paths; 0: what suits the device
  uint32_t samplesPerBatch = 0;            // samples in flight together; 0: what suits the pool
  uint32_t bandRows = 0;                   // rows of the image held on the device at a time; 0: as many as fit
  float frame = 1, time = 0;               // frame number and seconds, for the nodes of materials that ask
  uint64_t textureMemory = 0;              // bytes that texels may take; 0: what the device offers
  float radianceClamp = 0;                 // 0: only the film's stated limit
  bool cameraVisibleDome = true;           // dome lights seen by camera rays
  bool shadows = true;
  LightSampling lightSampling = LightSampling::Auto;
  // An edit is answered at once: short submits, and trees of edited meshes that are quick to make. Restarts nothing, unless
  // it ends and such a tree is built for good.
  bool interactive = false;
  std::vector<Aov> aovs;                   // Color is always there
  std::vector<std::string> primvarAovs;    // primvars by slot: what Aov::Primvar0 ... show where `aovs` holds them
};

struct Progress {
  uint64_t pathsDone = 0, pathsTotal = 0;
  uint32_t samplesDone = 0;                // whole samples of every pixel
  double seconds = 0;                      // in Start..now without pauses
  bool running = false, paused = false, converged = false;
};

// A fixed kernel, one entry point of a material's ("material:<key>:surface"), or a displacement ("displacement:<key>": on
// the host's clock, in the commit; items are corners of triangles).
struct KernelStats {
  std::string name;
  double milliseconds = 0;  // on the device
  uint64_t items = 0, dispatches = 0;
  std::string state = "ready";  // or compiling, failed, unused (no instance wears it: nothing was compiled)
  double codeMilliseconds = 0;  // GLSL to SPIR-V, or reading it from the cache; 0 for fixed kernels
  bool codeFromCache = false;
  double createMilliseconds = 0, firstDispatchMilliseconds = 0;  // the driver's part
  uint64_t spirvBytes = 0, spirvInstructions = 0;
  uint32_t stateBytesRead = 0, stateBytesWritten = 0;  // of path state, by an item, at most (scheduler/state_traffic.h)
  std::vector<std::string> driverStatistics;  // "name: value", with HDWAVEFRONT_DRIVER_STATISTICS=1 where the driver has them
  uint64_t peak = 0;     // most items in one iteration; 0 where it is not counted (the megakernel, what runs once an iteration)
  double occupancy = 0;  // items in an iteration on average, as a share of the pool's paths: 1 is every path every time
};
// Paths that stood in line for a kernel; times are of the kernel that empties it.
struct QueueStats {
  std::string name;
  uint64_t items = 0, peak = 0;
  double occupancy = 0, milliseconds = 0;  // as in KernelStats
};
// What commits did to bounding volume hierarchies, since the renderer was made (scene/bvh/mesh_trees.h has the rule): those of
// meshes, and those over all instances.
struct TreeStats { uint64_t built = 0, builtFast = 0, refitted = 0, instancesBuilt = 0, instancesRefitted = 0; };
struct RenderStats {
  std::vector<KernelStats> kernels;
  std::vector<QueueStats> queues;
  uint64_t paths = 0, segments = 0, extensionRays = 0, shadowRays = 0, iterations = 0, submits = 0;
  double renderSeconds = 0, commitSeconds = 0, bvhSeconds = 0;
  std::map<std::string, uint64_t> memoryBytes, memoryPeakBytes;  // by kind
  uint64_t triangles = 0, instances = 0, lights = 0, lightItems = 0, materials = 0, textures = 0;
  TreeStats trees;
  uint64_t uploadedBytes = 0;              // to the device, since it was made
  uint64_t validationMessages = 0;
  uint32_t errorFlags = 0;                 // shared/error_flags.h; 0: none
  uint32_t poolSize = 0;
  uint32_t kernelsPending = 0;             // entry points of material kernels that are still being compiled
  // Since the film was cleared by a commit; 0: not yet. The first finished path, and all kernels that were ordered.
  double firstPathSeconds = 0, kernelsReadySeconds = 0;
  ExecutionMode executionMode = ExecutionMode::Wavefront;  // as it renders
};

// Exact sums of a sample range; merging is associative and exact, so ranges, machines and restarts agree to the bit.
struct RawFilm {
  uint32_t width = 0, height = 0, firstSample = 0, samples = 0;
  bool complete = true;          // every pixel holds every sample of the range
  std::vector<Aov> aovs;         // what is held besides colour and sample count
  std::vector<std::string> primvarAovs;  // by slot
  std::vector<int64_t> sums;     // fixed point, by pixel then by channel (see shared/film_layout.h)
  std::vector<uint32_t> first;   // FirstSample AOVs, by pixel then channel
};
Result<RawFilm> MergeFilms(const RawFilm& a, const RawFilm& b);
AovImage ResolveFilm(const RawFilm& film, Aov aov);

using InstanceGroupId = uint32_t;

class Renderer {
 public:
  static Result<std::unique_ptr<Renderer>> Create(const RendererOptions& options);
  virtual ~Renderer() = default;  // stops, waits, frees

  // --- Scene. Ids are never reused within a renderer. Setting an unknown id is a bug.
  virtual MeshId CreateMesh(MeshData mesh) = 0;
  virtual void SetMesh(MeshId id, MeshData mesh) = 0;
  virtual void DestroyMesh(MeshId id) = 0;
  virtual InstanceGroupId CreateInstances(InstanceData instances) = 0;
  virtual void SetInstances(InstanceGroupId id, InstanceData instances) = 0;
  virtual void DestroyInstances(InstanceGroupId id) = 0;
  virtual LightId CreateLight(LightData light) = 0;
  virtual void SetLight(LightId id, LightData light) = 0;
  virtual void DestroyLight(LightId id) = 0;
  virtual TextureId CreateTexture(TextureData texture) = 0;
  virtual void DestroyTexture(TextureId id) = 0;
  // A set of tiles, read by materials that ask for one. Destroying it leaves the tiles, which must outlive it.
  virtual TextureId CreateTextureTiles(std::vector<TextureTile> tiles) = 0;
  // Of what the last commit left on the device: textures that were read coarser to fit, and would be finer with this
  // much memory (RenderSettings::textureMemory) if they were created anew. Any thread.
  virtual std::vector<TextureId> CoarseTextures(uint64_t textureMemory) = 0;
  virtual void RegisterKernel(MaterialKernelData kernel) = 0;  // no-op where the key is known
  virtual bool HasKernel(const std::string& key) const = 0;
  virtual void SetMegakernelLinker(MegakernelLinker linker) = 0;  // none: no megakernel
  virtual MaterialId CreateMaterial(MaterialData material) = 0;
  virtual void SetMaterial(MaterialId id, MaterialData material) = 0;
  virtual void DestroyMaterial(MaterialId id) = 0;
  virtual void SetDefaultMaterial(MaterialId id) = 0;          // for kInvalidId bindings
  virtual void SetCamera(const CameraData& camera) = 0;
  virtual void SetRenderSettings(const RenderSettings& settings) = 0;

  // Makes staged edits real. Resets the film only if something that the image depends on changed; version() counts that.
  virtual Status Commit() = 0;
  virtual uint64_t version() const = 0;

  // --- Rendering, in a thread of the renderer's own.
  virtual Status Start() = 0;
  virtual void Pause() = 0;    // returns at once; samples are kept
  virtual void Resume() = 0;
  virtual void Stop() = 0;     // returns when the device is idle; samples are kept
  virtual bool WaitUntilDone(double timeoutSeconds) = 0;  // true: converged, stopped or failed
  virtual Status status() const = 0;                      // the render thread's error, if any
  virtual Progress progress() const = 0;
  virtual bool IsConverged() const = 0;
  virtual Result<AovImage> Map(Aov aov) = 0;              // what is there now, also while rendering
  // Several of one moment, in the order asked, for one wait.
  virtual Result<std::vector<AovImage>> Map(std::span<const Aov> aovs) = 0;
  virtual Result<RawFilm> ReadFilm() = 0;
  virtual RenderStats stats() const = 0;

  // --- Colour: runs a compute kernel over RGBA float pixels in place. `spirv` is made from the colour library's own
  // GPU shader by the delegate; see delegate/colour.
  struct ColorLut { std::string sampler; uint32_t dimension = 1, width = 0, height = 1, depth = 1, components = 3;
                    bool linear = true; std::vector<float> values; uint32_t binding = 0; };
  virtual Status RunColorKernel(std::span<const uint32_t> spirv, const std::vector<ColorLut>& luts,
                                std::span<float> rgba, uint32_t width, uint32_t height) = 0;
};

}  // namespace wavefront
