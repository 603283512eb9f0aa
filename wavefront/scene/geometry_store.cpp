// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/geometry_store.h"

#include <algorithm>
#include <chrono>

#include "wavefront/shared/scene_layout.h"

namespace wavefront {
namespace {
using vulkan::MemoryKind;

PrimvarDescriptor Describe(const PrimvarData& primvar, uint32_t valueBase, uint32_t indexBase) {
  return {valueBase, indexBase, static_cast<uint32_t>(primvar.interpolation) | primvar.components << 8, 0};
}
uint32_t CountSlots(const MeshData& mesh) {
  uint32_t slots = 1;
  for (uint16_t slot : mesh.materialSlots) slots = std::max(slots, slot + 1u);
  return slots;
}
}  // namespace

GeometryStore::GeometryStore(vulkan::Device& device)
    : nodes(device, "BVH nodes", MemoryKind::Geometry, 64),
      triangles(device, "triangle records", MemoryKind::Geometry, 48),
      indices(device, "index stream", MemoryKind::Geometry, 4),
      primvars(device, "primvar stream", MemoryKind::Geometry, 4),
      meshRecords(device, "mesh records", MemoryKind::Geometry, 16 * layout::kMeshTexels) {}

MeshId GeometryStore::Create(MeshData mesh) {
  std::lock_guard lock(mutex_);
  staged_[next_] = std::move(mesh);
  return next_++;
}
void GeometryStore::Set(MeshId id, MeshData mesh) {
  std::lock_guard lock(mutex_);
  staged_[id] = std::move(mesh);
}
void GeometryStore::Destroy(MeshId id) {
  std::lock_guard lock(mutex_);
  staged_.erase(id);
  destroyed_.push_back(id);
}

const ResidentMesh* GeometryStore::Find(MeshId id) const {
  auto it = resident_.find(id);
  return it == resident_.end() ? nullptr : &it->second;
}
uint64_t GeometryStore::triangleCount() const {
  uint64_t sum = 0;
  for (const auto& [id, mesh] : resident_) sum += mesh.triangleCount;
  return sum;
}

void GeometryStore::Release(ResidentMesh& mesh) {
  nodes.Free(mesh.nodes);
  triangles.Free(mesh.triangles);
  indices.Free(mesh.indices);
  indices.Free(mesh.faceIds);
  indices.Free(mesh.primvarIndices);
  primvars.Free(mesh.primvarValues);
  meshRecords.Free({mesh.record, 1});
}

Status GeometryStore::Commit(uint32_t threads, const DiagnosticSink& sink, const Displace& displace, bool* changed) {
  std::lock_guard lock(mutex_);
  *changed = !staged_.empty() || !destroyed_.empty();
  for (MeshId id : destroyed_) {
    auto it = resident_.find(id);
    if (it == resident_.end()) continue;
    Release(it->second);
    resident_.erase(it);
  }
  destroyed_.clear();
  if (staged_.empty()) return {};

  for (auto& [id, mesh] : staged_) {
    if (mesh.displacements.empty()) continue;
    if (Status s = displace(mesh); !s) return s;
  }
  auto start = std::chrono::steady_clock::now();
  std::vector<MeshId> ids;
  std::vector<bvh::MeshInput> inputs;
  for (auto& [id, mesh] : staged_) {
    ids.push_back(id);
    inputs.push_back({mesh.positions, mesh.triangles, mesh.materialSlots});
  }
  std::vector<bvh::MeshBvh> trees = bvh::BuildMeshBvhs(inputs, {threads});
  bvhSeconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  // Ranges first, so that each stream grows once.
  for (std::size_t i = 0; i < ids.size(); ++i) {
    MeshData& mesh = staged_[ids[i]];
    auto old = resident_.find(ids[i]);
    if (old != resident_.end()) Release(old->second);
    ResidentMesh r;
    uint64_t values = 0, primvarIndices = 0;
    for (const PrimvarData& p : mesh.primvars) {
      if (p.components > 4) continue;
      values += p.values.size();
      primvarIndices += p.indices.size();
    }
    r.nodes = nodes.Allocate(trees[i].nodes.size());
    r.triangles = triangles.Allocate(trees[i].triangles.size());
    r.indices = indices.Allocate(mesh.triangles.size() * 3);
    r.faceIds = indices.Allocate(mesh.faceIds.size());
    r.primvarIndices = indices.Allocate(primvarIndices);
    r.primvarValues = primvars.Allocate(values);
    r.record = meshRecords.Allocate(1).first;
    r.triangleCount = static_cast<uint32_t>(mesh.triangles.size());
    r.slotCount = CountSlots(mesh);
    r.doubleSided = mesh.doubleSided;
    r.bounds = trees[i].bounds;
    resident_[ids[i]] = std::move(r);
  }
  for (Stream* stream : {&nodes, &triangles, &indices, &primvars, &meshRecords}) {
    if (Status s = stream->Fit(); !s) return s;
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (trees[i].brokenTriangles != 0 && sink) {
      sink({Severity::Warning, "mesh-broken-triangles",
            staged_[ids[i]].path.empty() ? "mesh " + std::to_string(ids[i]) : staged_[ids[i]].path,
            std::to_string(trees[i].brokenTriangles) + " triangles have vertices that are not finite and are not rendered"});
    }
    if (Status s = Upload(ids[i], staged_[ids[i]], trees[i]); !s) return s;
    trees[i] = {};
    staged_[ids[i]] = {};
  }
  staged_.clear();
  return {};
}

Status GeometryStore::Upload(MeshId id, MeshData& mesh, bvh::MeshBvh& tree) {
  ResidentMesh& r = resident_[id];
  if (Status s = nodes.Write<bvh::BvhNode4>(r.nodes, tree.nodes); !s) return s;
  if (Status s = triangles.Write<bvh::TriangleRecord>(r.triangles, tree.triangles); !s) return s;
  if (Status s = indices.Write<UInt3>(r.indices, mesh.triangles); !s) return s;
  if (Status s = indices.Write<uint32_t>(r.faceIds, mesh.faceIds); !s) return s;
  uint32_t value = r.primvarValues.first, index = r.primvarIndices.first;
  PrimvarDescriptor normals;
  for (const PrimvarData& p : mesh.primvars) {
    if (p.components > 4 || p.values.empty()) continue;
    Range values{value, static_cast<uint32_t>(p.values.size())};
    if (Status s = primvars.Write<float>(values, p.values); !s) return s;
    uint32_t indexBase = layout::kNoStream;
    if (!p.indices.empty()) {
      indexBase = index;
      if (Status s = indices.Write<uint32_t>({index, static_cast<uint32_t>(p.indices.size())}, p.indices); !s) return s;
    }
    PrimvarDescriptor descriptor = Describe(p, value, indexBase);
    if (p.name == "normals") normals = descriptor;
    r.primvars[p.name] = descriptor;
    value += static_cast<uint32_t>(p.values.size());
    index += static_cast<uint32_t>(p.indices.size());
  }
  const uint32_t record[8] = {r.indices.first, mesh.faceIds.empty() ? layout::kNoStream : r.faceIds.first, r.triangleCount, 0,
                              normals.valueBase, normals.indexBase, normals.packed, 0};
  return meshRecords.Write<uint32_t>({r.record, 1}, record);
}

}  // namespace wavefront
