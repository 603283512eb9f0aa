// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/geometry_store.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>

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
  ReleaseStreams(mesh);
}

void GeometryStore::ReleaseStreams(ResidentMesh& mesh) {
  indices.Free(mesh.indices);
  indices.Free(mesh.faceIds);
  indices.Free(mesh.primvarIndices);
  primvars.Free(mesh.primvarValues);
  meshRecords.Free({mesh.record, 1});
}

// One mesh of a commit: a staged one, or one whose tree is built for good.
struct GeometryStore::MeshJob {
  MeshId id = kInvalidId;
  MeshData* staged = nullptr;  // null: only the tree is new
  MeshData finished;           // then, its triangles as they came back from the device
  MeshContent before, content;
  bool keepsTree = false, keepsStreams = false;  // what is on the device stays in its place
  Range nodes, triangles;                        // of the tree
  bvh::TreeJob tree;
};

Status GeometryStore::Commit(uint32_t threads, bool interactive, const DiagnosticSink& sink, const Displace& displace, bool* changed) {
  std::lock_guard lock(mutex_);
  const std::vector<MeshId> unfinished = interactive ? std::vector<MeshId>{} : UnfinishedMeshes();
  *changed = !staged_.empty() || !destroyed_.empty() || !unfinished.empty();
  for (MeshId id : destroyed_) {
    auto it = resident_.find(id);
    if (it == resident_.end()) continue;
    Release(it->second);
    resident_.erase(it);
  }
  destroyed_.clear();
  if (staged_.empty() && unfinished.empty()) return {};

  for (auto& [id, mesh] : staged_) {
    if (mesh.displacements.empty()) continue;
    if (Status s = displace(mesh); !s) return s;
  }
  std::vector<MeshJob> jobs(staged_.size() + unfinished.size());
  std::size_t count = 0;
  for (auto& [id, mesh] : staged_) {
    jobs[count].id = id;
    jobs[count].staged = &mesh;
    if (Status s = PlanMesh(jobs[count++], interactive); !s) return s;
  }
  for (MeshId id : unfinished) {
    if (!resident_.contains(id)) continue;  // destroyed
    jobs[count].id = id;
    if (Status s = PlanFinish(jobs[count++]); !s) return s;
  }
  jobs.resize(count);

  auto start = std::chrono::steady_clock::now();
  std::vector<bvh::TreeJob> trees;
  for (MeshJob& job : jobs)
    if (!job.keepsTree) trees.push_back(std::move(job.tree));
  bvh::MakeTrees(trees, threads, treeCounts_);
  auto tree = trees.begin();
  for (MeshJob& job : jobs)
    if (!job.keepsTree) job.tree = std::move(*tree++);
  bvhSeconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  // Ranges first, so that each stream grows once.
  for (MeshJob& job : jobs) AllocateRanges(job);
  for (Stream* stream : {&nodes, &triangles, &indices, &primvars, &meshRecords}) {
    if (Status s = stream->Fit(); !s) {
      for (const MeshJob& job : jobs) DropRanges(job);
      return s;
    }
  }
  for (MeshJob& job : jobs) {
    const uint32_t broken = job.keepsTree ? resident_[job.id].tree.brokenTriangles : job.tree.mesh.brokenTriangles;
    if (broken != 0 && job.staged != nullptr && sink) {
      sink({Severity::Warning, "mesh-broken-triangles", job.staged->path.empty() ? "mesh " + std::to_string(job.id) : job.staged->path,
            std::to_string(broken) + " triangles have vertices that are not finite and are not rendered"});
    }
    if (Status s = Upload(job); !s) return s;
    if (job.staged != nullptr) *job.staged = {};
    job = {};
  }
  staged_.clear();
  return {};
}

std::vector<MeshId> GeometryStore::UnfinishedMeshes() const {
  std::vector<MeshId> ids;
  for (const auto& [id, mesh] : resident_) {
    if (!mesh.tree.final && mesh.content && !staged_.contains(id)) ids.push_back(id);
  }
  return ids;
}

