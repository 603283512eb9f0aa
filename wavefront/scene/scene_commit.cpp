// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/scene_commit.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "wavefront/base/parallel.h"
#include "wavefront/scene/bvh/refit.h"
#include "wavefront/scene/interface_table.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront {
namespace {

using vulkan::MemoryKind;
constexpr uint32_t kRecordWords = 4 * layout::kInstanceTexels;
// A tree over fewer is built within two milliseconds, and all rays pass it.
constexpr uint32_t kLeastRefitInstances = 4096;

Matrix4d FirstTransform(const std::vector<TimeSample<Matrix4d>>& samples) { return samples.empty() ? Matrix4d{} : samples.front().value; }

void WriteRows(uint32_t* words, const Rows& rows) {
  for (int r = 0; r < 3; ++r) {
    words[4 * r] = std::bit_cast<uint32_t>(rows[r].x);
    words[4 * r + 1] = std::bit_cast<uint32_t>(rows[r].y);
    words[4 * r + 2] = std::bit_cast<uint32_t>(rows[r].z);
    words[4 * r + 3] = std::bit_cast<uint32_t>(rows[r].w);
  }
}

struct DoubleBounds {
  double min[3] = {1e300, 1e300, 1e300}, max[3] = {-1e300, -1e300, -1e300};
  bool empty() const { return min[0] > max[0]; }
  void Add(double x, double y, double z) {
    const double p[3] = {x, y, z};
    for (int i = 0; i < 3; ++i) { min[i] = std::min(min[i], p[i]); max[i] = std::max(max[i], p[i]); }
  }
  void AddBox(const Bounds3& b, const Matrix4d& m) {
    if (b.min.x > b.max.x) return;
    for (int corner = 0; corner < 8; ++corner) {
      const double p[3] = {corner & 1 ? b.max.x : b.min.x, corner & 2 ? b.max.y : b.min.y, corner & 4 ? b.max.z : b.min.z};
      double q[3];
      for (int j = 0; j < 3; ++j) q[j] = p[0] * m.m[0][j] + p[1] * m.m[1][j] + p[2] * m.m[2][j] + m.m[3][j];
      if (std::isfinite(q[0]) && std::isfinite(q[1]) && std::isfinite(q[2])) Add(q[0], q[1], q[2]);
    }
  }
};

// One group's instances as the commit walks them.
struct GroupPlan {
  const InstanceData* data = nullptr;
  const ResidentMesh* mesh = nullptr;
  uint32_t firstInstance = 0, bindingIndexBase = 0;
  bool opaque = true;
  std::vector<bool> emissiveSlots;
  bool emissive = false;
};

// Triangles of an emissive instance, in mesh order, with world areas and corners.
EmissiveTriangles GatherEmissive(const GroupPlan& plan, uint32_t instance, const Matrix4d& transform, const Double3& origin,
                                 const std::vector<bvh::TriangleRecord>& records) {
  EmissiveTriangles e;
  e.instance = instance;
  e.records.assign(plan.mesh->triangleCount, layout::kNoLight);
  e.areas.assign(plan.mesh->triangleCount, 0.0f);
  e.corners.assign(3 * std::size_t{plan.mesh->triangleCount}, Float3{});
  const Rows rows = ToRows(transform, origin);
  const auto& m = transform.m;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const bvh::TriangleRecord& t = records[i];
    if (t.meshTriangle >= e.records.size()) continue;
    const double a[3] = {double(t.v1.x) - t.v0.x, double(t.v1.y) - t.v0.y, double(t.v1.z) - t.v0.z};
    const double b[3] = {double(t.v2.x) - t.v0.x, double(t.v2.y) - t.v0.y, double(t.v2.z) - t.v0.z};
    double wa[3], wb[3];
    for (int j = 0; j < 3; ++j) {
      wa[j] = a[0] * m[0][j] + a[1] * m[1][j] + a[2] * m[2][j];
      wb[j] = b[0] * m[0][j] + b[1] * m[1][j] + b[2] * m[2][j];
    }
    const double c[3] = {wa[1] * wb[2] - wa[2] * wb[1], wa[2] * wb[0] - wa[0] * wb[2], wa[0] * wb[1] - wa[1] * wb[0]};
    const double area = 0.5 * std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    const bool emits = t.materialSlot < plan.emissiveSlots.size() && plan.emissiveSlots[t.materialSlot];
    if (!emits || !(area > 0) || !std::isfinite(area)) continue;
    e.records[t.meshTriangle] = plan.mesh->triangles.first + static_cast<uint32_t>(i);
    e.areas[t.meshTriangle] = static_cast<float>(area);
    std::size_t corner = 3 * std::size_t{t.meshTriangle};
    for (const auto* v : {&t.v0, &t.v1, &t.v2}) {
      const auto at = [&](const Float4& r) { return r.x * v->x + r.y * v->y + r.z * v->z + r.w; };
      e.corners[corner++] = {at(rows[0]), at(rows[1]), at(rows[2])};
    }
  }
  return e;
}

}  // namespace

