// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/material.h"

#include <pxr/imaging/hd/sceneDelegate.h>

#include "plugin/hydra/convert_material.h"
#include "plugin/hydra/render_param.h"

namespace hydra {

void Material::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) {
  // Some hosts dirty parameters with bits of their own: any of them means to look again. The core compares.
  const VtValue resource = sceneDelegate->GetMaterialResource(GetId());
  // By reference, never copied: newer versions of OpenUSD append members.
  static const HdMaterialNetworkMap none;
  const HdMaterialNetworkMap& networks =
      resource.IsHolding<HdMaterialNetworkMap>() ? resource.UncheckedGet<HdMaterialNetworkMap>() : none;
  ConvertedMaterial material = ToMaterial(GetId(), networks);
  for (const auto& [code, message] : material.messages)
    Param(renderParam).Report(wavefront::Severity::Warning, code, GetId(), message);
  Param(renderParam).Edit(GetId(), std::move(material.update));
  *dirtyBits = Clean;
}

void Material::Finalize(HdRenderParam* renderParam) {
  Param(renderParam).core().DestroySprim(GetId().GetString());
  Param(renderParam).MarkEdited();
}

}  // namespace hydra
