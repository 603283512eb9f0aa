// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The RenderSettings prim.
#pragma once

#include <pxr/imaging/hd/renderSettings.h>

#include "plugin/hydra/hd_compat.h"

namespace hydra {

class RenderDelegate;

class RenderSettings final : public HdRenderSettings {
 public:
  RenderSettings(const SdfPath& id, RenderDelegate* owner) : HdRenderSettings(id), owner_(owner) {}

 protected:
  void _Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, const HdDirtyBits* dirtyBits) override;

 private:
  RenderDelegate* owner_;
  bool wasActive_ = false;
};

}  // namespace hydra
