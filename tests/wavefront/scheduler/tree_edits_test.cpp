// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Trees of edited meshes, through the renderer: which way each edit's tree is made, that no way shows in the picture, and that
// an edit uploads what it changed. Run with --gtest_also_run_disabled_tests --gtest_filter='TreeEdits.DISABLED_*' it measures
// (resources/TRAVERSAL.md).
#include <cmath>
#include <cstdio>
#include <ctime>

#include "tests/wavefront/scheduler/fixture.h"

namespace wavefront {
namespace {

// Hills over [-1, 1]^2, seen from the front; `time` moves them. With a primvar that stays.
MeshData Hills(uint32_t side, float time, float height = 0.2f) {
  MeshData mesh;
  for (uint32_t y = 0; y <= side; ++y)
    for (uint32_t x = 0; x <= side; ++x) {
      const float u = 2 * static_cast<float>(x) / static_cast<float>(side) - 1, v = 2 * static_cast<float>(y) / static_cast<float>(side) - 1;
      mesh.positions.push_back({u + 0.05f * std::sin(3 * v + time), v, height * std::sin(5 * u + time) * std::cos(4 * v) + 0.02f * std::sin(40 * u + 30 * v)});
    }
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      const uint32_t a = y * (side + 1) + x, b = a + side + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  PrimvarData weight{"weight", Interpolation::Vertex, 1, std::vector<float>(mesh.positions.size(), 0.5f), {}};
  mesh.primvars.push_back(std::move(weight));
  return mesh;
}

// The same surface with its triangles' corners in another order.
MeshData Rotated(MeshData mesh) {
  for (UInt3& t : mesh.triangles) t = {t.y, t.z, t.x};
  return mesh;
}

RawFilm Fresh(const MeshData& mesh) {
  World world;
  const MeshId id = world.renderer->CreateMesh(mesh);
  world.Instance("/hills", id, world.Material(MakeMaterial("lambert", {0.7f, 0.6f, 0.5f})), {Moved(0, 0, 0)});
  world.Dome(1);
  return world.Render();
}

struct Edited : World {
  MeshId mesh = kInvalidId;
  InstanceGroupId group = 0;

