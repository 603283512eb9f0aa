// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "plugin/hydra/camera.h"

#include <pxr/imaging/hd/sceneDelegate.h>

#include "plugin/hydra/convert_camera.h"
#include "plugin/hydra/convert_value.h"
#include "plugin/hydra/render_param.h"

namespace hydra {

void Camera::Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) {
  const HdDirtyBits bits = *dirtyBits;
  HdCamera::Sync(sceneDelegate, renderParam, dirtyBits);
  delegate::CameraUpdate update;
  if (bits & (DirtyParams | DirtyClipPlanes))
    update.params = params_ = ToCameraParams(
        *this, [&](const TfToken& name) { return sceneDelegate->GetCameraParamValue(GetId(), name); });
  if (bits & DirtyTransform) update.transforms = {{0, ToMatrix(GetTransform())}};
  if (update.params || update.transforms) Param(renderParam).Edit(GetId(), std::move(update));
  *dirtyBits = Clean;
}

void Camera::Finalize(HdRenderParam* renderParam) {
  Param(renderParam).core().DestroySprim(GetId().GetString());
  Param(renderParam).MarkEdited();
}

}  // namespace hydra
