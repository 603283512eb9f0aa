// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// wavefront-bench's own scenes, its options, and a replay on the device at hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "delegate/capture/scene_file.h"
#include "materialgen/materialgen.h"
#include "plugin/bench/json_writer.h"
#include "plugin/bench/measure.h"
#include "plugin/bench/options.h"
#include "plugin/bench/sweep_materials.h"
#include "plugin/bench/sweeps.h"

namespace bench {
namespace {

using testing::HasSubstr;

TEST(BenchSweeps, ScenesAreSoundAndAlwaysTheSame) {
  for (const Sweep& sweep : Sweeps()) {
    SCOPED_TRACE(sweep.name);
    EXPECT_EQ(FindSweep(sweep.name), &sweep);
    const auto points = PointsOf(sweep, {}, true, true);
    ASSERT_FALSE(points.empty());
    const auto scene = sweep.make(points.back(), true);
    const auto status = delegate::CheckScene(scene);
    EXPECT_TRUE(status.ok()) << status.error().message;
    EXPECT_EQ(delegate::EncodeScene(scene), delegate::EncodeScene(sweep.make(points.back(), true)));
    EXPECT_LE(sweep.cpu.back(), sweep.gpu.back());
  }
}

TEST(BenchSweeps, CountWhatTheySay) {
  const auto make = [](const char* name, SweepPoint point) { return FindSweep(name)->make(point, true); };
  EXPECT_EQ(make("lights", {"", 37, 0}).lights.size(), 37u);
  const auto triangles = make("triangles", {"", 20000, 0}).meshes.at(0).triangles.size();
  EXPECT_NEAR(static_cast<double>(triangles), 20000, 200);
  std::size_t instances = 0;
  for (const auto& [id, data] : make("instances", {"", 50, 0}).instances) instances += data.transforms.size();
  EXPECT_EQ(instances, 51u) << "and a floor";
  const auto materials = make("materials", {"", 200, 100});
  EXPECT_EQ(materials.materials.size(), 200u);
  EXPECT_EQ(materials.kernels.size(), 100u) << "a CPU's driver gets no more topologies";
  EXPECT_EQ(FindSweep("materials")->make({"", 200, 100}, false).kernels.size(), 200u);
  EXPECT_EQ(make("pool", {"", 512, 0}).settings.poolSize, 512u);
}

TEST(BenchMaterials, CompileAndDifferByNumberAndOperations) {
  std::set<std::string> sources;
  for (const auto& [number, operations] : {std::pair{0u, 100u}, {1u, 100u}, {0u, 400u}, {0u, 4000u}}) {
    const delegate::CapturedKernel kernel = MakeKernel(number, operations);
    std::string error;
    EXPECT_FALSE(materialgen::CompileGlsl(kernel.glsl[0], kernel.key, &error).empty()) << error;
    EXPECT_TRUE(sources.insert(kernel.glsl[0]).second);
  }
}

TEST(BenchOptions, AreReadAndRefused) {
  const auto parse = [](std::vector<const char*> arguments) { return ParseOptions(arguments); };
  auto options = parse({"a.scene", "b.scene", "--pool", "0,65536", "--mode", "wavefront", "--runs", "7", "--validate", "--json", "x"});
  ASSERT_TRUE(options.ok()) << options.error().message;
  EXPECT_EQ(options->files.size(), 2u);
  EXPECT_EQ(options->pools, (std::vector<uint32_t>{0, 65536}));
  EXPECT_TRUE(options->wavefront && !options->megakernel && options->validate);
  EXPECT_EQ(options->runs, 7u);
  EXPECT_TRUE(parse({"--sweep", "lights", "--points", "1,2"}).ok());
  EXPECT_TRUE(parse({"a", "b", "--compare"})->compare);
  for (const auto& wrong : std::vector<std::vector<const char*>>{
           {}, {"a", "--sweep", "lights"}, {"--sweep", "nothing"}, {"a", "--pool", "1,x"}, {"a", "--pool", "-1"}, {"a", "--pool", "99999999999"},
           {"a", "--runs", "0"}, {"a", "--mode", "fast"}, {"a", "--json"}, {"a", "--nonsense"}, {"--sweep", "lights", "--points", "0"},
           {"a", "--compare"}, {"a", "b", "c", "--compare"}})
    EXPECT_FALSE(parse(wrong).ok());
  EXPECT_THAT(Usage(), testing::AllOf(HasSubstr("--pool"), HasSubstr("triangles")));
}

TEST(BenchJson, QuotesAndSeparates) {
  JsonWriter json;
  json.Begin('{').Pair("a", "x\"\\\n").Key("b").Begin('[');
  json.Value(1.5);
  json.Value(uint64_t{7});
  json.Value(std::nan(""));
  json.End(']').Pair("c", true).End('}');
  EXPECT_EQ(json.text(), R"({"a": "x\"\\\u000a", "b": [1.5, 7, null], "c": true})");
}

TEST(BenchMeasure, PoolsMakeOneFilm) {  // tests/python/test_capture.py has the megakernel
  auto scene = FindSweep("materials")->make({"one", 1, 12}, true);
  scene.settings.width = 32;
  scene.settings.height = 18;
  scene.settings.samples = 2;
  scene.settings.aovs = {wavefront::Aov::MaterialCost};  // differs from run to run; the bench must not ask for it
  using wavefront::ExecutionMode;
  auto result = Measure(scene, {{ExecutionMode::Wavefront, 0}, {ExecutionMode::Wavefront, 256}}, {"", false, 2, {}});
  ASSERT_EQ(result.error, "");
  EXPECT_TRUE(result.identical);
  ASSERT_EQ(result.measurements.size(), 2u);
  for (const Measurement& m : result.measurements) {
    EXPECT_TRUE(m.rendered) << m.why;
    EXPECT_EQ(m.film, result.measurements[0].film);
    EXPECT_EQ(m.seconds.size(), 2u);
    EXPECT_EQ(m.stats.paths, 32u * 18u * 2u);
    EXPECT_GT(m.mpaths(), 0);
  }
  EXPECT_EQ(result.measurements[1].stats.poolSize, 256u);
  EXPECT_GT(result.measurements[0].stateBytesPerSegment, 200);
  EXPECT_EQ(result.instances, 1025u);
  // Another picture is another film.
  ++scene.settings.seed;
  auto other = Measure(scene, {{ExecutionMode::Wavefront, 0}}, {"", false, 1, {}});
  ASSERT_EQ(other.error, "");
  EXPECT_NE(other.measurements[0].film, result.measurements[0].film);
}

}  // namespace
}  // namespace bench
