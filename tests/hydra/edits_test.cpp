// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The edit script through Hd: a render index over our render delegate shows, after each series of edits, the picture
// that a fresh delegate makes of the scene, to the bit.
#include <gtest/gtest.h>
#include <pxr/base/tf/errorMark.h>
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
namespace {

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
  hydra::RenderDelegate renderDelegate{delegate_test::MakeRealDelegate(), {}};
  std::unique_ptr<HdRenderIndex> index{HdRenderIndex::New(&renderDelegate, {})};
  SceneDelegate scene{index.get()};
  HdSink sink{*index, scene};
  std::shared_ptr<RenderTask> task = std::make_shared<RenderTask>(*index);
  HdEngine engine;

  Host() {
    renderDelegate.param().SetTextureLoader([](const delegate::TextureKey& key) {
      return wavefront::Result<wavefront::TextureData>(delegate_test::SceneTexture(key.resolvedPath));
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

void CompareEveryState(uint32_t seed, int edits, bool implicitsAsMeshes) {
  delegate_test::EditScript script(seed);
  Host host;
  host.scene.implicitsAsMeshes = implicitsAsMeshes;
  script.Populate(host.sink);
  host.Execute(script.scene());
  ASSERT_EQ(delegate_test::Difference(host.Finish(), delegate_test::RenderFresh(host.AsSeen(script.scene()))), "");
  for (int i = 1; i <= edits; ++i) {
    const std::string edit = script.Step(host.sink);
    host.Execute(script.scene());
    switch (script.control()) {
      case delegate_test::RenderControl::PauseAndResume:
        host.renderDelegate.Pause();
        EXPECT_TRUE(host.renderDelegate.IsPaused());
        host.renderDelegate.Resume();
        break;
      case delegate_test::RenderControl::StopAndStart:
        host.renderDelegate.Stop();
        EXPECT_TRUE(host.task->IsConverged());
        host.renderDelegate.Restart();
        host.Execute(script.scene());
        break;
      default: break;
    }
    ASSERT_EQ(delegate_test::Difference(host.Finish(), delegate_test::RenderFresh(host.AsSeen(script.scene()))), "")
        << "after edit " << i << ": " << edit;
  }
}

TEST(EditsThroughHd, RandomEditsEqualFreshScenes) { CompareEveryState(11, 200, false); }

// Scene-index mode off: meshes of shapes are drawn as shapes, whatever happens to them.
TEST(EditsThroughHd, MeshesOfShapesEqualTheShapes) { CompareEveryState(12, 50, true); }

TEST(EditsThroughHd, ExecutingAgainDoesNothing) {
  delegate_test::EditScript script(4);
  Host host;
  script.Populate(host.sink);
  host.Execute(script.scene());
  host.Finish();
  const auto& core = host.renderDelegate.param().core();
  const auto commits = core.counters().commits;
  const uint64_t version = core.version();
  // usdview dirties lights in every frame, and re-reads what did not change.
  for (const auto& [path, prim] : script.scene().prims) host.sink.Change(path, prim, delegate_test::kPartAll);
  for (int frame = 0; frame < 3; ++frame) host.Execute(script.scene());
  EXPECT_EQ(core.version(), version);
  EXPECT_LE(core.counters().commits, commits + 1);  // prims that are hidden may ask for one
  EXPECT_TRUE(host.task->IsConverged());
}

TEST(EditsThroughHd, RecreationLeavesNothing) {
  for (int round = 0; round < 20; ++round) {
    delegate_test::EditScript script(static_cast<uint32_t>(round));
    Host host;
    EXPECT_EQ(wavefront::CountLiveObjects().renderers, 1);
    host.renderDelegate.SetRenderSetting(TfToken("wavefront:enableSceneMaterials"), VtValue(round % 10 == 0));
    script.Populate(host.sink);
    if (round % 3 != 1) host.Execute(script.scene());
    if (round % 3 == 2) host.renderDelegate.Pause();  // destroyed while it renders
  }
  EXPECT_EQ(wavefront::CountLiveObjects().handleCount(), 0);
  EXPECT_EQ(wavefront::CountLiveObjects().renderers, 0);
}

}  // namespace
}  // namespace hydra_test
