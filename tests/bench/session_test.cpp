// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Scenes one after the other: what fails does not take with it what was measured, and renders are long enough.
#include "plugin/bench/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "plugin/bench/report.h"
#include "plugin/bench/sample_count.h"
#include "plugin/bench/sweeps.h"

namespace bench {
namespace {

using testing::HasSubstr;
using testing::Not;

delegate::CapturedScene SmallScene(const char* name) {
  auto scene = FindSweep("materials")->make({name, 1, 12}, true);
  scene.settings.width = 32;
  scene.settings.height = 18;
  scene.settings.samples = 2;
  return scene;
}

std::string TextOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

Options WaveOptions(const char* json) {
  Options options;
  options.files = {"a"};
  options.megakernel = false;
  options.runs = 1;
  options.pools = {0};
  options.seconds = 0;
  options.json = testing::TempDir() + json;
  return options;
}

TEST(BenchSession, KeepsWhatWasMeasuredWhereALaterSceneFails) {
  const Options options = WaveOptions("session.json");
  Session session(options, {"device", "driver", "CPU", 1e9});
  ASSERT_TRUE(session.Begin().ok());
  session.Run(SmallScene("first"));
  EXPECT_THAT(TextOf(options.json), HasSubstr(session.results()[0].measurements[0].film)) << "it is in the file at once";
  auto wide = SmallScene("wide");
  wide.settings.width = wide.settings.height = 2000000;
  session.Run(std::move(wide));
  session.Run(SmallScene("third"));
  EXPECT_EQ(session.Finish(), kFailed);
  ASSERT_EQ(session.results().size(), 3u);
  EXPECT_EQ(session.results()[0].error, "");
  EXPECT_THAT(session.results()[1].error, HasSubstr("too large"));
  EXPECT_FALSE(session.results()[1].measurements[0].rendered);
  EXPECT_TRUE(session.results()[2].measurements[0].rendered) << "it goes on";
  const std::string json = TextOf(options.json);
  EXPECT_THAT(json, testing::AllOf(HasSubstr("\"first\""), HasSubstr("\"third\""), HasSubstr("\"error\": \"")));
  std::filesystem::remove(options.json);
}

TEST(BenchSession, SaysBeforeItRendersThatTheFileCannotBeWritten) {
  Options options = WaveOptions("no/such/folder.json");
  EXPECT_FALSE(Session(options, {}).Begin().ok());
}

TEST(BenchSession, SaysThatAPoolWasCut) {
  const Options options = WaveOptions("pools.json");
  Session session(options, {"device", "driver", "CPU", 1e9});
  for (const uint32_t pool : {4096u, 0xf0000000u}) {
    auto scene = SmallScene("pools");
    scene.settings.poolSize = pool;
    session.Run(std::move(scene));
    const Measurement& m = session.results().back().measurements[0];
    EXPECT_EQ(m.poolCut(), pool != 4096u);
    EXPECT_LE(m.stats.poolSize, pool);
  }
  EXPECT_EQ(session.Finish(), kDone);
  EXPECT_THAT(TextOf(options.json), testing::AllOf(HasSubstr("\"poolCut\": true"), HasSubstr("\"poolAsked\": 4026531840"), HasSubstr("\"poolCut\": false")));
  std::filesystem::remove(options.json);
}

TEST(BenchSamples, FillThePoolAndLastLongEnoughButNotTooLong) {
  const auto samples = [](uint32_t least, double seconds, std::vector<Probe> probes) { return SamplesFor(least, 57600, seconds, probes); };
  EXPECT_EQ(samples(8, 1, {{65536, 0.06}}), 19u) << "16 pools; 1 s would be 17";
  EXPECT_EQ(samples(8, 1, {{4096, 0.02}}), 50u) << "1 s";
  EXPECT_EQ(samples(8, 1, {{1u << 23, 0.0005}}), 2331u) << "16 pools of 8M";
  EXPECT_EQ(samples(8, 1, {{65536, 0.05}, {4096, 0.5}}), 10u) << "the slower one's 5 s";
  EXPECT_EQ(samples(8, 1, {{65536, 2}}), 8u) << "never fewer than the scene's";
  EXPECT_EQ(samples(8, 1, {{4096, 0}}), kMostSamples);
  EXPECT_EQ(samples(8, 1, {}), 8u);
}

TEST(BenchSamples, AreRaisedForEveryVariantAlike) {
  using wavefront::ExecutionMode;
  const SceneResult result = Measure(SmallScene("raised"), {{ExecutionMode::Wavefront, 256}, {ExecutionMode::Wavefront, 1024}}, {"", false, 1, 0.05, {}});
  ASSERT_EQ(result.error, "");
  EXPECT_GT(result.samples, 2u);
  EXPECT_TRUE(result.identical);
  for (const Measurement& m : result.measurements) EXPECT_EQ(m.stats.paths, uint64_t{32} * 18 * result.samples);
}

TEST(BenchOptions, SweepsAreRaisedAndScenesAreAsTheyAre) {
  const auto seconds = [](std::vector<const char*> arguments) { return ParseOptions(arguments)->seconds; };
  EXPECT_EQ(seconds({"a"}), 0);
  EXPECT_EQ(seconds({"a", "--seconds", "0.5"}), 0.5);
  EXPECT_EQ(seconds({"--sweep", "pool"}), 1);
  EXPECT_EQ(seconds({"--sweep", "pool", "--quick"}), 0.2);
  EXPECT_EQ(seconds({"--sweep", "pool", "--samples", "4"}), 0);
  EXPECT_EQ(seconds({"--sweep", "samples"}), 0);
  for (const char* wrong : {"-1", "x", "1s", "nan"}) EXPECT_FALSE(ParseOptions(std::vector<const char*>{"a", "--seconds", wrong}).ok());
}

}  // namespace
}  // namespace bench
