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
  void Finalize(HdRenderParam* renderParam) override;

 protected:
  void _Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, const HdDirtyBits* dirtyBits) override;

 private:
  void SyncPurposes(HdRenderIndex& index, HdRenderParam* renderParam, HdDirtyBits dirtyBits);
  void Bind(HdRenderIndex& index, HdRenderParam* renderParam, const TfToken& purpose);

  RenderDelegate* owner_;
  HdRenderIndex* index_ = nullptr;  // that synced it
  bool wasActive_ = false;
};

}  // namespace hydra
