// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// HDWAVEFRONT_CAPTURE: what the core is told through Hydra becomes a scene file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "delegate/capture/compare_scenes.h"
#include "delegate/capture/scene_file.h"
#include "tests/hydra/host.h"

namespace hydra_test {
namespace {

std::string FileName(const char* name) {
  return (std::filesystem::temp_directory_path() / ("hdwavefront_" + std::string(name) + ".hdwscene")).string();
}

delegate::CapturedScene ReadAndRemove(const std::string& file) {
  auto scene = delegate::ReadSceneFile(file);
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  std::filesystem::remove(file);
  return scene.ok() ? std::move(scene).value() : delegate::CapturedScene{};
}

TEST(Capture, ASceneThroughHdIsTheSceneThatTheCoreWasTold) {
  delegate_test::EditScript script(3);
  const std::string through = FileName("through_hd"), straight = FileName("straight");
  Host host(delegate_test::MakeRealDelegate(2, /*captureOnly=*/true));
  host.renderDelegate.param().CaptureTo(through);
  host.renderDelegate.SetRenderSetting(HdRenderSettingsTokens->enableInteractive, VtValue(false));
  script.Populate(host.sink);
  host.Execute(script.scene());
  EXPECT_TRUE(host.task->IsConverged());
  EXPECT_FALSE(host.renderDelegate.param().HasFailed());

  auto core = delegate_test::MakeRealDelegate(2, /*captureOnly=*/true);
  delegate_test::DelegateSink sink(*core);
  const delegate_test::Scene seen = host.AsSeen(script.scene());
  for (const auto& [path, prim] : seen.prims) sink.Insert(path, prim);
  sink.ChangeRender(seen);
  delegate_test::CommitScene(*core);
  ASSERT_TRUE(core->WriteCapture(straight, "straight", "").ok());

  const delegate::CapturedScene scene = ReadAndRemove(through);
  EXPECT_FALSE(scene.instances.empty() || scene.lights.empty() || scene.materials.empty());
  EXPECT_THAT(delegate::CompareScenes(scene, ReadAndRemove(straight)), testing::IsEmpty());
}

TEST(Capture, AFileThatCannotBeWrittenIsAnErrorAndNoHostWaits) {
  delegate_test::EditScript script(3);
  Host host(delegate_test::MakeRealDelegate(2, /*captureOnly=*/true));
  host.renderDelegate.param().CaptureTo("/nonexistent/folder/scene");
  script.Populate(host.sink);
  host.Execute(script.scene());
  EXPECT_TRUE(host.task->IsConverged());
  EXPECT_TRUE(host.renderDelegate.param().HasFailed());
}

}  // namespace
}  // namespace hydra_test