SceneStore::SceneStore(vulkan::Device& device)
    : geometry(device), textures(device), materials(device),
      instances_(device, "instance records", MemoryKind::Geometry, 16 * layout::kInstanceTexels),
      bindings_(device, "binding records", MemoryKind::Materials, 16),
      lightRecords_(device, "light records", MemoryKind::Tables, 16 * layout::kLightTexels),
      lightItems_(device, "light items", MemoryKind::Tables, 16),
      lightDistribution_(device, "light distribution", MemoryKind::Tables, 4),
      lobeTable_(device, "lobe table", MemoryKind::Tables, 8) {}

uint32_t SceneStore::CreateInstances(InstanceData data) {
  std::lock_guard lock(mutex_);
  instancesDirty_ = true;
  groups_[nextGroup_] = std::move(data);
  return nextGroup_++;
}
void SceneStore::SetInstances(uint32_t id, InstanceData data) {
  std::lock_guard lock(mutex_);
  instancesDirty_ = true;
  groups_[id] = std::move(data);
}
void SceneStore::DestroyInstances(uint32_t id) {
  std::lock_guard lock(mutex_);
  instancesDirty_ = true;
  groups_.erase(id);
}
LightId SceneStore::CreateLight(LightData light) {
  std::lock_guard lock(mutex_);
  lightsDirty_ = true;
  lights_[nextLight_] = std::move(light);
  return nextLight_++;
}
void SceneStore::SetLight(LightId id, LightData light) {
  std::lock_guard lock(mutex_);
  lightsDirty_ = true;
  lights_[id] = std::move(light);
}
void SceneStore::DestroyLight(LightId id) {
  std::lock_guard lock(mutex_);
  lightsDirty_ = true;
  lights_.erase(id);
}

void SceneStore::SetPrimvarAovs(std::vector<std::string> names) {
  std::lock_guard lock(mutex_);
  if (names == primvarAovs_) return;
  instancesDirty_ = true;
  primvarAovs_ = std::move(names);
}

void SceneStore::SetLightSampling(LightSampling sampling, bool shadows) {
  std::lock_guard lock(mutex_);
  if (sampling == lightSampling_ && shadows == shadows_) return;
  lightsDirty_ = true;
  lightSampling_ = sampling;
  shadows_ = shadows;
}

Status SceneStore::Commit(uint32_t threads, bool interactive, const DiagnosticSink& sink, const GeometryStore::Displace& displace, const std::function<void()>& used,
                          bool* changed) {
  bool texturesChanged = false, meshesChanged = false, valuesChanged = false, bindingsChanged = false;
  if (Status s = textures.Commit(sink, &texturesChanged); !s) return s;
  if (Status s = geometry.Commit(threads, interactive, sink, displace, &meshesChanged); !s) return s;
  if (Status s = materials.Commit(&valuesChanged, &bindingsChanged); !s) return s;
  std::lock_guard lock(mutex_);
  const bool rebuild = instancesDirty_ || lightsDirty_ || meshesChanged || bindingsChanged || texturesChanged ||
                       (!interactive && treeRefitted_);
  *changed = rebuild || valuesChanged;
  if (!rebuild) return {};
  // Dirty until it succeeds: a commit that failed half-way is tried again as a whole.
  instancesDirty_ = true;
  Status s = RebuildInstances(threads, interactive, sink, used);
  if (s) instancesDirty_ = lightsDirty_ = false;
  return s;
}

