// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The bit-identity contract: the film depends on the scene, the camera and the sample range, and on nothing else.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "tests/wavefront/scheduler/fixture.h"

namespace wavefront {
namespace {

// One world for all: kernels compile once. Each test asks for its settings; a seed of its own between two equal renders
// makes the second one a render, not a memory.
class Determinism : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = std::make_unique<World>();
    world_->AddMixedScene();
    usual_ = world_->settings;
    reference_ = world_->Render();
    ASSERT_FALSE(reference_.sums.empty());
  }
  static void TearDownTestSuite() { world_.reset(); }
  void SetUp() override { world_->settings = usual_; }

  static RawFilm Again() {
    const uint32_t samples = world_->settings.samples;
    world_->settings.seed = 99;
    world_->settings.samples = 1;
    EXPECT_TRUE(world_->Commit().ok());
    world_->settings.seed = 0;
    world_->settings.samples = samples;
    return world_->Render();
  }
  static void ExpectReference(const RawFilm& film) {
    EXPECT_EQ(HashFilm(film), HashFilm(reference_));
    ASSERT_EQ(film.sums.size(), reference_.sums.size());
    const FilmLayout layout = MakeFilmLayout(film.aovs);
    std::size_t different = 0;
    for (std::size_t i = 0; i < film.sums.size(); ++i) {
      if (film.sums[i] == reference_.sums[i] || different++ >= 4) continue;
      const std::size_t pixel = i / layout.sumChannels;
      ADD_FAILURE() << "pixel (" << pixel % film.width << ", " << pixel / film.width << ") channel " << i % layout.sumChannels << ": "
                    << film.sums[i] << " instead of " << reference_.sums[i];
    }
    EXPECT_EQ(different, 0u) << "of " << film.sums.size() << " sums";
    EXPECT_TRUE(film.first == reference_.first);
  }

  static std::unique_ptr<World> world_;
  static RenderSettings usual_;
  static RawFilm reference_;
};
std::unique_ptr<World> Determinism::world_;
RenderSettings Determinism::usual_;
RawFilm Determinism::reference_;

TEST_F(Determinism, TheSceneIsWorthTheTest) {
  double sum = 0, transparent = 0;
  for (uint32_t c = 0; c < 3; ++c) sum += MeanColor(reference_, c);
  transparent = MeanColor(reference_, 3);
  EXPECT_GT(sum, 0.3);
  EXPECT_GT(transparent, 0.3);
  const RenderStats stats = world_->renderer->stats();
  EXPECT_EQ(stats.errorFlags, 0u);
  EXPECT_GT(stats.shadowRays, 1000u);
  for (const KernelStats& k : stats.kernels) {
    if (k.name.rfind("material:", 0) == 0) {
      EXPECT_GT(k.items, 0u) << k.name;
    }
  }
}

TEST_F(Determinism, AnotherSeedIsAnotherImage) {
  world_->settings.seed = 7;
  EXPECT_NE(HashFilm(world_->Render()), HashFilm(reference_));
}

TEST_F(Determinism, FiveRuns) {
  for (int run = 0; run < 4; ++run) ExpectReference(Again());
}

TEST_F(Determinism, PoolSizes) {
  for (uint32_t pool : {64u, 4096u, 65536u, 524288u}) {
    SCOPED_TRACE(pool);
    world_->settings.poolSize = pool;
    ExpectReference(world_->Render());
    EXPECT_EQ(world_->renderer->stats().poolSize, pool);
  }
}

TEST_F(Determinism, SamplesPerBatch) {
  for (uint32_t batch : {1u, 4u, 16u, 5u}) {
    SCOPED_TRACE(batch);
    world_->settings.samplesPerBatch = batch;
    ExpectReference(world_->Render());
  }
}

TEST_F(Determinism, BandsOfTheImage) {
  for (uint32_t rows : {1u, 7u, 29u}) {
    SCOPED_TRACE(rows);
    world_->settings.bandRows = rows;
    world_->settings.samples = rows == 1 ? 2 : usual_.samples;
    const RawFilm film = world_->Render();
    if (rows != 1) {
      ExpectReference(film);
      continue;
    }
    world_->settings.bandRows = 0;
    const RawFilm whole = world_->Render();
    EXPECT_EQ(film.sums, whole.sums);
    EXPECT_EQ(film.first, whole.first);
  }
}

TEST_F(Determinism, HalvesMergeToTheWhole) {
  world_->settings.samples = 7;
  const RawFilm low = world_->Render();
  world_->settings.firstSample = 7;
  world_->settings.samples = usual_.samples - 7;
  const RawFilm high = world_->Render();
  for (const auto& merged : {MergeFilms(low, high), MergeFilms(high, low)}) {
    ASSERT_TRUE(merged.ok());
    EXPECT_EQ(merged.value().samples, usual_.samples);
    ExpectReference(merged.value());
  }
  EXPECT_FALSE(MergeFilms(low, low).ok()) << "the same samples must not count twice";
}

TEST_F(Determinism, PauseResumeStopAndStart) {
  world_->settings.poolSize = 1024;  // many iterations, so that there is something to interrupt
  ExpectReference(world_->RenderInterrupted());
}

