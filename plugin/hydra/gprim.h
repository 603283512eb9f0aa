// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What all Rprims read from Hydra in the same way.
#pragma once

#include <pxr/imaging/hd/rprim.h>
#include <pxr/imaging/hd/sceneDelegate.h>

#include "delegate/prims/gprim.h"
#include "plugin/hydra/hd_compat.h"

namespace hydra {

class RenderParam;

// The bits that every Rprim asks for first.
HdDirtyBits CommonDirtyBits();

// What is dirty of the common part, but for what HdRprim's protected methods read (Prologue of the classes). The
// results of computations (skinning) count as primvars; `points`, where not null, takes those.
void ReadCommon(HdSceneDelegate& sceneDelegate, RenderParam& param, const HdRprim& rprim, HdDirtyBits bits,
                delegate::GprimUpdate& update, VtValue* points = nullptr);

// An Rprim that asks the scene for what changed and tells the core by `Update`. Base of the types that the core draws.
template <typename Base, typename Update>
class Rprim : public Base {
 public:
  using Base::Base;
  void Finalize(HdRenderParam* renderParam) override;
  // Hydra asks this of all prims, also of those that it does not sync because of their tag.
  void UpdateRenderTag(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam) override;

 protected:
  HdDirtyBits _PropagateDirtyBits(HdDirtyBits bits) const override { return bits; }
  // The core draws one representation, whatever the host asks for.
  void _InitRepr(const TfToken&, HdDirtyBits*) override {}
  // Reads what HdRprim keeps: instancer, visibility, material.
  void Prologue(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits);
};

}  // namespace hydra
