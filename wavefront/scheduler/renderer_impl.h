// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The facade's implementation: stores, one path tracer, one render thread.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "wavefront/base/fair_mutex.h"
#include "wavefront/renderer.h"
#include "wavefront/scene/scene_commit.h"
#include "wavefront/scheduler/color_kernel.h"
#include "wavefront/scheduler/displacer.h"
#include "wavefront/scheduler/path_tracer.h"

namespace wavefront {

class RendererImpl final : public Renderer {
 public:
  static Result<std::unique_ptr<Renderer>> Make(const RendererOptions& options);
  ~RendererImpl() override;

  MeshId CreateMesh(MeshData mesh) override { return scene_->geometry.Create(std::move(mesh)); }
  void SetMesh(MeshId id, MeshData mesh) override { scene_->geometry.Set(id, std::move(mesh)); }
  void DestroyMesh(MeshId id) override { scene_->geometry.Destroy(id); }
  InstanceGroupId CreateInstances(InstanceData data) override { return scene_->CreateInstances(std::move(data)); }
  void SetInstances(InstanceGroupId id, InstanceData data) override { scene_->SetInstances(id, std::move(data)); }
  void DestroyInstances(InstanceGroupId id) override { scene_->DestroyInstances(id); }
  LightId CreateLight(LightData light) override { return scene_->CreateLight(std::move(light)); }
  void SetLight(LightId id, LightData light) override { scene_->SetLight(id, std::move(light)); }
  void DestroyLight(LightId id) override { scene_->DestroyLight(id); }
  TextureId CreateTexture(TextureData texture) override { return scene_->textures.Create(std::move(texture)); }
  void DestroyTexture(TextureId id) override { scene_->textures.Destroy(id); }
  TextureId CreateTextureTiles(std::vector<TextureTile> tiles) override {
    return scene_->textures.CreateTiles(std::move(tiles));
  }
  std::vector<TextureId> CoarseTextures(uint64_t textureMemory) override {
    return scene_->textures.Coarse(textureMemory);
  }
  void RegisterKernel(MaterialKernelData kernel) override { scene_->materials.RegisterKernel(std::move(kernel)); }
  bool HasKernel(const std::string& key) const override { return scene_->materials.HasKernel(key); }
  void SetMegakernelLinker(MegakernelLinker linker) override { tracer_->megakernel().SetLinker(std::move(linker)); }
  MaterialId CreateMaterial(MaterialData material) override { return scene_->materials.Create(std::move(material)); }
  void SetMaterial(MaterialId id, MaterialData material) override { scene_->materials.Set(id, std::move(material)); }
  void DestroyMaterial(MaterialId id) override { scene_->materials.Destroy(id); }
  void SetDefaultMaterial(MaterialId id) override { scene_->materials.SetDefault(id); }
  void SetCamera(const CameraData& camera) override;
  void SetRenderSettings(const RenderSettings& settings) override;

  Status Commit() override;
  uint64_t version() const override { return version_; }

  Status Start() override;
  void Pause() override;
  void Resume() override;
  void Stop() override;
  bool WaitUntilDone(double timeoutSeconds) override;
  Status status() const override;
  Progress progress() const override;
  bool IsConverged() const override;
  Result<AovImage> Map(Aov aov) override;
  Result<std::vector<AovImage>> Map(std::span<const Aov> aovs) override;
  Result<RawFilm> ReadFilm() override;
  RenderStats stats() const override;
  Status RunColorKernel(std::span<const uint32_t> spirv, const std::vector<ColorLut>& luts, std::span<float> rgba, uint32_t width, uint32_t height) override;

 private:
  using Clock = std::chrono::steady_clock;
  explicit RendererImpl(const RendererOptions& options);
  void Run();
  Status RenderUntilStopped();
  void RestartFilm();  // device mutex held
  void Publish();
  void ReportErrorFlags();
  Result<AovImage> MapLocked(Aov aov);  // with the device mutex held
  double SecondsLocked() const;

  RendererOptions options_;
  std::string pipelineCacheFile_;  // empty: the driver needs none, or there is no folder for it
  std::unique_ptr<vulkan::Device> device_;
  std::unique_ptr<SceneStore> scene_;
  std::unique_ptr<PathTracer> tracer_;
  std::unique_ptr<Displacer> displacer_;
  ColorKernel colorKernel_;         // the device mutex guards it

  std::mutex stagingMutex_;
  RenderSettings stagedSettings_;
  CameraData stagedCamera_;
  bool settingsDirty_ = true, cameraDirty_ = true;

  // Guards the tracer: held by the render thread for each step, by a mapping thread between steps.
  FairMutex deviceMutex_;
  RenderSettings settings_;
  CameraData camera_;
  RawFilm film_;                    // finished bands
  uint32_t band_ = 0;
  bool bandBegun_ = false, configured_ = false;
  std::atomic<uint64_t> version_{0};  // the render thread raises it where kernels come for what stand-ins have shaded
  double commitSeconds_ = 0;
  Clock::time_point committed_;     // when the commit began that cleared the film
  double firstPathSeconds_ = 0, kernelsReadySeconds_ = 0;
  uint32_t reportedFlags_ = 0;

  mutable std::mutex stateMutex_;
  std::condition_variable stateChanged_;
  std::thread thread_;
  bool running_ = false, paused_ = false, stopRequested_ = false, converged_ = false;
  Status error_;
  Progress progress_;
  RenderStats stats_;
  double secondsBefore_ = 0;
  Clock::time_point runStart_;
};

}  // namespace wavefront
