// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Every row of settings.def acts: a row that reaches nobody would be a flag that does nothing.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "delegate/prims/same.h"
#include "tests/delegate/fakes.h"

namespace {

using delegate::SettingInfo;
using delegate::SettingType;
using delegate::SettingValue;

SettingValue Another(const SettingInfo& info) {
  switch (info.type) {
    case SettingType::Bool: return !std::get<bool>(info.defaultValue);
    case SettingType::Int: return std::get<int64_t>(info.defaultValue) + 1;
    case SettingType::Float: return std::get<double>(info.defaultValue) + 0.5;
    case SettingType::Token: return delegate::ChoicesOf(info).back();
  }
  return false;
}

// What the core is told once the row has its other value; null: all are as they are by default.
wavefront::RenderSettings Told(const SettingInfo* info) {
  delegate_test::Fixture f;
  f.Commit();
  if (info) {
    EXPECT_TRUE(f.delegate->SetRenderSetting(std::string(info->token), Another(*info)).value()) << info->token;
    f.Commit();
  }
  return *f.renderer->settings;
}

TEST(RenderSettings, EveryRowReachesTheCore) {
  // These act in the delegate: see LightsAreRepeatedByInstancersAndSwitchedOff, testenv/Settings.Switches, Media.Wax and
  // displacement_test.cpp; and below.
  const std::set<std::string_view> own{"enableSceneMaterials", "enableSceneLights", "subsurfaceRandomWalk",
                                       "displacementTriangles", "frame", "time"};
  const wavefront::RenderSettings before = Told(nullptr);
  std::vector<wavefront::RenderSettings> seen;
  for (const SettingInfo& info : delegate::RenderSettingInfos()) {
    const wavefront::RenderSettings after = Told(&info);
    EXPECT_EQ(delegate::Same(before, after), own.count(info.token) == 1) << info.token;
    if (own.count(info.token)) continue;
    for (const wavefront::RenderSettings& other : seen)  // no two rows move the same member
      EXPECT_FALSE(delegate::Same(other, after)) << info.token;
    seen.push_back(after);
  }
}

TEST(RenderSettings, FrameAndTimeReachTheCoreOnceAMaterialAsksForThem) {
  delegate_test::Fixture f;
  const auto told = [&](double frame) {
    EXPECT_TRUE(f.delegate->SetRenderSetting("frame", frame).value());
    EXPECT_TRUE(f.delegate->SetRenderSetting("time", frame / 24).value());
    f.Commit();
    return std::pair(f.renderer->settings->frame, f.renderer->settings->time);
  };
  f.delegate->Sync("/still", delegate::MaterialUpdate{{{"", delegate_test::Network("/still", "surface")}}});
  EXPECT_EQ(told(12), std::pair(wavefront::RenderSettings().frame, wavefront::RenderSettings().time));
  const uint64_t version = f.delegate->version();
  told(24);
  EXPECT_EQ(f.delegate->version(), version);  // nothing restarts
  f.delegate->Sync("/moving", delegate::MaterialUpdate{{{"", delegate_test::Network("/moving", "frame")}}});
  f.Commit();
  EXPECT_EQ(f.renderer->settings->frame, 24);
  EXPECT_EQ(told(48), std::pair(48.0f, 2.0f));
  EXPECT_GT(f.delegate->version(), version);
}

TEST(RenderSettings, RowsReachTheCoreAndBumpTheVersionOnChange) {
  delegate_test::Fixture f;
  const uint32_t version = f.delegate->GetRenderSettingsVersion();
  EXPECT_FALSE(f.delegate->SetRenderSetting("samples", int64_t{64}).value());
  EXPECT_EQ(f.delegate->GetRenderSettingsVersion(), version);
  EXPECT_TRUE(f.delegate->SetRenderSetting("convergedSamplesPerPixel", int64_t{7}).value());
  EXPECT_TRUE(f.delegate->SetRenderSetting("maxBounces", 3.0).value());
  EXPECT_TRUE(f.delegate->SetRenderSetting("enableShadows", int64_t{0}).value());
  EXPECT_EQ(f.delegate->GetRenderSettingsVersion(), version + 3);
  EXPECT_FALSE(f.delegate->SetRenderSetting("nonsense", int64_t{1}).ok());
  EXPECT_FALSE(f.delegate->SetRenderSetting("samples", int64_t{0}).ok());
  EXPECT_FALSE(f.delegate->SetRenderSetting("samples", 1.5).ok());
  EXPECT_FALSE(f.delegate->SetRenderSetting("samples", true).ok());
  EXPECT_FALSE(f.delegate->SetRenderSetting("radianceClamp", std::nan("")).ok());
  f.Commit();
  EXPECT_EQ(f.renderer->settings->samples, 7u);
  EXPECT_EQ(f.renderer->settings->maxBounces, 3u);
  EXPECT_FALSE(f.renderer->settings->shadows);
  EXPECT_EQ(f.renderer->settings->width, 64u);
  std::set<std::string_view> tokens;
  for (const auto& info : delegate::RenderSettingInfos()) {
    EXPECT_TRUE(tokens.insert(info.token).second);
    EXPECT_FALSE(info.doc.empty());
  }
}

}  // namespace
