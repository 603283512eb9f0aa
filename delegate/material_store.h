// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// All materials of a delegate: networks in, kernels and parameter blocks out. Internal to delegate.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "delegate/displacement.h"
#include "delegate/material_explanation.h"
#include "delegate/prims/material.h"
#include "delegate/textures.h"
#include "materialgen/spirv_cache.h"
#include "wavefront/renderer.h"

namespace delegate {

// Sync from any thread; the rest from one.
class MaterialStore {
 public:
  MaterialStore(wavefront::Renderer& renderer, materialgen::Generator& generator, TextureTable& textures,
                wavefront::DiagnosticSink sink, unsigned threads);

  void Create(const std::string& path);
  bool Sync(const std::string& path, MaterialUpdate update);  // true: there is something to commit
  void Destroy(const std::string& path);

  // Before Generate; other options than before make all materials dirty.
  void SetOptions(const materialgen::GenerateOptions& options);
  // Networks of dirty materials become kernels' sources and values, in parallel; their textures are asked for.
  void Generate();
  // Registers kernels not seen before, which the core compiles in the background when they are worn first; creates and
  // updates materials in the core. Ids of materials that are gone stay valid until Collect.
  void Commit();
  void Collect();

  // kInvalidId: there is no such material (told once), or it shows the default.
  wavefront::MaterialId Id(const std::string& path, const std::string& user);
  // How the material moves points; null: it does not. The same pointer as long as nothing of it changed.
  std::shared_ptr<const wavefront::DisplacementData> Displacement(const std::string& path) const;
  // The defaults are made when somebody wears them first. The core's own is opaque, which spares the shadow rays of all
  // prims that author no displayOpacity the opacity kernel; the other is for those that do.
  void NeedDefault();
  wavefront::MaterialId TranslucentDefault();
  // A kernel met so far asks for the frame or the time: their change is one of the picture.
  bool followsFrame() const { return followsFrame_; }
  uint64_t idVersion() const { return idVersion_; }  // grows when a path's id changes
  uint64_t generated() const { return generated_; }
  uint64_t uploaded() const { return uploaded_; }
  uint64_t compiled() const { return compiled_ + displacementKernels_.compiled(); }

  struct Kernel {
    std::shared_ptr<const materialgen::KernelSource> source;
    double generateMilliseconds = 0;
  };
  const std::map<std::string, Kernel>& kernels() const { return kernels_; }
  std::vector<std::string> MaterialsOf(const std::string& kernelKey) const;
  // What became of a material; nothing: there is none of that path, or it shows the default.
  std::optional<MaterialExplanation> Explain(const std::string& path) const;
  std::shared_ptr<const materialgen::KernelSource> SourceOf(const std::string& path) const;
  std::shared_ptr<const materialgen::KernelSource> DisplacementSourceOf(const std::string& path) const;

 private:
  struct Material {
    std::string path;
    MaterialUpdate update;
    bool dirty = true;               // the network changed
    bool stale = false;              // compiled changed, the core has not seen it
    bool hasNetwork = false;
    std::string context;             // of the network
    double generateMilliseconds = 0;
    materialgen::CompiledMaterial compiled, displaced;  // of the surface's and the displacement's terminal
    std::vector<uint32_t> textureKeys, displacementKeys;  // by the textures of either
    std::shared_ptr<const wavefront::DisplacementData> displacement;
    wavefront::MaterialData data;       // as the core has it
    wavefront::MaterialId id = wavefront::kInvalidId;
  };
  Material& FindOrCreate(const std::string& path);
  void ReleaseTextures(Material& material);
  void RegisterKernel(const Material& material);
  void Upload(Material& material);
  std::vector<uint32_t> Acquire(const Material& material, const materialgen::CompiledMaterial& compiled);
  std::vector<wavefront::Float4> Block(const materialgen::CompiledMaterial& compiled, const std::vector<uint32_t>& keys);
  void UpdateDisplacement(Material& material);
  wavefront::Result<std::vector<uint32_t>> LinkMegakernel(std::span<const std::string> keys) const;
  void MakeDefault(Material& material, bool isOpaque);

  wavefront::Renderer& renderer_;
  materialgen::Generator& generator_;
  materialgen::GenerateOptions options_;
  TextureTable& textures_;
  wavefront::DiagnosticSink sink_;
  unsigned threads_;
  std::shared_ptr<materialgen::SpirvCache> cache_;
  mutable std::mutex mutex_;  // of the map; a material itself belongs to the thread that syncs it
  std::map<std::string, std::unique_ptr<Material>> materials_;
  std::vector<std::unique_ptr<Material>> removed_;
  std::vector<wavefront::MaterialId> garbage_;
  std::map<std::string, Kernel> kernels_;
  bool followsFrame_ = false;
  DisplacementKernels displacementKernels_;
  Material default_, translucentDefault_;
  uint64_t textureVersion_ = 0, idVersion_ = 1, generated_ = 0, uploaded_ = 0, compiled_ = 0;
};

}  // namespace delegate
