// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// A host of Hydra over our render delegate: a render index, a scene delegate, a task, an engine.
#pragma once

#include <gtest/gtest.h>
#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/engine.h>
#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/renderPass.h>
#include <pxr/imaging/hd/renderPassState.h>
#include <pxr/imaging/hd/rprim.h>
#include <pxr/imaging/hd/rprimCollection.h>
#include <pxr/imaging/hd/task.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "plugin/hydra/render_delegate.h"
#include "tests/delegate/edit_driver.h"
#include "tests/hydra/scene_delegate.h"

namespace hydra_test {

// What a host's render task does.
class RenderTask final : public HdTask {
 public:
  explicit RenderTask(HdRenderIndex& index)
      : HdTask(SdfPath("/task")),
        pass_(index.GetRenderDelegate()->CreateRenderPass(
            &index, HdRprimCollection(HdTokens->geometry, HdReprSelector(HdReprTokens->hull)))),
        state_(index.GetRenderDelegate()->CreateRenderPassState()) {}
  void Sync(HdSceneDelegate*, HdTaskContext*, HdDirtyBits* dirtyBits) override {
    pass_->Sync();
    *dirtyBits = 0;
  }
  void Prepare(HdTaskContext*, HdRenderIndex*) override {}
  void Execute(HdTaskContext*) override { pass_->Execute(state_, tags_); }
  const TfTokenVector& GetRenderTags() const override { return tags_; }
  HdRenderPassState& state() { return *state_; }
  bool IsConverged() const { return pass_->IsConverged(); }

 private:
  TfTokenVector tags_{HdRenderTagTokens->geometry, HdRenderTagTokens->render};
  HdRenderPassSharedPtr pass_;
  HdRenderPassStateSharedPtr state_;
};

struct Host {
  hydra::RenderDelegate renderDelegate;
  std::unique_ptr<HdRenderIndex> index{HdRenderIndex::New(&renderDelegate, {})};
  SceneDelegate scene{index.get()};
  HdSink sink{*index, scene};
  std::shared_ptr<RenderTask> task = std::make_shared<RenderTask>(*index);
  HdEngine engine;

  explicit Host(std::unique_ptr<delegate::RenderDelegate> core = delegate_test::MakeRealDelegate())
      : renderDelegate(std::move(core), {}) {
    renderDelegate.param().SetTextureDecoder([](const std::string& path) {
      return wavefront::Result<hydra::TextureConverter>([path](const delegate::TextureKey&) {
        return wavefront::Result<wavefront::TextureData>(delegate_test::SceneTexture(path));
      });
    });
  }
  ~Host() { task.reset(); }

  void Execute(const delegate_test::Scene& wanted) {
    const auto* camera =
        static_cast<const HdCamera*>(index->GetSprim(HdPrimTypeTokens->camera, SdfPath(wanted.camera)));
    task->state().SetCamera(camera);
    task->state().SetFraming(CameraUtilFraming(
        GfRect2i(GfVec2i(0), static_cast<int>(wanted.width), static_cast<int>(wanted.height))));
    HdRenderPassAovBindingVector bindings;
    for (const std::string& token : wanted.aovs) bindings.emplace_back().aovName = TfToken(token);
    task->state().SetAovBindings(bindings);
    HdTaskSharedPtrVector tasks{task};
    engine.Execute(index.get(), &tasks);
  }

  wavefront::RawFilm Finish() {
    while (!task->IsConverged()) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    EXPECT_FALSE(renderDelegate.param().HasFailed());
    auto film = renderDelegate.param().core().ReadFilm();
    EXPECT_TRUE(film.ok());
    return film.ok() ? std::move(film).value() : wavefront::RawFilm{};
  }

  // The scene as Hd shows it: AOVs in the order in which the pass asks, ids as the index gives them out, instances by
  // prototype.
  delegate_test::Scene AsSeen(delegate_test::Scene wanted) {
    std::map<std::string, std::map<int32_t, std::vector<int32_t>>> drawn;
    for (const auto& [path, prim] : wanted.prims) {
      const auto [instancer, prototype] = prim.drawnBy();
      if (instancer.empty()) continue;
      const VtIntArray indices = scene.GetInstanceIndices(SdfPath(instancer), SdfPath(path));
      drawn[instancer][prototype].assign(indices.cbegin(), indices.cend());
    }
    for (auto& [path, prototypes] : drawn)
      if (const auto found = wanted.prims.find(path); found != wanted.prims.end())
        found->second.instancer.prototypeInstances = std::move(prototypes);
    std::sort(wanted.aovs.begin(), wanted.aovs.end());
    wanted.aovs.erase(std::unique(wanted.aovs.begin(), wanted.aovs.end()), wanted.aovs.end());
    for (auto& [path, prim] : wanted.prims)
      if (const HdRprim* rprim = index->GetRprim(SdfPath(path))) prim.gprim().primId = rprim->GetPrimId();
    return wanted;
  }
};

}  // namespace hydra_test
