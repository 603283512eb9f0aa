// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The megakernel is the wavefront loop's oracle: both must make the same film, bit by bit.
#include <gtest/gtest.h>


#include "tests/wavefront/scheduler/fixture.h"

namespace wavefront {
namespace {

// One world for all, as in determinism_test.cpp: the reference is what the wavefront loop made of it.
class MegakernelTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = std::make_unique<World>();
    world_->AddMixedScene();
    world_->LinkMegakernels();
    world_->settings.aovs.push_back(Aov::InstanceId);
    world_->settings.aovs.push_back(Aov::Neye);
    usual_ = world_->settings;
    reference_ = world_->Render();
    usual_.executionMode = ExecutionMode::Megakernel;
    wavefront_ = world_->renderer->stats();
  }
  static void TearDownTestSuite() { world_.reset(); }
  void SetUp() override { world_->settings = usual_; }

  static void ExpectReference(const RawFilm& film) {
    EXPECT_EQ(world_->renderer->stats().executionMode, ExecutionMode::Megakernel);
    EXPECT_EQ(HashFilm(film), HashFilm(reference_));
    EXPECT_TRUE(film.first == reference_.first);
    std::size_t different = 0;
    for (std::size_t i = 0; i < film.sums.size(); ++i) different += film.sums[i] != reference_.sums[i];
    EXPECT_EQ(different, 0u) << "of " << film.sums.size() << " sums";
  }

  static std::unique_ptr<World> world_;
  static RenderSettings usual_;
  static RawFilm reference_;
  static RenderStats wavefront_;
};
std::unique_ptr<World> MegakernelTest::world_;
RenderSettings MegakernelTest::usual_;
RawFilm MegakernelTest::reference_;
RenderStats MegakernelTest::wavefront_;

TEST_F(MegakernelTest, MakesTheSameFilmOfTheSameSegments) {
  ExpectReference(world_->Render());
  const RenderStats stats = world_->renderer->stats();
  EXPECT_EQ(stats.paths, wavefront_.paths);
  EXPECT_EQ(stats.segments, wavefront_.segments);
  EXPECT_EQ(stats.shadowRays, wavefront_.shadowRays);
  EXPECT_EQ(stats.errorFlags, 0u);
  EXPECT_EQ(stats.validationMessages, wavefront_.validationMessages);
  const KernelStats& kernel = stats.kernels.back();
  EXPECT_EQ(kernel.name, "megakernel");
  EXPECT_EQ(kernel.items, stats.segments);
  EXPECT_GT(kernel.milliseconds, 0.0);
  EXPECT_GT(kernel.codeMilliseconds, 0.0);
  EXPECT_GT(kernel.createMilliseconds + kernel.firstDispatchMilliseconds, 0.0);
  for (const KernelStats& k : stats.kernels) {
    if (k.name == "logic" || k.name.starts_with("material:")) {
      EXPECT_EQ(k.items, 0u) << k.name << " has no work in this mode";
    }
  }
}

TEST_F(MegakernelTest, PoolSizesAndBatches) {
  for (uint32_t pool : {64u, 1000u, 65536u}) {
    SCOPED_TRACE(pool);
    world_->settings.poolSize = pool;
    world_->settings.samplesPerBatch = pool == 1000u ? 5 : 0;
    ExpectReference(world_->Render());
  }
  EXPECT_EQ(world_->linked, 1) << "the same kernels are linked once";
}

TEST_F(MegakernelTest, BandsOfTheImage) {
  world_->settings.bandRows = 7;
  ExpectReference(world_->Render());
}

TEST_F(MegakernelTest, HalvesMergeToTheWhole) {
  world_->settings.samples = 7;
  const RawFilm low = world_->Render();
  world_->settings.executionMode = ExecutionMode::Wavefront;  // one half each
  world_->settings.firstSample = 7;
  world_->settings.samples = usual_.samples - 7;
  const RawFilm high = world_->Render();
  EXPECT_EQ(world_->renderer->stats().executionMode, ExecutionMode::Wavefront);
  const auto merged = MergeFilms(low, high);
  ASSERT_TRUE(merged.ok());
  EXPECT_EQ(HashFilm(merged.value()), HashFilm(reference_));
}

TEST_F(MegakernelTest, PauseResumeStopAndStart) {
  world_->settings.poolSize = 128;  // many dispatches, so that there is something to interrupt
  world_->settings.interactive = true;
  ExpectReference(world_->RenderInterrupted());
}

TEST(Megakernel, LongPathsAreSavedAndGoOn) {
  // Sixty layers of gauze, which few paths scatter at: most are longer than the turns of a dispatch.
  World world;
  world.LinkMegakernels();
  const MeshId quad = world.renderer->CreateMesh(Quad());
  std::vector<Matrix4d> layers;
  for (int i = 0; i < 60; ++i) layers.push_back(Scaled(4, 4, 1, 0, 0, -0.01 * i));
  world.Instance("/gauze", quad, world.Material(MakeMaterial("cutout", {0.9f, 0.9f, 0.9f}, 0.02f)), layers);
  world.Dome(1);
  world.settings.width = world.settings.height = 8;
  world.settings.samples = 4;
  world.settings.maxBounces = 64;
  world.settings.rouletteBounce = 64;
  world.settings.poolSize = 64;
  const RawFilm reference = world.Render();
  world.settings.executionMode = ExecutionMode::Megakernel;
  EXPECT_EQ(HashFilm(world.Render()), HashFilm(reference));
  const RenderStats stats = world.renderer->stats();
  EXPECT_EQ(stats.executionMode, ExecutionMode::Megakernel);
  EXPECT_GT(stats.segments, 30 * stats.paths);
  EXPECT_GT(stats.kernels.back().dispatches, 3u);
  EXPECT_EQ(stats.errorFlags, 0u);
}

TEST(Megakernel, WhatCannotHaveOneRendersInWavefrontModeAndSaysSo) {
  World world;
  const MeshId quad = world.renderer->CreateMesh(Quad());
  for (int i = 0; i < 17; ++i) {
    const std::string name = std::to_string(i);
    world.Instance("/quad" + name, quad, world.Material(MakeMaterial("lambert" + name, {0.5f, 0.5f, 0.5f})), {Moved(0.01 * i, 0, -i)});
  }
  world.Dome(1);
  world.settings.samples = 1;
  const RawFilm reference = world.Render();
  world.settings.executionMode = ExecutionMode::Megakernel;
  EXPECT_EQ(HashFilm(world.Render()), HashFilm(reference));
  EXPECT_TRUE(world.Said("megakernel-unavailable"));
  world.LinkMegakernels();
  world.settings.seed = 1;
  EXPECT_NE(HashFilm(world.Render()), HashFilm(reference));
  EXPECT_TRUE(world.Said("megakernel-too-many-materials"));
  EXPECT_EQ(world.renderer->stats().executionMode, ExecutionMode::Wavefront);
  EXPECT_EQ(world.linked, 0);
}

}  // namespace
}  // namespace wavefront
