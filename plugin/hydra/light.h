// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <pxr/imaging/hd/light.h>

#include "plugin/hydra/hd_compat.h"

namespace hydra {

class Light final : public HdLight {
 public:
  Light(const TfToken& type, const SdfPath& id) : HdLight(id), type_(type) {}
  HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }
  void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) override;
  void Finalize(HdRenderParam* renderParam) override;

 private:
  TfToken type_;
};

// Lights, and filters of lights, that the core does not render: one diagnostic, nothing shines.
class UnsupportedSprim final : public HdSprim {
 public:
  UnsupportedSprim(const TfToken& type, const SdfPath& id) : HdSprim(id), type_(type) {}
  HdDirtyBits GetInitialDirtyBitsMask() const override { return HdLight::AllDirty; }
  void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits) override;

 private:
  TfToken type_;
};

}  // namespace hydra
