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
#include "wavefront/scene/bvh/mesh_trees.h"
#include "wavefront/scene/mesh_content.h"
#include "wavefront/scene/stream.h"

namespace wavefront {

// A primvar descriptor as in shared/scene_layout.h.
struct PrimvarDescriptor { uint32_t valueBase = 0xffffffffu, indexBase = 0xffffffffu, packed = 0, unused = 0; };

// How a mesh's tree on the device came about.
struct TreeOrigin {
  bool final = false;              // bvh/mesh_trees.h says when
  bvh::TreeCost built;             // of its last build, once a refit has asked for it
  uint32_t recordsInLeaves = 0, brokenTriangles = 0;
};

struct ResidentMesh {
  Range nodes, triangles, indices, faceIds, primvarValues, primvarIndices;
  uint32_t record = 0;                // mesh record index
  uint32_t triangleCount = 0;
  uint32_t slotCount = 1;
  bool doubleSided = true;
  Bounds3 bounds;
  std::map<std::string, PrimvarDescriptor> primvars;
  std::optional<MeshContent> content;  // what its ranges hold, once they do
  TreeOrigin tree;
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
  // Displaces staged meshes, makes their BVHs in parallel (bvh/mesh_trees.h says how) and uploads what differs. Unless it
  // is `interactive`, trees that are not final are built for good, too. `changed`: something happened.
  Status Commit(uint32_t threads, bool interactive, const DiagnosticSink& sink, const Displace& displace, bool* changed);
  const ResidentMesh* Find(MeshId id) const;
  double bvhSeconds() const { return bvhSeconds_; }
  const bvh::TreeCounts& treeCounts() const { return treeCounts_; }
  uint64_t triangleCount() const;

  Stream nodes, triangles, indices, primvars, meshRecords;

 private:
  struct MeshJob;
  std::vector<MeshId> UnfinishedMeshes() const;
  Status PlanMesh(MeshJob& job, bool interactive);
  Status PlanFinish(MeshJob& job);
  void AllocateRanges(MeshJob& job);
  Status Upload(MeshJob& job);
  Status UploadStreams(const MeshJob& job, ResidentMesh& mesh);
  void DropRanges(const MeshJob& job);
  Status ReadTree(const ResidentMesh& mesh, bvh::MeshBvh& tree);
  void Release(ResidentMesh& mesh);
  void ReleaseStreams(ResidentMesh& mesh);
  std::mutex mutex_;
  std::map<MeshId, MeshData> staged_;
  std::vector<MeshId> destroyed_;
  std::map<MeshId, ResidentMesh> resident_;
  MeshId next_ = 0;
  double bvhSeconds_ = 0;
  bvh::TreeCounts treeCounts_;
};

}  // namespace wavefront