// One binding record per distinct (mesh, material, instance primvars): instances share them.
uint32_t SceneStore::BindingFor(const InstanceData& group, const ResidentMesh& mesh, uint32_t slot, uint64_t instancePrimvarKey,
                                const std::map<std::string, PrimvarDescriptor>& instancePrimvars, bool* opaque, bool* emissive) {
  const MaterialId id = materials.Resolve(slot < group.materials.size() ? group.materials[slot] : kInvalidId);
  const MaterialInfo* material = materials.Find(id);
  const KernelInfo* kernel = material != nullptr ? materials.Kernel(material->kernelKey) : nullptr;
  *opaque = kernel == nullptr || kernel->opacity == layout::kNoBucket;
  *emissive = kernel != nullptr && kernel->emission != layout::kNoBucket;
  const std::vector<uint64_t> key{mesh.record, id, instancePrimvarKey};
  auto cached = bindingCache_.find(key);
  if (cached != bindingCache_.end()) return cached->second;

  const uint32_t texel = static_cast<uint32_t>(bindingTexels_.size() / 4);
  const uint32_t primvarCount = kernel != nullptr ? static_cast<uint32_t>(kernel->primvars.size()) : 0;
  auto put = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) { bindingTexels_.insert(bindingTexels_.end(), {a, b, c, d}); };
  if (kernel == nullptr) {
    put(layout::kNoBucket, layout::kNoBucket, layout::kNoBucket, 0);
  } else {
    put(kernel->surface, kernel->opacity, kernel->emission, material->parameters.first);
    for (uint32_t bucket : {kernel->surface, kernel->opacity, kernel->emission}) {
      if (bucket != layout::kNoBucket) usedBuckets_[bucket - layout::kFirstMaterialBucket] = true;
    }
    hasMedia_ = hasMedia_ || material->scatters;
    hasBodies_ = hasBodies_ || material->lightEnters || material->scatters;
  }
  put(0, id, primvarCount, material != nullptr ? material->mediumPriority : 0u);
  const auto putPrimvar = [&](const std::string& name) {
    PrimvarDescriptor d;
    auto own = instancePrimvars.find(name);
    if (own != instancePrimvars.end()) d = own->second;
    else if (auto found = mesh.primvars.find(name); found != mesh.primvars.end()) d = found->second;
    put(d.valueBase, d.indexBase, d.packed, d.unused);
  };
  for (uint32_t p = 0; p < primvarCount; ++p) putPrimvar(kernel->primvars[p]);
  for (const std::string& name : primvarAovs_) putPrimvar(name);
  bindingCache_[key] = texel;
  return texel;
}

// What one rebuild passes from step to step.
struct SceneStore::Rebuild {
  std::vector<GroupPlan> plans;                                          // by path
  std::vector<float> instanceValues;                                     // of instance primvars, all groups
  std::vector<std::map<std::string, PrimvarDescriptor>> groupPrimvars;   // by plan
  std::vector<uint32_t> bindingIndices;
  DoubleBounds world;
  uint32_t instanceCount = 0;
  std::vector<EmissiveTriangles> emissive;
  LightTable lights;
  std::vector<uint32_t> records;                                         // kRecordWords per instance, light shapes last
  std::vector<Bounds3> bounds;
  bvh::InstanceBvh tree;                                                 // first the one on the device, if it may be refitted
};

Status SceneStore::RebuildInstances(uint32_t threads, bool interactive, const DiagnosticSink& sink, const std::function<void()>& used) {
  Rebuild b;
  if (interactive && treeHeld_ >= kLeastRefitInstances && treeBuilt_.visits > 0) {
    if (Status s = ReadInstanceTree(b); !s) return s;
  }
  ReleaseRanges();
  PlanGroups(b);
  PlaceInstancePrimvars(b);
  MakeBindings(b);
  used();
  ChooseOrigin(b);
  if (Status s = GatherEmission(b); !s) return s;
  std::vector<LightData> lights;
  for (const auto& [id, light] : lights_) lights.push_back(light);
  b.lights = BuildLightTable(std::move(lights), b.emissive, textures, facts_.origin, facts_.sceneRadius, lightSampling_, shadows_, sink);
  WriteMeshInstances(b, threads, sink);
  WriteLightShapes(b);
  MakeInstanceTree(b, threads, interactive);
  return UploadRebuild(b);
}

void SceneStore::ReleaseRanges() {
  geometry.indices.Free(bindingIndexRange_);
  geometry.primvars.Free(instancePrimvarRange_);
  geometry.nodes.Free(tlasRange_);
  instances_.Free(instanceRange_);
  bindings_.Free(bindingRange_);
  lightRecords_.Free(lightRange_);
  lightItems_.Free(itemRange_);
  lightDistribution_.Free(distributionRange_);
  bindingIndexRange_ = instancePrimvarRange_ = tlasRange_ = instanceRange_ = bindingRange_ = lightRange_ = itemRange_ = distributionRange_ = {};
  bindingTexels_.clear();
  bindingCache_.clear();
  usedBuckets_.assign(materials.buckets().size(), false);
  hasMedia_ = hasBodies_ = false;
}

