// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Kernels that come while the render goes on: what is held, what stands in, and that the picture cannot tell.
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <thread>

#include "tests/wavefront/scheduler/fixture.h"

namespace wavefront {
namespace {

// Compiling that waits for the test.
class Gate {
 public:
  ~Gate() { Open(); }
  void Open() {
    std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  void Pass() {
    std::unique_lock lock(mutex_);
    ++waiting;
    changed_.wait(lock, [this] { return open_; });
  }
  std::atomic<int> waiting{0};

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
};

// A kernel of the fixture whose code is asked for when it is worn; `gate` may be null. Made here, so that a test's time is
// the core's.
MaterialKernelData Lazy(const std::string& key, std::shared_ptr<Gate> gate, std::shared_ptr<std::atomic<int>> calls = {}) {
  MaterialKernelData kernel = MakeKernel(key, key == "cutout", key == "emissive", key == "glass");
  kernel.hasOpacity = !kernel.opacitySpirv.empty();
  kernel.hasEmission = !kernel.emissionSpirv.empty();
  kernel.user = "/material/" + key;
  auto code = std::make_shared<std::vector<uint32_t>[]>(3);
  code[0] = std::move(kernel.surfaceSpirv);
  code[1] = std::move(kernel.opacitySpirv);
  code[2] = std::move(kernel.emissionSpirv);
  kernel.surfaceSpirv = kernel.opacitySpirv = kernel.emissionSpirv = {};
  kernel.compile = [code, gate, calls](KernelEntry entry) {
    if (calls) ++*calls;
    if (gate) gate->Pass();
    return KernelCode{code[static_cast<std::size_t>(entry)], {}, 0, false};
  };
  return kernel;
}

constexpr const char* kKeys[] = {"lambert", "emissive", "cutout", "glass"};

void WaitUntil(const std::function<bool()>& done) {
  bool isDone = done();
  for (int i = 0; i < 6000 && !isDone; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    isDone = done();
  }
  EXPECT_TRUE(isDone) << "nothing came of it within 30 seconds";
}

uint64_t ReadyFromTheStart(const std::function<void(World&)>& set) {
  World world;
  set(world);
  world.AddMixedScene();
  return HashFilm(world.Render());
}

TEST(KernelCompile, HeldPathsChangeNoBit) {
  for (const uint32_t pool : {0u, 256u}) {  // the small one fills with held paths
    const auto set = [&](World& world) { world.settings.poolSize = pool; };
    const uint64_t expected = ReadyFromTheStart(set);
    for (const std::string held : {"cutout", "emissive", "lambert"}) {
      SCOPED_TRACE(held + ", pool " + std::to_string(pool));
      auto gate = std::make_shared<Gate>();
      World world;
      set(world);
      for (const char* key : kKeys) world.renderer->RegisterKernel(Lazy(key, key == held ? gate : nullptr));
      world.AddMixedScene();
      ASSERT_TRUE(world.Commit().ok());
      ASSERT_TRUE(world.renderer->Start().ok());
      // The render goes on with all others, and then waits without spinning.
      WaitUntil([&] { return world.renderer->progress().pathsDone > 0 && gate->waiting > 0; });
      uint64_t submits = 0;
      int still = 0;
      WaitUntil([&] {
        const RenderStats stats = world.renderer->stats();
        still = stats.submits == submits && stats.kernelsPending != 0 ? still + 1 : 0;
        submits = stats.submits;
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        return still == 5;
      });
      EXPECT_FALSE(world.renderer->IsConverged());
      EXPECT_TRUE(world.renderer->Map(Aov::Color).ok());  // what there is
      const uint64_t version = world.renderer->version();
      gate->Open();
      EXPECT_TRUE(world.renderer->WaitUntilDone(120));
      EXPECT_TRUE(world.renderer->IsConverged());
      EXPECT_EQ(world.renderer->version(), version);  // nothing was thrown away
      EXPECT_EQ(HashFilm(world.renderer->ReadFilm().value()), expected);
      EXPECT_EQ(world.renderer->stats().kernelsPending, 0u);
    }
  }
}

TEST(KernelCompile, StandInsNeverStay) {
  const uint64_t expected = ReadyFromTheStart([](World&) {});
  auto gate = std::make_shared<Gate>();
  World world;
  world.settings.interactive = true;
  for (const char* key : kKeys) world.renderer->RegisterKernel(Lazy(key, std::string(key) == "lambert" ? nullptr : gate));
  world.AddMixedScene();
  ASSERT_TRUE(world.Commit().ok());
  ASSERT_TRUE(world.renderer->Start().ok());
  // All samples are taken, by stand-ins where need be; that is no finished picture.
  WaitUntil([&] { return world.renderer->progress().samplesDone == world.settings.samples; });
  EXPECT_FALSE(world.renderer->IsConverged());
  EXPECT_NE(HashFilm(world.renderer->ReadFilm().value()), expected);
  const uint64_t version = world.renderer->version();
  gate->Open();
  EXPECT_TRUE(world.renderer->WaitUntilDone(120));
  EXPECT_TRUE(world.renderer->IsConverged());
  EXPECT_GT(world.renderer->version(), version);
  EXPECT_EQ(HashFilm(world.renderer->ReadFilm().value()), expected);
}

TEST(KernelCompile, WhatDoesNotCompileIsMagentaAndSaid) {
  World world;
  MaterialKernelData broken;
  broken.key = "broken";
  broken.user = "/material/broken";
  broken.hasOpacity = broken.hasEmission = true;
  broken.compile = [](KernelEntry) { return KernelCode{{}, "line 1: no such thing", 0, false}; };
  world.renderer->RegisterKernel(broken);
  MaterialKernelData rubbish;  // SPIR-V by its first word only
  rubbish.key = "rubbish";
  rubbish.user = "/material/rubbish";
  rubbish.surfaceSpirv = {1, 2, 3, 4, 5, 6};
  world.renderer->RegisterKernel(rubbish);
  const MeshId quad = world.renderer->CreateMesh(Quad());
  MaterialData data = MakeMaterial("broken", {0.5f, 0.5f, 0.5f}, 1, {3, 3, 3});
  world.Instance("/broken", quad, world.renderer->CreateMaterial(data), {Scaled(0.5, 0.5, 1, -0.6, 0, 0)});
  data.kernelKey = "rubbish";
  world.Instance("/rubbish", quad, world.renderer->CreateMaterial(data), {Scaled(0.5, 0.5, 1, 0.6, 0, 0)});
  world.Instance("/good", quad, world.Material(MakeMaterial("lambert", {0.5f, 0.5f, 0.5f})), {Scaled(3, 3, 1, 0, 0, -1)});
  world.Dome(1);
  const RawFilm film = world.Render();
  EXPECT_TRUE(world.Said("material-kernel-failed", "/material/broken"));
  EXPECT_TRUE(world.Said("material-kernel-failed", "/material/rubbish"));
  for (const uint32_t x : {14u, 26u}) {
    EXPECT_GT(ColorAt(film, x, 15, 0), 0.5f);
    EXPECT_EQ(ColorAt(film, x, 15, 1), 0.0f);
    EXPECT_GT(ColorAt(film, x, 15, 2), 0.5f);
  }
  EXPECT_GT(ColorAt(film, 20, 2, 1), 0.2f);
}

TEST(KernelCompile, EachKernelIsMadeOnceAndOnlyWhenWorn) {
  auto calls = std::make_shared<std::atomic<int>>(0);
  World world;
  for (const char* key : kKeys) world.renderer->RegisterKernel(Lazy(key, nullptr, calls));
  const MeshId quad = world.renderer->CreateMesh(Quad());
  const MaterialId grey = world.Material(MakeMaterial("lambert", {0.5f, 0.5f, 0.5f}));
  const MaterialId gauze = world.Material(MakeMaterial("cutout", {0.5f, 0.5f, 0.5f}, 0.5f));
  const InstanceGroupId group = world.Instance("/quad", quad, grey, {Scaled(1, 1, 1)});
  world.Dome(1);
  world.Render();
  EXPECT_EQ(*calls, 1);
  world.renderer->SetMaterial(grey, MakeMaterial("lambert", {0.9f, 0.1f, 0.1f}));  // a value
  world.Render();
  EXPECT_EQ(*calls, 1);
  InstanceData data;
  data.path = "/quad";
  data.mesh = quad;
  data.materials = {gauze};
  data.transforms = {{{0, Matrix4d{}}}};
  world.renderer->SetInstances(group, data);
  world.Render();
  EXPECT_EQ(*calls, 3);  // surface and opacity
}

TEST(KernelCompile, DestroyingWaitsForWhatHasBegunOnly) {
  auto gate = std::make_shared<Gate>();
  auto calls = std::make_shared<std::atomic<int>>(0);
  auto world = std::make_unique<World>(1u);  // one thread compiles
  for (const char* key : kKeys) world->renderer->RegisterKernel(Lazy(key, gate, calls));
  world->AddMixedScene();
  ASSERT_TRUE(world->Commit().ok());
  ASSERT_TRUE(world->renderer->Start().ok());
  WaitUntil([&] { return gate->waiting == 1; });
  std::thread opener([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    gate->Open();
  });
  world.reset();
  opener.join();
  EXPECT_EQ(*calls, 1);  // the others were forgotten
}

TEST(KernelCompile, KernelsMayBeRegisteredWhileACommitRuns) {
  World world;
  world.AddMixedScene();
  const MaterialKernelData kernel = Lazy("lambert", nullptr);
  std::atomic<bool> stop{false};
  std::thread registering([&] {
    for (int i = 0; !stop && i < 2000; ++i) {
      MaterialKernelData other = kernel;
      other.key = "other" + std::to_string(i);
      world.renderer->RegisterKernel(std::move(other));
    }
  });
  for (int i = 0; i < 5; ++i) {
    world.settings.seed = static_cast<uint32_t>(i);
    EXPECT_TRUE(world.Commit().ok());
  }
  stop = true;
  registering.join();
  world.Render();
}

TEST(KernelCompile, WithoutTheDriversCacheTheRenderingDeviceCompiles) {
  const uint64_t expected = ReadyFromTheStart([](World&) {});
  ASSERT_EQ(setenv("MESA_SHADER_CACHE_DISABLE", "true", 1), 0);
  World world;
  for (const char* key : kKeys) world.renderer->RegisterKernel(Lazy(key, nullptr));
  world.AddMixedScene();
  EXPECT_EQ(HashFilm(world.Render()), expected);
  unsetenv("MESA_SHADER_CACHE_DISABLE");
  bool onCpu = false;
  for (const DeviceDescription& device : ListDevices()) onCpu = onCpu || device.type == "CPU";
  if (onCpu) EXPECT_TRUE(world.Said("kernel-compile-slow"));
}

}  // namespace
}  // namespace wavefront
