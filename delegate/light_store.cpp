// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/light_store.h"

#include "delegate/prims/same.h"
#include "delegate/texture_tiles.h"

namespace delegate {

LightStore::LightStore(wavefront::Renderer& renderer, InstancerStore& instancers, TextureTable& textures,
                       wavefront::DiagnosticSink sink, unsigned threads)
    : renderer_(renderer), instancers_(instancers), textures_(textures), sink_(std::move(sink)), threads_(threads) {}

LightStore::Light& LightStore::FindOrCreate(const std::string& path) {
  std::lock_guard lock(mutex_);
  auto& light = lights_[path];
  if (!light) {
    light = std::make_unique<Light>();
    light->path = path;
  }
  return *light;
}

void LightStore::Create(const std::string& path, const std::string& type) { FindOrCreate(path).params.type = type; }

bool LightStore::Sync(const std::string& path, LightUpdate update) {
  Light& light = FindOrCreate(path);
  if (update.params && !Same(light.params.texture, update.params->texture)) light.textureDirty = true;
  bool changed = Take(light.params, update.params);
  if (update.transforms && update.transforms->empty()) update.transforms.reset();
  changed |= Take(light.transforms, update.transforms);
  changed |= Take(light.visible, update.visible);
  changed |= Take(light.instancer, update.instancer);
  changed |= Take(light.prototype, update.prototype);
  if (changed) light.dirty = true;
  return light.dirty || light.textureDirty;
}

void LightStore::Destroy(const std::string& path) {
  std::lock_guard lock(mutex_);
  const auto found = lights_.find(path);
  if (found == lights_.end()) return;
  removed_.push_back(std::move(found->second));
  lights_.erase(found);
}

void LightStore::AcquireTextures() {
  for (auto& [path, light] : lights_) {
    if (!light->textureDirty) continue;
    light->textureDirty = false;
    const uint32_t old = light->textureKey;
    const materialgen::AssetValue& file = light->params.texture;
    light->textureKey = 0;
    if (IsTilePattern(file.resolvedPath)) {
      sink_({wavefront::Severity::Warning, "texture-missing", path,
             "The texture \"" + file.resolvedPath +
                 "\" cannot be used: lights read no tiles. The light shines without it."});
    } else if (!file.authoredPath.empty() || !file.resolvedPath.empty()) {
      TextureKey key;
      key.resolvedPath = file.resolvedPath;
      if (file.resolvedPath.empty()) key.authoredPath = file.authoredPath;
      key.colorSpace = file.colorSpace;
      light->textureKey = textures_.Acquire(key, file.authoredPath, path);
    }
    if (old) textures_.Release(old);
  }
}

std::vector<wavefront::LightData> LightStore::Convert(const Light& light) const {
  std::vector<wavefront::LightData> result;
  const auto add = [&](const std::string& path, const TimeSamples<wavefront::Matrix4d>& transforms) {
    auto data = ConvertLight(light.path, light.params, transforms, sink_);
    if (!data) return;
    data->path = path;
    if (light.textureKey) data->texture = textures_.Id(light.textureKey);
    result.push_back(std::move(*data));
  };
  if (light.instancer.empty()) {
    add(light.path, light.transforms);
    return result;
  }
  const auto instances = instancers_.Flatten(light.instancer, light.prototype);
  const auto transforms = InstanceTransforms(light.transforms, *instances, threads_);
  for (size_t i = 0; i < transforms.size(); ++i)
    add(light.path + "[" + std::to_string(instances->indices[i]) + "]", transforms[i]);
  return result;
}

void LightStore::Upload(Light& light, std::vector<wavefront::LightData> data) {
  while (light.ids.size() > data.size()) {
    renderer_.DestroyLight(light.ids.back());
    light.ids.pop_back();
    light.data.pop_back();
  }
  for (size_t i = 0; i < data.size(); ++i) {
    if (i < light.ids.size()) {
      if (Same(data[i], light.data[i])) continue;
      light.data[i] = data[i];
      renderer_.SetLight(light.ids[i], std::move(data[i]));
    } else {
      light.data.push_back(data[i]);
      light.ids.push_back(renderer_.CreateLight(std::move(data[i])));
    }
    ++uploaded_;
  }
}

void LightStore::Commit(bool sceneLights) {
  AcquireTextures();
  const uint64_t textureVersion = textures_.version();
  for (auto& [path, light] : lights_) {
    const uint64_t signature =
        light->instancer.empty() ? 0 : instancers_.Signature(light->instancer, light->prototype);
    const bool touched = light->dirty || signature != light->instancerSignature || sceneLights != sceneLights_ ||
                         (light->textureKey && textureVersion != textureVersion_);
    if (!touched) continue;
    light->dirty = false;
    light->instancerSignature = signature;
    Upload(*light, light->visible && sceneLights ? Convert(*light) : std::vector<wavefront::LightData>());
  }
  textureVersion_ = textureVersion;
  sceneLights_ = sceneLights;
  for (auto& light : removed_) {
    for (wavefront::LightId id : light->ids) renderer_.DestroyLight(id);
    if (light->textureKey) textures_.Release(light->textureKey);
  }
  removed_.clear();
}

}  // namespace delegate
