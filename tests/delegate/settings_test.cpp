// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Every row of settings.def acts: a row that reaches nobody would be a flag that does nothing.
#include <gtest/gtest.h>

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
  // displacement_test.cpp.
  const std::set<std::string_view> own{"enableSceneMaterials", "enableSceneLights", "subsurfaceRandomWalk",
                                             "displacementTriangles"};
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

}  // namespace
