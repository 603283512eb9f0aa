// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/implicit.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/sceneIndex.h>

#include "plugin/hydra/convert_mesh.h"
#include "plugin/hydra/render_param.h"

namespace hydra {
namespace {

// The attributes stand in a container named as the prim's type. Scene delegates have no query for them.
HdContainerDataSourceHandle ShapeSource(const HdSceneDelegate& sceneDelegate, const SdfPath& id, const TfToken& type) {
  const HdSceneIndexBaseRefPtr scene =
      const_cast<HdSceneDelegate&>(sceneDelegate).GetRenderIndex().GetTerminalSceneIndex();
  if (!scene) return nullptr;
  const HdSceneIndexPrim prim = scene->GetPrim(id);
  return prim.dataSource ? HdContainerDataSource::Cast(prim.dataSource->Get(type)) : nullptr;
}

}  // namespace

HdDirtyBits Implicit::GetInitialDirtyBitsMask() const {
  return CommonDirtyBits() | HdChangeTracker::DirtyTopology;
}

const TfTokenVector& Implicit::GetBuiltinPrimvarNames() const {
  static const TfTokenVector none;
  return none;
}

void Implicit::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
                    const TfToken&) {
  const SdfPath& id = GetId();
  const HdDirtyBits bits = *dirtyBits;
  Prologue(sceneDelegate, renderParam, dirtyBits);
  delegate::ImplicitUpdate update;
  ReadCommon(*sceneDelegate, Param(renderParam), *this, bits, update);
  // An edit of radius or size arrives as dirty primvars: the emulation knows no bit for it.
  if (bits & (HdChangeTracker::DirtyTopology | HdChangeTracker::DirtyPrimvar | HdChangeTracker::DirtyPoints)) {
    const HdContainerDataSourceHandle source = ShapeSource(*sceneDelegate, id, type_);
    update.shape = ToImplicit(*ToImplicitShape(type_), [&](const TfToken& name) {
      const auto sampled = source ? HdSampledDataSource::Cast(source->Get(name)) : nullptr;
      return sampled ? sampled->GetValue(0) : sceneDelegate->Get(id, name);
    });
  }
  Param(renderParam).Edit(id, std::move(update));
  *dirtyBits = HdChangeTracker::Clean;
}

HdDirtyBits UnsupportedRprim::GetInitialDirtyBitsMask() const { return HdChangeTracker::AllSceneDirtyBits; }

const TfTokenVector& UnsupportedRprim::GetBuiltinPrimvarNames() const {
  static const TfTokenVector none;
  return none;
}

void UnsupportedRprim::Sync(HdSceneDelegate*, HdRenderParam* renderParam, HdDirtyBits* dirtyBits, const TfToken&) {
  Param(renderParam).Report(wavefront::Severity::Warning, "prim-unsupported", GetId(),
                            "prims of type " + type_.GetString() + " are not rendered yet; it is left out");
  *dirtyBits = HdChangeTracker::Clean;
}

}  // namespace hydra
