// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What the loop and the facade promise: conservation of paths and rays, opacity, media, edits, errors.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "tests/wavefront/scheduler/fixture.h"

namespace wavefront {
namespace {

uint64_t Items(const RenderStats& stats, const std::string& prefix, const std::string& suffix) {
  uint64_t sum = 0;
  for (const KernelStats& k : stats.kernels) {
    if (k.name.rfind(prefix, 0) == 0 && k.name.size() >= suffix.size() && k.name.compare(k.name.size() - suffix.size(), suffix.size(), suffix) == 0) sum += k.items;
  }
  return sum;
}

TEST(Scheduler, EveryPathEndsAndEverySegmentIsShadedOnce) {
  World world;
  // A closed room of emitting walls (whose last hit is shaded, too), seen from inside; no roulette, no light bodies.
  const MeshId box = world.renderer->CreateMesh(Box());
  const MaterialId wall = world.Material(MakeMaterial("emissive", {0.5f, 0.5f, 0.5f}, 1, {1, 1, 1}));
  world.Instance("/room", box, wall, {Scaled(6, 6, 6)});
  world.settings.maxBounces = 5;
  world.settings.rouletteBounce = 200;
  for (uint32_t pool : {128u, 4096u, 65536u}) {
    SCOPED_TRACE(pool);
    world.settings.poolSize = pool;
    const RawFilm film = world.Render();
    const RenderStats stats = world.renderer->stats();
    const uint64_t paths = 40ull * 30 * 16;
    EXPECT_EQ(stats.paths, paths);
    EXPECT_EQ(Items(stats, "new_path", ""), paths);
    // Six segments a path, none lost: each is traced once and shaded once.
    EXPECT_EQ(stats.extensionRays, paths * 6);
    EXPECT_EQ(Items(stats, "material:", ":surface"), paths * 6);
    EXPECT_LE(stats.shadowRays, paths * 5);
    EXPECT_GT(stats.shadowRays, 0u);
    // Until the work runs out, every slot that has a path casts six rays in eleven iterations: after each but the last the
    // wall glows in one and scatters in the next.
    const uint64_t slots = std::min<uint64_t>(pool, paths);
    const auto rays = std::find_if(stats.kernels.begin(), stats.kernels.end(), [](const KernelStats& k) { return k.name == "extension_ray"; });
    EXPECT_EQ(rays->peak, slots);
    const double share = static_cast<double>(slots) / pool * 6 / 11;
    EXPECT_LE(rays->occupancy, share);
    EXPECT_GT(rays->occupancy, 0.8 * share);
    for (const QueueStats& q : stats.queues) {
      EXPECT_LE(q.peak, pool) << q.name;
      EXPECT_DOUBLE_EQ(q.occupancy, static_cast<double>(q.items) / static_cast<double>(stats.iterations * pool)) << q.name;
      if (q.name != "extensionRay") continue;
      EXPECT_EQ(q.peak, rays->peak);
      EXPECT_EQ(q.items, rays->items);
      EXPECT_EQ(q.milliseconds, rays->milliseconds);
      EXPECT_GT(q.milliseconds, 0);
    }
    for (uint32_t bits : ResolveFilm(film, Aov::SampleCount).bits) ASSERT_EQ(std::bit_cast<float>(bits), 16.0f);
    // Furnace: 1 + 1/2 + 1/4 + ... over six hits.
    EXPECT_NEAR(MeanColor(film, 0), 63.0 / 32.0, 2e-3);
    const Progress progress = world.renderer->progress();
    EXPECT_TRUE(progress.converged);
    EXPECT_EQ(progress.pathsDone, paths);
    EXPECT_EQ(progress.samplesDone, 16u);
    EXPECT_EQ(stats.errorFlags, 0u);
  }
}

TEST(Scheduler, NothingIsBlackAndTransparent) {
  World world;
  RawFilm film = world.Render();  // no prim at all
  for (int64_t v : std::vector<int64_t>(film.sums.begin(), film.sums.begin() + 4)) EXPECT_EQ(v, 0);
  EXPECT_EQ(MeanColor(film, 3), 0.0);
  // Geometry without light: black, and opaque where it is.
  world.Instance("/quad", world.renderer->CreateMesh(Quad()), world.Material(MakeMaterial("lambert", {1, 1, 1})), {Scaled(10, 10, 1)});
  film = world.Render();
  EXPECT_EQ(MeanColor(film, 0), 0.0);
  EXPECT_EQ(MeanColor(film, 3), 1.0);
}

TEST(Scheduler, SurfacesOfOpacityZeroAreNotThere) {
  World world;
  world.Dome(2);
  const MeshId quad = world.renderer->CreateMesh(Quad());
  const MaterialId clear = world.Material(MakeMaterial("cutout", {1, 1, 1}, 0));
  const MaterialId floor = world.Material(MakeMaterial("lambert", {0.5f, 0.5f, 0.5f}));
  // Twenty in one plane, between the camera and a white wall: seen and lit as if they were not there.
  world.Instance("/wall", quad, floor, {Scaled(20, 20, 1)});
  world.settings.maxBounces = 1;
  const RawFilm without = world.Render();
  std::vector<Matrix4d> stack(20, Scaled(20, 20, 1, 0, 0, 1));
  world.Instance("/clear", quad, clear, stack);
  const RawFilm with = world.Render();
  EXPECT_EQ(HashFilm(with), HashFilm(without)) << "passing through costs no bounce and no randomness";
  EXPECT_NEAR(MeanColor(with, 0), 1.0, 0.02);
  EXPECT_FALSE(world.Said("render-transparency-limit"));

  // More of them than the limit: blocked, and said so.
  world.settings.maxTransparency = 10;
  const RawFilm blocked = world.Render();
  EXPECT_TRUE(world.Said("render-transparency-limit"));
  EXPECT_EQ(MeanColor(blocked, 0), 0.0);
  // Twenty layers exactly fit a limit of twenty.
  world.settings.maxTransparency = 20;
  EXPECT_EQ(HashFilm(world.Render()), HashFilm(without));
}

TEST(Scheduler, HalfOpaqueLayersMultiply) {
  World world;
  world.Dome(1);
  const MaterialId gauze = world.Material(MakeMaterial("cutout", {0, 0, 0}, 0.5f));
  world.Instance("/gauze", world.renderer->CreateMesh(Quad()), gauze, {Scaled(20, 20, 1), Scaled(20, 20, 1), Scaled(20, 20, 1)});
  world.settings.samples = 64;
  const RawFilm film = world.Render();
  const double n = 40.0 * 30 * 64, p = 1.0 / 8;
  EXPECT_NEAR(MeanColor(film, 0), p, 4 * std::sqrt(p * (1 - p) / n));
}

TEST(Scheduler, ShadowsOfPartialOpacity) {
  // A wall lit by a small sphere behind the camera, through two black sheets of opacity 0.25: 9/16 of the light.
  World world;
  const MeshId quad = world.renderer->CreateMesh(Quad());
  world.Instance("/wall", quad, world.Material(MakeMaterial("lambert", {0.8f, 0.8f, 0.8f})), {Scaled(20, 20, 1)});
  LightData light;
  light.path = "/sphere";
  light.type = LightType::Sphere;
  light.radius = 0.5f;
  light.radiance = {100, 100, 100};
  light.visibleToCamera = false;
  light.transforms = {{0, Moved(0, 0, 20)}};
  world.renderer->CreateLight(light);
  world.settings.maxBounces = 1;
  const double open = MeanColor(world.Render(), 0);
  const MaterialId sheet = world.Material(MakeMaterial("cutout", {0, 0, 0}, 0.25f));
  world.Instance("/sheet", quad, sheet, {Scaled(50, 50, 1, 0, 0, 10), Scaled(50, 50, 1, 0, 0, 12)});
  EXPECT_NEAR(MeanColor(world.Render(), 0) / open, 9.0 / 16, 2e-3);
}

TEST(Scheduler, BeerLambert) {
  // A box of depth 2 that bends nothing, seen head-on from far: exp(-2 sigma).
  World world;
  world.Dome(1);
  const MaterialId glass = world.Material(MakeMaterial("glass", {}, 1, {}, {0.25f, 0.5f, 1.5f}));
  world.Instance("/glass", world.renderer->CreateMesh(Box()), glass, {Moved(0, 0, -1)});
  world.camera.orthographic = true;
  world.camera.left = world.camera.bottom = -0.9f;
  world.camera.right = world.camera.top = 0.9f;
  const RawFilm film = world.Render();
  EXPECT_NEAR(MeanColor(film, 0), std::exp(-0.5), 1e-3);
  EXPECT_NEAR(MeanColor(film, 1), std::exp(-1.0), 1e-3);
  EXPECT_NEAR(MeanColor(film, 2), std::exp(-3.0), 1e-3);
}

// Bodies that overlap, seen head-on through all of them: optical depths add up along the way.
struct Overlap {
  World world;
  MeshId box = kInvalidId;
  Overlap() {
    world.camera.transforms = {{0, Moved(0, 0, 8)}};
    world.Dome(1);
    box = world.renderer->CreateMesh(Box());
    world.camera.orthographic = true;
    world.camera.left = world.camera.bottom = -0.9f;
    world.camera.right = world.camera.top = 0.9f;
    world.settings.maxBounces = 32;
    world.settings.rouletteBounce = 64;
  }
  void Add(const std::string& path, double nearZ, double farZ, Float3 extinction, uint8_t priority = 0) {
    MaterialData material = MakeMaterial("glass", {}, 1, {}, extinction);
    material.mediumPriority = priority;
    world.Instance(path, box, world.Material(std::move(material)), {Scaled(1, 1, (nearZ - farZ) / 2, 0, 0, (nearZ + farZ) / 2)});
  }
};

TEST(Scheduler, BodiesThatOverlapAreLeftInAnyOrder) {
  // A in [0, 2], B in [-1, 1]: A is left while the path is in B.
  for (uint8_t priority : {uint8_t(0), uint8_t(3)}) {
    SCOPED_TRACE(int(priority));
    Overlap o;
    o.Add("/a", 2, 0, {1, 0, 0}, priority);
    o.Add("/b", 1, -1, {0, 1, 0}, 0);
    const RawFilm film = o.world.Render();
    // The overlap belongs to the one entered last, or to the one of higher priority.
    const double inA = priority == 0 ? 1 : 2;
    EXPECT_NEAR(MeanColor(film, 0), std::exp(-inA), 1e-3);
    EXPECT_NEAR(MeanColor(film, 1), std::exp(inA - 3), 1e-3);
    EXPECT_NEAR(MeanColor(film, 2), 1, 1e-3);
  }
}

TEST(Scheduler, FourBodiesInsideEachOtherAndNoMore) {
  Overlap o;
  o.Add("/a", 5, -5, {0.1f, 0, 0});
  o.Add("/b", 4, -4, {0, 0.2f, 0});
  o.Add("/c", 3, -3, {0.1f, 0, 0});
  o.Add("/d", 2, -2, {0, 0.2f, 0});
  const RawFilm four = o.world.Render();
  EXPECT_NEAR(MeanColor(four, 0), std::exp(-0.1 * (2 + 2)), 1e-3);
  EXPECT_NEAR(MeanColor(four, 1), std::exp(-0.2 * (2 + 4)), 1e-3);
  EXPECT_FALSE(o.world.Said("render-media-stack"));
  o.Add("/e", 1, -1, {0, 0, 0.7f});
  const RawFilm five = o.world.Render();
  EXPECT_TRUE(o.world.Said("render-media-stack"));
  EXPECT_NEAR(MeanColor(five, 2), 1, 1e-3);
  EXPECT_NEAR(MeanColor(five, 1), MeanColor(four, 1), 1e-6);
}

TEST(Scheduler, ImagesMappedTogetherAreOfOneMoment) {
  World world;
  world.AddMixedScene();
  world.settings.samples = 64;
  world.settings.poolSize = 1024;
  world.settings.interactive = true;
  world.settings.aovs = {Aov::Depth};
  ASSERT_TRUE(world.Commit().ok());
  ASSERT_TRUE(world.renderer->Start().ok());
  const std::array<Aov, 2> twice{Aov::SampleCount, Aov::SampleCount};
  uint64_t moving = 0;
  std::vector<uint32_t> last;
  // A host that does nothing but map: it neither keeps the render from going on, nor waits for its end.
  while (!world.renderer->IsConverged() && world.renderer->progress().seconds < 100) {
    auto images = world.renderer->Map(twice);
    ASSERT_TRUE(images.ok());
    ASSERT_EQ(images.value()[0].bits, images.value()[1].bits);
    moving += images.value()[0].bits != last;
    last = images.value()[0].bits;
  }
  EXPECT_GT(moving, 4u);
  ASSERT_TRUE(world.renderer->IsConverged());
  const std::array<Aov, 2> both{Aov::Depth, Aov::Color};
  auto images = world.renderer->Map(both);
  ASSERT_TRUE(images.ok());
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(images.value()[i].aov, both[i]);
    EXPECT_EQ(images.value()[i].bits, world.renderer->Map(both[i]).value().bits);
  }
  // A restart that does not go on at once shows no progress of the film before.
  world.settings.seed = 3;
  ASSERT_TRUE(world.Commit().ok());
  EXPECT_EQ(world.renderer->progress().samplesDone, 0u);
  EXPECT_EQ(world.renderer->stats().paths, 0u);
  const std::array<Aov, 2> missing{Aov::Color, Aov::InstanceId};
  EXPECT_FALSE(world.renderer->Map(missing).ok()) << "was not asked for";
}

TEST(Scheduler, InteractiveSubmitsOneIterationAtATimeAndChangesNothing) {
  World world;
  world.AddMixedScene();
  world.settings.poolSize = 256;  // many short iterations
  const RawFilm batch = world.Render();
  const RenderStats before = world.renderer->stats();
  EXPECT_LT(2 * before.submits, before.iterations) << "this pool should need several iterations per submit";
  const uint64_t version = world.renderer->version();
  world.settings.interactive = true;
  ASSERT_TRUE(world.Commit().ok());
  EXPECT_EQ(world.renderer->version(), version) << "the film is kept";
  EXPECT_TRUE(world.renderer->IsConverged());
  world.settings.seed = 1;
  ASSERT_TRUE(world.Commit().ok());
  world.settings.seed = 0;
  const RawFilm interactive = world.Render();
  EXPECT_EQ(HashFilm(interactive), HashFilm(batch));
  const RenderStats after = world.renderer->stats();
  EXPECT_EQ(after.submits - before.submits, after.iterations);
}

// Whenever one looks, all that was submitted is done: an edit waits for the iteration that runs, and for none behind it.
TEST(Scheduler, InteractiveQueuesNothingAhead) {
  World world;
  world.AddMixedScene();
  world.settings.poolSize = 256;
  world.Render();  // kernels are there
  world.settings.interactive = true;
  world.settings.seed = 1;
  world.settings.samples = 64;
  ASSERT_TRUE(world.Commit().ok());
  const uint64_t before = world.renderer->stats().submits;
  ASSERT_TRUE(world.renderer->Start().ok());
  int looks = 0;
  for (uint64_t last = 0; !world.renderer->IsConverged();) {
    const RenderStats now = world.renderer->stats();
    ASSERT_EQ(now.submits - before, now.iterations);
    looks += now.iterations != last;
    last = now.iterations;
  }
  EXPECT_GT(looks, 4);
}

TEST(Scheduler, ARenderBeginsWithShortSubmitsWhateverTheLastOneEndedWith) {
  World world;
  const MeshId box = world.renderer->CreateMesh(Box());
  world.Instance("/room", box, world.Material(MakeMaterial("emissive", {0.5f, 0.5f, 0.5f}, 1, {1, 1, 1})), {Scaled(6, 6, 6)});
  world.settings.maxBounces = 30;
  world.settings.rouletteBounce = 200;
  world.settings.samples = 4;
  world.settings.poolSize = 256;  // short iterations: many a submit
  world.Render();
  const RenderStats before = world.renderer->stats();
  EXPECT_LT(2 * before.submits, before.iterations);
  world.settings.poolSize = 65536;  // long ones: a submit of as many would keep a host that edits waiting for seconds
  world.Render();
  const RenderStats after = world.renderer->stats();
  ASSERT_GE(after.iterations, 31u);
  // Three submits are in flight, and none is more than twice as long as one that was measured: 3 * (1 + 2 + 4) < 31.
  EXPECT_GE(after.submits - before.submits, 10u);
}

TEST(Scheduler, LightsThrowNoShadowsOnEachOther) {
  // A wall under a dome, with a dark rect light between them, wherever the light is found: by its sample or by a bounce.
  World world;
  world.Dome(1);
  world.Instance("/wall", world.renderer->CreateMesh(Quad()), world.Material(MakeMaterial("lambert", {0.5f, 0.5f, 0.5f})), {Scaled(20, 20, 1)});
  LightData light;
  light.path = "/rect";
  light.type = LightType::Rect;
  light.width = light.height = 20;
  light.radiance = {1e-6f, 1e-6f, 1e-6f};
  light.visibleToCamera = false;
  light.transforms = {{0, Moved(0, 0, 6)}};
  world.renderer->CreateLight(light);
  world.settings.samples = 64;
  EXPECT_NEAR(MeanColor(world.Render(), 0), 0.5, 5e-3);
}

TEST(Scheduler, EditsOfValuesRestartAndCompileNothing) {
  World world;
  world.Dome(1);
  const MaterialId wall = world.Material(MakeMaterial("lambert", {0.5f, 0.5f, 0.5f}));
  world.Instance("/wall", world.renderer->CreateMesh(Quad()), wall, {Scaled(20, 20, 1)});
  world.settings.maxBounces = 1;
  const RawFilm half = world.Render();
  EXPECT_NEAR(MeanColor(half, 0), 0.5, 0.02);
  const uint64_t version = world.renderer->version();
  const std::size_t rows = world.renderer->stats().kernels.size();
  world.renderer->SetMaterial(wall, MakeMaterial("lambert", {0.25f, 0.5f, 0.5f}));
  const RawFilm quarter = world.Render();
  EXPECT_GT(world.renderer->version(), version);
  EXPECT_EQ(world.renderer->stats().kernels.size(), rows);
  EXPECT_NEAR(MeanColor(quarter, 0), MeanColor(half, 0) / 2, 1e-5);
  EXPECT_NEAR(MeanColor(quarter, 1), MeanColor(half, 1), 1e-6);
  for (uint32_t bits : ResolveFilm(quarter, Aov::SampleCount).bits) ASSERT_EQ(std::bit_cast<float>(bits), 16.0f);
}

TEST(Scheduler, WhatDoesNotChangeRestartsNothing) {
  World world;
  world.Dome(1);
  world.Render();
  const uint64_t version = world.renderer->version();
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(world.Commit().ok());
    EXPECT_EQ(world.renderer->version(), version);
    EXPECT_TRUE(world.renderer->IsConverged());
  }
  world.camera.transforms[0].value = Moved(0, 0, 5);
  ASSERT_TRUE(world.Commit().ok());
  EXPECT_EQ(world.renderer->version(), version + 1);
  EXPECT_FALSE(world.renderer->IsConverged());
}

