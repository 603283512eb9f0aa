// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/capture/scene_recorder.h"

#include <set>

namespace delegate {

using namespace wavefront;

TextureId SceneRecorder::CreateTexture(TextureData texture) {
  std::lock_guard lock(mutex_);
  scene_.textures.emplace(nextTexture_, std::move(texture));
  return nextTexture_++;
}

TextureId SceneRecorder::CreateTextureTiles(std::vector<TextureTile> tiles) {
  std::lock_guard lock(mutex_);
  scene_.tiles.emplace(nextTexture_, std::move(tiles));
  return nextTexture_++;
}

void SceneRecorder::DestroyTexture(TextureId id) {
  std::lock_guard lock(mutex_);
  scene_.textures.erase(id);
  scene_.tiles.erase(id);
}

void SceneRecorder::RegisterKernel(MaterialKernelData kernel) {
  std::lock_guard lock(mutex_);
  kernels_.try_emplace(kernel.key, std::move(kernel));
}

bool SceneRecorder::HasKernel(const std::string& key) const {
  std::lock_guard lock(mutex_);
  return kernels_.count(key) != 0;
}

void SceneRecorder::SetDefaultMaterial(MaterialId id) {
  std::lock_guard lock(mutex_);
  scene_.defaultMaterial = id;
}

void SceneRecorder::SetCamera(const CameraData& camera) {
  std::lock_guard lock(mutex_);
  scene_.camera = camera;
}

void SceneRecorder::SetRenderSettings(const RenderSettings& settings) {
  std::lock_guard lock(mutex_);
  scene_.settings = settings;
}

Status SceneRecorder::Commit() {
  ++version_;
  return {};
}

CapturedScene SceneRecorder::Scene() const {
  std::lock_guard lock(mutex_);
  CapturedScene scene = scene_;
  std::set<MeshId> meshes;
  std::set<MaterialId> materials{scene.defaultMaterial};
  for (const auto& [id, data] : scene.instances) {
    meshes.insert(data.mesh);
    materials.insert(data.materials.begin(), data.materials.end());
  }
  std::erase_if(scene.meshes, [&](const auto& mesh) { return meshes.count(mesh.first) == 0; });
  std::erase_if(scene.materials, [&](const auto& material) { return materials.count(material.first) == 0; });
  std::set<std::string> keys;
  for (const auto& [id, material] : scene.materials) keys.insert(material.kernelKey);
  for (const std::string& key : keys) {
    CapturedKernel kernel;
    kernel.key = key;
    kernel.primvars = kernels_.at(key).primvars;
    scene.kernels.push_back(std::move(kernel));
  }
  return scene;
}

KernelCode SceneRecorder::Compile(const std::string& key, KernelEntry entry) const {
  std::function<KernelCode(KernelEntry)> compile;
  {
    std::lock_guard lock(mutex_);
    compile = kernels_.at(key).compile;
  }
  return compile(entry);
}

}  // namespace delegate
