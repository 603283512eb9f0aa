// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/light.h"

#include <pxr/imaging/hd/instancer.h>
#include <pxr/imaging/hd/sceneDelegate.h>

#include "plugin/hydra/convert_light.h"
#include "plugin/hydra/convert_value.h"
#include "plugin/hydra/instancer.h"
#include "plugin/hydra/render_param.h"

namespace hydra {

void Light::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) {
  RenderParam& param = Param(renderParam);
  const SdfPath& id = GetId();
  const HdDirtyBits bits = *dirtyBits;
  const LightValues values = [&](const TfToken& name) { return sceneDelegate->GetLightParamValue(id, name); };
  delegate::LightUpdate update;
  if (bits & (DirtyParams | DirtyShadowParams | DirtyCollection | DirtyResource)) {
    update.params = ToLightParams(type_, values);
    update.visible = sceneDelegate->GetVisible(id);
    for (const auto& [code, message] : UnsupportedLightInputs(values))
      param.Report(wavefront::Severity::Warning, code, id, message);
  }
  if (bits & (DirtyTransform | DirtyParams))
    update.transforms = {{0, ToMatrix(DomeOffset(values) * sceneDelegate->GetTransform(id))}};
  if (bits & DirtyInstancer) {
    _UpdateInstancer(sceneDelegate, dirtyBits);
    const InstancerLink link = SyncInstancer(*sceneDelegate, param, GetInstancerId(), id);
    update.instancer = link.instancer;
    update.prototype = link.prototype;
  }
  param.Edit(id, std::move(update));
  *dirtyBits = Clean;
}

void Light::Finalize(HdRenderParam* renderParam) {
  Param(renderParam).core().DestroySprim(GetId().GetString());
  Param(renderParam).MarkEdited();
}

void UnsupportedSprim::Sync(HdSceneDelegate*, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) {
  Param(renderParam).Report(wavefront::Severity::Warning, "prim-unsupported", GetId(),
                            "prims of type " + type_.GetString() + " are not rendered yet; it is left out");
  *dirtyBits = 0;
}

}  // namespace hydra
