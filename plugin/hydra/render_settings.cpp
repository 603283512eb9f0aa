// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/render_settings.h"

#include "plugin/hydra/convert_settings.h"
#include "plugin/hydra/products.h"
#include "plugin/hydra/render_delegate.h"

namespace hydra {

void RenderSettings::_Sync(HdSceneDelegate*, HdRenderParam* renderParam, const HdDirtyBits* dirtyBits) {
  if (!IsActive()) {
    if (wasActive_) owner_->SetProducts({});
    wasActive_ = false;
    return;
  }
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
