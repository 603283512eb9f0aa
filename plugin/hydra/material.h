// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <pxr/imaging/hd/material.h>

#include "plugin/hydra/hd_compat.h"

namespace hydra {

class Material final : public HdMaterial {
 public:
  explicit Material(const SdfPath& id) : HdMaterial(id) {}
  HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }
  void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) override;
  void Finalize(HdRenderParam* renderParam) override;
};

}  // namespace hydra