// Order by path, never by arrival.
void SceneStore::PlanGroups(Rebuild& b) {
  for (auto& [id, data] : groups_) {
    const ResidentMesh* mesh = geometry.Find(data.mesh);
    if (mesh == nullptr || mesh->triangleCount == 0 || data.transforms.empty()) continue;
    b.plans.push_back({&data, mesh, 0, 0, true, {}, false});
  }
  std::stable_sort(b.plans.begin(), b.plans.end(), [](const GroupPlan& x, const GroupPlan& y) { return x.data->path < y.data->path; });
}

// Values of all groups in one range.
void SceneStore::PlaceInstancePrimvars(Rebuild& b) {
  b.groupPrimvars.resize(b.plans.size());
  uint64_t count = 0;
  for (const GroupPlan& plan : b.plans)
    for (const PrimvarData& p : plan.data->instancePrimvars) count += p.components <= 4 ? p.values.size() : 0;
  instancePrimvarRange_ = geometry.primvars.Allocate(count);
  for (std::size_t g = 0; g < b.plans.size(); ++g) {
    for (const PrimvarData& p : b.plans[g].data->instancePrimvars) {
      if (p.components > 4 || p.values.empty()) continue;
      b.groupPrimvars[g][p.name] = {instancePrimvarRange_.first + static_cast<uint32_t>(b.instanceValues.size()), layout::kNoStream,
                                    static_cast<uint32_t>(p.interpolation) | p.components << 8, 0};
      b.instanceValues.insert(b.instanceValues.end(), p.values.begin(), p.values.end());
    }
  }
}

// Bindings of every slot of every group, and what the groups' materials say about opacity and emission.
void SceneStore::MakeBindings(Rebuild& b) {
  for (std::size_t g = 0; g < b.plans.size(); ++g) {
    GroupPlan& plan = b.plans[g];
    plan.firstInstance = b.instanceCount;
    b.instanceCount += static_cast<uint32_t>(plan.data->transforms.size());
    plan.bindingIndexBase = static_cast<uint32_t>(b.bindingIndices.size());
    for (uint32_t slot = 0; slot < plan.mesh->slotCount; ++slot) {
      bool opaque = true, emissive = false;
      b.bindingIndices.push_back(BindingFor(*plan.data, *plan.mesh, slot, b.groupPrimvars[g].empty() ? 0 : g + 1, b.groupPrimvars[g], &opaque, &emissive));
      plan.opaque = plan.opaque && opaque;
      plan.emissive = plan.emissive || emissive;
      plan.emissiveSlots.push_back(emissive);
    }
    for (const auto& samples : plan.data->transforms) b.world.AddBox(plan.mesh->bounds, FirstTransform(samples));
  }
  bindingIndexRange_ = geometry.indices.Allocate(b.bindingIndices.size());
  bindingRange_ = bindings_.Allocate(bindingTexels_.size() / 4);
}

// Far from the origin floats are coarse: render relative to the scene's centre there.
void SceneStore::ChooseOrigin(const Rebuild& b) {
  facts_ = {};
  double extent = 0;
  if (!b.world.empty()) {
    double centre[3], far = 0;
    for (int i = 0; i < 3; ++i) {
      centre[i] = 0.5 * (b.world.min[i] + b.world.max[i]);
      extent = std::max(extent, b.world.max[i] - b.world.min[i]);
      far = std::max(far, std::abs(centre[i]));
    }
    if (far > 8 * extent) facts_.origin = {std::round(centre[0]), std::round(centre[1]), std::round(centre[2])};
  }
  facts_.sceneRadius = static_cast<float>(extent > 0 ? extent * 0.866 : 1.0);  // half a cube's diagonal
}

// Triangle records of emissive instances are only on the device by now.
Status SceneStore::GatherEmission(Rebuild& b) {
  for (const GroupPlan& plan : b.plans) {
    if (!plan.emissive) continue;
    std::vector<bvh::TriangleRecord> records(plan.mesh->triangles.count);
    if (Status s = geometry.triangles.Read(plan.mesh->triangles.first, std::as_writable_bytes(std::span(records))); !s) return s;
    for (std::size_t i = 0; i < plan.data->transforms.size(); ++i) {
      b.emissive.push_back(GatherEmissive(plan, plan.firstInstance + static_cast<uint32_t>(i), FirstTransform(plan.data->transforms[i]), facts_.origin, records));
    }
  }
  return {};
}

