// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <pxr/imaging/hd/camera.h>

#include "delegate/prims/camera.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

class Camera final : public HdCamera {
 public:
  explicit Camera(const SdfPath& id) : HdCamera(id) {}
  void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) override;
  void Finalize(HdRenderParam* renderParam) override;
  const delegate::CameraParams& params() const { return params_; }  // as of the last Sync

 private:
  delegate::CameraParams params_;
};

}  // namespace hydra