Status GeometryStore::ReadTree(const ResidentMesh& mesh, bvh::MeshBvh& tree) {
  tree.nodes.resize(mesh.nodes.count);
  tree.triangles.resize(mesh.triangles.count);
  tree.recordsInLeaves = mesh.tree.recordsInLeaves;
  tree.bounds = mesh.bounds;
  if (Status s = nodes.Read(mesh.nodes.first, std::as_writable_bytes(std::span(tree.nodes))); !s) return s;
  if (tree.triangles.empty()) return {};
  return triangles.Read(mesh.triangles.first, std::as_writable_bytes(std::span(tree.triangles)));
}

// What a staged mesh has in common with what it was, and what follows for its tree.
Status GeometryStore::PlanMesh(MeshJob& job, bool interactive) {
  const MeshData& mesh = *job.staged;
  job.content = ContentOf(mesh);
  job.tree.positions = mesh.positions;
  job.tree.triangles = mesh.triangles;
  job.tree.slots = mesh.materialSlots;
  auto it = resident_.find(job.id);
  if (it == resident_.end() || !it->second.content) return {};
  const ResidentMesh& old = it->second;
  const MeshContent& before = *old.content;
  job.keepsStreams = SameSizes(before, job.content);
  const bool sameTriangles = before.triangles == job.content.triangles;
  job.keepsTree = sameTriangles && before.positions == job.content.positions && before.slots == job.content.slots && (interactive || old.tree.final);
  if (job.keepsTree || !interactive) return {};
  job.tree.way = sameTriangles ? bvh::TreeJob::Way::Refit : bvh::TreeJob::Way::BuildFast;
  if (!sameTriangles) return {};
  job.tree.built = old.tree.built;
  return ReadTree(old, job.tree.mesh);
}

// The triangles of a mesh whose host data is gone, in the mesh's own order, with corners of their own: a build over these
// is the build over the mesh.
Status GeometryStore::PlanFinish(MeshJob& job) {
  const ResidentMesh& mesh = resident_[job.id];
  std::vector<bvh::TriangleRecord> records(mesh.triangles.count);
  if (Status s = triangles.Read(mesh.triangles.first, std::as_writable_bytes(std::span(records))); !s) return s;
  MeshData& m = job.finished;
  m.positions.resize(3 * std::size_t{mesh.triangleCount});
  m.triangles.resize(mesh.triangleCount);
  m.materialSlots.resize(mesh.triangleCount);
  for (uint32_t i = 0; i < mesh.triangleCount; ++i) m.triangles[i] = {3 * i, 3 * i + 1, 3 * i + 2};
  for (const bvh::TriangleRecord& t : records) {
    const std::size_t first = 3 * std::size_t{t.meshTriangle};
    m.positions[first] = t.v0;
    m.positions[first + 1] = t.v1;
    m.positions[first + 2] = t.v2;
    m.materialSlots[t.meshTriangle] = static_cast<uint16_t>(t.materialSlot);
  }
  job.keepsStreams = true;
  job.tree.positions = m.positions;
  job.tree.triangles = m.triangles;
  job.tree.slots = m.materialSlots;
  return {};
}

void GeometryStore::AllocateRanges(MeshJob& job) {
  const auto [it, isNew] = resident_.try_emplace(job.id);
  ResidentMesh& r = it->second;
  job.nodes = r.nodes;
  job.triangles = r.triangles;
  const bool fits = r.nodes.count == job.tree.mesh.nodes.size() && r.triangles.count == job.tree.mesh.triangles.size();
  if (!job.keepsTree && !fits) {
    // Where only the tree is new, the old one stays until this is there: its triangles are nowhere else.
    if (job.staged != nullptr) {
      nodes.Free(r.nodes);
      triangles.Free(r.triangles);
    }
    job.nodes = nodes.Allocate(job.tree.mesh.nodes.size());
    job.triangles = triangles.Allocate(job.tree.mesh.triangles.size());
  }
  if (job.staged == nullptr) return;
  r.nodes = job.nodes;
  r.triangles = job.triangles;
  if (r.content) job.before = std::move(*r.content);
  r.content.reset();  // until all of it is uploaded
  if (job.keepsStreams) return;
  const MeshData& mesh = *job.staged;
  if (!isNew) ReleaseStreams(r);
  uint64_t values = 0, primvarIndices = 0;
  for (const PrimvarData& p : mesh.primvars) {
    if (p.components > 4) continue;
    values += p.values.size();
    primvarIndices += p.indices.size();
  }
  r.indices = indices.Allocate(mesh.triangles.size() * 3);
  r.faceIds = indices.Allocate(mesh.faceIds.size());
  r.primvarIndices = indices.Allocate(primvarIndices);
  r.primvarValues = primvars.Allocate(values);
  r.record = meshRecords.Allocate(1).first;
  r.triangleCount = static_cast<uint32_t>(mesh.triangles.size());
  r.primvars.clear();
}

