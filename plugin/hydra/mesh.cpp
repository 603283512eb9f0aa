// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/mesh.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/tokens.h>

#include "plugin/hydra/convert_mesh.h"
#include "plugin/hydra/convert_value.h"
#include "plugin/hydra/implicit_mesh.h"
#include "plugin/hydra/render_param.h"

namespace hydra {
namespace {

bool IsBoundToJoints(HdSceneDelegate& sceneDelegate, const SdfPath& id) {
  static const TfToken jointIndices("skel:jointIndices");
  for (int i = 0; i < HdInterpolationInstance; ++i)
    for (const auto& primvar : sceneDelegate.GetPrimvarDescriptors(id, static_cast<HdInterpolation>(i)))
      if (primvar.name == jointIndices) return true;
  return false;
}

}  // namespace

HdDirtyBits Mesh::GetInitialDirtyBitsMask() const {
  return CommonDirtyBits() | HdChangeTracker::DirtyTopology | HdChangeTracker::DirtySubdivTags |
         HdChangeTracker::DirtyDisplayStyle;
}

void Mesh::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits, const TfToken&) {
  const SdfPath& id = GetId();
  Prologue(sceneDelegate, renderParam, dirtyBits);
  const HdDirtyBits bits = FindShape(*sceneDelegate, Param(renderParam), *dirtyBits);
  *dirtyBits = HdChangeTracker::Clean;
  if (shape_) return SyncShape(*sceneDelegate, Param(renderParam), bits);
  delegate::MeshUpdate update;
  VtValue points;
  ReadCommon(*sceneDelegate, Param(renderParam), *this, bits, update, &points);
  // UsdSkelImaging has had scene indices since 25.05 only.
  if (update.primvars && points.IsEmpty() && IsBoundToJoints(*sceneDelegate, id))
    Param(renderParam).Report(wavefront::Severity::Warning, "skinning-unsupported", id,
                              "this OpenUSD hands over no skinning in scene-index mode; the mesh is drawn in its rest "
                              "pose");
  // Subsets come with the topology and name materials of their own, or wear the prim's.
  if (HdChangeTracker::IsTopologyDirty(bits, id) || bits & HdChangeTracker::DirtySubdivTags ||
      bits & HdChangeTracker::DirtyMaterialId) {
    const HdMeshTopology topology = sceneDelegate->GetMeshTopology(id);
    update.topology = ToTopology(topology, sceneDelegate->GetSubdivTags(id));
    update.subsetMaterials = ToSubsetMaterials(topology, GetMaterialId());
  }
  if (HdChangeTracker::IsPrimvarDirty(bits, id, HdTokens->points) || !points.IsEmpty()) {
    if (points.IsEmpty()) points = sceneDelegate->Get(id, HdTokens->points);
    update.points = {{0, ToFloat3s(points).value_or(std::vector<wavefront::Float3>())}};
  }
  if (HdChangeTracker::IsDisplayStyleDirty(bits, id))
    update.refineLevel = sceneDelegate->GetDisplayStyle(id).refineLevel;
  Param(renderParam).Edit(id, std::move(update));
}

HdDirtyBits Mesh::FindShape(HdSceneDelegate& sceneDelegate, RenderParam& param, HdDirtyBits bits) {
  const SdfPath& id = GetId();
  const bool topologyDirty = HdChangeTracker::IsTopologyDirty(bits, id);
  if (topologyDirty) topologyOf_ = ShapeOfTopology(sceneDelegate.GetMeshTopology(id));
  // An edit of radius or size arrives as dirty points.
  if (!topologyDirty && !HdChangeTracker::IsPrimvarDirty(bits, id, HdTokens->points)) return bits;
  std::optional<delegate::ImplicitInput> shape;
  if (topologyOf_)
    shape = RecognizeImplicit(*topologyOf_, sceneDelegate.Get(id, HdTokens->points),
                              [&](const TfToken& name) { return sceneDelegate.Get(id, name); });
  const bool turned = shape.has_value() != shape_.has_value();
  shape_ = std::move(shape);
  if (!turned) return bits;
  param.core().DestroyRprim(id.GetString());
  return bits | GetInitialDirtyBitsMask();
}

void Mesh::SyncShape(HdSceneDelegate& sceneDelegate, RenderParam& param, HdDirtyBits bits) {
  delegate::ImplicitUpdate update;
  ReadCommon(sceneDelegate, param, *this, bits, update);
  update.shape = shape_;
  param.Edit(GetId(), std::move(update));
}

void Mesh::UpdateRenderTag(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam) {
  if (!shape_) return Rprim<HdMesh, delegate::MeshUpdate>::UpdateRenderTag(sceneDelegate, renderParam);
  HdRprim::UpdateRenderTag(sceneDelegate, renderParam);
  delegate::ImplicitUpdate update;
  update.renderTag = GetRenderTag().GetString();
  Param(renderParam).Edit(GetId(), std::move(update));
}

}  // namespace hydra
