// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Meshes on the device: BVH nodes, triangle records, index and primvar streams, mesh records. A mesh's host data is
// dropped once it is there.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "wavefront/base/diagnostics.h"
#include "wavefront/scene.h"
#include "wavefront/scene/bvh/bvh.h"
#include "wavefront/scene/stream.h"

namespace wavefront {

// A primvar descriptor as in shared/scene_layout.h.
struct PrimvarDescriptor { uint32_t valueBase = 0xffffffffu, indexBase = 0xffffffffu, packed = 0, unused = 0; };

struct ResidentMesh {
  Range nodes, triangles, indices, faceIds, primvarValues, primvarIndices;
  uint32_t record = 0;                // mesh record index
  uint32_t triangleCount = 0;
  uint32_t slotCount = 1;
  bool doubleSided = true;
  Bounds3 bounds;
  std::map<std::string, PrimvarDescriptor> primvars;
};

class GeometryStore {
 public:
  explicit GeometryStore(vulkan::Device& device);

  // Staging; thread-safe.
  MeshId Create(MeshData mesh);
  void Set(MeshId id, MeshData mesh);
  void Destroy(MeshId id);

  // Moves the points of a mesh by its displacements, and forgets those.
  using Displace = std::function<Status(MeshData&)>;
  // Displaces staged meshes, builds their BVHs in parallel and uploads. `changed`: something happened.
  Status Commit(uint32_t threads, const DiagnosticSink& sink, const Displace& displace, bool* changed);
  const ResidentMesh* Find(MeshId id) const;
  double bvhSeconds() const { return bvhSeconds_; }
  uint64_t triangleCount() const;

  Stream nodes, triangles, indices, primvars, meshRecords;

 private:
  Status Upload(MeshId id, MeshData& mesh, bvh::MeshBvh& tree);
  void Release(ResidentMesh& mesh);
  std::mutex mutex_;
  std::map<MeshId, MeshData> staged_;
  std::vector<MeshId> destroyed_;
  std::map<MeshId, ResidentMesh> resident_;
  MeshId next_ = 0;
  double bvhSeconds_ = 0;
};

}  // namespace wavefront