// After an error: a staged mesh holds its ranges, the new ones of others are nobody's.
void GeometryStore::DropRanges(const MeshJob& job) {
  if (job.staged != nullptr) return;
  const ResidentMesh& r = resident_[job.id];
  if (r.nodes.first != job.nodes.first) nodes.Free(job.nodes);
  if (r.triangles.first != job.triangles.first) triangles.Free(job.triangles);
}

Status GeometryStore::Upload(MeshJob& job) {
  ResidentMesh& r = resident_[job.id];
  if (!job.keepsTree) {
    const bvh::MeshBvh& tree = job.tree.mesh;
    if (Status s = nodes.Write<bvh::BvhNode4>(job.nodes, tree.nodes); !s) return s;
    if (Status s = triangles.Write<bvh::TriangleRecord>(job.triangles, tree.triangles); !s) return s;
    if (r.nodes.first != job.nodes.first) nodes.Free(std::exchange(r.nodes, job.nodes));
    if (r.triangles.first != job.triangles.first) triangles.Free(std::exchange(r.triangles, job.triangles));
    r.bounds = tree.bounds;
    r.tree = {job.tree.way == bvh::TreeJob::Way::Build, job.tree.built, tree.recordsInLeaves, job.staged != nullptr ? tree.brokenTriangles : r.tree.brokenTriangles};
  }
  if (job.staged == nullptr) return {};
  r.slotCount = CountSlots(*job.staged);
  r.doubleSided = job.staged->doubleSided;
  if (Status s = UploadStreams(job, r); !s) return s;
  r.content = std::move(job.content);
  return {};
}

// All but positions and slots, which are in the triangle records. Streams that kept their places get what differs.
Status GeometryStore::UploadStreams(const MeshJob& job, ResidentMesh& r) {
  const MeshData& mesh = *job.staged;
  const auto differs = [&](const ArrayContent& before, const ArrayContent& now) { return !job.keepsStreams || before != now; };
  if (differs(job.before.triangles, job.content.triangles)) {
    if (Status s = indices.Write<UInt3>(r.indices, mesh.triangles); !s) return s;
  }
  if (differs(job.before.faceIds, job.content.faceIds)) {
    if (Status s = indices.Write<uint32_t>(r.faceIds, mesh.faceIds); !s) return s;
  }
  uint32_t value = r.primvarValues.first, index = r.primvarIndices.first;
  PrimvarDescriptor normals;
  for (std::size_t i = 0; i < mesh.primvars.size(); ++i) {
    const PrimvarData& p = mesh.primvars[i];
    if (p.components > 4 || p.values.empty()) continue;
    const PrimvarContent& now = job.content.primvars[i];
    const PrimvarContent& before = job.keepsStreams ? job.before.primvars[i] : now;
    if (differs(before.values, now.values)) {
      if (Status s = primvars.Write<float>({value, static_cast<uint32_t>(p.values.size())}, p.values); !s) return s;
    }
    uint32_t indexBase = layout::kNoStream;
    if (!p.indices.empty()) {
      indexBase = index;
      if (differs(before.indices, now.indices)) {
        if (Status s = indices.Write<uint32_t>({index, static_cast<uint32_t>(p.indices.size())}, p.indices); !s) return s;
      }
    }
    PrimvarDescriptor descriptor = Describe(p, value, indexBase);
    if (p.name == "normals") normals = descriptor;
    r.primvars[p.name] = descriptor;
    value += static_cast<uint32_t>(p.values.size());
    index += static_cast<uint32_t>(p.indices.size());
  }
  if (job.keepsStreams) return {};  // so does the record
  const uint32_t record[8] = {r.indices.first, mesh.faceIds.empty() ? layout::kNoStream : r.faceIds.first, r.triangleCount, 0,
                              normals.valueBase, normals.indexBase, normals.packed, 0};
  return meshRecords.Write<uint32_t>({r.record, 1}, record);
}

}  // namespace wavefront
