// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// All Rprims of a delegate: authored values in, meshes and instances of the core out. Internal to delegate.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "delegate/instancer_store.h"
#include "delegate/material_store.h"
#include "delegate/prims/gprim.h"
#include "wavefront/renderer.h"

namespace delegate {

// Sync from any thread; the rest from one.
class GprimStore {
 public:
  GprimStore(wavefront::Renderer& renderer, InstancerStore& instancers, MaterialStore& materials,
             wavefront::DiagnosticSink sink, unsigned threads);

  void Create(const std::string& path, bool isMesh);
  // True: there is something to commit.
  bool Sync(const std::string& path, MeshUpdate update);
  bool Sync(const std::string& path, ImplicitUpdate update);
  void Destroy(const std::string& path);

  struct What {
    std::set<std::string> renderTags;
    bool sceneMaterials = true;
    uint64_t displacementTriangles = 0;  // setting of that name
  };
  // After the materials'. Builds what is dirty and drawn, and hands it to the core, in order of path.
  void Commit(const What& what);

  uint64_t built() const { return built_; }
  uint64_t meshesUploaded() const { return meshesUploaded_; }
  uint64_t instancesUploaded() const { return instancesUploaded_; }

 private:
  // Round shapes are fine meshes: equal ones are one mesh. Without primvars: those go with the instances.
  using ImplicitKey = std::tuple<int, double, double, double, double, double, double, double, std::string, bool>;
  struct SharedMesh {
    wavefront::MeshId id = wavefront::kInvalidId;  // kInvalidId: nothing to draw
    uint32_t users = 0;
  };
  struct Gprim {
    std::string path;
    bool isMesh = true;
    MeshInput input;                                         // points: see below
    TimeSamples<std::vector<wavefront::Float3>> points;
    ImplicitInput shape;
    TimeSamples<wavefront::Matrix4d> transforms{{0, {}}};
    std::string material;
    std::vector<std::string> subsetMaterials;
    bool visible = true;
    std::string renderTag = "geometry";
    std::string instancer;
    int32_t prototype = 0, primId = -1;
    bool geometryDirty = true, instancesDirty = true;
    std::vector<std::shared_ptr<const wavefront::DisplacementData>> displacements;  // by slot; empty: nothing moves
    // As the core has it.
    wavefront::MeshId mesh = wavefront::kInvalidId;          // own, or the shared one's
    std::optional<ImplicitKey> sharedKey;
    wavefront::InstanceGroupId group = wavefront::kInvalidId;
    std::vector<wavefront::MaterialId> bound;
    uint64_t instancerSignature = 0, materialVersion = 0;
    // Between building and handing over.
    std::optional<wavefront::MeshData> fresh;
  };
  Gprim& FindOrCreate(const std::string& path, bool isMesh);
  bool SyncCommon(Gprim& gprim, GprimUpdate& update);  // true: primvars or sidedness changed
  bool Wanted(const Gprim& gprim, const What& what) const;
  void UpdateDisplacements(const What& what);
  void ChooseLevels(const std::vector<Gprim*>& displaced, uint64_t triangles);
  void BuildGeometry(const std::vector<Gprim*>& dirty);
  void BuildDisplacedImplicit(Gprim& gprim);
  void UploadMesh(Gprim& gprim);
  void ShareImplicit(Gprim& gprim);
  void LetGoOfMesh(Gprim& gprim);
  void UpdateInstances(Gprim& gprim, const What& what, bool wanted);
  wavefront::InstanceData MakeInstances(const Gprim& gprim) const;
  void AddPrimvars(const Gprim& gprim, const FlatInstances* instances, wavefront::InstanceData& data) const;
  void ChooseDefault(const Gprim& gprim, wavefront::InstanceData& data) const;
  void Remove(Gprim& gprim);

  wavefront::Renderer& renderer_;
  InstancerStore& instancers_;
  MaterialStore& materials_;
  wavefront::DiagnosticSink sink_;
  unsigned threads_;
  std::mutex mutex_;
  std::map<std::string, std::unique_ptr<Gprim>> gprims_;
  std::vector<std::unique_ptr<Gprim>> removed_;
  std::map<ImplicitKey, SharedMesh> shared_;
  std::vector<wavefront::MeshId> garbage_;
  int32_t nextPrimId_ = 0;
  bool sceneMaterials_ = true;
  uint64_t built_ = 0, meshesUploaded_ = 0, instancesUploaded_ = 0;
};

}  // namespace delegate
