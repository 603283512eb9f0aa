// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Implicit surfaces reach a delegate that supports their types in scene-index mode; without it UsdImaging hands over
// meshes.
#pragma once

#include <pxr/imaging/hd/rprim.h>

#include "plugin/hydra/gprim.h"

namespace hydra {

class Implicit final : public Rprim<HdRprim, delegate::ImplicitUpdate> {
 public:
  Implicit(const TfToken& type, const SdfPath& id) : Rprim<HdRprim, delegate::ImplicitUpdate>(id), type_(type) {}
  HdDirtyBits GetInitialDirtyBitsMask() const override;
  void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
            const TfToken& reprToken) override;
  const TfTokenVector& GetBuiltinPrimvarNames() const override;

 private:
  TfToken type_;
};

// Rprims that the core does not draw: one diagnostic.
class UnsupportedRprim final : public HdRprim {
 public:
  UnsupportedRprim(const TfToken& type, const SdfPath& id) : HdRprim(id), type_(type) {}
  HdDirtyBits GetInitialDirtyBitsMask() const override;
  void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
            const TfToken& reprToken) override;
  const TfTokenVector& GetBuiltinPrimvarNames() const override;

 protected:
  HdDirtyBits _PropagateDirtyBits(HdDirtyBits bits) const override { return bits; }
  void _InitRepr(const TfToken&, HdDirtyBits*) override {}

 private:
  TfToken type_;
};

}  // namespace hydra
