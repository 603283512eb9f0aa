// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// All lights of a delegate, also those that an instancer repeats. Internal to delegate.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "delegate/instancer_store.h"
#include "delegate/prims/light.h"
#include "delegate/textures.h"
#include "wavefront/renderer.h"

namespace delegate {

// Sync from any thread; the rest from one.
class LightStore {
 public:
  LightStore(wavefront::Renderer& renderer, InstancerStore& instancers, TextureTable& textures,
             wavefront::DiagnosticSink sink, unsigned threads);

  void Create(const std::string& path, const std::string& type);
  bool Sync(const std::string& path, LightUpdate update);  // true: there is something to commit
  void Destroy(const std::string& path);

  void AcquireTextures();  // of lights whose image changed
  void Commit(bool sceneLights);
  uint64_t uploaded() const { return uploaded_; }

 private:
  struct Light {
    std::string path;
    LightParams params;
    TimeSamples<wavefront::Matrix4d> transforms{{0, {}}};
    bool visible = true;
    std::string instancer;
    int32_t prototype = 0;
    bool dirty = true, textureDirty = true;
    uint32_t textureKey = 0;  // 0: none
    uint64_t instancerSignature = 0;
    std::vector<wavefront::LightId> ids;       // as the core has them
    std::vector<wavefront::LightData> data;
  };
  Light& FindOrCreate(const std::string& path);
  std::vector<wavefront::LightData> Convert(const Light& light) const;
  void Upload(Light& light, std::vector<wavefront::LightData> data);

  wavefront::Renderer& renderer_;
  InstancerStore& instancers_;
  TextureTable& textures_;
  wavefront::DiagnosticSink sink_;
  unsigned threads_;
  std::mutex mutex_;
  std::map<std::string, std::unique_ptr<Light>> lights_;
  std::vector<std::unique_ptr<Light>> removed_;
  bool sceneLights_ = true;
  uint64_t textureVersion_ = 0, uploaded_ = 0;
};

}  // namespace delegate
