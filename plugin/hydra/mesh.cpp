// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/mesh.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/tokens.h>

#include "plugin/hydra/convert_mesh.h"
#include "plugin/hydra/convert_value.h"
#include "plugin/hydra/render_param.h"

namespace hydra {

HdDirtyBits Mesh::GetInitialDirtyBitsMask() const {
  return CommonDirtyBits() | HdChangeTracker::DirtyTopology | HdChangeTracker::DirtySubdivTags |
         HdChangeTracker::DirtyDisplayStyle;
}

void Mesh::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits, const TfToken&) {
  const SdfPath& id = GetId();
  const HdDirtyBits bits = *dirtyBits;
  Prologue(sceneDelegate, renderParam, dirtyBits);
  delegate::MeshUpdate update;
  VtValue points;
  ReadCommon(*sceneDelegate, Param(renderParam), *this, bits, update, &points);
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
  *dirtyBits = HdChangeTracker::Clean;
}

}  // namespace hydra