TEST(Scheduler, RemovedPrimsAreGone) {
  World world;
  world.Dome(1);
  const MeshId quad = world.renderer->CreateMesh(Quad());
  const MaterialId wall = world.Material(MakeMaterial("lambert", {0, 0, 0}));
  const RawFilm empty = world.Render();
  const InstanceGroupId id = world.Instance("/wall", quad, wall, {Scaled(20, 20, 1)});
  EXPECT_EQ(MeanColor(world.Render(), 0), 0.0);
  world.renderer->DestroyInstances(id);
  world.renderer->DestroyMesh(quad);
  world.renderer->DestroyMaterial(wall);
  EXPECT_EQ(HashFilm(world.Render()), HashFilm(empty));
  EXPECT_EQ(world.renderer->stats().triangles, 0u);
}

TEST(Scheduler, ImpossibleImagesAreErrors) {
  World world;
  world.settings.samples = 1;
  world.Render();  // a film that must not be handed out for other settings
  for (auto [width, height] : {std::pair<uint32_t, uint32_t>{0, 0}, {0, 10}, {10, 0}, {0xffffffffu, 0xffffffffu}, {1u << 20, 1u << 20}, {1u << 30, 1}}) {
    world.settings.width = width;
    world.settings.height = height;
    const Status s = world.Commit();
    EXPECT_FALSE(s.ok()) << width << " x " << height;
    EXPECT_FALSE(s.error().message.empty());
    EXPECT_FALSE(world.renderer->Start().ok());
    EXPECT_FALSE(world.renderer->Map(Aov::Color).ok());
  }
  world.settings.width = world.settings.height = 8;
  world.settings.firstSample = 0xfffffff0u;
  world.settings.samples = 64;
  EXPECT_FALSE(world.Commit().ok());
  world.settings.firstSample = 0;
  world.settings.samples = 0;
  ASSERT_TRUE(world.Commit().ok());
  ASSERT_TRUE(world.renderer->Start().ok());
  EXPECT_TRUE(world.renderer->WaitUntilDone(20));
  EXPECT_TRUE(world.renderer->IsConverged()) << "no samples asked for: done at once";
  EXPECT_TRUE(world.renderer->Map(Aov::Color).ok());
  world.settings.samples = 2;
  EXPECT_EQ(world.Render().samples, 2u);
}

