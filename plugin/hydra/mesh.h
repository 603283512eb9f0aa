// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#pragma once

#include <pxr/imaging/hd/mesh.h>

#include "plugin/hydra/gprim.h"

namespace hydra {

class Mesh final : public Rprim<HdMesh, delegate::MeshUpdate> {
 public:
  explicit Mesh(const SdfPath& id) : Rprim<HdMesh, delegate::MeshUpdate>(id) {}
  HdDirtyBits GetInitialDirtyBitsMask() const override;
  void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
            const TfToken& reprToken) override;
};

}  // namespace hydra
