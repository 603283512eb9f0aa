// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The scene of an edit script (tests/delegate/edit_script.h) told through Hd: a scene delegate that answers from it,
// and an EditSink that inserts, dirties and removes prims of a render index.
#pragma once

#include <map>
#include <set>
#include <string>

#include <pxr/imaging/hd/sceneDelegate.h>

#include "plugin/hydra/hd_compat.h"
#include "tests/delegate/edit_script.h"

namespace hydra_test {

PXR_NAMESPACE_USING_DIRECTIVE

class SceneDelegate final : public HdSceneDelegate {
 public:
  explicit SceneDelegate(HdRenderIndex* index) : HdSceneDelegate(index, SdfPath::AbsoluteRootPath()) {}
  std::map<std::string, delegate_test::ScenePrim> prims;
  bool implicitsAsMeshes = false;  // as UsdImaging hands them over with scene-index mode off

  // Rprims
  HdMeshTopology GetMeshTopology(const SdfPath& id) override;
  PxOsdSubdivTags GetSubdivTags(const SdfPath& id) override;
  HdDisplayStyle GetDisplayStyle(const SdfPath& id) override;
  bool GetDoubleSided(const SdfPath& id) override;
  TfToken GetRenderTag(const SdfPath& id) override;
  SdfPath GetMaterialId(const SdfPath& id) override;
  // Instancers
  VtIntArray GetInstanceIndices(const SdfPath& instancer, const SdfPath& prototype) override;
  SdfPathVector GetInstancerPrototypes(const SdfPath& id) override;
  GfMatrix4d GetInstancerTransform(const SdfPath& id) override { return GetTransform(id); }
  SdfPath GetInstancerId(const SdfPath& id) override;
  // Sprims
  VtValue GetMaterialResource(const SdfPath& id) override;
  VtValue GetLightParamValue(const SdfPath& id, const TfToken& name) override;
  VtValue GetCameraParamValue(const SdfPath& id, const TfToken& name) override;
  // All of them
  GfMatrix4d GetTransform(const SdfPath& id) override;
  bool GetVisible(const SdfPath& id) override;
  HdPrimvarDescriptorVector GetPrimvarDescriptors(const SdfPath& id, HdInterpolation interpolation) override;
  VtValue GetIndexedPrimvar(const SdfPath& id, const TfToken& key, VtIntArray* indices) override;
  VtValue Get(const SdfPath& id, const TfToken& key) override;

 private:
  const delegate_test::ScenePrim* Find(const SdfPath& id) const;
  const delegate::GprimUpdate* Gprim(const SdfPath& id) const;
  const std::vector<delegate::PrimvarInput>& Primvars(const SdfPath& id) const;
};

class HdSink final : public delegate_test::EditSink {
 public:
  HdSink(HdRenderIndex& index, SceneDelegate& scene) : index_(index), scene_(scene) {}
  void Insert(const std::string& path, const delegate_test::ScenePrim& prim) override;
  void Change(const std::string& path, const delegate_test::ScenePrim& prim, uint32_t parts) override;
  void Remove(const std::string& path, const delegate_test::ScenePrim& prim) override;
  void ChangeRender(const delegate_test::Scene& scene) override;

 private:
  HdRenderIndex& index_;
  SceneDelegate& scene_;
};

}  // namespace hydra_test