TEST(Scheduler, BrokenPrimsAreNamedAndTheRestRenders) {
  World world;
  world.Dome(1);
  const MeshId quad = world.renderer->CreateMesh(Quad());
  const MaterialId wall = world.Material(MakeMaterial("lambert", {0.5f, 0.5f, 0.5f}));
  world.Instance("/wall", quad, wall, {Scaled(20, 20, 1)});
  world.settings.maxBounces = 1;
  const RawFilm good = world.Render();
  EXPECT_EQ(world.diagnosticCount(), 0u);
  world.Instance("/flat", quad, wall, {Scaled(1, 0, 1), Scaled(0, 0, 0)});
  LightData light;
  light.path = "/dark";
  light.type = LightType::Disk;
  light.transforms = {{0, Scaled(1, 0, 1)}};
  world.renderer->CreateLight(light);
  world.Instance("/none", kInvalidId, wall, {Moved(0, 0, 0)});
  world.Instance("/empty", world.renderer->CreateMesh({}), wall, {Moved(0, 0, 0)});
  EXPECT_EQ(HashFilm(world.Render()), HashFilm(good));
  EXPECT_TRUE(world.Said("transform-singular", "/flat"));
  EXPECT_TRUE(world.Said("light-degenerate", "/dark"));

  // Vertices that are not finite cost their triangles, no more.
  MeshData broken = Quad();
  broken.positions[3].x = std::nanf("");
  world.Instance("/broken", world.renderer->CreateMesh(broken), wall, {Scaled(20, 20, 1, 0, 0, -1)});
  EXPECT_EQ(HashFilm(world.Render()), HashFilm(good));
  EXPECT_TRUE(world.Said("mesh-broken-triangles"));
}

