// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The render delegate, Hydra-shaped and host-neutral: prims by type and path, typed Sync, CommitResources, a render
// that goes on in the background. Both hosts (plugin/python, plugin/hydra) stay thin above it.
//
// One frame: Create and Sync (any order, any thread) -> PendingTextures -> SetTexture for each -> CommitResources ->
// Start. Threads: Sync may be called from several threads at once for different prims; CommitResources,
// PendingTextures, Start, Pause, Resume, Stop belong to one thread at a time; Map, progress, IsConverged, stats,
// diagnostics to any. Sync keeps what it is given and compares: a value that did not change marks nothing dirty. All
// work (triangles, kernels, instance transforms) is done in CommitResources, in parallel, for dirty prims only.
// Errors: Status for the environment and for arguments that make no sense; scene content gives diagnostics.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "delegate/diagnostics.h"
#include "delegate/material_explanation.h"
#include "delegate/prims/camera.h"
#include "delegate/prims/gprim.h"
#include "delegate/prims/instancer.h"
#include "delegate/prims/light.h"
#include "delegate/prims/material.h"
#include "delegate/settings.h"
#include "delegate/textures.h"
#include "wavefront/renderer.h"

namespace delegate {

struct RenderDelegateOptions {
  std::string device;
  bool validation = false;
  uint64_t memoryBudget = 0;
  uint32_t threads = 0;              // host threads; 0: all
  std::string materialxLibraries;    // folder holding stdlib, pbrlib, bxdf
  bool captureOnly = false;          // no device: the scene is kept for WriteCapture and cannot be rendered
};

// Hydra's HdRenderPassState in one update.
struct RenderPassUpdate {
  std::optional<std::string> camera;                  // path
  std::optional<uint32_t> width, height;
  std::optional<double> pixelAspectRatio;
  std::optional<DataWindow> dataWindow;               // the part that is rendered; width and height are its pixels
  std::optional<ConformPolicy> windowPolicy;          // default Fit (UsdRender's expandAperture)
  std::optional<std::vector<std::string>> renderTags; // default: geometry and render;
                                                      // "" counts as "geometry"; none at all: every tag
  // Color is always there. By token: wavefront::SelectAovs, whose two lists go here, and RenderDelegate::FindAov.
  std::optional<std::vector<wavefront::Aov>> aovs;
  std::optional<std::vector<std::string>> primvarAovs;  // names by slot, of the Primvar slots in `aovs`
};

// What was done so far; tests prove with it that an edit does no needless work.
struct DelegateCounters {
  uint64_t meshesBuilt = 0, meshesUploaded = 0, instancesUploaded = 0, lightsUploaded = 0, camerasUploaded = 0,
           materialsGenerated = 0, materialsUploaded = 0, kernelsCompiled = 0, imagesDecoded = 0, texturesUploaded = 0,
           commits = 0;
};

class SceneRecorder;

class RenderDelegate {
 public:
  static wavefront::Result<std::unique_ptr<RenderDelegate>> Create(const RenderDelegateOptions& options);
  // For tests and for hosts that bring their own. `log` collects what all three report.
  RenderDelegate(std::unique_ptr<wavefront::Renderer> renderer, std::unique_ptr<materialgen::Generator> generator,
                 std::shared_ptr<DiagnosticLog> log, uint32_t threads = 0);
  ~RenderDelegate();
  RenderDelegate(const RenderDelegate&) = delete;
  RenderDelegate& operator=(const RenderDelegate&) = delete;

  // --- Prims. A type that is not supported gives an error. The first Sync of a path creates the prim as well. Syncing
  // the other kind of Rprim to a path makes it that kind.
  static const std::vector<std::string>& SupportedRprimTypes();
  static const std::vector<std::string>& SupportedSprimTypes();
  wavefront::Status CreateRprim(const std::string& type, const std::string& path);
  wavefront::Status CreateSprim(const std::string& type, const std::string& path);
  void CreateInstancer(const std::string& path);
  // True: there is something to commit. False: nothing of it differs from what was committed.
  bool Sync(const std::string& path, MeshUpdate update);
  bool Sync(const std::string& path, ImplicitUpdate update);
  bool Sync(const std::string& path, InstancerUpdate update);
  bool Sync(const std::string& path, LightUpdate update);
  bool Sync(const std::string& path, CameraUpdate update);
  bool Sync(const std::string& path, MaterialUpdate update);
  void DestroyRprim(const std::string& path);       // unknown paths are nothing to do
  void DestroySprim(const std::string& path);       // light, camera and material of that path
  void DestroyInstancer(const std::string& path);

