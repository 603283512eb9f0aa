// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The edit script through Hd: a render index over our render delegate shows, after each series of edits, the picture
// that a fresh delegate makes of the scene, to the bit.
#include <gtest/gtest.h>

#include "tests/delegate/edit_driver.h"
#include "tests/hydra/host.h"

namespace hydra_test {
namespace {

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
