// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Drives a real render delegate (wavefront on the device that is there, MaterialX's library) by an edit script.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "tests/delegate/edit_script.h"

namespace delegate_test {

// Sends each update through Hydra's calls: Create, Sync of what is dirty, Destroy.
class DelegateSink : public EditSink {
 public:
  explicit DelegateSink(delegate::RenderDelegate& target) : target_(target) {}

  void Insert(const std::string& path, const ScenePrim& prim) override {
    switch (prim.kind) {
      case PrimKind::Mesh:
      case PrimKind::Implicit: EXPECT_TRUE(target_.CreateRprim(prim.type, path).ok()) << path; break;
      case PrimKind::Instancer: target_.CreateInstancer(path); break;
      default: EXPECT_TRUE(target_.CreateSprim(prim.type, path).ok()) << path;
    }
    Change(path, prim, kPartAll);
  }

  void Change(const std::string& path, const ScenePrim& prim, uint32_t parts) override {
    switch (prim.kind) {
      case PrimKind::Mesh: {
        delegate::MeshUpdate update = prim.mesh;
        Trim(update, parts);
        if (!(parts & kPartPoints)) update.points.reset();
        if (!(parts & kPartTopology)) update.topology.reset();
        if (!(parts & (kPartMaterial | kPartTopology))) update.subsetMaterials.reset();
        if (!(parts & kPartRefine)) update.refineLevel.reset();
        target_.Sync(path, std::move(update));
        break;
      }
      case PrimKind::Implicit: {
        delegate::ImplicitUpdate update = prim.implicit;
        Trim(update, parts);
        if (!(parts & kPartShape)) update.shape.reset();
        target_.Sync(path, std::move(update));
        break;
      }
      case PrimKind::Instancer: {
        delegate::InstancerUpdate update = prim.instancer;
        if (!(parts & kPartInstances)) {
          update.transforms.reset();
          update.positions.reset();
          update.orientations.reset();
          update.scales.reset();
          update.protoIndices.reset();
          update.ids.reset();
          update.invisibleIds.reset();
        }
        if (!(parts & kPartPrimvars)) update.primvars.reset();
        if (!(parts & kPartTransform)) update.transform.reset();
        if (!(parts & kPartVisibility)) update.visible.reset();
        if (parts != kPartAll) update.parent.reset(), update.parentPrototype.reset();
        target_.Sync(path, std::move(update));
        break;
      }
      case PrimKind::Light: {
        delegate::LightUpdate update = prim.light;
        if (!(parts & kPartParams)) update.params.reset();
        if (!(parts & kPartTransform)) update.transforms.reset();
        if (!(parts & kPartVisibility)) update.visible.reset();
        if (parts != kPartAll) update.instancer.reset(), update.prototype.reset();
        target_.Sync(path, std::move(update));
        break;
      }
      case PrimKind::Camera: {
        delegate::CameraUpdate update = prim.camera;
        if (!(parts & kPartParams)) update.params.reset();
        if (!(parts & kPartTransform)) update.transforms.reset();
        target_.Sync(path, std::move(update));
        break;
      }
      case PrimKind::Material:
        if (parts & kPartNetwork) target_.Sync(path, prim.material);
        break;
    }
  }

  void Remove(const std::string& path, const ScenePrim& prim) override {
    switch (prim.kind) {
      case PrimKind::Mesh:
      case PrimKind::Implicit: target_.DestroyRprim(path); break;
      case PrimKind::Instancer: target_.DestroyInstancer(path); break;
      default: target_.DestroySprim(path);
    }
  }

  void ChangeRender(const Scene& scene) override {
    delegate::RenderPassUpdate pass;
    pass.camera = scene.camera;
    pass.width = scene.width;
    pass.height = scene.height;
    auto selection = wavefront::SelectAovs(scene.aovs);
    ASSERT_TRUE(selection.ok()) << selection.error().message;
    pass.aovs = selection->aovs;
    pass.primvarAovs = selection->primvars;
    const auto status = target_.SetRenderPass(pass);
    EXPECT_TRUE(status.ok()) << status.error().message;
    for (const auto& [token, value] : scene.settings) EXPECT_TRUE(target_.SetRenderSetting(token, value).ok()) << token;
  }

