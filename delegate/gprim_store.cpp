// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/gprim_store.h"

#include <algorithm>
#include <cmath>

#include "delegate/mesh/build_mesh.h"
#include "delegate/mesh/split_triangles.h"
#include "delegate/prims/matrix.h"
#include "delegate/prims/same.h"
#include "wavefront/base/parallel.h"

namespace delegate {
namespace {

using wavefront::kInvalidId;
using wavefront::Severity;

// All displaced meshes of a scene together; about 150 bytes each on the device.
constexpr uint64_t kMostDisplacedTriangles = 8'000'000;

// About: sizes of zero leave some out.
uint64_t TrianglesOf(const ImplicitInput& shape) {
  static std::mutex mutex;
  static std::map<ImplicitShape, uint64_t> counts;
  std::lock_guard lock(mutex);
  const auto [known, isNew] = counts.try_emplace(shape.shape, 0);
  if (isNew) {
    ImplicitInput input;
    input.shape = shape.shape;
    if (const auto mesh = BuildImplicit(input, {})) known->second = mesh->triangles.size();
  }
  return known->second;
}

std::optional<wavefront::PrimvarData> ConstantPrimvar(const PrimvarInput& primvar) {
  const size_t at = primvar.indices.empty() ? 0 : static_cast<size_t>(std::max(primvar.indices[0], 0));
  if (primvar.components == 0 || primvar.values.size() < (at + 1) * primvar.components) return std::nullopt;
  if (!primvar.indices.empty() && primvar.indices[0] < 0) return std::nullopt;
  wavefront::PrimvarData data;
  data.name = primvar.name;
  data.components = primvar.components;
  const auto first = primvar.values.begin() + static_cast<std::ptrdiff_t>(at * primvar.components);
  data.values.assign(first, first + primvar.components);
  for (float v : data.values)
    if (!std::isfinite(v)) return std::nullopt;
  return data;
}

}  // namespace

GprimStore::GprimStore(wavefront::Renderer& renderer, InstancerStore& instancers, MaterialStore& materials,
                       wavefront::DiagnosticSink sink, unsigned threads)
    : renderer_(renderer), instancers_(instancers), materials_(materials), sink_(std::move(sink)), threads_(threads) {}

GprimStore::Gprim& GprimStore::FindOrCreate(const std::string& path, bool isMesh) {
  std::lock_guard lock(mutex_);
  auto& gprim = gprims_[path];
  if (!gprim) {
    gprim = std::make_unique<Gprim>();
    gprim->path = path;
    gprim->isMesh = isMesh;
    gprim->input.path = path;
    gprim->shape.path = path;
    gprim->primId = nextPrimId_++;
  }
  if (gprim->isMesh != isMesh) {
    gprim->isMesh = isMesh;
    gprim->geometryDirty = true;
  }
  return *gprim;
}

void GprimStore::Create(const std::string& path, bool isMesh) { FindOrCreate(path, isMesh); }

bool GprimStore::SyncCommon(Gprim& g, GprimUpdate& update) {
  bool moved = Take(g.visible, update.visible);
  if (update.transforms && update.transforms->empty()) update.transforms.reset();
  moved |= Take(g.transforms, update.transforms);
  moved |= Take(g.material, update.material);
  if (update.renderTag && update.renderTag->empty()) update.renderTag = "geometry";
  moved |= Take(g.renderTag, update.renderTag);
  moved |= Take(g.instancer, update.instancer);
  moved |= Take(g.prototype, update.prototype);
  moved |= Take(g.primId, update.primId);
  if (moved) g.instancesDirty = true;
  const bool primvars = Take(g.input.primvars, update.primvars);
  const bool sides = Take(g.input.doubleSided, update.doubleSided);
  // Instances hold the primvars of implicit shapes, what the prim overrides of its instancer, and the default material.
  if (primvars) g.instancesDirty = true;
  return g.isMesh ? primvars || sides : sides;
}

bool GprimStore::Sync(const std::string& path, MeshUpdate update) {
  Gprim& g = FindOrCreate(path, true);
  bool geometry = SyncCommon(g, update);
  geometry |= Take(g.input.topology, update.topology);
  geometry |= Take(g.points, update.points);
  geometry |= Take(g.input.refineLevel, update.refineLevel);
  if (geometry) g.geometryDirty = true;
  if (Take(g.subsetMaterials, update.subsetMaterials)) g.instancesDirty = true;
  return g.geometryDirty || g.instancesDirty;
}

bool GprimStore::Sync(const std::string& path, ImplicitUpdate update) {
  Gprim& g = FindOrCreate(path, false);
  bool geometry = SyncCommon(g, update);
  geometry |= Take(g.shape, update.shape);
  g.shape.path = path;
  if (geometry) g.geometryDirty = true;
  return g.geometryDirty || g.instancesDirty;
}

void GprimStore::Destroy(const std::string& path) {
  std::lock_guard lock(mutex_);
  const auto found = gprims_.find(path);
  if (found == gprims_.end()) return;
  removed_.push_back(std::move(found->second));
  gprims_.erase(found);
}

bool GprimStore::Wanted(const Gprim& g, const What& what) const {
  return g.visible && (what.renderTags.empty() || what.renderTags.count(g.renderTag) > 0);
}

// Triangles of meshes, in parallel. The authored points stand in the time samples; they are lent to the input.
void GprimStore::BuildGeometry(const std::vector<Gprim*>& dirty) {
  wavefront::ParallelFor(dirty.size(), threads_, [&](size_t i) {
    Gprim& g = *dirty[i];
    if (!g.isMesh) {
      if (!g.displacements.empty()) BuildDisplacedImplicit(g);
      return;
    }
    if (g.points.size() > 1)
      sink_({Severity::Info, "mesh-still", g.path,
             "Deformation within the shutter is not rendered; its first sample is shown."});
    if (!g.points.empty()) g.input.points.swap(g.points.front().value);
    g.fresh = BuildMesh(g.input, sink_);
    if (!g.points.empty()) g.input.points.swap(g.points.front().value);
    if (g.fresh) g.fresh->displacements = g.displacements;
  });
}

// Implicit shapes share their meshes until something moves their points.
void GprimStore::BuildDisplacedImplicit(Gprim& g) {
  ImplicitInput input = g.shape;
  input.doubleSided = g.input.doubleSided;
  g.fresh = BuildImplicit(input, sink_);
  if (!g.fresh) return;
  g.fresh->path = g.path;
  for (const PrimvarInput& primvar : g.input.primvars)  // those that are none are told of with the instances
    if (auto constant = primvar.interpolation == "constant" ? ConstantPrimvar(primvar) : std::nullopt)
      g.fresh->primvars.push_back(std::move(*constant));
  WeldPoints(*g.fresh);
  SplitTriangles(*g.fresh, g.input.displacementLevel.value_or(0));
  g.fresh->displacements = g.displacements;
}

// What moves the points of each prim, and how finely it is cut for that. A prim whose displacement is not what its mesh was
// built with is built anew; nothing else is.
void GprimStore::UpdateDisplacements(const What& what) {
  std::vector<Gprim*> displaced;
  for (auto& [path, gprim] : gprims_) {
    Gprim& g = *gprim;
    if (!Wanted(g, what)) continue;
    std::vector<std::shared_ptr<const wavefront::DisplacementData>> displacements;
    bool moves = false;
    const size_t slots = what.sceneMaterials ? 1 + (g.isMesh ? g.input.topology.subsets.size() : 0) : 0;
    for (size_t i = 0; i < slots; ++i) {
      const bool hasOwn = i > 0 && i <= g.subsetMaterials.size() && !g.subsetMaterials[i - 1].empty();
      displacements.push_back(materials_.Displacement(hasOwn ? g.subsetMaterials[i - 1] : g.material));
      moves |= displacements.back() != nullptr;
    }
    if (!moves) displacements.clear();
    if (displacements != g.displacements) {
      g.displacements = std::move(displacements);
      g.geometryDirty = true;
    }
    if (moves) {
      displaced.push_back(&g);
    } else if (g.input.displacementLevel) {
      g.input.displacementLevel.reset();
      g.geometryDirty = true;
    }
  }
  ChooseLevels(displaced, what.displacementTriangles);
}

void GprimStore::ChooseLevels(const std::vector<Gprim*>& displaced, uint64_t triangles) {
  std::vector<DisplacementLevel> levels(displaced.size());
  const uint64_t wanted = triangles;
  for (;; triangles /= 4) {  // one level less for all but those that are fine by themselves
    uint64_t sum = 0;
    for (size_t i = 0; i < displaced.size(); ++i) {
      const Gprim& g = *displaced[i];
      const DisplacementTarget target{triangles, g.input.maxTriangles};
      levels[i] = g.isMesh ? ChooseDisplacementLevel(g.input, target)
                           : ChooseDisplacementLevel(TrianglesOf(g.shape), g.input.primvars, target);
      sum += levels[i].triangles;
    }
    if (sum <= kMostDisplacedTriangles || triangles == 0) break;
  }
  if (triangles < wanted)
    sink_({Severity::Warning, "displacement-coarse", displaced.front()->path,
           "The scene's " + std::to_string(displaced.size()) + " displaced prims, this one the first, would take more than " +
               std::to_string(kMostDisplacedTriangles) + " triangles; each is refined to about " +
               std::to_string(triangles) + " instead of " + std::to_string(wanted) + "."});
  for (size_t i = 0; i < displaced.size(); ++i) {
    if (displaced[i]->input.displacementLevel == levels[i].level) continue;
    displaced[i]->input.displacementLevel = levels[i].level;
    displaced[i]->geometryDirty = true;
  }
}

void GprimStore::LetGoOfMesh(Gprim& g) {
  if (g.sharedKey) {
    const auto found = shared_.find(*g.sharedKey);
    if (--found->second.users == 0) {
      if (found->second.id != kInvalidId) garbage_.push_back(found->second.id);
      shared_.erase(found);
    }
    g.sharedKey.reset();
  } else if (g.mesh != kInvalidId) {
    garbage_.push_back(g.mesh);
  }
  g.mesh = kInvalidId;
}

void GprimStore::UploadMesh(Gprim& g) {
  ++built_;
  if (g.sharedKey) LetGoOfMesh(g);  // it was an implicit shape
  if (!g.fresh) {
    LetGoOfMesh(g);
  } else if (g.mesh != kInvalidId) {
    renderer_.SetMesh(g.mesh, std::move(*g.fresh));
    ++meshesUploaded_;
  } else {
    g.mesh = renderer_.CreateMesh(std::move(*g.fresh));
    ++meshesUploaded_;
    g.instancesDirty = true;
  }
  g.fresh.reset();
}

void GprimStore::ShareImplicit(Gprim& g) {
  const ImplicitInput& s = g.shape;
  const ImplicitKey key{static_cast<int>(s.shape), s.size,   s.radius, s.radiusTop, s.radiusBottom,
                        s.height,                  s.width,  s.length, s.axis,      g.input.doubleSided};
  if (g.sharedKey && *g.sharedKey == key) return;
  LetGoOfMesh(g);
  auto [known, isNew] = shared_.try_emplace(key);
  if (isNew) {
    ImplicitInput input = s;
    input.doubleSided = g.input.doubleSided;
    ++built_;
    if (auto mesh = BuildImplicit(input, sink_)) {
      known->second.id = renderer_.CreateMesh(std::move(*mesh));
      ++meshesUploaded_;
    }
  }
  if (known->second.id == kInvalidId) {  // told; another prim of this size is told as well
    if (known->second.users == 0) shared_.erase(known);
    g.instancesDirty = true;
    return;
  }
  ++known->second.users;
  g.sharedKey = key;
  g.mesh = known->second.id;
  g.instancesDirty = true;
}

void GprimStore::AddPrimvars(const Gprim& g, const FlatInstances* instances, wavefront::InstanceData& data) const {
  std::set<std::string> own;
  for (const PrimvarInput& primvar : g.input.primvars) own.insert(primvar.name);
  if (!g.isMesh)
    for (const PrimvarInput& primvar : g.input.primvars) {
      auto constant = primvar.interpolation == "constant" ? ConstantPrimvar(primvar) : std::nullopt;
      if (constant)
        data.instancePrimvars.push_back(std::move(*constant));
      else
        sink_({Severity::Warning, "primvar-unsupported", g.path,
               "Primvar \"" + primvar.name + "\" is left out: implicit shapes take constant, finite primvars only."});
    }
  if (instances)
    for (const wavefront::PrimvarData& primvar : instances->primvars)
      if (!own.count(primvar.name)) data.instancePrimvars.push_back(primvar);
}

wavefront::InstanceData GprimStore::MakeInstances(const Gprim& g) const {
  wavefront::InstanceData data;
  data.path = g.path;
  data.mesh = g.mesh;
  data.materials = g.bound;
  data.primId = g.primId;
  if (g.instancer.empty()) {
    for (const auto& sample : g.transforms)
      if (!IsFinite(sample.value)) {
        sink_({Severity::Warning, "transform-not-finite", g.path, "Its transform is not finite; it is not drawn."});
        return data;
      }
    data.transforms.push_back(g.transforms);
    data.instanceIds.push_back(-1);
    AddPrimvars(g, nullptr, data);
    ChooseDefault(g, data);
    return data;
  }
  const auto instances = instancers_.Flatten(g.instancer, g.prototype);
  data.transforms = InstanceTransforms(g.transforms, *instances, threads_);
  data.instanceIds = instances->indices;
  AddPrimvars(g, instances.get(), data);
  ChooseDefault(g, data);
  return data;
}

// Prims without a material wear the core's opaque default, unless something on them says displayOpacity.
void GprimStore::ChooseDefault(const Gprim& g, wavefront::InstanceData& data) const {
  if (std::find(data.materials.begin(), data.materials.end(), kInvalidId) == data.materials.end()) return;
  const auto isOpacity = [](const auto& primvar) { return primvar.name == "displayOpacity"; };
  const bool authored = std::any_of(g.input.primvars.begin(), g.input.primvars.end(), isOpacity) ||
                        std::any_of(data.instancePrimvars.begin(), data.instancePrimvars.end(), isOpacity);
  if (!authored) {
    materials_.NeedDefault();
    return;
  }
  for (wavefront::MaterialId& id : data.materials)
    if (id == wavefront::kInvalidId) id = materials_.TranslucentDefault();
}

void GprimStore::UpdateInstances(Gprim& g, const What& what, bool wanted) {
  const bool drawn = wanted && g.mesh != kInvalidId;
  const uint64_t signature = g.instancer.empty() ? 0 : instancers_.Signature(g.instancer, g.prototype);
  if (!drawn) {
    if (g.group != kInvalidId) {
      renderer_.DestroyInstances(g.group);
      g.group = kInvalidId;
    }
    g.instancesDirty = true;
    return;
  }
  const size_t slots = 1 + (g.isMesh ? g.input.topology.subsets.size() : 0);
  if (g.instancesDirty || g.materialVersion != materials_.idVersion() || g.bound.size() != slots) {
    const wavefront::MaterialId own = what.sceneMaterials ? materials_.Id(g.material, g.path) : kInvalidId;
    std::vector<wavefront::MaterialId> bound(slots, own);  // a subset without a binding wears the prim's
    for (size_t i = 1; what.sceneMaterials && i < slots && i <= g.subsetMaterials.size(); ++i)
      if (!g.subsetMaterials[i - 1].empty()) bound[i] = materials_.Id(g.subsetMaterials[i - 1], g.path);
    if (bound != g.bound) {
      g.bound = std::move(bound);
      g.instancesDirty = true;
    }
    g.materialVersion = materials_.idVersion();
  }
  if (signature != g.instancerSignature) g.instancesDirty = true;
  if (!g.instancesDirty) return;
  g.instancesDirty = false;
  g.instancerSignature = signature;
  wavefront::InstanceData data = MakeInstances(g);
  if (data.transforms.empty()) {
    if (g.group != kInvalidId) renderer_.DestroyInstances(g.group);
    g.group = kInvalidId;
    return;
  }
  ++instancesUploaded_;
  if (g.group != kInvalidId)
    renderer_.SetInstances(g.group, std::move(data));
  else
    g.group = renderer_.CreateInstances(std::move(data));
}

void GprimStore::Remove(Gprim& g) {
  if (g.group != kInvalidId) renderer_.DestroyInstances(g.group);
  LetGoOfMesh(g);
}

void GprimStore::Commit(const What& what) {
  UpdateDisplacements(what);
  std::vector<Gprim*> dirty;
  for (auto& [path, gprim] : gprims_)
    if (gprim->geometryDirty && Wanted(*gprim, what)) dirty.push_back(gprim.get());
  BuildGeometry(dirty);
  for (Gprim* gprim : dirty) {  // in order of path: ids do not depend on who was built first
    gprim->geometryDirty = false;
    if (gprim->isMesh || !gprim->displacements.empty())
      UploadMesh(*gprim);
    else
      ShareImplicit(*gprim);
  }
  if (what.sceneMaterials != sceneMaterials_) {
    sceneMaterials_ = what.sceneMaterials;
    for (auto& [path, gprim] : gprims_) gprim->instancesDirty = true;
  }
  for (auto& [path, gprim] : gprims_) UpdateInstances(*gprim, what, Wanted(*gprim, what));
  for (auto& gprim : removed_) Remove(*gprim);
  removed_.clear();
  for (wavefront::MeshId id : garbage_) renderer_.DestroyMesh(id);
  garbage_.clear();
}

}  // namespace delegate