  // --- Textures (textures.h says what is decoded, and when). PendingTextures generates dirty materials first, and asks
  // again for what was read coarser than the setting textureMemory now asks for. SetUnconvertedColorSpaces: before it.
  void SetUnconvertedColorSpaces(const std::vector<std::string>& names);
  std::vector<TextureLoadRequest> PendingTextures();
  void CountDecodedImage();  // by the host, for each file that it decodes, whatever comes of it; any thread
  wavefront::Status SetTexture(uint32_t key, wavefront::TextureData data);
  wavefront::Status SetTextureTiles(uint32_t key, std::vector<std::pair<uint32_t, wavefront::TextureData>> tiles);
  wavefront::Status SetTextureMissing(uint32_t key, const std::string& reason);

  // --- Settings and what is rendered.
  wavefront::Status SetRenderPass(const RenderPassUpdate& update);
  wavefront::Result<bool> SetRenderSetting(const std::string& token, const SettingValue& value);  // true: changed
  wavefront::Result<SettingValue> GetRenderSetting(const std::string& token) const;
  uint32_t GetRenderSettingsVersion() const;         // grows on changed values only

  // Writes what was committed to a file that wavefront-bench replays (capture/scene_file.h). An error where the delegate was
  // not made with captureOnly, where a kernel does not compile, or where the file cannot be written. Textures of a longer
  // side than `maxTextureSide` (0: any) are halved; the number of them is returned.
  wavefront::Result<size_t> WriteCapture(const std::string& path, const std::string& name, const std::string& version,
                                         uint32_t maxTextureSide = 0) const;

  // --- Render.
  wavefront::Status CommitResources();
  uint64_t version() const { return renderer_->version(); }  // grows when the image restarts
  wavefront::Status Start() { return renderer_->Start(); }
  void Pause() { renderer_->Pause(); }
  void Resume() { renderer_->Resume(); }
  void Stop() { renderer_->Stop(); }
  bool WaitUntilDone(double seconds) { return renderer_->WaitUntilDone(seconds); }
  wavefront::Status status() const { return renderer_->status(); }
  bool IsConverged() const { return renderer_->IsConverged(); }
  wavefront::Progress progress() const { return renderer_->progress(); }
  // Of a token, "primvars:<name>" included, in the render pass as it is set; nothing: unknown, or not asked for by name.
  std::optional<wavefront::Aov> FindAov(const std::string& token) const;
  wavefront::Result<wavefront::AovImage> Map(wavefront::Aov aov) { return renderer_->Map(aov); }
  // Several of one moment, for one wait.
  wavefront::Result<std::vector<wavefront::AovImage>> Map(std::span<const wavefront::Aov> aovs) {
    return renderer_->Map(aovs);
  }
  wavefront::Result<wavefront::RawFilm> ReadFilm() { return renderer_->ReadFilm(); }
  wavefront::RenderStats stats() const { return renderer_->stats(); }
  DelegateCounters counters() const;
  CameraMatrices cameraMatrices() const;              // of the committed camera
  std::vector<wavefront::Diagnostic> diagnostics(size_t since = 0) const { return log_->Read(since); }
  wavefront::Renderer& renderer() { return *renderer_; }

  // Each kernel of the last commit: what it is made of, the materials on it, what compiling it cost, and what it costs in
  // the render so far; any thread.
  struct KernelUse {
    std::string key;
    std::vector<std::string> lobes, primvars, materials;
    double generateMilliseconds = 0;
    // Sums over its entry points. State: the surface's (KernelStats).
    std::string state = "unused";
    double codeMilliseconds = 0, createMilliseconds = 0, firstDispatchMilliseconds = 0;
    bool codeFromCache = false;
    uint64_t spirvBytes = 0, spirvInstructions = 0;
    std::vector<std::string> driverStatistics;
    double milliseconds = 0;         // on the device
    uint64_t paths = 0;              // work items
    double nanosecondsPerPath = 0;   // 0: no path yet
    double share = 0;                // of the time of all kernels
  };
  std::vector<KernelUse> kernelUses() const;
  // GLSL of a material's kernel entries, for inspection; empty: unknown path or not generated yet. Not while
  // committing.
  std::optional<MaterialExplanation> ExplainMaterial(const std::string& path) const;
  std::vector<std::pair<std::string, std::string>> MaterialSource(const std::string& path) const;

 private:
  struct Impl;
  std::shared_ptr<DiagnosticLog> log_;
  std::unique_ptr<wavefront::Renderer> renderer_;
  SceneRecorder* recorder_ = nullptr;  // the renderer, where it is one
  std::unique_ptr<Impl> impl_;
};

}  // namespace delegate