 private:
  static void Trim(delegate::GprimUpdate& update, uint32_t parts) {
    if (!(parts & kPartPrimvars)) update.primvars.reset();
    if (!(parts & kPartTransform)) update.transforms.reset();
    if (!(parts & kPartMaterial)) update.material.reset();
    if (!(parts & kPartVisibility)) update.visible.reset();
    if (!(parts & kPartRenderTag)) update.renderTag.reset();
    if (!(parts & kPartSides)) update.doubleSided.reset();
    if (parts != kPartAll) update.instancer.reset(), update.prototype.reset(), update.primId.reset();
  }
  delegate::RenderDelegate& target_;
};

// A real delegate. Fails the test and ends the program where there is no device: nothing here can be tested then.
inline std::unique_ptr<delegate::RenderDelegate> MakeRealDelegate(uint32_t threads = 2, bool captureOnly = false) {
  delegate::RenderDelegateOptions options;
  options.materialxLibraries = HDWAVEFRONT_MATERIALX_LIBRARIES;
  options.threads = threads;
  options.captureOnly = captureOnly;
  auto made = delegate::RenderDelegate::Create(options);
  if (!made) {
    ADD_FAILURE() << made.error().message;
    std::abort();
  }
  return std::move(made).value();
}

// What a host does before it starts a render.
inline void CommitScene(delegate::RenderDelegate& d) {
  for (const delegate::TextureLoadRequest& request : d.PendingTextures())
    EXPECT_TRUE(d.SetTexture(request.key, SceneTexture(request.texture.resolvedPath)).ok());
  const auto status = d.CommitResources();
  EXPECT_TRUE(status.ok()) << status.error().message;
}

inline wavefront::RawFilm FinishRender(delegate::RenderDelegate& d) {
  const auto started = d.Start();
  EXPECT_TRUE(started.ok()) << started.error().message;
  EXPECT_TRUE(d.WaitUntilDone(120));
  EXPECT_TRUE(d.status().ok()) << d.status().error().message;
  EXPECT_TRUE(d.IsConverged());
  EXPECT_EQ(d.stats().errorFlags, 0u);
  auto film = d.ReadFilm();
  EXPECT_TRUE(film.ok()) << film.error().message;
  return film.ok() ? std::move(film).value() : wavefront::RawFilm{};
}

// The scene as a delegate shows it that never saw anything else.
inline wavefront::RawFilm RenderFresh(const Scene& scene) {
  auto fresh = MakeRealDelegate();
  DelegateSink sink(*fresh);
  for (const auto& [path, prim] : scene.prims) sink.Insert(path, prim);
  sink.ChangeRender(scene);
  CommitScene(*fresh);
  return FinishRender(*fresh);
}

// Empty where equal to the bit; else which AOVs differ in how many words.
inline std::string Difference(const wavefront::RawFilm& a, const wavefront::RawFilm& b) {
  if (a.width != b.width || a.height != b.height || a.aovs != b.aovs || a.primvarAovs != b.primvarAovs) return "films of different make";
  if (a.sums == b.sums && a.first == b.first) return "";
  std::string all;
  for (const wavefront::AovInfo& info : wavefront::Aovs()) {
    const auto left = wavefront::ResolveFilm(a, info.aov), right = wavefront::ResolveFilm(b, info.aov);
    size_t words = 0;
    for (size_t i = 0; i < left.bits.size(); ++i) words += left.bits[i] != right.bits[i];
    if (words) all += std::string(info.token) + ": " + std::to_string(words) + " of " + std::to_string(left.bits.size()) + " words; ";
  }
  return all.empty() ? "sums that resolve to the same values" : all;
}

}  // namespace delegate_test
