// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/render_settings.h"

#include "plugin/hydra/convert_settings.h"
#include "plugin/hydra/render_delegate.h"

namespace hydra {

void RenderSettings::_Sync(HdSceneDelegate*, HdRenderParam*, const HdDirtyBits* dirtyBits) {
  if (!IsActive()) return;
  if (*dirtyBits & (DirtyNamespacedSettings | DirtyActive))
    for (const auto& [name, value] : GetNamespacedSettings())
      if (!ToCoreSetting(TfToken(name)).empty()) owner_->SetRenderSetting(TfToken(name), value);
}

}  // namespace hydra