TEST(Scheduler, AMaterialWithoutAKernelIsBlack) {
  World world;
  world.Dome(1);
  const MaterialId unknown = world.renderer->CreateMaterial({"/m", "no such kernel", {}});
  world.Instance("/wall", world.renderer->CreateMesh(Quad()), unknown, {Scaled(20, 20, 1)});
  const RawFilm film = world.Render();
  EXPECT_EQ(MeanColor(film, 0), 0.0);
  EXPECT_EQ(MeanColor(film, 3), 1.0);
}

TEST(Scheduler, FirstHitAovs) {
  World world;
  world.Dome(1);
  const MaterialId wall = world.Material(MakeMaterial("lambert", {0.5f, 0.25f, 0.125f}));
  InstanceData data;
  data.path = "/wall";
  data.mesh = world.renderer->CreateMesh(Quad());
  data.materials = {wall};
  data.transforms = {{{0, Scaled(20, 20, 1)}}};
  data.primId = 42;
  data.instanceIds = {7};
  world.renderer->CreateInstances(data);
  world.settings.aovs = {Aov::Albedo, Aov::Normal, Aov::Depth, Aov::CameraDepth, Aov::PrimId, Aov::InstanceId, Aov::ElementId};
  world.camera.nearClip = 1;
  const RawFilm film = world.Render();
  auto value = [&](Aov aov, uint32_t c, uint32_t n) { return std::bit_cast<float>(ResolveFilm(film, aov).bits[c + n * 5]); };
  EXPECT_NEAR(value(Aov::Albedo, 1, 3), 0.25f, 1e-6f);
  EXPECT_NEAR(value(Aov::Normal, 2, 3), 1.0f, 1e-6f);
  EXPECT_NEAR(value(Aov::CameraDepth, 0, 1), 4.0f, 1e-5f);
  EXPECT_NEAR(value(Aov::Depth, 0, 1), 0.75f, 1e-6f) << "near 1, far at the largest float";
  EXPECT_EQ(ResolveFilm(film, Aov::PrimId).bits[5], 42u);
  EXPECT_EQ(ResolveFilm(film, Aov::InstanceId).bits[5], 7u);
  EXPECT_LE(ResolveFilm(film, Aov::ElementId).bits[5], 1u);
}

TEST(Scheduler, TheValidationLayerHasNothingToSay) {
  const char* validation = std::getenv("HDWAVEFRONT_VALIDATION");
  if (validation == nullptr) setenv("HDWAVEFRONT_VALIDATION", "1", 1);
  World world;
  const uint64_t before = world.renderer->stats().validationMessages;
  world.AddMixedScene();
  world.Render();
  world.settings.bandRows = 11;
  world.settings.samplesPerBatch = 3;
  world.Render();
  EXPECT_EQ(world.renderer->stats().validationMessages, before);
  if (validation == nullptr) unsetenv("HDWAVEFRONT_VALIDATION");
}

}  // namespace
}  // namespace wavefront