  explicit Edited(const MeshData& data) {
    mesh = renderer->CreateMesh(data);
    group = Instance("/hills", mesh, Material(MakeMaterial("lambert", {0.7f, 0.6f, 0.5f})), {Moved(0, 0, 0)});
    Dome(1);
    settings.interactive = true;
  }
  RawFilm Edit(MeshData data) {
    renderer->SetMesh(mesh, std::move(data));
    return Render();
  }
  // Trees built, built fast and refitted by now.
  std::vector<uint64_t> trees() const {
    const TreeStats t = renderer->stats().trees;
    return {t.built, t.builtFast, t.refitted};
  }
};

using Counts = std::vector<uint64_t>;

TEST(TreeEdits, EachWayGivesThePictureOfAFreshRender) {
  Edited world(Hills(60, 0));
  EXPECT_EQ(HashFilm(world.Render()), HashFilm(Fresh(Hills(60, 0))));
  EXPECT_EQ(world.trees(), (Counts{1, 0, 0})) << "the first build is for good";
  for (const float time : {0.1f, 0.2f, 0.5f}) EXPECT_EQ(HashFilm(world.Edit(Hills(60, time))), HashFilm(Fresh(Hills(60, time)))) << time;
  EXPECT_EQ(world.trees(), (Counts{1, 0, 3}));
  EXPECT_EQ(HashFilm(world.Edit(Rotated(Hills(60, 0.5f)))), HashFilm(Fresh(Rotated(Hills(60, 0.5f)))));
  EXPECT_EQ(world.trees(), (Counts{1, 1, 3})) << "other triangles";
  EXPECT_EQ(HashFilm(world.Edit(Rotated(Hills(60, 0.5f, 40)))), HashFilm(Fresh(Rotated(Hills(60, 0.5f, 40)))));
  EXPECT_EQ(world.trees(), (Counts{1, 2, 3})) << "a refit would cost rays too much";
  MeshData broken = Rotated(Hills(60, 0.5f, 40));
  broken.positions[1000].x = std::nanf("");
  EXPECT_EQ(HashFilm(world.Edit(broken)), HashFilm(Fresh(broken)));
  EXPECT_EQ(world.trees(), (Counts{1, 3, 3})) << "triangles can no longer be hit";
  EXPECT_TRUE(world.Said("mesh-broken-triangles"));
}

TEST(TreeEdits, ARenderThatIsNotInteractiveSeesFinalTreesOnly) {
  Edited world(Hills(60, 0));
  world.Render();
  const RawFilm moved = world.Edit(Hills(60, 0.3f));
  EXPECT_EQ(world.trees(), (Counts{1, 0, 1}));
  const uint64_t version = world.renderer->version();
  world.settings.interactive = false;
  EXPECT_EQ(HashFilm(world.Render()), HashFilm(moved));
  EXPECT_EQ(world.trees(), (Counts{2, 0, 1})) << "built for good from what is on the device";
  EXPECT_GT(world.renderer->version(), version);
  // Final trees stay; so do those of meshes that only their primvars change.
  const uint64_t finished = world.renderer->version();
  world.Render();
  EXPECT_EQ(world.renderer->version(), finished);
  MeshData painted = Hills(60, 0.3f);
  painted.primvars[0].values[7] = 2;
  world.Edit(painted);
  EXPECT_EQ(world.trees(), (Counts{2, 0, 1}));
  EXPECT_EQ(HashFilm(world.Edit(Hills(60, 0.4f))), HashFilm(Fresh(Hills(60, 0.4f))));
  EXPECT_EQ(world.trees(), (Counts{3, 0, 1})) << "edits are built for good again";
}

TEST(TreeEdits, UploadWhatChanged) {
  Edited world(Hills(60, 0));
  world.Render();
  const auto uploaded = [&](MeshData mesh) {
    const uint64_t before = world.renderer->stats().uploadedBytes;
    world.Edit(std::move(mesh));
    return world.renderer->stats().uploadedBytes - before;
  };
  const uint64_t triangles = 2 * 60 * 60, points = 61 * 61;
  constexpr uint64_t kScene = 8192;  // instance, bindings, frame
  const uint64_t moved = uploaded(Hills(60, 0.1f));
  EXPECT_GT(moved, 48 * triangles);
  EXPECT_LT(moved, (48 + 24) * triangles) << "no indices";
  MeshData painted = Hills(60, 0.1f);
  painted.primvars[0].values[7] = 2;
  const uint64_t paint = uploaded(painted);
  EXPECT_GE(paint, 4 * points);
  EXPECT_LT(paint, 4 * points + kScene) << "no tree";
  EXPECT_LT(uploaded(painted), kScene) << "nothing changed";
  EXPECT_EQ(world.trees(), (Counts{1, 0, 1}));
}

TEST(TreeEdits, ManyInstancesThatMovedAreRefitted) {
  const auto places = [](double time) {
    std::vector<Matrix4d> all;
    for (int i = 0; i < 5000; ++i) all.push_back(Scaled(0.01, 0.01, 0.01, i % 71 / 36.0 - 1 + 0.02 * std::sin(i + time), i / 71 / 36.0 - 1, 0.1 * std::cos(0.7 * i + time)));
    return all;
  };
  const auto group = [&](World& world, MeshId mesh, double time) {
    InstanceData data;
    data.path = "/crowd";
    data.mesh = mesh;
    data.materials = {world.Material(MakeMaterial("lambert", {0.7f, 0.6f, 0.5f}))};
    for (const Matrix4d& m : places(time)) data.transforms.push_back({{0, m}});
    return data;
  };
  const auto fresh = [&](double time) {
    World world;
    world.renderer->CreateInstances(group(world, world.renderer->CreateMesh(Box()), time));
    world.Dome(1);
    return HashFilm(world.Render());
  };
  World world;
  world.settings.interactive = true;
  const MeshId mesh = world.renderer->CreateMesh(Box());
  const InstanceGroupId id = world.renderer->CreateInstances(group(world, mesh, 0));
  world.Dome(1);
  world.Render();
  world.renderer->SetInstances(id, group(world, mesh, 0.1));
  EXPECT_EQ(HashFilm(world.Render()), fresh(0.1));
  EXPECT_EQ(world.renderer->stats().trees.instancesBuilt, 1u);
  EXPECT_EQ(world.renderer->stats().trees.instancesRefitted, 1u);
  world.settings.interactive = false;
  EXPECT_EQ(HashFilm(world.Render()), fresh(0.1));
  EXPECT_EQ(world.renderer->stats().trees.instancesBuilt, 2u);
}

// ---- Measured ---------------------------------------------------------------------------------------------------

double CpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Cost {
  std::vector<double> commit, ray;
  static double Median(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
  }
};

// A commit and a render of each frame in turn, made anew, built fast and refitted.
TEST(TreeEdits, DISABLED_DeformingMesh) {
  for (const uint32_t side : {224u, 708u}) {
    std::unique_ptr<Edited> worlds[3];
    for (auto& w : worlds) {
      w = std::make_unique<Edited>(Hills(side, 0));
      w->settings.width = 320;
      w->settings.height = 240;
      w->settings.samples = 4;
      w->settings.interactive = &w != &worlds[0];
      w->Render();
    }
    Cost costs[3];
    for (int frame = 1; frame <= 9; ++frame) {
      const MeshData mesh = Hills(side, 0.1f * static_cast<float>(frame));
      for (int way = 0; way < 3; ++way) {
        Edited& w = *worlds[way];
        w.renderer->SetMesh(w.mesh, way == 1 && frame % 2 == 1 ? Rotated(mesh) : mesh);
        double start = CpuSeconds();
        ASSERT_TRUE(w.Commit().ok());
        costs[way].commit.push_back(CpuSeconds() - start);
        w.Finish();
        for (const KernelStats& k : w.renderer->stats().kernels)
          if (k.name == "extension_ray" || k.name == "extensionRay") costs[way].ray.push_back(1e6 * k.milliseconds / static_cast<double>(k.items));
      }
    }
    std::printf("%u triangles\n", 2 * side * side);
    const char* const names[3] = {"built for good", "built fast", "refitted"};
    for (int way = 0; way < 3; ++way) {
      const Counts t = worlds[way]->trees();
      std::printf("  %-15s commit %.1f ms of CPU time, extension ray %.0f ns (%zu measured); built %llu, fast %llu, refitted %llu\n", names[way],
                  1e3 * Cost::Median(costs[way].commit), costs[way].ray.empty() ? 0 : Cost::Median(costs[way].ray), costs[way].ray.size(),
                  static_cast<unsigned long long>(t[0]), static_cast<unsigned long long>(t[1]), static_cast<unsigned long long>(t[2]));
    }
  }
}

}  // namespace
}  // namespace wavefront