void SceneStore::WriteMeshInstances(Rebuild& b, uint32_t threads, const DiagnosticSink& sink) {
  const uint32_t total = b.instanceCount + static_cast<uint32_t>(b.lights.shapes.size());
  b.records.assign(static_cast<std::size_t>(total) * kRecordWords, 0u);
  b.bounds.assign(total, Bounds3{});
  std::vector<uint32_t> itemBase(b.instanceCount, layout::kNoLight);
  for (const EmissiveTriangles& e : b.emissive) itemBase[e.instance] = e.itemBase;
  for (const GroupPlan& plan : b.plans) {
    const InstanceData& data = *plan.data;
    std::vector<uint8_t> singular(data.transforms.size());
    ParallelFor(data.transforms.size(), threads, [&](std::size_t i) {
      const uint32_t index = plan.firstInstance + static_cast<uint32_t>(i);
      uint32_t* words = &b.records[static_cast<std::size_t>(index) * kRecordWords];
      const Matrix4d transform = FirstTransform(data.transforms[i]);
      const auto inverse = InverseRows(transform, facts_.origin);
      if (!inverse) { singular[i] = 1; return; }
      const Rows rows = ToRows(transform, facts_.origin);
      WriteRows(words, *inverse);
      WriteRows(words + 16, rows);
      words[12] = plan.mesh->nodes.first;
      words[13] = plan.mesh->triangles.first;
      words[14] = layout::kKindMesh | (plan.opaque ? layout::kInstanceOpaque : 0u) | (Determinant3(transform) < 0 ? layout::kInstanceFlip : 0u) |
                  (plan.mesh->doubleSided ? layout::kInstanceDoubleSided : 0u);
      words[15] = (data.visibility & 0xffu) | data.categories << 8;
      words[28] = plan.mesh->record;
      words[29] = bindingIndexRange_.first + plan.bindingIndexBase;
      words[30] = static_cast<uint32_t>(i);
      words[31] = itemBase[index];
      words[32] = static_cast<uint32_t>(data.primId);
      words[33] = static_cast<uint32_t>(i < data.instanceIds.size() ? data.instanceIds[i] : -1);
      b.bounds[index] = bvh::InstanceBounds(plan.mesh->bounds, rows, *inverse);
    });
    const auto bad = std::count(singular.begin(), singular.end(), 1);
    if (bad != 0 && sink) {
      sink({Severity::Warning, "transform-singular", data.path, std::to_string(bad) + (bad == 1 ? " instance has a transform" : " instances have transforms") +
            " that cannot be inverted; not rendered"});
    }
  }
}

void SceneStore::WriteLightShapes(Rebuild& b) {
  for (std::size_t s = 0; s < b.lights.shapes.size(); ++s) {
    const LightShape& shape = b.lights.shapes[s];
    const std::size_t index = b.instanceCount + s;
    uint32_t* words = &b.records[index * kRecordWords];
    const Rows rows = ToRows(shape.transform, facts_.origin);
    const Rows inverse = *InverseRows(shape.transform, facts_.origin);  // checked by BuildLightTable
    WriteRows(words, inverse);
    WriteRows(words + 16, rows);
    words[14] = shape.kind | layout::kInstanceOpaque;
    words[15] = (shape.visibleToCamera ? kVisibleToCamera : 0u) | kVisibleToIndirect;
    words[28] = shape.light;
    words[31] = layout::kNoLight;
    words[32] = words[33] = 0xffffffffu;
    b.bounds[index] = bvh::InstanceBounds(bvh::LightShapeBounds(shape.kind), rows, inverse);
  }
}

Status SceneStore::ReadInstanceTree(Rebuild& b) {
  b.tree.nodes.resize(tlasRange_.count);
  b.tree.held = treeHeld_;
  treeHeld_ = 0;  // until the new one is there
  return geometry.nodes.Read(tlasRange_.first, std::as_writable_bytes(std::span(b.tree.nodes)));
}