TEST_F(Determinism, MapWhileRenderingShowsWholeSamplesOnly) {
  world_->settings.poolSize = 2048;
  world_->settings.samples = 64;
  ASSERT_TRUE(world_->Commit().ok());
  Renderer& r = *world_->renderer;
  ASSERT_TRUE(r.Start().ok());
  int maps = 0;
  while (!r.IsConverged() && maps < 200) {
    auto count = r.Map(Aov::SampleCount);
    auto color = r.Map(Aov::Color);
    ASSERT_TRUE(count.ok() && color.ok());
    ASSERT_EQ(color.value().bits.size(), 40u * 30u * 4u);
    for (uint32_t bits : count.value().bits) {
      const float n = std::bit_cast<float>(bits);
      ASSERT_EQ(n, std::floor(n));
      ASSERT_LE(n, 64.0f);
    }
    for (uint32_t bits : color.value().bits) ASSERT_TRUE(std::isfinite(std::bit_cast<float>(bits)));
    ++maps;
  }
  EXPECT_GT(maps, 0);
  ASSERT_TRUE(r.WaitUntilDone(60));
  // Resolving on the device and on the host give the same bits.
  auto film = r.ReadFilm();
  ASSERT_TRUE(film.ok());
  for (Aov aov : {Aov::Color, Aov::SampleCount, Aov::Albedo, Aov::Normal, Aov::Depth, Aov::CameraDepth, Aov::PrimId, Aov::ElementId}) {
    auto mapped = r.Map(aov);
    ASSERT_TRUE(mapped.ok());
    EXPECT_EQ(mapped.value().bits, ResolveFilm(film.value(), aov).bits) << static_cast<int>(aov);
  }
  EXPECT_FALSE(r.Map(Aov::InstanceId).ok()) << "was not asked for";
}

TEST_F(Determinism, OrderOfCreationDoesNotShow) {
  World other;
  // The same prims, lights first and in another order of paths; ids differ, paths do not.
  other.Dome(0.2f);
  LightData light;
  light.path = "/sphere";
  light.type = LightType::Sphere;
  light.radiance = {6, 6, 7};
  light.radius = 0.2f;
  light.transforms = {{0, Moved(-1.2, 0, 0.5)}};
  other.renderer->CreateLight(light);
  light.path = "/rect";
  light.type = LightType::Rect;
  light.transforms = {{0, Moved(0.5, 1.2, 2.5)}};
  other.renderer->CreateLight(light);
  const MeshId box = other.renderer->CreateMesh(Box()), quad = other.renderer->CreateMesh(Quad());
  const MaterialId glass = other.Material(MakeMaterial("glass", {}, 1, {}, {0.3f, 0.6f, 0.1f}, {1, 2, 3}, 0.3f));
  const MaterialId wax = other.Material(MakeMaterial("wax", {0.8f, 0.5f, 0.3f}, 1, {0.1f, 0.2f, 0.05f}));
  const MaterialId gauze = other.Material(MakeMaterial("cutout", {0.4f, 0.8f, 0.3f}, 0.4f));
  const MaterialId lamp = other.Material(MakeMaterial("emissive", {0.2f, 0.2f, 0.2f}, 1, {4, 3, 2}));
  const MaterialId grey = other.Material(MakeMaterial("lambert", {0.7f, 0.6f, 0.5f}));
  other.Instance("/gauze", quad, gauze, {Scaled(0.8, 0.8, 1, 0.2, -0.3, 0.4), Scaled(0.8, 0.8, 1, 0.3, -0.2, 0.4)});
  other.Instance("/glass", box, glass, {Scaled(0.3, 0.3, 0.3, -0.7, -0.6, 0)});
  other.Instance("/wax", box, wax, {Scaled(0.2, 0.3, 0.2, 0.9, -0.4, 0)});
  other.Instance("/lamp", quad, lamp, {Scaled(0.3, 0.3, 1, -0.9, 0.7, -0.7)});
  other.Instance("/wall", quad, grey, {Scaled(3, 3, 1, 0, 0, -1.5), Scaled(0.4, 0.4, 0.4, 0.8, 0.5, 0.3)});
  other.settings = usual_;
  ExpectReference(other.Render());
}

// Runs in a process of its own, see below.
TEST(DeterminismChild, DISABLED_PrintsTheHash) {
  World world;
  world.AddMixedScene();
  std::printf("film hash %016llx\n", static_cast<unsigned long long>(HashFilm(world.Render())));
}

TEST_F(Determinism, ThreadsOfTheDevice) {
  char path[4096];
  const ssize_t length = readlink("/proc/self/exe", path, sizeof path - 1);
  ASSERT_GT(length, 0);
  path[length] = 0;
  char expected[64];
  std::snprintf(expected, sizeof expected, "film hash %016llx", static_cast<unsigned long long>(HashFilm(reference_)));
  for (const char* threads : {"1", "2", "5"}) {
    const std::string command = std::string("LP_NUM_THREADS=") + threads + " '" + path +
                                "' --gtest_also_run_disabled_tests --gtest_filter='DeterminismChild.*' 2>&1";
    std::string output;
    FILE* pipe = popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    for (char buffer[512]; fgets(buffer, sizeof buffer, pipe) != nullptr;) output += buffer;
    EXPECT_EQ(pclose(pipe), 0) << output;
    EXPECT_NE(output.find(expected), std::string::npos) << threads << " threads:\n" << output;
  }
}

}  // namespace
}  // namespace wavefront
