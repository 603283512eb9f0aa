// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Meshes, and the meshes that UsdImaging makes of implicit shapes.
#pragma once

#include <optional>

#include <pxr/imaging/hd/mesh.h>

#include "delegate/mesh/implicit.h"
#include "plugin/hydra/gprim.h"

namespace hydra {

class Mesh final : public Rprim<HdMesh, delegate::MeshUpdate> {
 public:
  explicit Mesh(const SdfPath& id) : Rprim<HdMesh, delegate::MeshUpdate>(id) {}
  HdDirtyBits GetInitialDirtyBitsMask() const override;
  void Sync(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam, HdDirtyBits* dirtyBits,
            const TfToken& reprToken) override;
  void UpdateRenderTag(HdSceneDelegate* sceneDelegate, HdRenderParam* renderParam) override;

 private:
  // Looks again whether this is a shape. What must be read: all, where it turned into one or back.
  HdDirtyBits FindShape(HdSceneDelegate& sceneDelegate, RenderParam& param, HdDirtyBits bits);
  void SyncShape(HdSceneDelegate& sceneDelegate, RenderParam& param, HdDirtyBits bits);

  // UsdImaging's mesh of an implicit shape (implicit_mesh.h): the core draws the shape.
  std::optional<delegate::ImplicitShape> topologyOf_;  // what the topology alone says
  std::optional<delegate::ImplicitInput> shape_;
};

}  // namespace hydra
