// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/render_vars.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "wavefront/film.h"

namespace delegate {
namespace {

using testing::ElementsAre;

TEST(RenderVars, NamesOfOthersAndOurOwn) {
  EXPECT_EQ(AovTokenOfVar("Ci", "raw"), "color");
  EXPECT_EQ(AovTokenOfVar("lpe:C.*[LO]", "raw"), "color");
  EXPECT_EQ(AovTokenOfVar("Camera Depth", "raw"), "cameraDepth");
  EXPECT_EQ(AovTokenOfVar("z", ""), "cameraDepth");
  EXPECT_EQ(AovTokenOfVar("unheardOf", "raw"), "");
  for (const wavefront::AovInfo& aov : wavefront::Aovs()) {
    if (wavefront::IsPrimvarAov(aov.aov)) continue;
    EXPECT_EQ(AovTokenOfVar(std::string(aov.token), "raw"), aov.token);
  }
}

TEST(RenderVars, Primvars) {
  EXPECT_EQ(AovTokenOfVar("st", "primvar"), "primvars:st");
  EXPECT_EQ(AovTokenOfVar("primvars:st", "primvar"), "primvars:st");
  EXPECT_EQ(AovTokenOfVar("primvars:st", "raw"), "primvars:st");
  EXPECT_EQ(AovTokenOfVar("primvars:", "raw"), "");
  EXPECT_EQ(AovTokenOfVar("", "primvar"), "");
  EXPECT_EQ(AovTokenOfVar("primvars:#0", "raw"), "primvars:#0");  // a name like any other
}

TEST(RenderVars, ChannelsOfEveryAov) {
  EXPECT_THAT(AovChannels("color"), ElementsAre("R", "G", "B", "A"));
  EXPECT_THAT(AovChannels("albedo"), ElementsAre("albedo.R", "albedo.G", "albedo.B"));
  EXPECT_THAT(AovChannels("normal"), ElementsAre("normal.X", "normal.Y", "normal.Z"));
  EXPECT_THAT(AovChannels("depth"), ElementsAre("depth.Z"));
  EXPECT_THAT(AovChannels("primId"), ElementsAre("primId.id"));
  EXPECT_THAT(AovChannels("sampleCount"), ElementsAre("sampleCount.samples"));
  EXPECT_THAT(AovChannels("primvars:st"), ElementsAre("primvars:st.X", "primvars:st.Y", "primvars:st.Z"));
  for (const wavefront::AovInfo& aov : wavefront::Aovs())
    EXPECT_EQ(AovChannels(std::string(aov.token)).size(), aov.components) << aov.token;
}

}  // namespace
}  // namespace delegate
