// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A renderer that renders nothing and keeps what it is told, for a delegate whose scene is to be captured. Needs no device.
#pragma once

#include <atomic>
#include <mutex>

#include "delegate/capture/captured_scene.h"

namespace delegate {

class SceneRecorder final : public wavefront::Renderer {
 public:
  // What is alive now, but materials, kernels and meshes that no instance wears; kernels without code. By the committing
  // thread.
  CapturedScene Scene() const;
  // SPIR-V of an entry of a kernel that was registered, as a render would get it.
  wavefront::KernelCode Compile(const std::string& key, wavefront::KernelEntry entry) const;

  wavefront::MeshId CreateMesh(wavefront::MeshData mesh) override { return Add(scene_.meshes, std::move(mesh)); }
  void SetMesh(wavefront::MeshId id, wavefront::MeshData mesh) override { Set(scene_.meshes, id, std::move(mesh)); }
  void DestroyMesh(wavefront::MeshId id) override { Remove(scene_.meshes, id); }
  wavefront::InstanceGroupId CreateInstances(wavefront::InstanceData data) override { return Add(scene_.instances, std::move(data)); }
  void SetInstances(wavefront::InstanceGroupId id, wavefront::InstanceData data) override { Set(scene_.instances, id, std::move(data)); }
  void DestroyInstances(wavefront::InstanceGroupId id) override { Remove(scene_.instances, id); }
  wavefront::LightId CreateLight(wavefront::LightData light) override { return Add(scene_.lights, std::move(light)); }
  void SetLight(wavefront::LightId id, wavefront::LightData light) override { Set(scene_.lights, id, std::move(light)); }
  void DestroyLight(wavefront::LightId id) override { Remove(scene_.lights, id); }
  wavefront::TextureId CreateTexture(wavefront::TextureData texture) override;
  void DestroyTexture(wavefront::TextureId id) override;
  wavefront::TextureId CreateTextureTiles(std::vector<wavefront::TextureTile> tiles) override;
  std::vector<wavefront::TextureId> CoarseTextures(uint64_t) override { return {}; }  // it keeps all as they come
  void RegisterKernel(wavefront::MaterialKernelData kernel) override;
  bool HasKernel(const std::string& key) const override;
  void SetMegakernelLinker(wavefront::MegakernelLinker) override {}  // a replay links its own
  wavefront::MaterialId CreateMaterial(wavefront::MaterialData material) override { return Add(scene_.materials, std::move(material)); }
  void SetMaterial(wavefront::MaterialId id, wavefront::MaterialData material) override { Set(scene_.materials, id, std::move(material)); }
  void DestroyMaterial(wavefront::MaterialId id) override { Remove(scene_.materials, id); }
  void SetDefaultMaterial(wavefront::MaterialId id) override;
  void SetCamera(const wavefront::CameraData& camera) override;
  void SetRenderSettings(const wavefront::RenderSettings& settings) override;

  wavefront::Status Commit() override;
  uint64_t version() const override { return version_; }

  wavefront::Status Start() override { return Nothing(); }
  void Pause() override {}
  void Resume() override {}
  void Stop() override {}
  bool WaitUntilDone(double) override { return true; }
  wavefront::Status status() const override { return {}; }
  wavefront::Progress progress() const override { return {}; }
  bool IsConverged() const override { return false; }
  wavefront::Result<wavefront::AovImage> Map(wavefront::Aov) override { return Nothing(); }
  wavefront::Result<std::vector<wavefront::AovImage>> Map(std::span<const wavefront::Aov>) override { return Nothing(); }
  wavefront::Result<wavefront::RawFilm> ReadFilm() override { return Nothing(); }
  wavefront::RenderStats stats() const override { return {}; }
  wavefront::Status RunColorKernel(std::span<const uint32_t>, const std::vector<ColorLut>&, std::span<float>, uint32_t,
                                   uint32_t) override {
    return Nothing();
  }

 private:
  static wavefront::Error Nothing() { return {"A scene that is captured is not rendered."}; }
  template <typename T>
  uint32_t Add(std::map<uint32_t, T>& all, T value) {
    std::lock_guard lock(mutex_);
    all.emplace(next_, std::move(value));
    return next_++;
  }
  template <typename T>
  void Set(std::map<uint32_t, T>& all, uint32_t id, T value) {
    std::lock_guard lock(mutex_);
    all.at(id) = std::move(value);
  }
  template <typename T>
  void Remove(std::map<uint32_t, T>& all, uint32_t id) {
    std::lock_guard lock(mutex_);
    all.erase(id);
  }

  mutable std::mutex mutex_;
  CapturedScene scene_;  // without kernels
  std::map<std::string, wavefront::MaterialKernelData> kernels_;
  uint32_t next_ = 0;
  wavefront::TextureId nextTexture_ = 0;  // as the core counts: see SendScene
  std::atomic<uint64_t> version_{0};
};

}  // namespace delegate
