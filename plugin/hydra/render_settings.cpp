// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/render_settings.h"

#include <pxr/imaging/hd/changeTracker.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/sceneDelegate.h>
#include <pxr/imaging/hd/tokens.h>

#include "plugin/hydra/convert_settings.h"
#include "plugin/hydra/products.h"
#include "plugin/hydra/render_delegate.h"

namespace hydra {

// Hydra syncs this prim before the Rprims, which ask for their material after it, those of scene indices by this purpose.
// Scene delegates have chosen by the one that they were made with.
void RenderSettings::Bind(HdRenderIndex& index, HdRenderParam* renderParam, const TfToken& purpose) {
  if (purpose == owner_->GetMaterialBindingPurpose()) return;
  const HdSceneIndexPrim self = index.GetTerminalSceneIndex()->GetPrim(GetId());
  if (self.dataSource && self.dataSource->Get(HdSceneIndexEmulationTokens->sceneDelegate)) {
    Param(renderParam).Report(wavefront::Severity::Warning, "render-settings-binding-purpose", GetId(),
                              "materialBindingPurposes asks for '" + purpose.GetString() + "', but this host chose materials for '" +
                                  owner_->GetMaterialBindingPurpose().GetString() +
                                  "' before it knew; with USDIMAGINGGL_ENGINE_ENABLE_SCENE_INDEX=1 the prim counts");
    return;
  }
  owner_->SetMaterialBindingPurpose(purpose);
  for (const SdfPath& id : index.GetRprimIds())
    index.GetChangeTracker().MarkRprimDirty(id, HdChangeTracker::DirtyMaterialId | HdChangeTracker::DirtyTopology);
}

void RenderSettings::SyncPurposes(HdRenderIndex& index, HdRenderParam* renderParam, HdDirtyBits dirtyBits) {
  if (dirtyBits & (DirtyIncludedPurposes | DirtyActive)) {
    IncludedPurposes included = ToIncludedPurposes(GetIncludedPurposes());
    for (const std::string& purpose : included.unknown)
      Param(renderParam).Report(wavefront::Severity::Warning, "render-settings-bad-value", GetId(),
                                "includedPurposes has the unknown '" + purpose + "'; it is ignored");
    owner_->SetIncludedPurposes(GetId(), std::move(included));
  }
  if (dirtyBits & (DirtyMaterialBindingPurposes | DirtyActive) && !GetMaterialBindingPurposes().empty())
    Bind(index, renderParam, ToBindingPurpose(GetMaterialBindingPurposes()));
}

// Removed, or active no more: nothing of it counts.
void RenderSettings::Finalize(HdRenderParam* renderParam) {
  if (!wasActive_) return;
  wasActive_ = false;
  owner_->SetProducts({});
  owner_->SetIncludedPurposes({}, {});
  Bind(*index_, renderParam, HdTokens->full);
}

void RenderSettings::_Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, const HdDirtyBits* dirtyBits) {
  HdRenderIndex& index = sceneDelegate->GetRenderIndex();
  index_ = &index;
  if (!IsActive()) {
    Finalize(renderParam);
    return;
  }
  SyncPurposes(index, renderParam, *dirtyBits);
  if (*dirtyBits & (DirtyRenderProducts | DirtyActive)) {
    ConvertedProducts converted = ToProducts(GetRenderProducts());
    for (const auto& [path, code, text] : converted.messages)
      Param(renderParam).Report(wavefront::Severity::Warning, code, path, text);
    owner_->SetProducts(converted.products);
  }
  wasActive_ = true;
  if (*dirtyBits & (DirtyRenderingColorSpace | DirtyActive))
    if (const TfToken& space = GetRenderingColorSpace(); !space.IsEmpty())
      owner_->SetRenderSetting(TfToken("wavefront:renderingColorSpace"), VtValue(space));
  if (*dirtyBits & (DirtyNamespacedSettings | DirtyActive))
    for (const auto& [name, value] : GetNamespacedSettings())
      if (IsOwnSetting(TfToken(name))) owner_->SetRenderSetting(TfToken(name), value);
}

}  // namespace hydra