// The rule of meshes' trees (bvh/mesh_trees.h), but for splits, which there are none of here.
void SceneStore::MakeInstanceTree(Rebuild& b, uint32_t threads, bool interactive) {
  treeRefitted_ = !b.tree.nodes.empty() && bvh::RefitInstanceBvh(b.bounds, b.tree, threads) &&
                  bvh::Growth(treeBuilt_, bvh::CostOf(b.tree, b.bounds, threads)) <= bvh::kMostGrowth;
  if (treeRefitted_) {
    ++instanceTreesRefitted_;
    return;
  }
  ++instanceTreesBuilt_;
  b.tree = bvh::BuildInstanceBvh(b.bounds, {threads});
  const bool mayBeRefitted = interactive && b.tree.held >= kLeastRefitInstances;
  treeBuilt_ = mayBeRefitted ? bvh::CostOf(b.tree, b.bounds, threads) : bvh::TreeCost{};
}

Status SceneStore::UploadRebuild(const Rebuild& b) {
  if (Status s = UploadLobeTable(); !s) return s;
  const LightTable& lights = b.lights;
  instanceRange_ = instances_.Allocate(b.bounds.size());
  tlasRange_ = geometry.nodes.Allocate(b.tree.nodes.size());
  lightRange_ = lightRecords_.Allocate(lights.lightCount);
  itemRange_ = lightItems_.Allocate(lights.items.size() / 4);
  distributionRange_ = lightDistribution_.Allocate(lights.distribution.size());
  for (Stream* stream : {&geometry.nodes, &geometry.triangles, &geometry.indices, &geometry.primvars, &geometry.meshRecords, &instances_, &bindings_,
                         &lightRecords_, &lightItems_, &lightDistribution_}) {
    if (Status s = stream->Fit(); !s) return s;
  }
  if (geometry.nodes.elements() > layout::kBvhMaxNodes) return Error{"the scene does not fit: more than 2^26 nodes of its trees"};
  for (Status s : {geometry.nodes.Write<bvh::BvhNode4>(tlasRange_, b.tree.nodes), geometry.indices.Write<uint32_t>(bindingIndexRange_, b.bindingIndices),
                   geometry.primvars.Write<float>(instancePrimvarRange_, b.instanceValues), instances_.Write<uint32_t>(instanceRange_, b.records),
                   bindings_.Write<uint32_t>(bindingRange_, bindingTexels_), lightRecords_.Write<Float4>(lightRange_, lights.records),
                   lightItems_.Write<uint32_t>(itemRange_, lights.items), lightDistribution_.Write<float>(distributionRange_, lights.distribution)}) {
    if (!s) return s;
  }
  treeHeld_ = b.tree.held;
  facts_.tlasRoot = tlasRange_.first;
  facts_.hasGeometry = b.bounds.empty() ? 0 : 1;
  facts_.lightItemCount = lights.itemCount;
  facts_.lightTree = lights.tree;
  facts_.infiniteLightCount = lights.infiniteCount;
  facts_.lightTraits = lights.traits;
  facts_.lightCount = lights.lightCount;
  facts_.instances = b.instanceCount;
  facts_.hasMedia = hasMedia_;
  facts_.hasBodies = hasBodies_;
  return {};
}

// What lobes look up does not depend on the scene.
Status SceneStore::UploadLobeTable() {
  if (lobeTable_.buffer() != nullptr) return {};
  const std::vector<uint32_t> texels = InterfaceTableTexels();
  const Range range = lobeTable_.Allocate(texels.size() / 2);
  if (Status s = lobeTable_.Fit(); !s) return s;
  return lobeTable_.Write<uint32_t>(range, texels);
}

Status SceneStore::Bind(vulkan::DescriptorSet& set) {
  struct Row { uint32_t binding; Stream* stream; };
  for (const Row& row : {Row{8, &geometry.nodes}, {9, &geometry.triangles}, {10, &instances_},
                         {11, &geometry.meshRecords}, {12, &geometry.indices}, {13, &geometry.primvars},
                         {14, &bindings_}, {15, &materials.parameters}, {16, &lightRecords_},
                         {17, &lightItems_}, {18, &lightDistribution_}, {19, &textures.records},
                         {20, &textures.pageTable}, {21, &textures.pages}, {22, &lobeTable_}, {23, &geometry.nodes}}) {
    if (row.stream->buffer() == nullptr) continue;
    if (Status s = set.WriteTexels(row.binding, *row.stream->buffer()); !s) return s;
  }
  return {};
}

}  // namespace wavefront
