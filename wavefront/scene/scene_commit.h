// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The scene as kernels see it: gathers the stores, orders everything by path, and rebuilds what depends on a change.
#pragma once

#include <functional>
#include <map>
#include <mutex>

#include "wavefront/scene/geometry_store.h"
#include "wavefront/scene/light_table.h"
#include "wavefront/scene/material_table.h"
#include "wavefront/scene/texture_store.h"
#include "wavefront/vulkan/descriptors.h"

namespace wavefront {

struct SceneFacts {
  uint32_t tlasRoot = 0, hasGeometry = 0, lightItemCount = 0, lightTree = 0, infiniteLightCount = 0, lightCount = 0;
  uint32_t lightTraits = 0;  // of any light, see light_table.h
  float sceneRadius = 1;
  Double3 origin;
  uint64_t instances = 0;
  bool hasMedia = false;   // some body scatters light inside
  bool hasBodies = false;  // light enters some body
};

class SceneStore {
 public:
  explicit SceneStore(vulkan::Device& device);

  // Staging; thread-safe.
  uint32_t CreateInstances(InstanceData data);
  void SetInstances(uint32_t id, InstanceData data);
  void DestroyInstances(uint32_t id);
  LightId CreateLight(LightData light);
  void SetLight(LightId id, LightData light);
  void DestroyLight(LightId id);
  void SetLightSampling(LightSampling sampling, bool shadows);
  void SetPrimvarAovs(std::vector<std::string> names);  // bindings hold their descriptors, too

  GeometryStore geometry;
  TextureStore textures;
  MaterialTable materials;

  // Makes staged edits real; `changed`: the image may differ. No submitted work may run. `displace`: as GeometryStore's;
  // it finds the textures on the device. `used`: called when buckets and usedBuckets() are those of the new scene, long before
  // the rest of it is: their kernels can be compiled meanwhile. `interactive`: trees may be made for an answer at once
  // (bvh/mesh_trees.h).
  Status Commit(uint32_t threads, bool interactive, const DiagnosticSink& sink, const GeometryStore::Displace& displace, const std::function<void()>& used,
                bool* changed);
  Status Bind(vulkan::DescriptorSet& set);
  const SceneFacts& facts() const { return facts_; }
  // Trees over instances, since the store was made.
  uint64_t instanceTreesBuilt() const { return instanceTreesBuilt_; }
  uint64_t instanceTreesRefitted() const { return instanceTreesRefitted_; }
  // By bucket number less kFirstMaterialBucket: does any instance of the committed scene use it?
  const std::vector<bool>& usedBuckets() const { return usedBuckets_; }

 private:
  // The rebuild of everything that depends on instances, bindings and lights, step by step.
  struct Rebuild;
  Status RebuildInstances(uint32_t threads, bool interactive, const DiagnosticSink& sink, const std::function<void()>& used);
  Status ReadInstanceTree(Rebuild& b);
  void MakeInstanceTree(Rebuild& b, uint32_t threads, bool interactive);
  void ReleaseRanges();
  void PlanGroups(Rebuild& b);
  void PlaceInstancePrimvars(Rebuild& b);
  void MakeBindings(Rebuild& b);
  void ChooseOrigin(const Rebuild& b);
  Status GatherEmission(Rebuild& b);
  void WriteMeshInstances(Rebuild& b, uint32_t threads, const DiagnosticSink& sink);
  void WriteLightShapes(Rebuild& b);
  Status UploadLobeTable();
  Status UploadRebuild(const Rebuild& b);
  uint32_t BindingFor(const InstanceData& group, const ResidentMesh& mesh, uint32_t slot, uint64_t instancePrimvarKey,
                      const std::map<std::string, PrimvarDescriptor>& instancePrimvars, bool* opaque, bool* emissive);

  std::mutex mutex_;
  std::map<uint32_t, InstanceData> groups_;
  std::map<LightId, LightData> lights_;
  uint32_t nextGroup_ = 0;
  LightId nextLight_ = 0;
  bool instancesDirty_ = true, lightsDirty_ = true;
  LightSampling lightSampling_ = LightSampling::Auto;
  bool shadows_ = true;
  std::vector<std::string> primvarAovs_;

  Stream instances_, bindings_, lightRecords_, lightItems_, lightDistribution_;
  Stream lobeTable_;  // written once
  Range instanceRange_, bindingRange_, bindingIndexRange_, instancePrimvarRange_, tlasRange_, lightRange_, itemRange_, distributionRange_;
  std::vector<uint32_t> bindingTexels_;                 // being built
  std::map<std::vector<uint64_t>, uint32_t> bindingCache_;  // while building
  std::vector<bool> usedBuckets_;
  bool hasMedia_ = false, hasBodies_ = false;
  // The tree over instances on the device: refitted where an interactive render's instances moved, built for all others.
  uint32_t treeHeld_ = 0;
  bool treeRefitted_ = false;
  bvh::TreeCost treeBuilt_;  // its cost when it was built, if that is known
  uint64_t instanceTreesBuilt_ = 0, instanceTreesRefitted_ = 0;
  SceneFacts facts_;
};

}  // namespace wavefront
